"""The recipes for JAX and PyTorch, where these are installed, against differences of solves."""

import contextlib
import io

import numpy as np
import pytest

import restitution as rs
from checkout import blocks

PAGE = "docs/gradients.md"
FIRST, OF_JAX, OF_TORCH = blocks(PAGE, "python")
SHOWN = blocks(PAGE, "text")
POINT = np.array([1.0, 1e3])


def printed(*codes: str) -> tuple[list[str], dict]:
    """What each block prints, and the names they leave."""
    names: dict = {}
    texts = []
    for code in codes:
        with contextlib.redirect_stdout(io.StringIO()) as text:
            exec(compile(code, PAGE, "exec"), names)  # the page's own code
        texts.append(text.getvalue())
    return texts, names


def slopes_of_square() -> np.ndarray:
    """Gradient of e^2 by central differences of fourth order, steps of 1 %: errors of 1e-8 of it."""
    rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    ball = rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)

    def square(x: np.ndarray) -> float:
        moved = rs.vary(ball, {"velocity": x[0], "viscosity": x[1]})
        return float(rs.solve(moved, rtol=1e-11).restitution_coefficient) ** 2

    results = []
    for step in np.diag(0.01 * POINT):
        near, far = (square(POINT + k * step) - square(POINT - k * step) for k in (1, 2))
        results.append((8.0 * near - far) / (12.0 * step.sum()))
    return np.array(results)


def test_the_function_behind_the_recipes():
    texts, names = printed(FIRST)
    assert texts == SHOWN[:1]
    value, gradient = names["value_and_gradient"](POINT)
    assert 2.0 * value * gradient == pytest.approx(slopes_of_square(), rel=1e-6)


def test_the_recipe_for_jax():
    jax = pytest.importorskip("jax")
    texts, names = printed(FIRST, OF_JAX)
    assert texts[1] == SHOWN[1]
    assert np.asarray(names["gradient"]) == pytest.approx(slopes_of_square(), rel=1e-6)
    rows = jax.numpy.array([POINT, 1.1 * POINT])
    each = [float(names["value_and_gradient"](row)[0]) for row in np.asarray(rows)]
    assert np.asarray(jax.vmap(names["restitution"])(rows)) == pytest.approx(each, rel=1e-12)


def test_the_recipe_for_torch():
    torch = pytest.importorskip("torch")
    texts, names = printed(FIRST, OF_TORCH)
    assert texts[1] == SHOWN[2]
    assert names["x"].grad.numpy() == pytest.approx(slopes_of_square(), rel=1e-6)
    # PyTorch's own comparison with differences of its function, steps of 1e-6.
    x = torch.tensor(POINT / [1.0, 1e3], dtype=torch.float64, requires_grad=True)
    scale = torch.tensor([1.0, 1e3], dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda y: names["Restitution"].apply(y * scale), (x,), eps=1e-3, rtol=1e-3)
