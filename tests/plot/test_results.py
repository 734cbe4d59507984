"""Every result has a picture that a notebook can show."""

from io import BytesIO

import matplotlib.image
import numpy as np
import pytest

import restitution as rs
from restitution.material.measurement import RelaxationTable

RUBBER = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1100.0)
BALL = rs.Parabola(0.01)
TIME = np.geomspace(1e-4, 1e2, 60)

RESULTS = {
    "impact": lambda: rs.solve(rs.Impact(RUBBER, BALL, mass=0.005, velocity=0.1)),
    "bounces": lambda: rs.bounces(
        rs.drop(rs.Body(RUBBER, radius=0.01), rs.Body(None), height=0.1), max_bounces=2
    ),
    "indentation": lambda: rs.indent(RUBBER, BALL, depth=[0.0, 1e-4, 0.0], time=[0.0, 1.0, 2.0]),
    "material": lambda: RUBBER,
    "series": lambda: RUBBER.shear,
    "fit": lambda: rs.fit_prony(RelaxationTable(TIME, RUBBER.shear.relaxation_modulus(TIME), "shear")),
    "surrogate": lambda: rs.surrogate(
        rs.Impact(RUBBER, BALL, mass=0.005, velocity=1.0), (0.1, 1.0), rtol=1e-3
    ),
}


@pytest.mark.parametrize("make", RESULTS.values(), ids=RESULTS.keys())
def test_picture_of_a_result(make) -> None:
    figure = make().plot()
    image = matplotlib.image.imread(BytesIO(figure._repr_png_()))
    # The PNG has the size of the figure at 100 dots per inch, as a notebook shows it.
    width, height = figure.get_size_inches()
    assert image.shape[:2] == pytest.approx((100 * height, 100 * width), abs=1)
    assert 300 <= image.shape[1] <= 1200
    # Lines and letters cover some of the paper, and most of it stays white.
    ink = np.mean(image[..., :3].min(axis=-1) < 0.9)
    assert 0.005 < ink < 0.5
