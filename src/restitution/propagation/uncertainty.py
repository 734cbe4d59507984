"""Standard deviations of the outputs of impacts from those of their inputs: linear, and by draws."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast, runtime_checkable

import numpy as np

from restitution import checks
from restitution.checks import Array, single_positive, whole
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import shaped
from restitution.impact.problem import Impact
from restitution.propagation.derivatives import DERIVATIVE_RTOL, Derivatives, differentiate, output_names, solved
from restitution.propagation.inputs import Input, Model, input_of, model_of, quantity_of
from restitution.propagation.result import Drawn, UncertaintyResult, UncertaintyStatus
from restitution.quantities import ALIASES, DEFAULT_OUTPUTS
from restitution.variation import HeldElastic, varied

if TYPE_CHECKING:
    from numpy.random import Generator

    from restitution.material.viscoelastic import Material

# Name of the entry that is an identified material.
_MATERIAL = "material"
_LEAST_DRAWS, _MOST_DRAWS = 10, 1_000_000
# Draws have this tolerance; their scatter is far above it.
_DRAW_RTOL = 1e-7
# Rounds in which draws outside of the ranges are drawn again.
_ROUNDS = 50
# Linear and drawn deviations agree within these shares of the deviation, and the sampling error thrice.
_DEVIATION, _MEAN = 0.1, 0.2
# Share of the deviation by which the curvature may shift an output without a warning.
_BENT = 0.2
# Relative size of an eigenvalue below zero that rounding gives a covariance.
_ROUNDING = 1e-10


@runtime_checkable
class Identified(Protocol):
    """What an identified material must have: `Identification` and `ScatteredMaterial` do."""

    covariance: Array
    coordinates: Array
    problem: Any
    parameters: Mapping[str, Any]


class Block(NamedTuple):
    """Inputs that scatter together.

    Attributes
    ----------
    names : tuple of str
        Their names.
    covariance : array, shape (n, n)
        Covariance of the inputs in SI, or of their coordinates.
    parameters : tuple
        Parameters of an identification, whose methods `inward`, `outward` and `slope` belong to their coordinates; ()
        for inputs that scatter in SI.
    """

    names: tuple[str, ...]
    covariance: Array
    parameters: tuple[Any, ...] = ()

    def in_si(self, values: Array) -> Array:
        """Return the covariance of the inputs in SI, to first order."""
        if not self.parameters:
            return self.covariance
        pairs = zip(self.parameters, values, strict=True)
        slope = np.array([float(each.slope(value)) for each, value in pairs])
        return self.covariance * slope * slope[:, None]

    def moved(self, values: Array, changes: Array) -> Array:
        """Return inputs, shape (n, ...), after changes of their coordinates."""
        if not self.parameters:
            return values + changes
        triples = zip(self.parameters, values, changes, strict=True)
        return np.stack([each.moved(value, change) for each, value, change in triples])


def uncertainty(
    impact: Impact,
    inputs: Mapping[Any, Any] | Identified,
    outputs: Iterable[str] = DEFAULT_OUTPUTS,
    *,
    draws: int | None = None,
    rng: Generator | int | None = None,
    held: HeldElastic = "bulk_modulus",
    rtol: float = DERIVATIVE_RTOL,
    workers: int | None = None,
) -> UncertaintyResult:
    r"""Return the outputs of an impact with standard deviations, from those of its inputs.

    Parameters
    ----------
    impact : Impact
        The impact, single or an array.
    inputs : dict, or Identification
        Standard deviations in SI by the names of `restitution.vary`, such as ``{"velocity": 0.01}``. A tuple of names
        has a covariance matrix in SI: ``{("branch_modulus", "viscosity"): [[a, b], [b, c]]}``. The name `material` has
        an `Identification` of `restitution.identify`, or what `PronyFit.scattered` returns: its material replaces that
        of the impact, and its covariance counts. The entries are independent of each other.
    outputs : sequence of str
        Names of the outputs of `restitution.quantities.IMPACT_OUTPUTS`.
    draws : int, optional
        Number of random draws by which to check the linear deviations, 10 or more.
    rng : numpy Generator, or int, optional
        Source of the draws, or its seed, as in `numpy.random.default_rng`.
    held, rtol, workers
        As in `restitution.derivatives`.

    Returns
    -------
    UncertaintyResult
        Values, standard deviations, covariance, and the share of each input in each variance.

    Raises
    ------
    InputError
        If a name is not known, a deviation is not positive, a matrix is no covariance, or nearly no draw lies in the
        ranges of the inputs.
    SolverError
        If the impact itself is not solved.

    Notes
    -----
    Linear: with the derivatives J and the covariance C of the inputs, that of the outputs is :math:`J C J^T`. A
    warning says where the curvature :math:`\tfrac12 \sum_k y_{kk} \sigma_k^2` is above 0.2 standard deviations.

    Draws are normal in SI, and normal in the logarithm for the constants of an identification. Those outside of the
    range of an input are drawn again. They agree with the linear numbers if deviations differ by less than 10 % and
    means by less than 0.2 deviations, beyond three times their sampling errors.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> result = rs.uncertainty(ball, {"velocity": 0.05, "viscosity": 100.0, "poisson_ratio": 0.01})
    >>> e = result["restitution_coefficient"]
    >>> print(f"{e.value:.3f} +- {e.standard_deviation:.3f}; {result.contributions('restitution_coefficient')}")
    0.334 +- 0.016; poisson_ratio 98 %, viscosity 2 %
    """
    checks.instance("impact", impact, Impact, "must be an Impact")
    checks.one_of("held", held, ("bulk_modulus", "poisson_ratio"))
    model, blocks = read_inputs(impact, inputs, held)
    return propagate(model, blocks, output_names(outputs), draws=draws, rng=rng, rtol=rtol, workers=workers)


def read_inputs(impact: Impact, inputs: Any, held: HeldElastic) -> tuple[Model, list[Block]]:
    """Return the impacts as a function of the inputs, and how these scatter."""
    if isinstance(inputs, Identified):
        inputs = {_MATERIAL: inputs}
    if not isinstance(inputs, Mapping):
        raise InputTypeError("inputs", inputs, "must be a dict of names to standard deviations, or an Identification")
    entries = dict(inputs)
    if not entries:
        raise InputError("inputs", rule="must name at least one input")
    identified = entries.pop(_MATERIAL, None)
    blocks = [_block(key, value) for key, value in entries.items()]
    names = [name for block in blocks for name in block.names]
    for name in names:
        if names.count(name) > 1:
            raise InputError("inputs", rule=f"{name} is there twice")
    if identified is None:
        return _model_of(impact, blocks, held), blocks
    if not isinstance(identified, Identified):
        raise InputTypeError("inputs.material", identified, "must be of restitution.identify or PronyFit.scattered")
    return _with_material(impact, identified, blocks, held)


def _block(key: Any, value: Any) -> Block:
    """Return one entry of the inputs: a name with a deviation, or names with a covariance."""
    if isinstance(key, str):
        name = ALIASES.get(key, key)
        return Block((name,), np.array([[single_positive(f"inputs.{key}", value, quantity_of(name).unit) ** 2]]))
    if not isinstance(key, tuple) or not key or not all(isinstance(name, str) for name in key):
        raise InputTypeError("inputs", str(key), "must be a name, or a tuple of names with a covariance")
    names = tuple(ALIASES.get(name) or name for name in cast("tuple[str, ...]", key))
    return Block(names, covariance_matrix(f"inputs.{', '.join(key)}", value, len(names)))


def covariance_matrix(field: str, value: Any, size: int) -> Array:
    """Return a covariance, refusing a matrix that is none."""
    matrix = np.asarray(checks.finite(field, value))
    if matrix.shape != (size, size):
        raise InputError(field, rule=f"must be a matrix of shape ({size}, {size}), not {matrix.shape}")
    scale = np.sqrt(np.abs(np.diag(matrix)))
    unit = matrix / np.where(scale > 0.0, scale, 1.0) / np.where(scale > 0.0, scale, 1.0)[:, None]
    if np.any(np.abs(unit - unit.T) > _ROUNDING) or np.linalg.eigvalsh(unit).min() < -_ROUNDING or not scale.all():
        raise InputError(
            field, rule="must be a covariance: symmetric, with positive variances, no negative eigenvalue"
        )
    return matrix


def _model_of(impact: Impact, blocks: Sequence[Block], held: HeldElastic) -> Model:
    """Return the model of an impact; a number that is 0 has a step of a quarter of its deviation."""
    deviations = _deviations(blocks)
    model = model_of(impact, list(deviations), held, {name: 0.25 * size for name, size in deviations.items()})
    inputs = tuple(each if np.any(each.value == 0.0) else input_of(each.name, each.quantity, each.value)
                   for each in model.inputs)  # fmt: skip
    return replace(model, inputs=inputs)


def _deviations(blocks: Sequence[Block]) -> dict[str, float]:
    """Return the standard deviations of the inputs of blocks in their coordinates."""
    return {
        name: math.sqrt(variance)
        for block in blocks
        for name, variance in zip(block.names, np.diag(block.covariance).tolist(), strict=True)
    }


def _with_material(
    impact: Impact, identified: Identified, blocks: list[Block], held: HeldElastic
) -> tuple[Model, list[Block]]:
    """Return the model and the blocks of an impact on an identified material."""
    problem, best = identified.problem, np.asarray(identified.coordinates, dtype=np.float64)
    parameters = tuple(problem.space.free)
    covariance = np.asarray(identified.covariance, dtype=np.float64)
    if not np.all(np.isfinite(covariance)):
        rule = "has constants that its data do not determine; fix them, or give priors"
        raise InputError("inputs.material", rule=rule)
    names = tuple(each.name for each in parameters)
    if both := set(names) & {name for block in blocks for name in block.names}:
        raise InputError(
            "inputs", rule=f"{min(both)} is a constant of the identified material; leave one of the two out"
        )

    def materials(values: Mapping[str, Array]) -> Material:
        columns = [each.inward(np.asarray(values[each.name]).reshape(-1)) for each in parameters]
        rows = np.repeat(best[None], len(columns[0]), axis=0)
        rows[:, : len(columns)] = np.stack(columns, axis=1)
        return cast("Material", problem.materials(rows))

    at = {each.name: np.asarray(float(each.outward(z))) for each, z in zip(parameters, best, strict=False)}
    base = varied(impact, {_MATERIAL: materials(at).reshaped(())})
    others = _model_of(base, blocks, held) if blocks else Model((), lambda values: base, impact.shape, impact.axes)
    flat = base.take(np.arange(math.prod(base.shape))) if base.shape else base
    inputs = tuple(input_of(each.name, each.quantity, at[each.name]) for each in parameters)

    def build(values: Mapping[str, Array]) -> Impact:
        trial = materials(values)
        numbers = {each.name: values[each.name] for each in others.inputs}
        return varied(flat, {_MATERIAL: trial if base.shape else trial.reshaped(trial.shape[:1]), **numbers}, held)

    model = Model((*inputs, *others.inputs), build, impact.shape, impact.axes, impact.adhesion is not None)
    return model, [Block(names, covariance, parameters), *blocks]


def propagate(
    model: Model, blocks: Sequence[Block], outputs: tuple[str, ...], *, draws: int | None = None, rng: Any = None,
    rtol: float = DERIVATIVE_RTOL, workers: int | None = None,
) -> UncertaintyResult:  # fmt: skip
    """Return the outputs of a model with standard deviations; the blocks have the inputs in the order of the model."""
    if draws is not None:
        whole("draws", draws, _LEAST_DRAWS, _MOST_DRAWS)
    generator = _generator(rng)
    slopes = differentiate(model, outputs, rtol, workers)
    values = {each.name: each.value for each in model.inputs}
    scatter = np.zeros((len(values), len(values)))
    place = 0
    for block in blocks:
        rows = slice(place, place := place + len(block.names))
        # Constants of an identification are single numbers.
        numbers = np.array([np.asarray(values[name]).flat[0] for name in block.names])
        scatter[rows, rows] = block.in_si(numbers)
    matrix = slopes.matrix
    common = np.einsum("kl,jl...->kj...", scatter, matrix)
    covariance = np.einsum("ik...,kj...->ij...", matrix, common)
    variance = np.einsum("ii...->i...", covariance)
    deviations = np.sqrt(np.maximum(variance, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = matrix * np.swapaxes(common, 0, 1) / variance[:, None]
    spread = {name: shaped(row, model.shape) for name, row in zip(outputs, deviations, strict=True)}
    doubts = [*slopes.warnings, *_bends(slopes, scatter, deviations)]
    drawn, status = None, UncertaintyStatus.LINEAR
    if draws is not None:
        drawn = _draw(model, blocks, slopes, spread, (draws, generator, workers))
        good = all(np.all(each) for each in drawn.agrees.values())
        status = UncertaintyStatus.CONFIRMED if good else UncertaintyStatus.DIFFERS
        doubts = [*slopes.warnings, *_of_draws(drawn, spread)]
    return UncertaintyResult(
        outputs,
        slopes.inputs,
        slopes.values,
        spread,
        covariance,
        shares,
        scatter,
        slopes,
        drawn,
        status,
        tuple(doubts),
    )


def _generator(rng: Any) -> Any:
    try:
        return np.random.default_rng(rng)
    # The conversion of a foreign object may raise anything.
    except Exception:
        raise InputTypeError("rng", rng, "must be a numpy Generator, or a seed that is a whole number >= 0") from None


def _bends(slopes: Derivatives, scatter: Array, deviations: Array) -> list[str]:
    """Return warnings of outputs whose curvature is not small over the scatter of the inputs."""
    shift = 0.5 * np.einsum("ik...,kk->i...", np.nan_to_num(slopes.second), scatter)
    lines: list[str] = []
    for name, each, deviation in zip(slopes.outputs, np.abs(shift), deviations, strict=True):
        # Rounding errors bend outputs that do not change.
        rounding = 1e-6 * np.abs(np.asarray(slopes.values[name]))
        if np.any(each > _BENT * deviation + rounding):
            share = float(np.max(each / np.maximum(deviation, 1e-300)))
            lines.append(f"linear: the curvature shifts {name} by {share:.2g} standard deviations; check it by draws")
    return lines


def _draw(
    model: Model, blocks: Sequence[Block], slopes: Derivatives, spread: Mapping[str, Any], how: tuple[int, Any, Any]
) -> Drawn:
    """Return the numbers of random draws, and whether they agree with the linear ones."""
    draws, generator, workers = how
    values, outside = _points(model, blocks, draws, generator)
    columns = solved(model, values, slopes.outputs, _DRAW_RTOL, workers)
    shape = model.shape
    numbers: dict[str, dict[str, Any]] = {part: {} for part in ("mean", "deviation", "low", "high", "agrees")}
    lost: dict[str, int] = {}
    kept: list[Array] = []
    for name in slopes.outputs:
        y = np.where(np.isfinite(columns[name]), columns[name], np.nan)
        lost[name] = int(np.isnan(y).sum())
        kept.append(y)
        moments = _moments(y)
        for part, each in zip(("mean", "deviation", "low", "high"), moments, strict=True):
            numbers[part][name] = shaped(each, shape)
        agrees = _agrees(y, moments, np.asarray(slopes.values[name]), np.asarray(spread[name]))
        numbers["agrees"][name] = agrees if shape else bool(agrees)
    stack = np.stack(kept)
    away = stack - stack.mean(axis=1, keepdims=True)
    covariance = np.einsum("id...,jd...->ij...", away, away) / (draws - 1)
    return Drawn(draws, outside, numbers["mean"], numbers["deviation"], numbers["low"], numbers["high"], covariance,
                 lost, numbers["agrees"])  # fmt: skip


def _moments(y: Array) -> tuple[Array, Array, Array, Array]:
    """Return mean, standard deviation and the ends of the central 95 % of draws; NaN where too few are finite."""
    if (np.isfinite(y).sum(axis=0) < 2).any():
        nothing = np.full(y.shape[1:], np.nan)
        return nothing, nothing, nothing, nothing
    low, high = np.nanquantile(y, (0.025, 0.975), axis=0)
    return np.nanmean(y, axis=0), np.nanstd(y, axis=0, ddof=1), low, high


def _agrees(y: Array, moments: tuple[Array, ...], value: Array, linear: Array) -> Any:
    """Return whether drawn and linear numbers agree beyond the sampling errors of the draws."""
    mean, deviation = moments[:2]
    with np.errstate(divide="ignore", invalid="ignore"):
        kurtosis = np.nan_to_num(np.nanmean((y - mean) ** 4, axis=0) / deviation**4, nan=3.0)
        error = np.sqrt(np.maximum(kurtosis - 1.0, 0.0) / (4.0 * len(y)))
    floor = 1e-6 * np.abs(value)
    close = np.abs(deviation - linear) <= (_DEVIATION + 3.0 * error) * deviation + floor
    return close & (np.abs(mean - value) <= (_MEAN + 3.0 / math.sqrt(len(y))) * deviation + floor)


def _points(model: Model, blocks: Sequence[Block], draws: int, generator: Any) -> tuple[dict[str, Array], int]:
    """Return drawn values of all inputs by name, and how many draws lay outside of their ranges."""
    inputs, size = {each.name: each for each in model.inputs}, math.prod(model.shape)
    roots = [_root(block.covariance) for block in blocks]
    kept: dict[str, list[Array]] = {name: [] for name in inputs}
    number = outside = 0
    for _ in range(_ROUNDS):
        values: dict[str, Array] = {}
        for block, root in zip(blocks, roots, strict=True):
            changes = root @ generator.standard_normal((len(block.names), draws))
            at = [inputs[name].value.reshape(-1) for name in block.names]
            width = max(each.size for each in at) if model.shape else 1
            start = np.stack([np.broadcast_to(each, (draws, width)) for each in at])
            values |= dict(zip(block.names, block.moved(start, changes[..., None]), strict=True))
        good = np.ones(draws, dtype=bool)
        for name, column in values.items():
            good &= _admissible(inputs[name], column).all(axis=1)
        # All that are in the ranges are kept until there are enough, so that no draw is favoured.
        take = np.flatnonzero(good)[: draws - number]
        tried = int(take[-1]) + 1 if take.size and number + take.size == draws else draws
        outside += tried - take.size
        number += take.size
        for name, column in values.items():
            kept[name].append(column[take])
        if number == draws:
            columns = {name: np.concatenate(parts) for name, parts in kept.items()}
            return {name: each if model.shape and each.shape[1] == size else each[:, 0]
                    for name, each in columns.items()}, outside  # fmt: skip
    raise InputError("inputs", rule="have such deviations that nearly no draw lies in their admissible ranges")


def _root(covariance: Array) -> Array:
    """Return a matrix whose product with its transpose is the covariance, which may be singular."""
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / scale / scale[:, None])
    return scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def _admissible(each: Input, values: Array) -> Any:
    low, high, is_open = each.quantity.low, each.quantity.high, each.quantity.open
    return (values > low if is_open else values >= low) & (values < high if is_open else values <= high)


def _of_draws(drawn: Drawn, spread: Mapping[str, Any]) -> list[str]:
    """Return warnings of draws that were repeated, lost, or at odds with the linear deviations."""
    lines: list[str] = []
    if drawn.outside > 0.01 * drawn.number:
        lines.append(f"draws: {drawn.outside} lay outside of the admissible ranges and were drawn again")
    for name, agrees in drawn.agrees.items():
        if drawn.lost[name]:
            lines.append(f"draws: {drawn.lost[name]} have no {name} and are left out of it")
        if not np.all(agrees):
            pairs = zip(np.ravel(drawn.standard_deviation[name]), np.ravel(spread[name]), strict=True)
            by_draws, linear = next(pair for pair, good in zip(pairs, np.ravel(agrees), strict=True) if not good)
            lines.append(
                f"linear: {name} has a deviation of {linear:.3g} by derivatives and of {by_draws:.3g} by draws"
            )
    return lines
