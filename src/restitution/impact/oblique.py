"""Oblique impacts: the tangential half on the normal one, which friction leaves as it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial, reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, Numeric, positive
from restitution.errors import InputError
from restitution.impact.batch import Batch, flat
from restitution.impact.members import of_each
from restitution.impact.problem import SOLID_BALL, Impact
from restitution.impact.result import ImpactResult
from restitution.impact.solution import Progress, Solution
from restitution.impact.status import Status
from restitution.impact.tangential import MOTION, Slider, Tangential
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, dundurs_parameter, reduced_shear_modulus
from restitution.parallel import on_threads
from restitution.quantities import DEFAULT_OUTPUTS, OBLIQUE, SLIDING, STATUS
from restitution.result import draw

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

TANGENTIAL_RTOL = 1e-6
"""Least tolerance of e_t, which is that of e where this is larger."""
_GAPS_LIMIT = 0.01
# Residual of the balance of energy over the tolerance of e_t above which results warn.
_BALANCE = 10.0
# Largest tolerance of the normal solution behind the tangential one.
_NORMAL_RTOL = 1e-9
# Most rows of one task, which share a normal solution.
_TASK = 16
# Outputs that a march gives, in its order, and what else a row has.
_SOLVED = (
    "tangential_restitution_coefficient",
    "tangential_error",
    "tangential_split_error",
    "friction",
    "viscous",
    "stored",
)
_ROW = (*_SOLVED, "stick", "gaps", "impulse")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ObliqueResult(ImpactResult):
    """Result of one impact with friction or of several: that of the normal motion, and what follows, in SI units.

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
    tangential_energy_in, tangential_energy_out : float or array
        Energy [J] of the contact point before and after, m_t v_c^2/2.
    friction_energy, tangential_dissipated_energy, tangential_stored_energy : float or array
        Parts [J] of what it loses: by slip, in the material, and stored in elements when they leave contact. The
        energies of the normal motion are in `energy`.
    tangential_energy_residual : float or array
        (friction + dissipated + stored + out - in)/in [-]. e_t does not depend on the split into parts.
    tangential_error, tangential_split_error : float or array
        Estimates of the errors [-] of e_t, and of each of the three parts over `tangential_energy_in`. `rtol` bounds
        the first only; the second is larger where a slipping rim is thin and relaxation fast.

    Notes
    -----
    Coulomb's law in each point of the contact, with the normal loads of the normal impact, which friction does not
    change; exact where Dundurs' parameter is 0, and where all slides. In between the theory is that of Cattaneo,
    Mindlin and Jaeger with the memory of the material. Motion is in one plane, without a spin about the normal. e_t
    depends on friction and velocity by ``v_c0/(mu v0)`` alone. The error of e_t stays below `rtol`, or 1e-6 where
    that is smaller. Where it does not, the status is `NOT_ACCURATE` and the tangential numbers are NaN.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5)
    >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> thrown = rs.solve(rs.vary(ball, {"friction": 0.5, "tangential_velocity": 0.6, "spin": 20.0}))
    >>> print(round(thrown.tangential_restitution_coefficient, 4), round(thrown.rebound_spin, 2))
    0.1078 -43.3
    """

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
    tangential_split_error: Numeric
    _march: Callable[[], dict[str, Array]] | None = field(default=None, repr=False)

    _default_outputs = (*DEFAULT_OUTPUTS, *OBLIQUE)

    @property
    def _compared(self) -> dict[str, Any]:
        return super()._compared | sliding_numbers(self.impact, self._by_name)

    @cached_property
    def _motion(self) -> dict[str, Array] | None:
        """Columns of the history of a single impact, by a march of their own."""
        return None if self._march is None else self._march()

    @cached_property
    def history(self) -> xarray.Dataset:
        """History at the times of the tangential solution, with its force, radius of sticking and velocities."""
        return self.sample(None if self._motion is None else self._motion["time"])

    @property
    def way(self) -> float:
        """Way [m] of the centre along the surface during a single impact; NaN where the body does not separate."""
        if self._motion is None or isinstance(self.impact, list):
            return math.nan
        time, velocity = self._motion["time"], self._motion["contact_point_velocity"]
        gyration = float(self.impact.gyration)
        change = float(velocity[0]) * float(time[-1]) - float(np.trapezoid(velocity, time))
        return float(self.impact.tangential_velocity) * float(time[-1]) - gyration / (1.0 + gyration) * change

    def _columns(self, times: ArrayLike | None = None, *, n_points: int = 401) -> dict[str, Array]:
        columns = super()._columns(times, n_points=n_points)
        for name, values in (self._motion or {}).items():
            if name != "time":
                columns[name] = np.interp(columns["time"], (self._motion or {})["time"], values)
        if "stick_radius" in columns:
            columns["stick_radius"] = np.minimum(columns["stick_radius"], columns["contact_radius"])
        return columns

    def plot(self, times: ArrayLike | None = None) -> Figure:
        """Return the figure of the impact, or of several e_t and the angle of the rebound.

        `times` is that of `ImpactResult.plot`, which shows the normal motion.
        """
        if times is not None or (self._march is None and not np.shape(self.status)):
            return super().plot(times)
        return draw("oblique.of_several" if np.shape(self.status) else "oblique.overview", self)

    @property
    def _short(self) -> str:
        if np.shape(self.status):
            return f"{np.size(self.status)} oblique impacts"
        angle = math.degrees(float(self.rebound_angle))
        e, e_t = float(self.restitution_coefficient), float(self.tangential_restitution_coefficient)
        return f"e = {e:.6g}, e_t = {e_t:.6g}, rebound at {angle:.4g} degrees"


def hollow_gyration(inner_radius: Any, outer_radius: Any) -> Any:
    """Return the moment of inertia of a hollow ball over m R^2, for `gyration` of `Impact`.

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


