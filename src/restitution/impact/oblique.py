"""Oblique impact of a body with friction and spin, on the normal impact that friction leaves as it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.axes import aligned, named, unnamed
from restitution.checks import Array, Numeric, common_shape, positive, whole, within
from restitution.contact.profiles import as_profile
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import Batch, flat
from restitution.impact.problem import Impact
from restitution.impact.result import ImpactResult
from restitution.impact.solution import Solution
from restitution.impact.solve import Errors, judge, solve_exact
from restitution.impact.status import Status
from restitution.impact.tangential import Slider, Tangential
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, dundurs_parameter, reduced_shear_modulus
from restitution.parallel import on_threads
from restitution.quantities import OBLIQUE, OBLIQUE_HISTORY, OBLIQUE_INPUTS, STATUS, dataset
from restitution.result import Result, Summary, Table, draw, of_values, plain_symbol
from restitution.units import scaled_unit

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

SOLID_BALL = 0.4
"""Moment of inertia of a solid ball over m R^2."""

COUPLING_LIMIT = 0.3
"""Dundurs' parameter over friction: up to it v_c'/(mu v0) of an elastic impact changes by some 0.03."""
TRAVEL_LIMIT = 0.5
"""Way of the centre during contact over the largest contact radius, up to which the patch counts as at rest."""
_GAPS_LIMIT = 0.01
# Tolerance of the normal solution, and its share of that of e_t.
_NORMAL_RTOL, _SHARE = 1e-9, 1e-2
_LEAST_RTOL, _MOST_RTOL = 1e-7, 1e-2
# Outputs that a march gives, in its order.
_SOLVED = ("tangential_restitution_coefficient", "error", "friction", "viscous", "stored", "stick", "gaps")


@dataclass(frozen=True, eq=False, repr=False)
class ObliqueResult(Result):
    """Result of one oblique impact or of several, in SI units; `plot` shows forces, radii and velocities.

    The tangential direction x is that of the plane of motion. The contact point has the velocity
    ``v_c = v_x + R w``: a spin w > 0 moves it along x.

    Attributes
    ----------
    tangential_restitution_coefficient : float or array
        e_t = -v_c'/v_c0 [-], between -1 (no friction) and 1; NaN where v_c0 = 0.
    rebound_tangential_velocity, rebound_spin, rebound_angle : float or array
        Tangential velocity of the centre [m/s], spin [rad/s] (NaN where the body has no radius), and angle of the
        velocity from the normal [rad], > 0 along x.
    impulse_ratio : float or array
        Tangential over normal impulse [-]; the friction coefficient where all of the contact slides all the time.
    stick_time, slip_time : float or array
        Times [s] in which some of the contact sticks, and in which all of it slides.
    friction_energy, tangential_dissipated_energy, tangential_stored_energy : float or array
        Parts [J] of `tangential_energy_in` - `tangential_energy_out`: lost by slip, dissipated in the material, and
        stored in elements when they leave contact. The energies of the normal impact are in `normal.energy`.
    tangential_energy_residual : float or array
        (friction + dissipated + stored + out - in)/in [-]. e_t does not depend on the split into parts.
    tangential_error : float or array
        Estimate of the error of e_t [-].
    status : Status, or array of int
        End of the solve; the numbers are NaN where the body does not separate or a solve failed.
    friction, tangential_velocity, spin, gyration : float or array
        What was given; the velocity also follows from an angle.
    normal : ImpactResult
        The normal impact: e, contact time, force, depth, energies, validity.
    rtol : float
        Tolerance of e_t.
    """

    _numbers = (
        *OBLIQUE, "tangential_error", "status", "friction", "tangential_velocity", "spin", "gyration", "rtol",
        "warnings", "normal",
    )  # fmt: skip

    tangential_restitution_coefficient: Numeric
    rebound_tangential_velocity: Numeric
    rebound_spin: Numeric
    rebound_angle: Numeric
    impulse_ratio: Numeric
    stick_time: Numeric
    slip_time: Numeric
    tangential_energy_in: Numeric
    tangential_energy_out: Numeric
    friction_energy: Numeric
    tangential_dissipated_energy: Numeric
    tangential_stored_energy: Numeric
    tangential_energy_residual: Numeric
    tangential_error: Numeric
    status: Status | NDArray[np.int64]
    friction: Numeric
    tangential_velocity: Numeric
    spin: Numeric
    gyration: Numeric
    normal: ImpactResult
    rtol: float
    _doubts: tuple[str, ...] = ()
    _kept: _Kept | None = field(default=None, repr=False)

    @property
    def impact(self) -> Impact:
        """The normal impact."""
        assert isinstance(self.normal.impact, Impact)
        return self.normal.impact

    @property
    def restitution_coefficient(self) -> Numeric:
        """Normal restitution coefficient e [-], in the shape of the normal impacts."""
        return self.normal.restitution_coefficient

    @property
    def rebound_velocity(self) -> Numeric:
        """Normal speed of the rebound e v0 [m/s], in the shape of the normal impacts."""
        return self.normal.rebound_velocity

    @property
    def warnings(self) -> list[str]:
        """Doubtful assumptions of both theories, with numbers."""
        return [*self.normal.warnings, *self._doubts]

    @cached_property
    def history(self) -> xarray.Dataset:
        """History of velocity and force of the contact point, and of the radii in contact and stuck, over time.

        Raises
        ------
        InputError
            If the result is of several impacts, or the body does not separate.
        """
        if self._kept is None:
            rule = "must be a single one that ends and slides or sticks: a history is of one impact"
            raise InputError("impact", rule=rule)
        solution, motion, velocity = self._kept
        times = np.minimum(motion[:, 0] * solution.units.time, solution.contact_time)
        normal = solution.at(times)
        columns: dict[str, Array] = {
            "time": times,
            "contact_point_velocity": motion[:, 1] * velocity,
            "tangential_force": motion[:, 2] * (velocity * solution.mass / solution.units.time),
            "force": normal.force,
            "contact_radius": normal.contact_radius,
            "stick_radius": np.minimum(motion[:, 3] * solution.units.radius, normal.contact_radius),
            "slip_velocity": motion[:, 4] * abs(velocity),
        }
        named_columns = {name: (values, OBLIQUE_HISTORY[name]) for name, values in columns.items()}
        return dataset("time", named_columns, {"rtol": self.rtol})

    def to_dataset(self) -> xarray.Dataset:
        """Return all outputs, the normal restitution and the status over the named axes, or over dim_0 and so on."""
        shape = np.shape(self.status)
        first = self.tangential_restitution_coefficient
        variables = {name: (np.asarray(getattr(self, name)), OBLIQUE[name].attributes) for name in OBLIQUE}
        variables[STATUS] = np.asarray(self.status), Status.attributes()
        if not hasattr(first, "dims"):
            return unnamed(shape).dataset(variables, {"rtol": self.rtol})
        columns = {name: getattr(self, name) for name in variables}
        named_ones: Any = first
        return named_ones.coords.to_dataset().assign(columns).assign_attrs(rtol=self.rtol)

    def plot(self) -> Figure:
        """Return the figure of the impact, or of several e_t and the angle of the rebound."""
        return draw("oblique.of_several" if np.shape(self.status) else "oblique.overview", self)

    def summary(self, title: str = "") -> Summary:
        """Return the table of the outputs, of several impacts their ranges, and the warnings."""
        line = f"method elements, rtol {self.rtol:g}"
        if not np.shape(self.status):
            rows = [
                (q.words, plain_symbol(q.symbol), float(getattr(self, name)), q.unit) for name, q in OBLIQUE.items()
            ]
            rows.insert(0, ("restitution coefficient", "e", float(self.restitution_coefficient), ""))
            return Summary(title or "Oblique impact", of_values(rows), (line,), warnings=self.warnings)
        cells = list[tuple[str, ...]]()
        for name, quantity in OBLIQUE.items():
            values = np.asarray(getattr(self, name), dtype=np.float64)
            values = values[np.isfinite(values)]
            factor, unit = scaled_unit(values, quantity.unit)
            ends = [f"{factor * end:.6g}" for end in (values.min(), values.max())] if values.size else ["-", "-"]
            cells.append((quantity.words, plain_symbol(quantity.symbol), *ends, unit))
        table = Table(("quantity", "symbol", "lowest", "highest", "unit"), cells)
        return Summary(title or f"{np.size(self.status)} oblique impacts", table, (line,), warnings=self.warnings)

    @property
    def _short(self) -> str:
        if np.shape(self.status):
            return f"{np.size(self.status)} oblique impacts"
        angle = math.degrees(float(self.rebound_angle))
        e, e_t = float(self.restitution_coefficient), float(self.tangential_restitution_coefficient)
        return f"e = {e:.6g}, e_t = {e_t:.6g}, rebound at {angle:.4g} degrees"


class _Kept(NamedTuple):
    """What a history needs: the normal solution, the scaled motion, and the velocity of the contact point [m/s]."""

    solution: Solution
    motion: Array
    velocity: float


def hollow_gyration(inner_radius: Any, outer_radius: Any) -> Any:
    """Return the moment of inertia of a hollow ball over m R^2, for `gyration` of `oblique`.

    Parameters
    ----------
    inner_radius, outer_radius : float or array
        Radii [m] of the cavity and of the ball, > 0; the first is the smaller one.

    Returns
    -------
    float or array
        ``(2/5) (1 - q^5)/(1 - q^3)`` with the ratio q of the radii: 2/5 of a solid ball, 2/3 of a thin shell.

    Examples
    --------
    >>> print(round(hollow_gyration(0.018, 0.020), 4))
    0.6044
    """
    inner, outer = np.asarray(positive("inner_radius", inner_radius, "m")), positive("outer_radius", outer_radius, "m")
    ratio = inner / outer
    if np.any(ratio >= 1.0):
        raise InputError("inner_radius", inner_radius, "must be smaller than the outer radius", "m")
    # Sums of powers in place of 1 - q^n, which cancel for a thin shell.
    fifth, third = (np.sum([ratio**n for n in range(count)], axis=0) for count in (5, 3))
    return np.asarray(SOLID_BALL * fifth / third)[()]


def oblique(
    impact: Impact | ImpactResult,
    *,
    friction: Any,
    tangential_velocity: Any = None,
    spin: Any = 0.0,
    angle: Any = None,
    speed: Any = None,
    gyration: Any = SOLID_BALL,
    rtol: float = 1e-6,
    errors: Errors | None = None,
    workers: int | None = None,
) -> ObliqueResult:
    """Return the rebound of an oblique impact with Coulomb friction: tangential restitution, spin, angle, energies.

    Numbers may be arrays that broadcast against each other and against the impact. DataArrays keep their dimensions
    and coordinates by name.

    Parameters
    ----------
    impact : Impact or ImpactResult
        The normal impact, whose `velocity` is the normal one: a body on a half-space, or two bodies, with a profile.
    friction : float or array
        Coefficient of friction mu [-], >= 0; infinite for a contact that never slips.
    tangential_velocity : float or array
        Velocity v_x [m/s] of the centre along the surface, of two bodies that of one contact point relative to the
        other. This or `angle`.
    spin : float or array
        Spin w [rad/s] about the axis across the plane of motion, > 0 where it moves the contact point along x. Of a
        single body with a radius.
    angle : float or array
        Angle of incidence [rad] from the normal: v_x = v0 tan(angle).
    speed : float or array, optional
        Speed [m/s] of the centre, with `angle`: the normal velocity is then speed cos(angle) in place of that of the
        impact, and v_x = speed sin(angle).
    gyration : float or array
        Moment of inertia over m R^2 [-], > 0: 2/5 for a solid ball (the default); see `hollow_gyration`. Of two
        bodies that of both.
    rtol : float
        Largest error of e_t, in [1e-7, 1e-2].
    errors : {"raise", "warn"}, optional
        As in `solve`.
    workers : int, optional
        Number of threads for several impacts.

    Returns
    -------
    ObliqueResult
        Numbers for a single impact, arrays in the common shape for several.

    Raises
    ------
    InputError
        If a number is out of range, the geometry is no profile on a half-space, the target has an impedance, or a
        body without a radius has a spin.
    SolverError
        If a solve fails or does not reach `rtol`, and `errors` is "raise".

    Notes
    -----
    Coulomb's law in each point of the contact, with the normal loads of the normal impact, which friction does not
    change; exact where Dundurs' parameter is 0, and where all slides. In between the theory is that of Cattaneo,
    Mindlin and Jaeger with the memory of the material. Motion is in one plane, without a spin about the normal. e_t
    depends on friction and velocity by ``v_c0/(mu v0)`` alone.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> thrown = rs.oblique(ball, friction=0.5, tangential_velocity=0.6, spin=20.0)
    >>> print(round(thrown.tangential_restitution_coefficient, 4), round(thrown.rebound_spin, 2))
    0.1078 -43.3
    """
    problem, values, axes = _checked(impact, friction, tangential_velocity, spin, angle, speed, gyration)
    limit = float(np.asarray(within("rtol", rtol, _LEAST_RTOL, _MOST_RTOL)))
    if workers is not None:
        whole("workers", workers)
    shapes = {name: np.shape(value) for name, value in values.items()}
    shape = common_shape(shapes | ({"impact": problem.shape} if problem.shape else {}))
    normal = solve_exact(problem, _normal_rtol(limit), errors, workers)
    columns = {name: flat(value, shape) for name, value in values.items()}
    rows, kept = _solved(problem, columns, shape, limit, workers)
    status = rows.pop(STATUS)
    judge(status, errors or ("warn" if shape else "raise"), stacklevel=3)
    outputs = _outputs(problem, normal, columns, rows, shape)
    doubts = _doubts(problem, normal, columns, outputs, rows["gaps"], shape)
    outputs["tangential_error"] = rows["error"]
    numbers: dict[str, Any] = {name: _shaped(column, shape) for name, column in outputs.items()}
    codes: Any = status.astype(np.int64).reshape(shape) if shape else Status(int(status[0]))
    if axes is not None:
        attributes = {name: OBLIQUE[name].attributes if name in OBLIQUE else {} for name in numbers}
        numbers = {name: axes.array(column, name, attributes[name]) for name, column in numbers.items()}
        codes = axes.array(codes, STATUS, Status.attributes())
    return ObliqueResult(**numbers, status=codes, **values, normal=normal, rtol=limit, _doubts=doubts, _kept=kept)


def _normal_rtol(rtol: float) -> float:
    return min(_NORMAL_RTOL, _SHARE * rtol)


def _shaped(column: Array, shape: tuple[int, ...]) -> Any:
    return column.reshape(shape) if shape else float(column[0])


def _checked(
    impact: Any, friction: Any, tangential_velocity: Any, spin: Any, angle: Any, speed: Any, gyration: Any
) -> tuple[Impact, dict[str, Any], Any]:
    """Return the normal impact, the numbers by name as the result has them, and the axes; refuse bad input."""
    if isinstance(impact, ImpactResult):
        if impact.began_on is not None:
            raise InputError("impact", rule="must begin on a fresh surface")
        impact = impact.impact
    if not isinstance(impact, Impact):
        raise InputTypeError("impact", impact, "must be an Impact, single or an array, or its result")
    if (tangential_velocity is None) == (angle is None):
        raise InputError("tangential_velocity, angle", rule="must be one of them, not both or none")
    if speed is not None and angle is None:
        raise InputError("speed", speed, "belongs to an angle; give the tangential velocity without it", "m/s")
    as_profile(impact.profile, "friction")
    if np.any(np.isfinite(impact.impedance)):
        raise InputError("impedance", impact.impedance, "must be infinite: the target may not move", "kg/s")
    given = {
        "friction": friction, "tangential_velocity": tangential_velocity, "spin": spin, "angle": angle,
        "speed": speed, "gyration": gyration,
    }  # fmt: skip
    given = {name: value for name, value in given.items() if value is not None}
    values, axes = aligned({"impact": impact, **given})
    problem: Impact = values.pop("impact")
    numbers: dict[str, Any] = {name: OBLIQUE_INPUTS[name].check(value) for name, value in values.items()}
    if angle is not None:
        incidence = np.asarray(numbers.pop("angle"))
        if speed is not None:
            whole_speed = np.asarray(numbers.pop("speed"))
            problem = named(replace(problem, velocity=(whole_speed * np.cos(incidence))[()]), axes)
            numbers["tangential_velocity"] = (whole_speed * np.sin(incidence))[()]
        else:
            numbers["tangential_velocity"] = (np.asarray(problem.velocity) * np.tan(incidence))[()]
    _check_spin(problem, numbers["spin"])
    return problem, numbers, axes


def _check_spin(impact: Impact, spin: Any) -> None:
    """Refuse a spin of bodies whose radius does not give the velocity of the surface."""
    if not np.any(spin):
        return
    if not np.any(np.isinf(impact.diameters[0]) | np.isinf(impact.diameters[1])):
        rule = "must be 0 of two balls; their contact points have the relative tangential velocity v_x + R1 w1 + R2 w2"
        raise InputError("spin", spin, rule, "rad/s")
    if np.any(np.isnan(impact.profile.ball_radius)):
        raise InputError("spin", spin, "must be 0 for a profile without the radius of a ball", "rad/s")


def _point_velocity(impact: Impact, columns: dict[str, Array], shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Return the velocity [m/s] of the contact point at first touch, and the radius [m] of the body."""
    radius = np.array(flat(impact.profile.ball_radius, shape))
    if not np.any(np.isinf(impact.diameters[0]) | np.isinf(impact.diameters[1])):
        radius[:] = np.nan
    turning = np.where(columns["spin"] == 0.0, 0.0, radius * columns["spin"])
    return columns["tangential_velocity"] + turning, radius


