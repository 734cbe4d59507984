"""Maps of indentation curves: the material at many places, from one Levenberg-Marquardt descent for all curves."""

from __future__ import annotations

import math
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import whole
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.identification.arguments import parameters
from restitution.identification.bands import FAR, quantile
from restitution.identification.curve import IndentationCurve
from restitution.identification.curve_fits import EDGE, STEP, CurveFits, Descent
from restitution.identification.estimation import Estimation, estimate
from restitution.identification.parameters import Parameters
from restitution.identification.uncertainty import Uncertainty
from restitution.parallel import on_threads

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Curves = Iterable[IndentationCurve | Callable[[], IndentationCurve]]

# Curves in a task of a thread: a few tenths of a second.
_CHUNK = 64
# Number of the first curves that are tried as the start of all others.
_SEEDS = 5
# A curve with this multiple of the median of chi2 is fitted again, from starts of its own.
_POOR = 2.0
# Messages of curves that were not reached, and of those whose descent ends without a minimum.
_INTERRUPTED, _NO_REASON = "interrupted before this curve", "the descent finds no minimum; give start or bounds"


class MapStatus(IntEnum):
    """How the fit of one curve of a map ended."""

    FITTED = 0
    NOT_CONVERGED = 1
    NO_FIT = 2
    REFUSED = 3
    NOT_DONE = 4


def identify_map(
    curves: Curves,
    model: Any,
    *,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    prior: Mapping[str, Any] | None = None,
    terms: int = 2,
    shape: tuple[int, ...] | None = None,
    workers: int = 2,
    progress: bool | Callable[[int, int], None] = True,
) -> xarray.Dataset:
    """Material at each place of a map of indentation curves.

    Parameters
    ----------
    curves : iterable of IndentationCurve or callable
        Curves, or functions without arguments that return one. A function may raise an error, which does not stop the
        map.
    model, fixed, bounds, start, prior, terms
        See `identify`. Each curve has its own unknowns.
    shape : tuple of int, optional
        Shape of the grid of places, whose last dimension runs fastest; one dimension by default.
    workers : int
        Number of threads.
    progress : bool or callable
        Whether to show progress on stderr if it is a terminal; or a function of the number of curves done and of the
        number of all.

    Returns
    -------
    xarray.Dataset
        Each parameter and `contact_point` with their `..._standard_error`, `chi2`, `reduced_chi2`, `status`
        (`MapStatus`) and `message`. A parameter is NaN if its curve does not determine it. After Ctrl-C the other
        curves have the status NOT_DONE.

    Raises
    ------
    InputError
        If an argument is wrong, or none of the first curves can be fitted.

    Notes
    -----
    The first curve that can be fitted is the start of all others, with one factor on all moduli. Curves that fit much
    worse than the others are fitted again as in `identify`. Standard errors are those of the linearised problem.

    Examples
    --------
    >>> import restitution as rs
    >>> time, rng = np.linspace(0.0, 2.8, 200), np.random.default_rng(1)
    >>> depth, tip = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0]), rs.Parabola(2.5e-6)
    >>> curves = []
    >>> for equilibrium_modulus in (50.0, 100.0):
    ...     gel = rs.standard_solid(equilibrium_modulus, 270.0, 80.0, poisson_ratio=0.5)
    ...     force = rs.indent(gel, tip, depth=depth - 0.4e-6, time=time).force + rng.normal(0.0, 5e-12, 200)
    ...     curves.append(rs.IndentationCurve(time, depth, force, profile=tip))
    >>> found = identify_map(curves, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(found["equilibrium_modulus"].values.round(-1))
    [ 50. 100.]
    """
    items = checks.items("curves", curves, "must be curves, or functions that return one")
    grid = (
        [len(items)]
        if shape is None
        else checks.items("shape", shape, "must be the numbers of places along each axis")
    )
    dimensions = tuple(whole("shape", n) for n in grid) if items else ()
    whole("workers", workers)
    if not isinstance(progress, bool):
        checks.function("progress", progress, "must be True, False, or a function of the curves done and of all", 2)
    if not items or math.prod(dimensions) != len(items):
        raise InputError("shape", dimensions, f"must be that of {len(items)} curves")
    space = parameters(
        model, fixed=fixed, bounds=bounds, start=start, prior=prior, shift=None, terms=whole("terms", terms),
        temperature=None,
    )  # fmt: skip
    table = _Table(space, len(items))
    seed = _seed(items, space)
    report = _progress(progress, len(items))

    def run(first: int) -> None:
        places, ready = list[int](), list[IndentationCurve]()
        for place in range(first, min(first + _CHUNK, len(items))):
            try:
                ready.append(_curve(items[place]))
                places.append(place)
            except InputError as error:
                table.refuse(place, str(error))
        for alike in _alike(ready):
            own = [ready[n] for n in alike]
            found = Descent(own, seed, space).found()
            reasons = _improved(found, own, space)
            table.enter(np.array(places)[alike], found, reasons)

    try:
        on_threads(run, range(0, len(items), _CHUNK), workers, lambda: report(table.done))
    except KeyboardInterrupt:
        text = f"interrupted: {len(items) - table.done} of {len(items)} curves are not done"
        warnings.warn(RestitutionWarning("interrupted", text), stacklevel=2)
    return table.dataset(dimensions)