class Sliding(NamedTuple):
    """Tangential half of impacts: outputs and status by name, raveled; doubts in words; the motion of a single one."""

    columns: dict[str, Array]
    notes: tuple[str, ...]
    march: Callable[[], dict[str, Array]] | None  # of the history


def normal_rtol(rtol: float) -> float:
    """Return the tolerance of the normal half of impacts with friction."""
    return min(rtol, _NORMAL_RTOL)


def solve_sliding(
    impact: Impact, normal: dict[str, Array], rtol: float, workers: int | None = None,
    progress: Progress | None = None, solution: Solution | None = None,
) -> Sliding:  # fmt: skip
    """Solve the tangential half of impacts with friction; `normal` has the raveled outputs of their normal half.

    The tolerance of the latter is `normal_rtol`. `solution` is that of a single impact, where it is known.
    """
    columns = {name: flat(getattr(impact, name), impact.shape) for name in SLIDING}
    rows, march = _solved(impact, columns, rtol, workers, progress, solution)
    status = np.where(normal[STATUS] == Status.SEPARATED, rows.pop(STATUS), normal[STATUS])
    gaps = rows["gaps"][rows["gaps"] > _GAPS_LIMIT]
    notes = [] if not gaps.size else [
        f"disc: for {100.0 * float(gaps.max()):.2g} % of the contact time some elements slip within the radius that "
        f"sticks; the theory needs a disc{f'; in {gaps.size} of {status.size} impacts' if impact.shape else ''}"
    ]  # fmt: skip
    notes += _unbalanced(rows, max(rtol, TANGENTIAL_RTOL))
    return Sliding(_outputs(impact, normal, columns, rows) | {STATUS: status}, tuple(notes), march)


def _unbalanced(rows: dict[str, Array], rtol: float) -> list[str]:
    """Return a warning where the parts of the tangential energy do not add up, in words; e_t has its own error."""
    parts = rows["friction"] + rows["viscous"] + rows["stored"]
    residual = np.abs(parts + rows["tangential_restitution_coefficient"] ** 2 - 1.0)
    open_ = residual[residual > _BALANCE * rtol]
    if not open_.size:
        return []
    return [
        f"balance: the parts of the tangential energy miss it by {float(open_.max()):.2g} of it, above the limit "
        f"{_BALANCE * rtol:.2g}, in {open_.size} of {residual.size} impacts; take a smaller rtol to split the energy"
    ]