def _solved(
    impact: Impact, columns: dict[str, Array], shape: tuple[int, ...], rtol: float, workers: int | None
) -> tuple[dict[str, Array], _Kept | None]:
    """Solve all rows; return what the marches give by name, with the status, and what the history of one row needs."""
    size = columns["friction"].size
    rows = {name: np.full(size, np.nan) for name in (*_SOLVED, "impulse", STATUS)}
    velocity, _ = _point_velocity(impact, columns, shape)
    places = np.broadcast_to(np.arange(math.prod(impact.shape)).reshape(impact.shape), shape).reshape(-1)
    kept = list[_Kept]()

    def run(place: int) -> None:
        single = impact.take(np.asarray(place)) if impact.shape else impact
        found, solution = Batch.from_impact(single).solve_stored(_normal_rtol(rtol))
        mine = np.flatnonzero(places == place)
        rows[STATUS][mine] = found["status"][0]
        if solution is None:
            return
        slider = _slider(single, solution)
        for n in mine.tolist():
            rows["impulse"][n] = slider.impulse
            if velocity[n] == 0.0:
                rows["error"][n] = rows["friction"][n] = rows["viscous"][n] = rows["stored"][n] = 0.0
                continue
            slope = _slope(float(velocity[n]), float(columns["friction"][n]), float(single.velocity))
            motion = slider.solve(slope, 1.0 + 1.0 / float(columns["gyration"][n]), rtol)
            _write(rows, n, motion, solution, rtol)
            if not shape:
                kept.append(_Kept(solution, motion.motion, float(velocity[n])))

    todo = np.unique(places).tolist()
    for place in todo[:1]:
        run(place)
    if len(todo) > 1:
        on_threads(run, todo[1:], workers, lambda: None)
    return rows, kept[0] if kept else None


