"""Materials from the sound of a bouncing ball: bias of the usual evaluation, standard errors, coverage, drag of air.

Run as `python validation/identification_bounces.py`; prints tables and writes them to `identification_bounces.md`
beside this file. Takes two minutes.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import restitution as rs
from restitution.identification.parameters import column

RADIUS, MASS, HEIGHT, NOISE, REPETITIONS = 0.01, 7850.0 * 4.0 / 3.0 * math.pi * 1e-6, 0.3, 5e-5, 40
GRAVITY, AIR, DRAG = 9.80665, 1.2, 0.47
CASES = {"A": (1e6, 1e7, 1e-3, 6), "B": (1e6, 1e7, 3e-5, 12), "D": (1e6, 2e5, 1e-3, 25), "hard": (1e9, 1e9, 1e-6, 25)}
"""Equilibrium modulus [Pa], branch modulus [Pa], relaxation time [s], number of touches."""

TEXT = """\
# Materials from the sound of a bouncing ball

Made by `validation/identification_bounces.py`. A steel ball, R = 10 mm, falls 0.3 m onto an incompressible standard
solid. A has Ginf = 1 MPa, G1 = 10 MPa and tau = 1 ms, B 1 MPa, 10 MPa and 0.03 ms, D 1 MPa, 0.2 MPa and 1 ms, the
hard one 1 GPa, 1 GPa and 1 us. The instants of touch are those of `rs.bounces`.

## Bias of e

Error of e at the last bounce: from the ratio of successive times between touches, and from the same after the contact
time has been subtracted; the body leaves from a depth, and arrives at the surface. The last column is the largest
error of an interval that `rs.BounceTimes` predicts from the true material, over a noise of 50 us.

{bias}

## What the sound shows

Standard errors in per cent at the true material: of abs(E*) and E'' at pi over the contact time in the middle, and of
tan delta at pi over the contact time that each trial material has itself.

{errors}

The loss at the time scale of the contact is known to a per cent, that of the hard ball to 8. The time scale itself and
the stiffness are known only where contacts are long compared with the noise: not for D and for the hard ball, even
with a noise of 20 us.

## Coverage

Share in per cent of {repetitions} random series for which the 95 % interval of the linearised fit holds the true
value, and the root mean square of the deviation over the stated error; noise 50 us.

{coverage}

## Drag of air

Instants of a ball on D in air, by SciPy's integration of each flight with quadratic drag (density {air} kg/m^3,
coefficient {drag}) between solves of each impact. Largest deviation of an interval from the prediction of the true
material over a noise of 50 us, with and without the drag in `rs.BounceTimes`, and chi2 over the degrees of freedom of
a fit without it.

{air_table}
"""


def material(case: str) -> rs.Material:
    """Incompressible standard solid of a case."""
    equilibrium, branch, time, _ = CASES[case]
    return rs.standard_solid(equilibrium, branch, branch * time, poisson_ratio=0.5)


def series(case: str) -> rs.Bounces:
    """Bounces of the ball from its height."""
    impact = rs.drop(rs.Body(None, RADIUS, MASS), rs.Body(material(case)), HEIGHT)
    return rs.bounces(impact, max_bounces=CASES[case][3], min_height=0.0)


def sound(time: np.ndarray, noise: float = NOISE, air_density: float = 0.0) -> rs.BounceTimes:
    """Observation; the data of these tables have no drag unless it is given."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rs.BounceTimes(time, radius=RADIUS, mass=MASS, noise=rs.Noise(time=noise), air_density=air_density)


def fitted(case: str, data: rs.BounceTimes) -> rs.Identification:
    """Fit from the true constants, so that each fit takes one start."""
    equilibrium, branch, tau, _ = CASES[case]
    start = {"equilibrium_modulus": equilibrium, "branch_modulus": branch, "viscosity": branch * tau}
    return rs.identify(data, rs.standard_solid, fixed={"poisson_ratio": 0.5}, start=start, profiles=False)


def functions_of(data: rs.BounceTimes, constants: np.ndarray, omega: float) -> np.ndarray:
    """Logarithms of |E*| and E'' at omega, and of tan delta at pi over the own contact time in the middle."""
    materials = column([rs.standard_solid(*np.exp(constants), poisson_ratio=0.5)])
    at_contact = math.pi / float(np.nanmedian(data.contact_times(materials)))
    fixed, there = rs.reduced_modulus(materials).complex_modulus(np.array([omega, at_contact]))[0]
    return np.log([abs(fixed), fixed.imag, there.imag / there.real])


def errors_of(data: rs.BounceTimes, constants: np.ndarray, omega: float) -> np.ndarray:
    """Standard errors of these functions for a material."""
    steps = 1e-4 * np.eye(3)
    points = np.concatenate([constants + steps, constants - steps])
    materials = column([rs.standard_solid(*np.exp(point), poisson_ratio=0.5) for point in points])
    residuals = data.residuals(materials, np.empty((6, 0)))
    functions = np.array([functions_of(data, point, omega) for point in points])
    J, G = ((point[:3] - point[3:]).T / 2e-4 for point in (residuals, functions))
    return np.sqrt(np.diag(G @ np.linalg.pinv(J.T @ J, rcond=1e-14) @ G.T))