def join_sliding(
    impact: Impact | list[Impact], columns: dict[str, Any], rtol: float, workers: int | None = None,
    progress: Progress | None = None, solution: Solution | None = None,
) -> Sliding | None:  # fmt: skip
    """Add the outputs of the tangential half of impacts to the columns of their normal half; None without friction.

    `solution` is that of the normal half of a single impact, where it is known.
    """
    if isinstance(impact, Impact):
        if impact.friction is None:
            return None
        sliding = solve_sliding(impact, columns, rtol, workers, progress, solution)
    else:
        if any(each.friction is None for each in impact):
            return None
        rows = ({name: column[n : n + 1] for name, column in columns.items()} for n in range(len(impact)))
        parts = [solve_sliding(each, row, rtol, workers) for each, row in zip(impact, rows, strict=True)]
        joined = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
        sliding = Sliding(joined, tuple(dict.fromkeys(note for part in parts for note in part.notes)), None)
    columns |= sliding.columns
    return sliding


def contact_point(impact: Impact) -> tuple[Any, Any]:
    """Return the velocity [m/s] of the contact point at first touch, and the radius [m] of the body, NaN of two."""
    radius = impact.profile.ball_radius if impact.is_single_body else math.nan
    spin = np.asarray(impact.spin)
    return impact.tangential_velocity + np.where(spin == 0.0, 0.0, np.asarray(radius) * spin), radius


def sliding_numbers(impact: Impact | list[Impact], outputs: Mapping[str, Any]) -> dict[str, Array]:
    """Return what the decoupled theory of a patch at rest leaves out, for the validity report.

    Dundurs' parameter over friction, 0 where a rigid body would slide to the end, and the way of the centre over the
    largest contact radius. The velocity of the centre after the impact is estimated as that of a rigid body, whose
    contact point then rests, e_t = 0, or slides.
    """

    def numbers(single: Impact) -> list[Any]:
        beta = dundurs_parameter(single.material, single.counter_material)
        return [*(getattr(single, name) for name in SLIDING), single.velocity, contact_point(single)[0], beta]

    friction, along, _, gyration, velocity, point, beta = map(np.asarray, of_each(impact, numbers))
    e, time, radius = (np.asarray(outputs[name]) for name in (
        "restitution_coefficient", "contact_time", "max_contact_radius"
    ))  # fmt: skip
    share = gyration / (1.0 + gyration)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slides = friction * (1.0 + e) * velocity
        rests = share * np.abs(point)
        after = along - np.sign(point) * np.minimum(slides, rests)
        way = np.maximum(np.abs(along), np.abs(after)) * time
        # A body that stays has no way of its own during the contact.
        way = np.where(np.isfinite(time), way, np.nan)
        coupling = np.where((slides < rests) | (beta == 0.0), 0.0, np.abs(beta) / friction)
        return {"coupling_number": coupling, "travel_number": np.where(way == 0.0, 0.0, way / radius)}


def _solved(
    impact: Impact, columns: dict[str, Array], rtol: float, workers: int | None, progress: Progress | None,
    solution: Solution | None,
) -> tuple[dict[str, Array], Callable[[], dict[str, Array]] | None]:  # fmt: skip
    """Solve all rows; return what they give by name, with the status, and the march of the history of a single one."""
    problem, shape, limit = impact.normal, impact.shape, max(rtol, TANGENTIAL_RTOL)
    size, done, sliders = columns["friction"].size, list[int](), Sliders(problem)
    rows = {name: np.full(size, np.nan) for name in (*_ROW, STATUS)}
    velocity = flat(contact_point(impact)[0], shape)
    # Rows of the same normal impact share its solution.
    places = np.broadcast_to(np.arange(math.prod(problem.shape)).reshape(problem.shape), shape).reshape(-1)
    order = np.argsort(places, kind="stable")
    alike = np.split(order, np.flatnonzero(np.diff(places[order])) + 1) if size else []
    tasks = [rows_of[n : n + _TASK] for rows_of in alike for n in range(0, rows_of.size, _TASK)]
    marches = list[Callable[[], dict[str, Array]]]()

    def run(mine: NDArray[np.intp]) -> None:
        place = int(places[mine[0]])
        ready = None if solution is None else sliders.on(place, solution)
        status, slider = (Status.SEPARATED, ready) if ready is not None else sliders.solve(place, rtol)
        rows[STATUS][mine] = status
        done.append(mine.size)
        if slider is None:
            return
        for n in mine.tolist():
            speed, friction, kappa = (float(each[n]) for each in (velocity, columns["friction"], columns["gyration"]))
            slope = math.inf if friction == 0.0 else abs(speed) / friction / slider.solution.velocity
            mobility = 1.0 + 1.0 / kappa
            known = slider.solve(slope, mobility, limit) if speed else _at_rest(slider.solution)
            _write(rows, n, slider, known, limit)
            if not shape:
                marches.append(partial(_motion, slider, slope, mobility, known, speed))

    def report() -> None:
        if progress is not None:
            progress(sum(done), size)

    # The first impact compiles the kernel.
    for mine in tasks[:1]:
        run(mine)
    if len(tasks) > 1:
        on_threads(run, tasks[1:], workers, report)
    report()
    return rows, marches[0] if marches else None


