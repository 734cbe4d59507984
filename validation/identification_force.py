"""Materials from force histories: standard errors with known and unknown gain, and coverage of the intervals.

Run as `python validation/identification_force.py`; prints tables and writes them to `identification_force.md` beside
this file. Takes a minute.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs
from restitution.identification.parameters import column

RADIUS, MASS, NOISE, SAMPLES, REPETITIONS = 0.01, 7850.0 * 4.0 / 3.0 * math.pi * 1e-6, 0.01, 240, 60
CASES = {"A": (1e6, 1e7, 1e-3), "B": (1e6, 1e7, 3e-5), "D": (1e6, 2e5, 1e-3)}
"""Equilibrium modulus [Pa], branch modulus [Pa], relaxation time [s]."""

TEXT = """\
# Materials from force histories

Made by `validation/identification_force.py`. A steel ball, R = 10 mm, hits an incompressible standard solid of
Ginf = 1 MPa at 1 m/s: A has G1 = 10 MPa and tau = 1 ms, B 10 MPa and 0.03 ms, D 0.2 MPa and 1 ms. A record has
{samples} samples from 0.1 contact times before the touch to 0.1 after the end, with white noise of 1 % of the peak.
First touch and baseline are unknown.

Standard errors in per cent at the true material, of the constants and of the reduced modulus at pi over the contact
time. "gain" and "velocity" are further unknowns. Both together have a flat direction and are refused.

{errors}

Coverage: the share in per cent of {repetitions} random records for which the 95 % interval contains the true value,
and the median of the deviation over the stated error, in units of that of a normal distribution. A coverage of
{repetitions} records scatters by 3 %. The intervals are those of the linearised fit.

{coverage}

The impulse m v (1 + e) needs an absolute gain: without it one record of D determines the material about ten times
less well. The modulus at the time scale of the contact is well determined. A Kelvin-Voigt solid (tau = 0) fits one of
the {repetitions} records of D better, by 1.4 in chi2; intervals about the other solution do not show it. With an
unknown velocity records of A have a second minimum near a Kelvin-Voigt solid, whose chi2 may be the lower one. A
warning of `rs.identify` names the other minimum.
"""


def material(case: str) -> rs.Material:
    """Incompressible standard solid of a case."""
    equilibrium, branch, time = CASES[case]
    return rs.standard_solid(equilibrium, branch, branch * time, poisson_ratio=0.5)


def record(case: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, exact forces and contact time."""
    result = rs.solve(rs.Impact(material(case), rs.Parabola(RADIUS), MASS, 1.0))
    duration = float(result.contact_time)
    time = np.linspace(-0.1, 1.1, SAMPLES) * duration
    force = np.zeros(SAMPLES)
    touching = (time >= 0.0) & (time <= duration)
    force[touching] = result.sample(time[touching])["force"]
    return time, force, duration


def observed(time: np.ndarray, force: np.ndarray, peak: float, **unknown: Any) -> rs.ForceHistory:
    """Record of a ball at 1 m/s, apart from what is unknown."""
    options: dict[str, Any] = {"velocity": 1.0, "noise": rs.Noise(force=NOISE * peak)} | unknown
    return rs.ForceHistory(time, force, radius=RADIUS, mass=MASS, **options)


def fitted(time: np.ndarray, force: np.ndarray, peak: float) -> rs.Identification:
    """Fit from the starts that the data show."""
    data = observed(time, force, peak)
    return rs.identify(data, rs.standard_solid, fixed={"poisson_ratio": 0.5}, profiles=False)


def errors_of(fit: rs.Identification) -> np.ndarray:
    """Standard errors of the logarithms of Ginf, G1 and tau."""
    change = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    return np.sqrt(np.diag(change @ fit.covariance @ change.T))


def logs_of(fit: rs.Identification) -> np.ndarray:
    """Logarithms of Ginf, G1 and tau."""
    g, b, eta = fit.coordinates[:3]
    return np.array([g, b, eta - b])