def constants_of(case: str) -> np.ndarray:
    """Logarithms of equilibrium modulus, branch modulus and viscosity."""
    equilibrium, branch, tau, _ = CASES[case]
    return np.log([equilibrium, branch, branch * tau])


def bias_table() -> str:
    lines = [
        "| case | touches | contact times, ms | e, last | intervals | less contact times | prediction, sd |",
        "|---|---|---|---|---|---|---|",
    ]
    for case in CASES:
        result = series(case)
        e, times, intervals = result.restitution_coefficient, result.contact_time[:-1], np.diff(result.touch_time)
        naive, less = (gaps[-1] / gaps[-2] - e[-2] for gaps in (intervals, intervals - times))
        data = sound(result.touch_time)
        error = data.predicted(column([material(case)]))[0] - intervals[1:]
        lines.append(
            f"| {case} | {result.n_bounces} | {1e3 * times[0]:.2f} to {1e3 * times[-1]:.2f} | {e[-2]:.4f} | "
            f"{naive:+.4f} | {less:+.4f} | {np.abs(error).max() / NOISE:.1g} |"
        )
    return "\n".join(lines)


def error_table() -> str:
    lines = ["| case | noise, us | abs(E*) | E'' | tan delta |", "|---|---|---|---|---|"]
    for case in CASES:
        result = series(case)
        omega = math.pi / float(np.median(result.contact_time))
        for noise in (NOISE, 2e-5):
            errors = 100.0 * errors_of(sound(result.touch_time, noise), constants_of(case), omega)
            shown = " | ".join(f"{percent:.2g}" if percent < 100.0 else "> 100" for percent in errors)
            lines.append(f"| {case} | {1e6 * noise:.0f} | {shown} |")
    return "\n".join(lines)


def coverage_table() -> str:
    lines = ["| case | of | coverage of 95 % | deviation over error |", "|---|---|---|---|"]
    for case in ("A", "B", "D"):
        result = series(case)
        omega = math.pi / float(np.median(result.contact_time))
        truth = functions_of(sound(result.touch_time), constants_of(case), omega)
        random, rows = np.random.default_rng([2, ord(case)]), []
        for _ in range(REPETITIONS):
            data = sound(result.touch_time + NOISE * random.standard_normal(result.n_bounces))
            constants = fitted(case, data).coordinates[:3]
            rows.append((functions_of(data, constants, omega) - truth) / errors_of(data, constants, omega))
        z = np.array(rows)
        names = ("abs(E*)", "E''", "tan delta") if case != "D" else ("", "", "tan delta")
        for name, scores in zip(names, z.T, strict=True):
            if name:
                share, spread = 100.0 * np.mean(np.abs(scores) < 1.96), math.sqrt(np.mean(scores**2))
                lines.append(f"| {case} | {name} | {share:.0f} | {spread:.2f} |")
    return "\n".join(lines)


def in_air(case: str, number: int) -> np.ndarray:
    """Instants of touch in air."""
    drag = 0.5 * AIR * DRAG * math.pi * RADIUS**2 / MASS

    def motion(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -GRAVITY - drag * y[1] * abs(y[1])]

    def landing(_: float, y: np.ndarray) -> float:
        return y[0] if y[1] < 0.0 else -1.0

    landing.terminal, landing.direction = True, -1.0  # pyright: ignore[reportFunctionMemberAccess]
    time, velocity, instants = 0.0, math.sqrt(2.0 * GRAVITY * HEIGHT), list[float]()
    for _ in range(number):
        instants.append(time)
        hit = rs.solve(rs.Impact(material(case), rs.Parabola(RADIUS), MASS, velocity, external_force=MASS * GRAVITY))
        start = [-float(hit.residual_indentation_depth), float(hit.rebound_velocity)]
        flight = solve_ivp(motion, (0.0, 3.0), start, events=landing, rtol=1e-10, atol=1e-12, max_step=0.02)
        time += float(hit.contact_time) + float(flight.t_events[0][0])
        velocity = -float(flight.y_events[0][0, 1])
    return np.array(instants)


def air_table() -> str:
    lines = ["| touches | with drag | without | chi2/dof without |", "|---|---|---|---|"]
    time = in_air("D", 25)
    truth, none = column([material("D")]), np.empty((1, 0))
    for number in (7, 12, 25):
        with_drag, without = sound(time[:number], air_density=AIR), sound(time[:number])
        sizes = [np.abs(impact.residuals(truth, none)).max() for impact in (with_drag, without)]
        fit = fitted("D", without)
        chi2 = f"{fit.chi2:.2f}/{fit.degrees_of_freedom}"
        lines.append(f"| {number} | {sizes[0]:.1g} | {sizes[1]:.2g} | {chi2} |")
    return "\n".join(lines)


def main() -> None:
    text = TEXT.format(
        bias=bias_table(), errors=error_table(), coverage=coverage_table(), air_table=air_table(),
        repetitions=REPETITIONS, air=AIR, drag=DRAG,
    )  # fmt: skip
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