def _slope(velocity: float, friction: float, normal: float) -> float:
    """Return v_c0/(mu v0): 0 without slip, infinite without friction."""
    return math.inf if friction == 0.0 else abs(velocity) / friction / normal


def _write(rows: dict[str, Array], n: int, found: Tangential, solution: Solution, rtol: float) -> None:
    """Write the numbers of a row, NaN where the tolerance is not reached."""
    if not found.error <= rtol:
        rows[STATUS][n] = Status.NOT_ACCURATE
        return
    for name, value in zip(_SOLVED[:5], found[:5], strict=True):
        rows[name][n] = value
    durations = np.diff(found.motion[:, 0])
    rows["stick"][n] = float(durations @ (found.motion[1:, 3] > 0.0)) * solution.units.time
    rows["gaps"][n] = found.gaps


def _slider(impact: Impact, solution: Solution) -> Slider:
    """Return the solver of the tangential half of a single impact."""
    material, counter = impact.material, impact.counter_material
    spectrum = reduced_shear_modulus(material, counter)
    return Slider(solution, spectrum, impact.reduced_modulus, _ratios(material, counter))


def _ratios(material: Material, counter: Material | None) -> tuple[float, float] | None:
    """Return E*/G* of the instantaneous and the static moduli where it rises in between; None where it may not."""
    bodies = [material] if counter is None else [material, counter]
    if all(bool(body.is_incompressible) for body in bodies):
        return 1.5, 1.5
    if counter is not None and counter != material:
        return None
    bulk = material.bulk
    if isinstance(bulk, PronySeries) and not np.all(bulk.is_elastic):
        return None
    glass, static = float(material.instantaneous_poisson_ratio), float(material.poisson_ratio)
    return (2.0 - glass) / (2.0 * (1.0 - glass)), (2.0 - static) / (2.0 * (1.0 - static))


