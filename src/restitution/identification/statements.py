"""Statements: what data determine of a material, what they do not, and which measurement would help most."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Noise
from restitution.identification.uncertainty import (
    EXACT,
    FAR,
    MODULUS_NAMES,
    modulus_functions,
    principal_directions,
    without,
)
from restitution.material.viscoelastic import Material, reduced_modulus
from restitution.numerics.differences import CENTRAL
from restitution.quantities import ADHESION_INPUTS

Materials = Callable[[Array], Material]


FUNCTIONALS = {"absolute_modulus": "abs(E*)", "loss_modulus": "E''", "loss_tangent": "tan delta"}
"""Physical functionals of a material, with their symbols."""

# Step in the logarithm of a parameter; rank is judged, and a longer step has less noise.
_STEP = 1e-3
SINGULAR = 1e-11
"""An eigenvalue of an information matrix counts as zero below this share of the largest one."""
# Two directions are the same if they differ by less than this share.
_SAME = 1e-3
# Parameters that change by less than this share of the largest change are not listed.
_SMALL = 0.03
# A measurement determines a parameter if it lowers the standard error of its logarithm below this.
_SETTLED = 0.5


def _points(theta: Array) -> Array:
    """Return a point and those beside it in each parameter, shape (1 + 2 n_theta, n_theta)."""
    return CENTRAL.points(theta, np.full(theta.size, _STEP))


def _slope(values: Array) -> Array:
    """Return derivatives of values on these points: from shape (1 + 2 n_theta, n) to (n, n_theta)."""
    return CENTRAL.slopes(values, np.full(len(values) // 2, _STEP)).T


def sensitivities(
    impacts: Rebounds, materials: Materials, theta: Array, noise: Noise
) -> tuple[dict[str, Array], Array]:
    """Return predicted values by name, and the derivatives of the measured ones over their noise.

    The derivatives have the shape (n, n_measured, n_theta). Quantities with a noise count as measured.
    """
    predicted = impacts.predicted(materials(_points(theta)))
    slopes: list[Array] = []
    for name, values in predicted.items():
        if (deviation := noise.of(name, values[0])) is not None:
            slopes.append(_slope(values) / deviation[:, None])
    return {name: values[0] for name, values in predicted.items()}, np.stack(slopes, axis=1)


def functional_slopes(materials: Materials, theta: Array, omega: Any) -> Array:
    """Return slopes of the logarithms of `FUNCTIONALS` at one omega [rad/s], or one for each of the points."""
    functions = modulus_functions(reduced_modulus(materials(_points(theta))), np.atleast_1d(omega))[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        return _slope(np.log(functions[:, [MODULUS_NAMES.index(name) for name in FUNCTIONALS]]))


def standard_errors(information: Array, gradients: Array) -> Array:
    """Return standard errors of functions with gradients of shape (k, p); infinite without information."""
    eigenvalues, vectors = np.linalg.eigh(information)
    flat = eigenvalues <= SINGULAR * eigenvalues[-1]
    shares = (gradients @ vectors) ** 2
    variance = (shares[:, ~flat] / eigenvalues[~flat]).sum(axis=1)
    return np.sqrt(np.where(shares[:, flat].sum(axis=1) > 1e-6 * shares.sum(axis=1), np.inf, variance))


def per_cent(error: float) -> str:
    """Return the standard error as a share, with two digits."""
    return f"{float(f'{100.0 * error:.2g}'):g} %"


def precision(error: float) -> str:
    """Return the standard error of a logarithm, in words."""
    if error < 0.5:
        return f"to {per_cent(error)}"
    return f"to a factor of {math.exp(error):.2g}" if error < FAR else "not at all"


class StatedDirection(NamedTuple):
    """Change of the parameters with no effect, or almost none, on the data."""

    exponents: dict[str, float]  # each parameter is multiplied by x to this power
    exact: bool  # whether the change has no effect at all
    words: str


def knowledge(
    names: Sequence[str], jacobian: Array, materials: Materials, theta: Array, window: tuple[float, float], *,
    exponent: float | None = None, impacts: Rebounds | None = None, unseen: Callable[[Array], bool] | None = None,
) -> tuple[list[StatedDirection], list[str]]:  # fmt: skip
    """Return flat directions of a fit, and statements in words.

    The jacobian holds the derivatives of the residuals over their standard deviations with respect to the parameters
    theta (logarithms, or logits), then to the nuisances; `names` has both. The window is that of the data [rad/s]. All
    data are impacts without a force of bodies with a = c d^(p/2), if the exponent p is given. Further measurements
    are like `impacts`. `unseen` is whether also a large change in a direction of the parameters leaves the data.
    """
    p = theta.size
    parameters, nuisances = names[:p], names[p:]
    seen = without(jacobian[:, :p], jacobian[:, p:])
    singular, rows = principal_directions(seen)
    exact, flat = singular <= EXACT * singular[0], singular < 1.0
    if unseen is not None:
        # The Jacobian does not show the logarithm of a modulus near zero either, but a large change does.
        exact &= np.array([not small or unseen(row) for small, row in zip(exact, rows, strict=True)])
    information = seen.T @ seen
    directions: list[StatedDirection] = []

    def add(vector: Array, exactly: bool, words: str) -> None:
        changes = _changes(parameters, vector)
        start = "The data do not change at all" if exactly else "The data hardly change"
        directions.append(StatedDirection(changes, exactly, f"{start} when {_listed(changes)}. {words}".strip()))

    space = rows[exact]
    # Invariances that the theory knows come first, with their words; then what is left of the space.
    for vector, words in _invariances(parameters, materials, theta, window, exponent):
        if np.linalg.norm(vector - space.T @ (space @ vector)) < _SAME * np.linalg.norm(vector):
            add(vector, True, words)
            space = _complement(space, vector)
    for vector in _reduced_rows(space)[0]:
        culprits = [name for n, name in enumerate(nuisances) if _settles(jacobian, p, n, vector)]
        add(vector, True, f"Give {' or '.join(culprits)}." if culprits else "")
    for vector in rows[flat & ~exact]:
        add(_sparse(vector, rows[exact]), False, _frequencies(materials, theta, window, vector))
    lines = [direction.words for direction in directions]
    if all(map(math.isfinite, window)):
        lines.insert(0, _functionals(materials, theta, window, information, impacts))
    if directions:
        hidden = flat | exact
        lines += _combinations(parameters, rows[hidden], rows[~hidden], singular[~hidden])
        lines += _further(parameters, materials, theta, information, impacts)
    return directions, lines


def _settles(jacobian: Array, p: int, n: int, vector: Array) -> bool:
    """Return whether the data determine a direction of the parameters if nuisance n is known."""
    others = np.delete(jacobian[:, p:], n, axis=1)
    return float(np.linalg.norm(without(jacobian[:, :p], others) @ vector)) > float(np.linalg.norm(vector))


def _invariances(
    parameters: Sequence[str], materials: Materials, theta: Array, window: tuple[float, float], exponent: float | None
) -> list[tuple[Array, str]]:
    """Return changes of the parameters without effect on the data by theory, if the model has them."""
    omega = np.geomspace(1e-3 * window[0], 1e3 * window[1], 41)
    matrix = _slope(_logarithms(reduced_modulus(materials(_points(theta))).complex_modulus(omega)))
    # Those of an adhesion change no modulus, but the contact.
    sticky = [n for n, name in enumerate(parameters) if name in ADHESION_INPUTS]
    matrix = np.vstack([matrix, np.eye(theta.size)[sticky]])
    if not np.all(np.isfinite(matrix)):  # moduli beyond the range of numbers
        return []
    sizes, rows = principal_directions(matrix)
    same = sizes < EXACT * sizes[0]
    words = "The reduced modulus E* stays the same, and with it all contacts with rigid bodies: fix one of these."
    directions = [(vector, words) for vector in rows[same]]
    if exponent is not None:
        # E*(t) to L^beta E*(L t): the logarithm of E*(omega) changes by beta - d ln E*/d ln omega per unit of ln L.
        step, series = 1e-4, reduced_modulus(materials(theta[None]))
        up, down = (_logarithms(series.complex_modulus(omega * math.exp(sign * step)))[0] for sign in (1.0, -1.0))
        target = np.repeat((2.0 + 0.5 * exponent, 0.0), omega.size) - (up - down) / (2.0 * step)
        # Lengths shrink by L at equal energies.
        powers = {"work": exponent, "stress": 1.0 + exponent, "range": -1.0}
        target = np.append(target, [powers[parameters[n]] for n in sticky])
        vector = np.linalg.lstsq(matrix, target, rcond=None)[0]
        if np.linalg.norm(matrix @ vector - target) < 1e-5 * np.linalg.norm(target):
            words = (
                "The restitution coefficient determines no modulus and no time: give a contact time, force or modulus."
            )
            directions.append((vector, words))
    return directions


def _logarithms(moduli: NDArray[np.complex128]) -> Array:
    """Return logarithms of the magnitudes of moduli of shape (m, n), then their phases, shape (m, 2 n)."""
    return np.hstack([np.log(np.abs(moduli)), np.angle(moduli)])


def _complement(space: Array, vector: Array) -> Array:
    """Return the basis of the part of the space of some rows that is orthogonal to a vector in it."""
    unit = vector / np.linalg.norm(vector)
    return np.linalg.svd(space - np.outer(space @ unit, unit))[2][: len(space) - 1]


def _reduced_rows(space: Array) -> tuple[Array, list[int]]:
    """Return the basis of a space of rows with an identity matrix in some columns, and these columns."""
    basis, pivots = space.copy(), list[int]()
    for n in range(len(basis)):
        pivots.append(int(np.argmax(np.abs(basis[n]))))
        basis[n] /= basis[n, pivots[n]]
        others = np.arange(len(basis)) != n
        basis[others] -= np.outer(basis[others, pivots[n]], basis[n])
    return basis, pivots


def _sparse(vector: Array, exact: Array) -> Array:
    """Return the direction plus the multiple of an exact one that leaves the fewest parameters."""
    candidates = [vector]
    for row in exact:
        candidates += [vector - vector[n] / row[n] * row for n in np.flatnonzero(np.abs(row) > _SMALL)]
    best = min(candidates, key=lambda row: (len(_changes(range(row.size), row)), float(np.abs(row).sum())))
    return best / best[np.argmax(np.abs(best))]


def _changes(names: Iterable[Any], vector: Array) -> dict[Any, float]:
    """Return powers of a common factor by which parameters change, rounded to halves if close."""
    largest = float(np.abs(vector).max())
    pairs = zip(names, vector.tolist(), strict=True)
    return {name: _simple(power) for name, power in pairs if abs(power) > _SMALL * largest}


def _simple(power: float) -> float:
    half = round(2.0 * power) / 2.0
    return half if half and abs(half - power) < 0.02 else float(f"{power:.2g}")


def _power(name: str, power: float) -> str:
    return name if power == 1.0 else f"{name}^{power:g}"


def _factor(power: float) -> str:
    return f"multiplied by {_power('x', power)}" if power > 0.0 else f"divided by {_power('x', -power)}"


def _listed(changes: dict[str, float]) -> str:
    """Return changes in words, equal changes together."""
    groups: dict[float, list[str]] = {}
    for name, power in changes.items():
        groups.setdefault(power, []).append(name)
    return _joined([f"{_joined(n)} {'is' if len(n) == 1 else 'are'} {_factor(power)}" for power, n in groups.items()])


def _joined(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _functionals(
    materials: Materials, theta: Array, window: tuple[float, float], information: Array, impacts: Rebounds | None
) -> str:
    """Return errors of abs(E*), E'' and tan delta in the middle of the data, in words."""
    omega: Any = math.sqrt(window[0] * window[1])
    place = f"{omega:.4g} rad/s"
    if impacts is not None:
        # The frequency of a bounce shifts with its contact time.
        times = impacts.contact_times(materials(_points(theta)))
        middle = int(np.argsort(times[0])[times.shape[1] // 2])
        omega, place = math.pi / times[:, [middle]], f"pi over the contact time at {impacts.velocity[middle]:.3g} m/s"
    gradients = functional_slopes(materials, theta, omega)
    errors = standard_errors(information, gradients)
    listed = [f"{symbol} {precision(error)}" for symbol, error in zip(FUNCTIONALS.values(), errors, strict=True)]
    return f"At {place} the data determine {', '.join(listed)}."


def _frequencies(materials: Materials, theta: Array, window: tuple[float, float], vector: Array) -> str:
    """Return frequencies at which a change of the parameters has a larger effect than within the window, in words."""

    def seen(low: float, high: float) -> float:
        logs = _logarithms(reduced_modulus(materials(_points(theta))).complex_modulus(np.geomspace(low, high, 15)))
        return float(np.abs(_slope(logs) @ vector).max())

    inside, below, above = seen(*window), seen(0.01 * window[0], window[0]), seen(window[1], 100.0 * window[1])
    if max(below, above) < 3.0 * inside:
        return ""
    if above > below:
        return "Higher frequencies would show it: shorter contacts, of smaller balls or at higher velocities."
    return "Lower frequencies would show it: longer contacts, of larger balls or at lower velocities, or a hold."


def _combinations(names: Sequence[str], hidden: Array, seen: Array, singular: Array) -> list[str]:
    """Return products of powers of parameters that the data determine, but not each parameter alone."""
    basis, pivots = _reduced_rows(hidden)
    lines: list[str] = []
    for n, name in enumerate(names):
        gradient = np.eye(len(names))[n]
        gradient[pivots] -= basis[:, n]
        error = float(np.sqrt(np.sum((seen @ gradient / singular) ** 2)))
        powers = {names[pivot]: _simple(gradient[pivot]) for pivot in pivots if abs(gradient[pivot]) > _SMALL}
        if n not in pivots and powers and error < 1.0:
            above = [name, *(_power(other, power) for other, power in powers.items() if power > 0.0)]
            below = [f"/{_power(other, -power)}" for other, power in powers.items() if power < 0.0]
            lines.append(f"{' '.join(above)}{''.join(below)} {precision(error)}")
    return [f"The data determine {', '.join(lines)}."] if lines else []


def _further(
    names: Sequence[str], materials: Materials, theta: Array, information: Array, impacts: Rebounds | None
) -> list[str]:
    """Return one further measurement that would determine the parameters, and the largest standard error after it."""
    ways = {} if impacts is None else _impacts_like(impacts, materials, theta)
    for n, name in enumerate(names):
        ways[f"a known {name} (to 5 %)"] = 20.0 * np.eye(len(names))[n : n + 1]
    left = {words: float(standard_errors(information + rows.T @ rows, np.eye(len(names))).max())
            for words, rows in ways.items() if np.all(np.isfinite(rows))}  # fmt: skip
    best = min(left, key=left.__getitem__)
    if left[best] > _SETTLED:
        return [
            f"No single further measurement is sufficient; the best, {best}, "
            f"determines the worst {precision(left[best])}."
        ]
    # The simplest measurement comes first.
    simple = next(words for words, error in left.items() if error <= _SETTLED)
    listed = [f"{words} leaves standard errors of at most {per_cent(left[words])}" for words in {simple: 0, best: 0}]
    return [f"One more measurement is sufficient: {'; '.join(listed)}."]


def _impacts_like(impacts: Rebounds, materials: Materials, theta: Array) -> dict[str, Array]:
    """Return derivatives of the data of further impacts like the middle one, over a noise of 1 %."""
    middle = int(np.argsort(impacts.velocity)[impacts.velocity.size // 2])
    velocity, mass = float(impacts.velocity[middle]), float(impacts.mass[middle])
    both = Noise(restitution_coefficient="1 %", contact_time="1 %")
    kinds = [
        ("a contact time", 1.0, 1.0, Noise(contact_time="1 %")),
        ("a peak force", 1.0, 1.0, Noise(max_force="1 %")),
        ("e and contact time at ten times the velocity", 1.0, 10.0, both),
        ("e and contact time at a tenth of the velocity", 1.0, 0.1, both),
        ("e and contact time of a ball of three times the radius", 3.0, 1.0, both),
        ("e and contact time of a ball of a third of the radius", 1.0 / 3.0, 1.0, both),
    ]
    derivatives: dict[str, Array] = {}
    for words, size, speed, noise in kinds:
        body: dict[str, Any] = {"profile": impacts.profile}
        if impacts.radius is not None:
            body = {"radius": size * float(impacts.radius[middle])}
        elif size != 1.0:
            continue
        body |= {"mass": size**3 * mass, "counter_material": impacts.counter_material}
        if impacts.adhesion:
            body |= {"adhesion": True, "noise": Noise(restitution_coefficient="1 %", velocity="1 %")}
        bounce = Rebounds(speed * velocity, [1.0], **body)
        derivatives[f"{words} (to 1 %)"] = sensitivities(bounce, materials, theta, noise)[1][0]
    return derivatives