def _at_rest(solution: Solution) -> Tangential:
    """Return the motion of a contact point that rests and feels no force."""
    motion = np.zeros((2, len(MOTION)))
    motion[:, 0], motion[:, 3] = (0.0, solution.end), math.inf
    return Tangential(math.nan, 0.0, 0.0, 0.0, 0.0, 0.0, motion, 0.0)


def _write(rows: dict[str, Array], n: int, slider: Slider, tangential: Tangential, rtol: float) -> None:
    """Write the numbers of a row, NaN where the tolerance is not reached."""
    if not tangential.error <= rtol:
        rows[STATUS][n] = Status.NOT_ACCURATE
        return
    for name, value in zip(_SOLVED, tangential[:6], strict=True):
        rows[name][n] = value
    time, _, _, radius, slip = tangential.motion.T
    # Where nothing slips, all steps count, also the last one, at whose end the radius is 0.
    stick = _time_of_sticking(time, radius) if slip.any() else float(time[-1])
    rows["stick"][n] = stick * slider.solution.units.time
    rows["gaps"][n], rows["impulse"][n] = tangential.gaps, slider.impulse


def _time_of_sticking(time: Array, radius: Array) -> float:
    """Return the time in which some of the contact sticks, from the radius at the ends of steps.

    A disc ends within a step, where the line through the last squares of its radius vanishes. Steps in which one
    begins count as a whole, which is nearest to marches of 6144 steps: a disc below an element does not show.
    """
    steps, square = np.diff(time), radius * radius
    sticks = radius > 0.0
    shares = sticks[1:].astype(np.float64)
    last = np.flatnonzero(sticks[:-1] & ~sticks[1:])
    last = last[last > 0]
    fall = np.maximum(square[last - 1] - square[last], 0.0) * steps[last] / steps[last - 1]
    shares[last] = square[last] / np.maximum(fall, square[last])
    return float(steps @ shares)


def _motion(slider: Slider, slope: float, mobility: float, known: Tangential, velocity: float) -> dict[str, Array]:
    """Return the columns of the history in SI."""
    solution = slider.solution
    time, speed, force, radius, slip = slider.history(slope, mobility, known).T
    return {
        "time": np.minimum(time * solution.units.time, solution.contact_time),
        "contact_point_velocity": speed * velocity,
        "tangential_force": force * (velocity * solution.mass / solution.units.time),
        "stick_radius": radius * solution.units.radius,
        "slip_velocity": slip * abs(velocity),
    }


class _Part(NamedTuple):
    """Rows of normal impacts that one batch holds; G* of each, or of all, and where E*/G* rises all the time."""

    batch: Batch
    spectrum: PronySeries
    rises: NDArray[np.bool_]

    @classmethod
    def of(cls, impact: Impact) -> _Part:
        material, counter, shape = impact.material, impact.counter_material, impact.shape
        spectrum = reduced_shear_modulus(material, counter)
        if spectrum.shape:
            spectrum = spectrum.broadcast_to(shape).reshaped((math.prod(shape),))
        rises = np.broadcast_to(_ratio_rises(material, counter), shape).reshape(-1)
        return cls(Batch.from_impact(impact), spectrum, rises)

    def slider(self, row: int, solution: Solution) -> Slider:
        """Return the solver on the solution of a row."""
        spectrum = self.spectrum.row(row) if self.spectrum.shape else self.spectrum
        return Slider(solution, spectrum, bool(self.rises[row]))


