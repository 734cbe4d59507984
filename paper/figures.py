"""Figures of the paper: `python paper/figures.py` writes them into `paper/figures`, with the numbers it states."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot import style

FOLDER = Path(__file__).parent / "figures"
# Row D1 of the reference values of reloading: E* = 1 + 4 exp(-t) under a parabola of radius 1.
PROGRAM = ([0.0, 1.0, 1.3, 1.6, 2.0, 3.0, 4.2], [0.0, 1.0, 0.7, 0.9, 0.6, 1.2, 0.0])


def velocities() -> dict[str, float]:
    """Restitution over velocity: a rubber of 15 terms, and laws of one constant with the same e at 1 m/s."""
    times = np.geomspace(1e-8, 1e-1, 15)
    rubber = rs.Material(rs.PronySeries(2e6, 8e6 / (1.0 + (times / 1e-6) ** 0.35), times), bulk=2e9)
    ball = rs.Impact(rubber, rs.Parabola(radius=0.01), mass=0.005, velocity=np.geomspace(1e-4, 1.0, 61))
    e = np.asarray(rs.solve(ball).restitution_coefficient)
    v = np.asarray(ball.velocity)
    at = float(e[-1])
    # First order of the viscous law: 1 - e ~ v^(1/5).
    viscous = 1.0 - (1.0 - at) * v**0.2
    with style.context():
        figure, axes = plt.subplots(figsize=(4.6, 2.9), layout="constrained")
        axes.semilogx(v, e, color=style.BLACK, label="15 relaxation times, exact")
        axes.semilogx(v, viscous, "--", color=style.VERMILION, label=r"one viscosity, $1-e\propto v^{1/5}$")
        axes.axhline(at, color=style.GREY, linestyle=":", label="constant $e$")
        axes.set(xlabel="impact velocity [m/s]", ylabel="coefficient of restitution", ylim=(0.0, 1.0))
        axes.legend()
        style.save_figure(figure, FOLDER / "velocity.png")
    plt.close(figure)
    return {"e at 0.1 mm/s": float(e[0]), "e at 1 m/s": at, "viscous law at 0.1 mm/s": float(viscous[0])}


def reloading() -> dict[str, float]:
    """Force over depth of a tip that is pulled back and pushed again, and pressed into its own imprint."""
    # E* = 4G of an incompressible half-space. All numbers are scaled, and the strain is of no meaning.
    material = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=np.inf)
    times, depths = PROGRAM
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = rs.indent(material, rs.Parabola(radius=1.0), depth=np.array(depths), time=np.array(times))
    history = result.sample(np.linspace(0.0, 4.2, 841))
    with style.context():
        figure, (left, right) = plt.subplots(1, 2, figsize=(6.4, 2.7), layout="constrained")
        left.plot(history["time"], history["indentation_depth"], color=style.BLUE, label="depth")
        left.plot(history["time"], history["contact_radius"], color=style.VERMILION, label="contact radius")
        left.set(xlabel="time", ylabel="depth, radius")
        left.legend()
        right.plot(history["indentation_depth"], history["force"], color=style.BLACK)
        right.set(xlabel="depth", ylabel="force")
        style.save_figure(figure, FOLDER / "reloading.png")
    plt.close(figure)
    return {"end of contact": float(result.contact_end_time), "work": float(result.work)}


def main() -> None:
    """Draw both figures and write their numbers."""
    FOLDER.mkdir(exist_ok=True)
    numbers = {"velocity": velocities(), "reloading": reloading()}
    (FOLDER / "numbers.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(numbers, indent=1))


if __name__ == "__main__":
    main()
