"""Transform of splines at and beside their breaks, where rounding decides which piece contains a point."""

import math

import numpy as np
import pytest

from restitution import Tabulated, TruncatedCone

pytestmark = pytest.mark.plain


def tables(kind: str):
    """Tables of a shape at uneven radii, and its transform."""
    rng = np.random.default_rng(0)
    for _ in range(40):
        r = np.append(0.0, np.cumsum(rng.uniform(0.3, 1.0, rng.integers(3, 12))))
        r *= 10.0 ** rng.uniform(-6.0, 6.0) / r[-1]
        size, face = float(r[-1]), float(r[1])
        if kind == "truncated cone":
            cone = TruncatedCone(face, math.atan(2.5))
            yield r, np.maximum(r - face, 0.0) * 0.4, cone.transform
        elif kind == "parabola":
            yield r, r**2 / (2.0 * size), lambda x, size=size: x**2 / size
        else:
            yield r, 0.3 * r + r**2 / size, lambda x, size=size: 0.15 * math.pi * x + 2.0 * x**2 / size


# Before these cases were treated, about one in 60 tables gave an IndexError or a falling transform.
@pytest.mark.parametrize("kind", ["truncated cone", "parabola", "cone and parabola"])
def test_transform_beside_the_breaks(kind):
    for r, f, transform in tables(kind):
        tip = Tabulated(r, f)
        x = np.concatenate([r, np.nextafter(r[1:], 0.0), np.nextafter(r[1:-1], np.inf), 0.999 * r[1:]])
        wanted = transform(x)
        np.testing.assert_allclose(tip.transform(x), wanted, rtol=1e-9, atol=1e-9 * float(transform(r[-1])))
        flank = x > r[1] * (1.0 + 1e-6)
        np.testing.assert_allclose(tip.contact_radius(tip.transform(x[flank])), x[flank], rtol=1e-9)


@pytest.mark.parametrize("spacing", ["even", "uneven", "geometric", "with a gap"])
def test_transform_of_long_tables(spacing):
    """The transform of a r + b r^2 is pi/2 a x + 2 b x^2; pieces far from x count in groups of 32."""
    rng = np.random.default_rng(7)
    steps = {
        "even": np.ones(500),
        "uneven": rng.uniform(0.1, 1.0, 500),
        "geometric": np.geomspace(1e-4, 1.0, 300),
        "with a gap": np.repeat([0.1, 50.0, 0.1], [200, 1, 199]),
    }[spacing]
    r = np.append(0.0, np.cumsum(steps))
    r /= r[-1]
    tip = Tabulated(r, 0.3 * r + r**2)
    x = np.sort(np.concatenate([r, rng.uniform(0.0, 1.0, 500)]))
    np.testing.assert_allclose(tip.transform(x), 0.15 * math.pi * x + 2.0 * x**2, rtol=1e-10)
    wanted = 0.15 * math.pi * x**2 / 2.0 + 4.0 * x**3 / 3.0
    np.testing.assert_allclose(tip.force_integral(x), wanted, rtol=1e-10)