class Sliders:
    """Solvers of the tangential half of impacts, on the solutions of their normal half.

    What belongs to all rows of an array is computed once. `n` is a place in the raveled shape.
    """

    def __init__(self, impact: Impact) -> None:
        self._of = dict[int, tuple[_Part, int]]()
        for places, rows in impact.parts():
            part = _Part.of(rows)
            self._of |= {n: (part, row) for row, n in enumerate(places.tolist())}

    def on(self, n: int, solution: Solution) -> Slider:
        """Return the solver on the solution of a row."""
        part, row = self._of[n]
        return part.slider(row, solution)

    def solve(self, n: int, rtol: float) -> tuple[Status, Slider | None]:
        """Solve the normal half of a row; return its status, and the solver if the body separates."""
        part, row = self._of[n]
        status, solution = part.batch.solve_row(row, normal_rtol(rtol))
        return status, None if solution is None else part.slider(row, solution)


def _ratio_rises(material: Material, counter: Material | None) -> Any:
    """Return whether E*/G* rises all the time from that of the instantaneous to that of the static moduli."""
    bodies, bulk = [material] if counter is None else [material, counter], material.bulk
    constant = bulk.is_elastic if isinstance(bulk, PronySeries) else True
    if counter is not None:
        constant = constant & _equal(material, counter)
    return reduce(np.logical_and, [body.is_incompressible for body in bodies]) | constant


def _equal(material: Material, counter: Material) -> Any:
    """Return whether the moduli of two materials are the same, of each pair of two arrays."""
    same: Any = True
    for first, other in ((material.shear, counter.shear), (material.bulk, counter.bulk)):
        if not isinstance(first, PronySeries) or not isinstance(other, PronySeries):
            same = same & (first is other or first == other)
        elif first.branch_moduli.shape[-1] != other.branch_moduli.shape[-1]:
            return False
        else:
            for name in ("equilibrium_modulus", "parallel_viscosity"):
                same = same & (np.asarray(getattr(first, name)) == np.asarray(getattr(other, name)))
            for name in ("branch_moduli", "relaxation_times"):
                same = same & (getattr(first, name) == getattr(other, name)).all(axis=-1)
    return same


def _outputs(
    impact: Impact, normal: dict[str, Array], columns: dict[str, Array], rows: dict[str, Array]
) -> dict[str, Array]:
    """Return the outputs in SI by name; see `docs/theory/oblique.md` for the kinematics."""
    velocity, radius = (flat(value, impact.shape) for value in contact_point(impact))
    kappa, mass, v0 = columns["gyration"], flat(impact.mass, impact.shape), flat(impact.velocity, impact.shape)
    e, contact_time = normal["restitution_coefficient"], normal["contact_time"]
    e_t, solved = rows["tangential_restitution_coefficient"], ~np.isnan(rows["tangential_error"])
    change = np.where(velocity == 0.0, np.where(solved, 0.0, np.nan), (1.0 + e_t) * velocity)
    along = columns["tangential_velocity"] - kappa / (1.0 + kappa) * change
    tangential_mass = mass * kappa / (1.0 + kappa)
    before = 0.5 * tangential_mass * velocity * velocity
    after = 0.5 * tangential_mass * (velocity - change) ** 2
    parts = {name: rows[name] * before for name in ("friction", "viscous", "stored")}
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = np.where(velocity == 0.0, 0.0, (sum(parts.values()) + after - before) / before)
        spin = columns["spin"] - change / ((1.0 + kappa) * radius)
    return {
        "tangential_restitution_coefficient": e_t,
        "rebound_tangential_velocity": along,
        "rebound_spin": spin,
        "rebound_angle": np.where(solved, np.arctan2(along, e * v0), np.nan),
        "impulse_ratio": tangential_mass * change / (mass * v0 * rows["impulse"]),
        "stick_time": rows["stick"],
        "slip_time": np.where(solved, np.maximum(contact_time - rows["stick"], 0.0), np.nan),
        "tangential_energy_in": before,
        "tangential_energy_out": after,
        "friction_energy": parts["friction"],
        "tangential_dissipated_energy": parts["viscous"],
        "tangential_stored_energy": parts["stored"],
        "tangential_energy_residual": np.where(solved, residual, np.nan),
        "tangential_error": rows["tangential_error"],
        "tangential_split_error": rows["tangential_split_error"],
    }
