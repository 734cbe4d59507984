"""The page of the explorer in Debian's Chromium, driven by Playwright."""

import shutil
from contextlib import contextmanager

import numpy as np
import pytest

import restitution as rs

CHROMIUM = shutil.which("chromium")
MARKS = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="the browser tests need Chromium: apt-get install chromium"),
]
OPTIONS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
# The examples of the page may change; these tests start here.
BASE = {
    "material.equilibrium_modulus": 1e6, "material.branch_modulus": 1e7, "material.viscosity": 1e3,
    "material.poisson_ratio": 0.49, "material.density": 1100.0, "body.radius": 0.01, "body.mass": 0.005,
    "impact.velocity": 1.0,
}  # fmt: skip
SHOWN = 1e-12
"""The page has each number of the solver to the last digits of its decimal form."""


@contextmanager
def serving(state=None, title=None, port=0, token=None):
    from restitution.explorer import launch

    running = launch.listen(state, title, port=port)
    if token is not None:
        object.__setattr__(running.access, "token", token)
    thread = launch.in_thread(running)
    yield running
    running.stop()
    thread.join()


def until(page, condition):
    """Wait for a condition in JavaScript; the page's policy forbids Playwright's own way, which evaluates texts."""
    for _ in range(1500):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(20)
    raise TimeoutError(condition)


def number(page, name):
    text = page.locator(f"[data-output={name}]:visible").first.get_attribute("data-value")
    return float(text) if text else np.nan


def wait_for(page, name, expected, rtol=SHOWN):
    """Wait until the page shows a number."""
    result = f"[...document.querySelectorAll('[data-output={name}]')].map(x => Number(x.dataset.value))"
    until(page, f"{result}.some(x => Math.abs(x - {expected!r}) <= {rtol} * Math.abs({expected!r}))")


def ball(**changes):
    """The impact of `BASE`, with changes."""
    values = {key.partition(".")[2]: value for key, value in BASE.items()} | changes
    names = ("equilibrium_modulus", "branch_modulus", "viscosity", "poisson_ratio", "density")
    material = rs.standard_solid(**{name: values[name] for name in names})
    return rs.Impact(material, rs.Parabola(values["radius"]), mass=values["mass"], velocity=values["velocity"])


def value_of(page, key):
    return page.evaluate(f"explorer.state.get({key!r})")