def _of_normal(normal: ImpactResult, name: str, shape: tuple[int, ...]) -> Array:
    """Return numbers of the normal impacts for all rows; those with names lack the axes along which they are equal."""
    assert isinstance(normal.impact, Impact)
    return flat(np.asarray(getattr(normal, name)).reshape(normal.impact.shape), shape)


def _outputs(
    impact: Impact, normal: ImpactResult, columns: dict[str, Array], rows: dict[str, Array], shape: tuple[int, ...]
) -> dict[str, Array]:
    """Return the outputs in SI by name; see `docs/theory/oblique.md` for the kinematics."""
    velocity, radius = _point_velocity(impact, columns, shape)
    kappa, mass, v0 = columns["gyration"], flat(impact.mass, shape), flat(impact.velocity, shape)
    e, contact_time = (_of_normal(normal, name, shape) for name in ("restitution_coefficient", "contact_time"))
    e_t = rows["tangential_restitution_coefficient"]
    solved = ~np.isnan(rows["error"])
    change = np.where(velocity == 0.0, np.where(solved, 0.0, np.nan), (1.0 + e_t) * velocity)
    along = columns["tangential_velocity"] - kappa / (1.0 + kappa) * change
    tangential_mass = mass * kappa / (1.0 + kappa)
    before = 0.5 * tangential_mass * velocity * velocity
    after = 0.5 * tangential_mass * (velocity - change) ** 2
    parts = {name: rows[name] * before for name in ("friction", "viscous", "stored")}
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = np.where(velocity == 0.0, 0.0, (sum(parts.values()) + after - before) / before)
        spin = columns["spin"] - change / ((1.0 + kappa) * radius)
    stick = np.where(solved & (velocity == 0.0), contact_time, rows["stick"])
    return {
        "tangential_restitution_coefficient": e_t,
        "rebound_tangential_velocity": along,
        "rebound_spin": spin,
        "rebound_angle": np.where(solved, np.arctan2(along, e * v0), np.nan),
        "impulse_ratio": tangential_mass * change / (mass * v0 * rows["impulse"]),
        "stick_time": stick,
        "slip_time": np.where(solved, np.maximum(contact_time - stick, 0.0), np.nan),
        "tangential_energy_in": before,
        "tangential_energy_out": after,
        "friction_energy": parts["friction"],
        "tangential_dissipated_energy": parts["viscous"],
        "tangential_stored_energy": parts["stored"],
        "tangential_energy_residual": np.where(solved, residual, np.nan),
    }


