"""Forces of an elastic twin with their fit, and its residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.display import scaled_unit
from restitution.plot import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def force_law(law: Any) -> Figure:
    """Return a figure of the forces of a `ForceLaw` over depth with their fit, and of the residuals.

    Examples
    --------
    >>> from restitution.contact.force_law.law import ForceLaw
    >>> d = np.linspace(1e-5, 1e-3, 20)
    >>> force_law(ForceLaw(d, 1e3 * d, modulus=1e6, poisson_ratio=0.5)).axes[1].get_ylabel()
    'residual over the largest force'
    """
    used = law.depth > 0.0
    fine = np.linspace(0.0, 1.0, 400)
    (depth_factor, depth_unit), (force_factor, force_unit) = scaled_unit(law.depth, "m"), scaled_unit(law.force, "N")
    depth = f"depth $d$ [{depth_unit}]"
    with style.context():
        figure, (left, right) = style.panels("AB", height=3.2)
        left.plot(law.depth * depth_factor, law.force * force_factor, ".", color=style.GREY, label="data")
        fitted = law.fit.force_unit * law.fit.force(fine) * force_factor
        words = f"$d^{{{law.fit.exponent:.4g}}}$, degree {law.fit.degree}"
        left.plot(fine**2 * law.max_depth * depth_factor, fitted, color=style.BLUE, label=words)
        left.legend()
        style.labelled(left, depth, f"elastic force $F$ [{force_unit}]")
        right.plot(law.depth[used] * depth_factor, law.fit.residual, ".", color=style.BLUE)
        style.labelled(right, depth, "residual over the largest force")
        return style.finish(figure)