class _Table:
    """Results of all curves."""

    def __init__(self, space: Parameters, size: int) -> None:
        self._space = space
        self._values, self._errors = np.full((2, size, len(space.free) + 1), np.nan)
        self._chi2, self._reduced = np.full((2, size), np.nan)
        self._status = np.full(size, MapStatus.NOT_DONE, dtype=np.int8)
        self._message = np.full(size, _INTERRUPTED, dtype=object)

    @property
    def done(self) -> int:
        """Number of curves that are done."""
        return int(np.sum(self._status != MapStatus.NOT_DONE))

    def refuse(self, place: int, message: str) -> None:
        """Enter a curve that was refused."""
        self._status[place], self._message[place] = MapStatus.REFUSED, message

    def enter(self, places: Places, found: CurveFits, reasons: Mapping[int, str]) -> None:
        """Enter the fits of the curves at these places, with the reasons why some of them failed."""
        fitted = np.isfinite(found.chi2)
        width = quantile(0.95)
        status = np.where(found.ended, MapStatus.FITTED, MapStatus.NOT_CONVERGED)
        for k, one in enumerate(self._space.free):
            z, error = found.points[:, k], found.errors[:, k]
            known = fitted & (width * error < FAR) & ~found.bound[:, k]
            slope = (one.outward(z + STEP) - one.outward(z - STEP)) / (2.0 * STEP)
            self._values[places, k] = np.where(known, one.outward(z), np.nan)
            self._errors[places, k] = np.where(known, slope * error, np.where(fitted, np.inf, np.nan))
        for column, numbers in ((self._values, found.points), (self._errors, found.errors)):
            column[places, -1] = np.where(fitted, numbers[:, -1] * found.units, np.nan)
        self._chi2[places] = np.where(fitted, found.chi2, np.nan)
        self._reduced[places] = np.where(fitted, found.chi2 / found.freedom, np.nan)
        status = np.where(fitted, status, MapStatus.NO_FIT)
        self._status[places] = status
        self._message[places] = [
            reasons.get(n, _NO_REASON) if one != MapStatus.FITTED else "" for n, one in enumerate(status)
        ]

    def dataset(self, shape: tuple[int, ...]) -> xarray.Dataset:
        """All results over the grid of places."""
        import xarray as xr

        names = {1: ("curve",), 2: ("y", "x")}.get(len(shape), tuple(f"axis_{n}" for n in range(len(shape))))
        columns: dict[str, Any] = {}
        units = [(one.name, one.quantity.attributes) for one in self._space.free]
        units.append(("contact_point", {"units": "m", "long_name": "depth reading at first touch"}))
        for k, (name, attributes) in enumerate(units):
            words = {"units": attributes["units"], "long_name": f"standard error of the {attributes['long_name']}"}
            columns[name] = self._values[:, k], attributes
            columns[f"{name}_standard_error"] = self._errors[:, k], words
        columns["chi2"] = self._chi2, {"units": "", "long_name": "sum of the squares of the residuals"}
        columns["reduced_chi2"] = self._reduced, {"units": "", "long_name": "chi2 over the degrees of freedom"}
        meanings = " ".join(one.name.lower() for one in MapStatus)
        flags = {"flag_values": [int(one) for one in MapStatus], "flag_meanings": meanings}
        columns["status"] = self._status, {"long_name": "status of the fit", **flags}
        columns["message"] = self._message.astype(str), {"long_name": "why the curve has no fit"}
        return xr.Dataset({name: (names, data.reshape(shape), about) for name, (data, about) in columns.items()})