def _doubts(
    impact: Impact, normal: ImpactResult, columns: dict[str, Array], outputs: dict[str, Array], gaps: Array,
    shape: tuple[int, ...],
) -> tuple[str, ...]:  # fmt: skip
    """Return what the decoupled theory of a patch at rest leaves out, with numbers, where it matters."""
    beta = np.abs(flat(dundurs_parameter(impact.material, impact.counter_material), shape))
    radius, time = (_of_normal(normal, name, shape) for name in ("max_contact_radius", "contact_time"))
    ways = np.abs(columns["tangential_velocity"]), np.abs(outputs["rebound_tangential_velocity"])
    with np.errstate(divide="ignore", invalid="ignore"):
        coupling = np.where(outputs["stick_time"] > 0.0, beta / columns["friction"], 0.0)
        travel = np.maximum(*ways) * time / radius
    numbers: list[tuple[Array, float, Callable[[float], str]]] = [
        (coupling, COUPLING_LIMIT, lambda x: (
            f"coupling: Dundurs' parameter over friction is {x:.3g}, above {COUPLING_LIMIT:g}; normal and tangential "
            "displacements are not independent then, and e_t is off by some hundredths or more"
        )),
        (travel, TRAVEL_LIMIT, lambda x: (
            f"travel: the body moves by {x:.3g} contact radii during contact, above {TRAVEL_LIMIT:g}; rolling and "
            "ploughing on fresh material are not part of the theory"
        )),
        (gaps, _GAPS_LIMIT, lambda x: (
            f"disc: for {100.0 * x:.2g} % of the contact time some elements slip within the radius that sticks; the "
            "theory needs a disc"
        )),
    ]  # fmt: skip
    doubts = list[str]()
    for values, limit, words in numbers:
        above = values[values > limit]
        if above.size:
            count = f"; in {above.size} of {values.size} impacts" if shape else ""
            doubts.append(words(float(above.max())) + count)
    return tuple(doubts)
