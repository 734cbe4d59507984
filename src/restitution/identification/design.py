"""Design of experiments: which impacts determine a material best."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array
from restitution.contact.profiles import sphere_mass
from restitution.errors import InputError, InputTypeError
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Noise
from restitution.identification.parameters import Parameters, parameters
from restitution.identification.result import Identification
from restitution.identification.statements import (
    FUNCTIONALS,
    SINGULAR,
    functional_slopes,
    per_cent,
    precision,
    sensitivities,
    standard_errors,
)
from restitution.identification.uncertainty import without
from restitution.impact.window import window_around
from restitution.material.viscoelastic import Material
from restitution.quantities import INPUTS, NUMBER, OUTPUTS, Quantity, dataset
from restitution.result import Result, Summary, Table
from restitution.units import LENGTH, in_words

if TYPE_CHECKING:
    import xarray as xr

Criterion = Literal["E", "D"]
# What a criterion makes small.
_AIMS = {
    "E": "the least known combination of the parameters, not for a single one",
    "D": "all parameters together, not for the worst one",
}

# Largest number of rounds of exchanges; usually a few suffice.
_ROUNDS = 20


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """Impacts to measure next, and the errors of the parameters that they would leave.

    Standard errors are relative, those of Poisson ratios and exponents absolute, and infinite if nothing is known.
    `plot` shows the impacts over velocity and radius, and the predicted errors.
    """

    _numbers = (
        "radius", "mass", "velocity", "repeats", "restitution_coefficient", "contact_time", "standard_errors",
        "functional_errors", "angular_frequency", "one_radius", "criterion", "gains", "statements",
    )  # fmt: skip
    _picture = "identification.design"

    radius: Array  # of the chosen impacts in ascending order [m], shape (n,)
    mass: Array  # [kg]
    velocity: Array  # [m/s]
    repeats: NDArray[np.int64]  # how often each impact is to be done
    restitution_coefficient: Array  # from the guess
    contact_time: Array  # from the guess [s]
    standard_errors: dict[str, float]  # of each parameter
    functional_errors: dict[str, float]  # of abs(E*), E'' and tan delta at `angular_frequency`
    angular_frequency: float  # pi over the mean contact time [rad/s]
    one_radius: dict[float, float]  # largest standard error with the best design for each ball alone, by radius [m]
    criterion: Criterion

    @property
    def largest_error(self) -> float:
        """Largest standard error of a parameter."""
        return max(self.standard_errors.values())

    @property
    def gains(self) -> dict[float, float]:
        """Largest standard error of the best design with one ball over that of this design, by its radius [m]."""
        return {radius: error / self.largest_error for radius, error in self.one_radius.items()}

    @property
    def statements(self) -> tuple[str, ...]:
        """Predictions in words."""
        parameters = ", ".join(f"{name} {precision(error)}" for name, error in self.standard_errors.items())
        moduli = ", ".join(f"{FUNCTIONALS[name]} {precision(error)}" for name, error in self.functional_errors.items())
        lines = [
            f"{self.repeats.sum()} impacts determine {parameters}.",
            f"At {self.angular_frequency:.4g} rad/s they determine {moduli}.",
        ]
        if math.isinf(self.largest_error):
            lines.append("No choice among the candidates determines all parameters: measure another quantity.")
        elif len(self.one_radius) > 1:
            alone = ", ".join(
                f"{per_cent(error)} with R = {in_words(radius, LENGTH.unit)} ({self.gains[radius]:.2g} times as large)"
                for radius, error in self.one_radius.items()
            )
            largest = per_cent(self.largest_error)
            lines.append(f"The largest standard error is {largest}; with one ball alone: {alone}.")
            if min(self.gains.values()) < 1.0:
                aim = _AIMS[self.criterion]
                lines.append(f"One ball alone may do better here, as the impacts are chosen for {aim}.")
        return tuple(lines)

    def to_dataset(self) -> xr.Dataset:
        """Return a table of the chosen impacts over the dimension `impact`, with units."""
        number = Quantity("impact", NUMBER, "number of the impact")
        columns: dict[str, tuple[Any, Quantity]] = {"impact": (np.arange(self.velocity.size), number)}
        columns |= {name: (getattr(self, name), quantity) for name, quantity in _TABLE.items()}
        return dataset("impact", columns, {"statements": "\n".join(self.statements)})

    def summary(self, title: str = "") -> Summary:
        """Return a table of the impacts, which `print` and notebooks show."""
        heads = tuple(f"{quantity.words} [{quantity.unit or '-'}]" for quantity in _TABLE.values())
        columns = (getattr(self, name) for name in _TABLE)
        rows = [tuple(f"{value:.4g}" for value in row) for row in zip(*columns, strict=True)]
        return Summary(title or "Impacts to measure", Table(heads, rows), self.statements)

    @property
    def _short(self) -> str:
        return f"{self.velocity.size} impacts"


_TABLE = {
    **{name: INPUTS[name] for name in ("radius", "mass", "velocity")},
    "repeats": Quantity("repeats", NUMBER, "repeats"),
    **{name: OUTPUTS[name] for name in ("restitution_coefficient", "contact_time")},
}


def design(
    model_at_guess: partial[Any] | Identification,
    candidates: Mapping[str, Any],
    n: int = 20,
    criterion: Criterion = "E",
    *,
    fixed: Iterable[str] = ("poisson_ratio", "bulk_modulus"),
    noise: Noise | None = None,
) -> Design:
    """Return impacts that determine the parameters of a model best, given a rough guess of the material.

    Parameters
    ----------
    model_at_guess : functools.partial or Identification
        A model with its numbers, such as `partial(rs.standard_solid, 1e6, 1e7, 1e4, poisson_ratio=0.5)`, or what was
        identified so far: the impacts are then those that add most to its data.
    candidates : mapping
        `velocity` [m/s] and `radius` [m], numbers or arrays, and `density` [kg/m^3] or `mass` [kg] of the balls, one
        number or one for each radius. Each velocity is possible with each ball.
    n : int
        Number of impacts, repeats included.
    criterion : {"E", "D"}
        "E" minimises the error of the worst determined direction in the logarithms of the parameters, "D" the volume
        of their error ellipsoid.
    fixed : names
        Parameters of the model that are known; an identification has its own.
    noise : Noise
        Noise of the measured quantities; by default 1 % of restitution coefficient and contact time.

    Returns
    -------
    Design
        The impacts, the predicted errors, and the gain over designs with one ball.

    Raises
    ------
    InputError
        If a candidate is out of range, no body separates, or no parameter is free.

    Notes
    -----
    Each impact in turn is the one that improves the criterion most. Then impacts are exchanged one by one until no
    exchange improves the criterion (Fedorov, *Theory of Optimal Experiments*, 1972). One Jacobian over all candidates
    suffices.

    Examples
    --------
    >>> from functools import partial
    >>> import restitution as rs
    >>> guess = partial(rs.standard_solid, 1e6, 1e7, 1e4, poisson_ratio=0.5)
    >>> plan = rs.design(guess, {"velocity": [0.1, 1.0, 10.0], "radius": [0.003, 0.03], "density": 7800.0}, n=6)
    >>> int(plan.repeats.sum()), plan.gains[0.003] > 10.0
    (6, True)
    """
    count = checks.whole("n", n, 1, 100_000)
    checks.one_of("criterion", criterion, ("E", "D"))
    checks.instance("candidates", candidates, Mapping, "must be a mapping of names to values")
    fixed = checks.items("fixed", fixed, "must be the names of parameters")
    for name in fixed:
        checks.instance("fixed", name, str, "must hold names of parameters")
    impacts, radius = _grid(candidates)
    space, theta, before = _at_guess(model_at_guess, fixed)
    window = window_around(impacts.predicted(space.materials(theta[None], (1e-12, 1e7)))["contact_time"])

    def materials(coordinates: Array) -> Material:
        return space.materials(coordinates, (window.low, window.high))

    noise = Noise(restitution_coefficient="1 %", contact_time="1 %") if noise is None else Noise.from_argument(noise)
    values, jacobian = sensitivities(impacts, materials, theta, noise)
    possible = np.all(np.isfinite(jacobian), axis=(1, 2))
    if not np.any(possible):
        raise InputError("candidates", rule="must hold an impact after which the body separates")
    information = np.einsum("nqp,nqr->npr", jacobian, jacobian)
    # Standard errors are relative for parameters that enter by their logarithm, absolute for others.
    slopes = [
        float(parameter.slope(x)) for parameter, x in zip(space.free, space.numbers(theta[None])[0], strict=True)
    ]
    logs = [parameter.kind == "log" for parameter in space.free]
    scales = np.diag(np.where(logs, 1.0, slopes))

    def errors(places: NDArray[np.intp]) -> Array:
        return standard_errors(before + information[places].sum(axis=0), scales)

    chosen = _best(information, before, np.flatnonzero(possible), count, criterion)
    one_radius: dict[float, float] = {}
    for size in np.unique(radius[possible]).tolist():
        of_radius = np.flatnonzero(possible & (radius == size))
        one_radius[size] = float(errors(_best(information, before, of_radius, count, criterion)).max())
    omega = math.pi / float(np.exp(np.mean(np.log(values["contact_time"][chosen]))))
    gradients = functional_slopes(materials, theta, omega)
    functionals = standard_errors(before + information[chosen].sum(axis=0), gradients)
    places, repeats = np.unique(chosen, return_counts=True)
    return Design(
        radius[places], impacts.mass[places], impacts.velocity[places], repeats,
        values["restitution_coefficient"][places], values["contact_time"][places],
        dict(zip(space.names, errors(chosen).tolist(), strict=True)),
        dict(zip(FUNCTIONALS, functionals.tolist(), strict=True)), omega, one_radius, criterion,
    )  # fmt: skip


def _at_guess(model: Any, fixed: Iterable[str]) -> tuple[Parameters, Array, Array]:
    """Return the parameters of a model with its numbers, their coordinates, and an information matrix."""
    if isinstance(model, Identification):
        n = model.problem.n_parameters
        seen = without(model.estimation.jacobian[:, :n], model.estimation.jacobian[:, n:])
        return model.problem.space, model.coordinates[:n], seen.T @ seen
    if not isinstance(model, partial):
        rule = "must be a model with its numbers, such as functools.partial(rs.standard_solid, 1e6, 1e7, 1e4)"
        raise InputTypeError("model_at_guess", model, rule)
    numbers = dict(zip(inspect.signature(model.func).parameters, model.args, strict=False)) | model.keywords
    held = {name: value for name, value in numbers.items() if name in set(fixed)}
    free = {name: value for name, value in numbers.items() if name not in held}
    terms = max((np.size(value) for value in free.values()), default=1)
    space = parameters(model.func, fixed=held, start=free, terms=terms)
    for name in space.names:
        if name not in space.start:
            raise InputError(f"model_at_guess.{name}", rule="must be given")
    n = len(space.free)
    return (
        space,
        np.array([parameter.inward(space.start[parameter.name]) for parameter in space.free]),
        np.zeros((n, n)),
    )


def _grid(candidates: Mapping[str, Any]) -> tuple[Rebounds, Array]:
    """Return every velocity with every ball, in ascending order of radius, mass and velocity; and the radii."""
    for name in candidates:
        checks.one_of("candidates", name, ("velocity", "radius", "mass", "density"))
    for name in ("velocity", "radius"):
        if name not in candidates:
            raise InputError(f"candidates.{name}", rule="must be given")
    if ("mass" in candidates) == ("density" in candidates):
        raise InputError("candidates.mass, candidates.density", rule="exactly one must be given")
    columns = {
        name: np.atleast_1d(INPUTS[name].check(value, f"candidates.{name}")) for name, value in candidates.items()
    }
    velocity, radius, name = (
        columns["velocity"].ravel(),
        columns["radius"].ravel(),
        "mass" if "mass" in columns else "density",
    )
    if columns[name].size not in (1, radius.size):
        raise InputError(f"candidates.{name}", rule=f"must be one number, or {radius.size}, one for each radius")
    mass = columns["mass"] if name == "mass" else sphere_mass(columns["density"], radius)
    mass = np.broadcast_to(mass, radius.shape)
    every = np.repeat(radius, velocity.size), np.repeat(mass, velocity.size), np.tile(velocity, radius.size)
    radius, mass, velocity = (column[np.lexsort(every[::-1])] for column in every)
    return Rebounds(velocity, np.ones(velocity.size), radius=radius, mass=mass), radius


def _best(
    information: Array, before: Array, places: NDArray[np.intp], count: int, criterion: Criterion
) -> NDArray[np.intp]:
    """Choose candidates greedily by information, shape (n, p, p); one may be chosen twice."""
    some = information[places]
    ridge = SINGULAR * np.trace(before + some.sum(axis=0)) * np.eye(some.shape[1])

    def best_with(total: Array) -> int:
        eigenvalues = np.linalg.eigvalsh(total + ridge + some)
        # The volume guides the choice until every direction has some information.
        if criterion == "E" and eigenvalues[:, 0].max() > 100.0 * ridge[0, 0]:
            return int(np.argmax(eigenvalues[:, 0]))
        return int(np.argmax(np.log(np.maximum(eigenvalues, 1e-300)).sum(axis=1)))

    chosen: list[int] = []
    total = before.copy()
    for _ in range(count):
        chosen.append(best_with(total))
        total = total + some[chosen[-1]]
    for _ in range(_ROUNDS):
        last = list(chosen)
        for n, old in enumerate(last):
            chosen[n] = best_with(total - some[old])
            total = total - some[old] + some[chosen[n]]
        if chosen == last:
            break
    return places[chosen]
