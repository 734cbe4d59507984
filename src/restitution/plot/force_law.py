"""Forces of an elastic twin with their fit, and its residuals."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from restitution.plot import style
from restitution.quantities import MEASURED

_FORCE = MEASURED["force"]._replace(words="elastic force")


def force_law(law: Any) -> Figure:
    """Return a figure of the forces of a `ForceLaw` over depth with their fit, and of the residuals.

    Examples
    --------
    >>> from restitution.contact.force_law import ForceLaw
    >>> d = np.linspace(1e-5, 1e-3, 20)
    >>> force_law(ForceLaw(d, 1e3 * d, modulus=1e6, poisson_ratio=0.5)).axes[1].get_ylabel()
    'residual over the largest force'
    """
    used = law.depth > 0.0
    fine = np.linspace(0.0, 1.0, 400)
    depth, force = style.axis(MEASURED["depth"], law.depth), style.axis(_FORCE, law.force)
    with style.page("AB", height=3.2) as (figure, (left, right)):
        left.plot(law.depth * depth.factor, law.force * force.factor, ".", color=style.GREY, label="data")
        fitted = law.fit.force_unit * law.fit.force(fine) * force.factor
        words = f"$d^{{{law.fit.exponent:.4g}}}$, degree {law.fit.degree}"
        left.plot(fine**2 * law.max_depth * depth.factor, fitted, color=style.BLUE, label=words)
        left.legend()
        style.labelled(left, depth.label, force.label)
        right.plot(law.depth[used] * depth.factor, law.fit.residual, ".", color=style.BLUE)
        style.labelled(right, depth.label, "residual over the largest force")
    return figure