def moduli_of(fit: rs.Identification, omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms of |E*|, E'' and tan delta, and their standard errors."""
    names = ("absolute_modulus", "loss_modulus", "loss_tangent")
    bands = fit.moduli([omega])
    values = np.array([float(bands[name][0]) for name in names])
    high = np.array([float(bands[f"{name}_high"][0]) for name in names])
    return np.log(values), np.log(high / values) / 1.959963985


def per_cent(values: Any) -> str:
    return ", ".join(f"{100.0 * value:.2g}" if value < 0.1 else f"{100.0 * value:.0f}" for value in values)


def true_errors(case: str, data: rs.ForceHistory, nuisances: list[float], omega: float) -> np.ndarray:
    """Standard errors of the logarithms of Ginf, G1, tau, |E*|, E'' and tan delta at the true material."""
    truth = np.append(np.log(CASES[case]), nuisances)
    sizes = np.array([1e-4] * 3 + [0.1 * nuisance.step for nuisance in data.nuisances])
    points = np.concatenate([truth + np.diag(sizes), truth - np.diag(sizes)])
    solids = [rs.standard_solid(g, b, b * t, poisson_ratio=0.5) for g, b, t in np.exp(points[:, :3])]
    materials = column(solids)
    residuals = data.residuals(materials, points[:, 3:])
    modulus = rs.reduced_modulus(materials).complex_modulus(np.array([omega]))[:, 0]
    functions = np.column_stack(
        [points[:, :3], np.log(np.array([abs(modulus), modulus.imag, modulus.imag / modulus.real]).T)]
    )
    n = sizes.size
    J, G = ((changes[:n] - changes[n:]).T / 2.0 for changes in (residuals, functions))
    return np.sqrt(np.diag(G @ np.linalg.pinv(J.T @ J, rcond=1e-15) @ G.T))


def error_table() -> str:
    lines = ["| case | unknown | Ginf, G1, tau | abs(E*), E'', tan delta |", "|---|---|---|---|"]
    for case in CASES:
        time, force, duration = record(case)
        for words, unknown in (("", {}), ("gain", {"gain": None}), ("velocity", {"velocity": None})):
            data = observed(time, force, float(force.max()), **unknown)
            errors = true_errors(case, data, [0.0, 1.0][: len(data.nuisances)], math.pi / duration)
            lines.append(f"| {case} | {words} | {per_cent(errors[:3])} | {per_cent(errors[3:])} |")
    return "\n".join(lines)


def coverage_table() -> str:
    lines = ["| case | of | coverage of 95 % | deviation over error |", "|---|---|---|---|"]
    for case in ("A", "D"):
        time, force, duration = record(case)
        peak = float(force.max())
        truth = fitted(time, force, peak)
        expected = np.concatenate([np.log(CASES[case]), moduli_of(truth, math.pi / duration)[0]])
        random, deviations = np.random.default_rng([1, ord(case)]), []
        for _ in range(REPETITIONS):
            result = fitted(time, force + NOISE * peak * random.standard_normal(SAMPLES), peak)
            values, errors = moduli_of(result, math.pi / duration)
            estimates, sizes = np.concatenate([logs_of(result), values]), np.concatenate([errors_of(result), errors])
            deviations.append((estimates - expected) / sizes)
        z = np.array(deviations)
        inside, spread = 100.0 * np.mean(np.abs(z) < 1.96, axis=0), np.median(np.abs(z), axis=0) / 0.6745
        for words, part in (("Ginf, G1, tau", slice(0, 3)), ("abs(E*), E'', tan delta", slice(3, 6))):
            shares = ", ".join(f"{value:.0f}" for value in inside[part])
            lines.append(f"| {case} | {words} | {shares} | {', '.join(f'{value:.2f}' for value in spread[part])} |")
    return "\n".join(lines)


def main() -> None:
    text = TEXT.format(samples=SAMPLES, repetitions=REPETITIONS, errors=error_table(), coverage=coverage_table())
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
