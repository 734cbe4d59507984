"""Problems by their names, the numbers that they return, and differences between two sets of numbers."""

from __future__ import annotations

import math
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import restitution as rs

SEED = 20260727
FLOOR = 1e-3  # a coefficient of restitution below it has an absolute tolerance
# Outputs whose rounding errors are those of a larger one.
BOUNDS = {
    "residual_indentation_depth": "max_indentation_depth",
    "dissipated": "kinetic_in",
    "stored": "kinetic_in",
    "radiated": "kinetic_in",
    "dissipated_energy": "kinetic_energy_out",
    "stored_energy": "kinetic_energy_out",
}
# Energy that an indentation leaves, over its work.
OF_STORED = 1e-6
# `rs.solve` keeps the error of e below 1e-9 by default; that of the largest force is up to 14 times as large.
OF_IMPACTS = {"": 2e-8, "restitution_coefficient": 1e-9}

Random = np.random.Generator
Values = dict[str, NDArray[np.float64]]


class Problem(NamedTuple):
    """One problem: a function of its own random numbers and of the variant, and the tolerance of its numbers."""

    kind: str
    name: str
    function: Callable[..., Any]
    variant: Any
    tolerances: Mapping[str, float]
    slow: bool

    def values(self) -> Values:
        """Numbers of the problem, flat; the random numbers depend on the seed and on the name alone."""
        random = np.random.default_rng([SEED, zlib.crc32(self.name.encode())])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rs.RestitutionWarning)
            try:
                result = self.function(random, self.variant)
            except rs.SolverError as error:
                return {"solver_error": np.array(float(error.status))}
            except rs.InputError as error:
                return {f"input_error {error.field}": np.array(1.0)}
        return dict(flat(result))

    def tolerance(self, output: str) -> float:
        """Relative tolerance of one output; the longest part of its name in `tolerances` decides."""
        return self.tolerances[max((part for part in self.tolerances if part in output), key=len)]

    def short(self, values: Values) -> Values:
        """Some numbers of each output that has a finite tolerance, for a small file."""
        return {name: short(item) for name, item in values.items() if math.isfinite(self.tolerance(name))}


PROBLEMS: dict[str, Problem] = {}


def problem(
    kind: str, variants: Iterable[Any] = (0,), *, rtol: float | None = None, slow: Iterable[Any] = (), **loose: float
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register a function of (random numbers, variant) as one problem for each variant.

    Parameters
    ----------
    kind : str
        Kind of the problem, the first part of its name.
    variants : iterable
        Second arguments of the function: numbers or names.
    rtol : float, optional
        Relative tolerance of all outputs; by default those of impacts. Outputs whose tolerance is infinite are compared
        by their bits alone.
    slow : iterable
        Variants that take long.
    **loose : float
        Tolerances of the outputs whose names contain this text.
    """

    tolerances = (OF_IMPACTS if rtol is None else {"": rtol}) | loose

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        for variant in variants:
            name = f"{kind}/{function.__name__}/{variant}"
            PROBLEMS[name] = Problem(kind, name, function, variant, tolerances, variant in set(slow))
        return function

    return register


def flat(value: Any, name: str = "") -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Names and numbers of nested results; text is left out."""
    if isinstance(value, str):
        return
    if isinstance(value, rs.PronySeries):
        parts = ("equilibrium_modulus", "branch_moduli", "relaxation_times", "parallel_viscosity")
        value = {part: getattr(value, part) for part in parts}
    elif isinstance(value, rs.Material):
        value = {"shear": value.shear, "bulk": value.bulk}
    elif hasattr(value, "data_vars"):
        value = {str(key): column.values for key, column in value.data_vars.items()}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from flat(part, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list | tuple) and not all(isinstance(part, int | float) for part in value):
        for number, part in enumerate(value):
            yield from flat(part, f"{name}[{number}]")
    else:
        numbers = np.asarray(math.nan if value is None else value)
        if numbers.dtype.kind not in "OUS":
            if numbers.dtype.kind == "c":
                numbers = np.stack([numbers.real, numbers.imag])
            yield name or "value", np.array(numbers, dtype=np.float64)


def short(values: NDArray[np.float64], count: int = 4) -> NDArray[np.float64]:
    """At most `count` of the values, evenly spaced, for a small file."""
    row = values.ravel() + 0.0  # without a sign of zero
    return row if row.size <= count else row[np.linspace(0, row.size - 1, count).round().astype(int)]


def same_bits(first: Values, other: Values) -> bool:
    """Whether both have the same names, shapes and bits."""
    return first.keys() == other.keys() and all(
        first[name].shape == other[name].shape and first[name].tobytes() == other[name].tobytes() for name in first
    )


def difference(first: NDArray[np.float64], other: NDArray[np.float64], floor: float = 0.0) -> float:
    """Largest difference over the largest finite magnitude; infinite if shapes, NaN or infinities differ."""
    if first.shape != other.shape:
        return math.inf
    finite = np.isfinite(other)
    if not np.array_equal(np.isfinite(first), finite) or not np.array_equal(
        first[~finite], other[~finite], equal_nan=True
    ):
        return math.inf
    largest = float(np.max(np.abs(first[finite] - other[finite]), initial=0.0))
    scale = max(float(np.max(np.abs(other[finite]), initial=0.0)), floor)
    return largest / scale if largest else 0.0


def differences(first: Values, other: Values) -> dict[str, float]:
    """Difference of each output relative to its largest magnitude; infinite if one of both lacks it."""
    return {
        name: difference(first[name], other[name]) if name in first and name in other else math.inf
        for name in first.keys() | other.keys()
    }


def beyond(problem: Problem, result: Values, recorded: Values) -> dict[str, float]:
    """Outputs that differ by more than their tolerance, with the difference over the scale of the output.

    The scale is the largest magnitude, and at least that of the output that bounds its rounding errors: the depth of
    the imprint is a difference of depths of the size of the largest one, and energies are parts of the kinetic one.
    """
    outside = {}
    for name in sorted(result.keys() | recorded.keys()):
        if name not in result or name not in recorded:
            outside[name] = math.inf
            continue
        head, dot, last = name.rpartition(".")
        bound = recorded.get(f"{head}{dot}{BOUNDS[last]}") if last in BOUNDS else None
        share = problem.tolerance(name)
        if bound is None and last in ("stored", "dissipated"):
            # What an indentation leaves has the errors of the largest force and depth, whose product exceeds the work.
            bound, share = recorded.get(f"{head}{dot}work"), max(share, OF_STORED)
        floor = FLOOR if last.endswith("restitution_coefficient") else 0.0
        if bound is not None and np.isfinite(bound).any():
            floor = float(np.max(np.abs(bound[np.isfinite(bound)])))
        if (error := difference(result[name], recorded[name], floor)) > share:
            outside[name] = error
    return outside