def _curve(item: IndentationCurve | Callable[[], IndentationCurve]) -> IndentationCurve:
    made = item() if callable(item) else item
    if not isinstance(made, IndentationCurve):
        raise InputTypeError("curves", made, "must be an IndentationCurve, or a function that returns one")
    return made


def _seed(items: list[Any], space: Parameters) -> Estimation:
    """Fit of the first of the curves that can be fitted."""
    for n, item in enumerate(items):
        try:
            return estimate([_curve(item)], space)
        except InputTypeError:
            raise
        except InputError:
            if n + 1 >= min(_SEEDS, len(items)):
                raise
    raise AssertionError


def _alike(curves: list[IndentationCurve]) -> list[list[int]]:
    """Indices of the curves, in groups of the same indenter and temperature."""
    groups: list[list[int]] = []
    for n, one in enumerate(curves):
        for group in groups:
            first = curves[group[0]]
            if (first.profile is one.profile or first.profile == one.profile) and first.temperature == one.temperature:
                group.append(n)
                break
        else:
            groups.append([n])
    return groups


def _improved(found: CurveFits, curves: list[IndentationCurve], space: Parameters) -> dict[int, str]:
    """Fit curves whose chi2 is far above that of the others again, from their own starts; the reasons of failures."""
    reasons: dict[int, str] = {}
    reduced = found.chi2 / found.freedom
    usual = np.median(reduced[np.isfinite(reduced)]) if np.isfinite(reduced).any() else 0.0
    for n in np.flatnonzero(~found.ended | ~(reduced < _POOR * usual)):
        try:
            own = Uncertainty(estimate([curves[n]], space))
        except InputError as error:
            reasons[int(n)] = str(error)
            continue
        problem, fit = own.estimation.problem, own.estimation.fit
        chi2 = fit.cost * problem.factors[0] ** 2
        if chi2 < found.chi2[n] or not found.ended[n]:
            found.points[n], found.errors[n], found.chi2[n] = fit.coordinates, own.standard_errors, chi2
            z = fit.coordinates
            found.bound[n] = (z - problem.low < EDGE) | (problem.high - z < EDGE)
            found.ended[n] = True
    return reasons


def _progress(wanted: bool | Callable[[int, int], None], total: int) -> Callable[[int], None]:
    """Function that shows the number of curves done."""
    if callable(wanted):
        return lambda done: wanted(done, total)
    if not wanted or not sys.stderr.isatty():
        return lambda done: None
    begin = time.monotonic()

    def show(done: int) -> None:
        left = (time.monotonic() - begin) * (total - done) / max(done, 1)
        end = "\n" if done == total else ""
        sys.stderr.write(f"\r{done} of {total} curves, {left:.0f} s left \033[K{end}")
        sys.stderr.flush()

    return show
