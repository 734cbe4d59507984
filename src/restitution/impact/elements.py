"""The method of the paper: independent elements and explicit Euler.

E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, The Influence of Compressibility on the Restitution
Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts, eqs. (7) to (9).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, instance, single_positive, whole
from restitution.contact.profiles import as_profile
from restitution.errors import InputError
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.solution import SampledSolution
from restitution.impact.status import Status
from restitution.kernel.outcome import LEAST_RESTITUTION
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import HISTORY

if TYPE_CHECKING:
    import xarray

# Time step, elements in contact, and columns of the elements that are or were in contact.
Snapshot = tuple[int, NDArray[np.bool_], dict[str, Array]]

MAX_STEPS = 500_000
"""Largest number of time steps; about half a minute with 800 elements."""

# Time steps per element in 3 d_m/v0, the contact time of an elastic sphere to 2 %. With 200 elements the error of e is
# then about 1e-3, mostly from the time step.
_STEPS_PER_ELEMENT = 25
_FEWEST, _MOST, _SIZING = 16, 20_000, 64


def solve_elements(impact: Impact, *, n_elements: int = 800, time_step: float | None = None) -> SampledSolution:
    """Solve an impact by the elements of the method of dimensionality reduction and explicit Euler in time.

    Parameters
    ----------
    impact : Impact
        A single impact.
    n_elements : int
        Number of elements across the largest contact, in [16, 20000]. Their spacing is `dx = 2 a_max/n_elements`, with
        a_max from a coarse run.
    time_step : float, optional
        Time step [s]. The default is the smaller of `3 d_m/(25 v0 n_elements)`, which makes the error first order in
        `1/n_elements`, and half of the longest step with which explicit Euler does not overshoot. A longer step than
        this longest one, or more than `MAX_STEPS` steps, are an `InputError`.

    Returns
    -------
    SampledSolution
        In SI units. `restitution_error` is an estimate of the error of e, not a bound: the difference from a run with
        half as many elements and twice the time step; NaN if that step is too long. In the paper's plane it is within
        a few percent of the true error, except where e is below 0.01.

    Notes
    -----
    On the paper's material, a standard solid that is elastic in bulk, these are the equations (7) to (9) of the page
    Problem of the theory. On any other material an element is a spring, a dashpot and Maxwell branches in parallel,
    with the reduced modulus. An element whose force would become negative leaves contact for good; the impact ends
    when all elements have left. The body is CAPTURED if it moves inwards again before that. A liquid, or a target with
    an impedance, that gives back e < 1e-6 holds the body, as in the method "exact".
    """
    foundation, spacing, step, sizes = _laid_out(impact, n_elements, time_step)
    solution = foundation.march(spacing, step)
    if 2.0 * step > sizes.limit:
        return solution
    half = foundation.march(2.0 * spacing, 2.0 * step)
    return solution._replace(restitution_error=abs(solution.restitution_coefficient - half.restitution_coefficient))


def element_history(
    impact: Impact, *, n_elements: int = 800, time_step: float | None = None, n_times: int = 200
) -> xarray.Dataset:
    """Return the displacements and forces of the elements of the paper's model over time.

    Parameters
    ----------
    impact, n_elements, time_step
        As in `solve` with the method "elements".
    n_times : int
        Approximate number of times, >= 2.

    Returns
    -------
    xarray.Dataset
        Over `time` [s] and `position` [m], the distance x > 0 of an element from the axis; each element stands for its
        mirror image as well. `displacement` u and, on the paper's material, the inner displacements `u1`, `u2`, `u3`
        [m] of equations (7) and (8) of the paper, NaN while an element is not in contact; its `force` F [N], zero
        then. The contact force is twice the sum of the forces.

    Raises
    ------
    InputError
        As `solve` with the method "elements", and if `n_times` is below 2.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    >>> impact = rs.Impact(material=solid, profile=rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)
    >>> elements = element_history(impact, n_elements=50)
    >>> sorted(elements.data_vars)
    ['displacement', 'force', 'u1', 'u2', 'u3']
    """
    import xarray as xr

    whole("n_times", n_times, 2, 10_000_000)
    foundation, spacing, step, sizes = _laid_out(impact, n_elements, time_step)
    snapshots: list[Snapshot] = []
    foundation.march(spacing, step, snapshots, every=max(1, round(sizes.duration / (step * n_times))))
    count = max(touching.size for _, touching, _ in snapshots)
    words = {"displacement": "displacement u of an element", "force": "force F of an element"}
    described: dict[str, Any] = {}
    for name in snapshots[-1][2]:
        values = np.full((len(snapshots), count), 0.0 if name == "force" else np.nan)
        for row, (_, touching, columns) in enumerate(snapshots):
            values[row, : touching.size][touching] = columns[name][touching]
        unit, long_name = "N" if name == "force" else "m", words.get(name, f"inner displacement {name}")
        described[name] = ("time", "position"), values, {"units": unit, "long_name": long_name}
    time = ("time", step * np.array([float(n) for n, *_ in snapshots]), HISTORY["time"].attributes)
    distances = (np.arange(count) + 0.5) * spacing
    position = ("position", distances, {"units": "m", "long_name": "distance x from the axis"})
    attributes = {"spacing": spacing, "time_step": step, "references": "Willert et al., eqs. (7) and (8)"}
    return xr.Dataset(described, {"time": time, "position": position}, attributes)


def _laid_out(impact: Impact, n_elements: Any, time_step: Any) -> tuple[_Foundation, float, float, _Sizes]:
    """Check the options; return the foundation, the spacing [m], the time step [s] and the sizes of a coarse run."""
    whole("n_elements", n_elements, _FEWEST, _MOST)
    if instance("impact", impact, Impact, "must be an Impact").shape != ():
        raise InputError("impact.shape", impact.shape, "must be () for the method of elements: a single impact")
    fixed = None if time_step is None else single_positive("time_step", time_step, "s")
    foundation = _Foundation(impact)
    sizes = foundation.measure(n_elements)
    step = min(sizes.fitting_step(n_elements), 0.5 * sizes.limit) if fixed is None else fixed
    sizes.admit(n_elements, step, automatic=fixed is None)
    return foundation, 2.0 * sizes.radius / n_elements, step, sizes


class _Sizes(NamedTuple):
    """Largest depth [m] and contact radius [m], duration [s], and the longest time step [s] for the relaxation."""

    depth: float
    velocity: float
    radius: float
    duration: float
    relaxation_limit: float

    @property
    def limit(self) -> float:
        return min(self.relaxation_limit, self.fitting_step(_FEWEST))

    def fitting_step(self, n_elements: int) -> float:
        return 3.0 * self.depth / (_STEPS_PER_ELEMENT * n_elements * self.velocity)

    def admit(self, n_elements: int, step: float, *, automatic: bool) -> None:
        """Refuse a time step that is too long, or too short for `MAX_STEPS` steps, with a remedy."""
        limit, steps, least = self.limit, self.duration / step, self.duration / MAX_STEPS
        if step > limit:
            raise InputError("time_step", step, f"must be <= {limit:.3g} s here, for explicit Euler", "s")
        if steps <= MAX_STEPS:
            return
        remedy = f"take time_step in [{least:.3g}, {limit:.3g}] s"
        if least > limit:
            remedy = f"explicit Euler needs time_step <= {limit:.3g} s, so use method 'exact'"
        elif automatic and least <= 0.5 * limit:
            remedy = f"take n_elements <= {int(n_elements * MAX_STEPS / steps)}, or {remedy[5:]}"
        rule = f"must not need more than {MAX_STEPS} time steps, and {step:.3g} s makes {steps:.2g}; {remedy}"
        raise InputError("n_elements, time_step", (n_elements, step), rule)


class _Foundation:
    def __init__(self, impact: Impact) -> None:
        self.profile = as_profile(impact.profile, "method 'elements'")
        self.impact, self.series = impact, impact.reduced_modulus
        self.mass, self.velocity = float(impact.mass), float(impact.velocity)
        self.load, self.admittance = float(impact.external_force), 1.0 / float(impact.impedance)

    def measure(self, n_elements: int) -> _Sizes:
        """Return depth, radius and duration of a coarse run, which starts from an elastic estimate."""
        block = Batch.from_impact(self.impact).scaled()
        depth = float(block.firsts[0] ** 2 * block.length[0])
        sizes = self.sizes(depth, 3.0 * depth / self.velocity)
        step = min(sizes.fitting_step(_SIZING), sizes.limit)
        sizes.admit(n_elements, step, automatic=False)
        coarse = self.march(2.0 * sizes.radius / _SIZING, step)
        return self.sizes(coarse.max_indentation_depth, float(coarse.time[-1]))

    def sizes(self, depth: float, duration: float) -> _Sizes:
        radius = float(self.profile.contact_radius(depth))
        # Explicit Euler is stable below twice the shortest relaxation time, and below 2/drag of dashpots and target.
        glass = self.series.equilibrium_modulus + float(self.series.branch_moduli.sum())
        drag = 2.0 * radius * max(self.series.parallel_viscosity / self.mass, glass * self.admittance)
        shortest = float(self.series.relaxation_times.min(initial=math.inf))
        return _Sizes(depth, self.velocity, radius, duration, min(shortest, 1.0 / drag if drag > 0.0 else math.inf))

    def march(
        self, spacing: float, step: float, snapshots: list[Snapshot] | None = None, every: int = 1
    ) -> SampledSolution:
        """March by explicit Euler; elements at (i + 1/2) dx, each for its mirror image too; keep `snapshots`."""
        law = element_law(self.impact.material, self.impact.counter_material, self.series)
        g, u, contact = np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool)
        d, v, deepest, n, dissipated, stored = 0.0, self.velocity, 0.0, 0, 0.0, 0.0
        may_rest = self.series.is_liquid or self.load > 0.0
        rows: list[tuple[float, float, float, float]] = []
        while True:
            while g.size == 0 or g[-1] <= d:
                g = self._depths_of_touch(max(2 * g.size, _SIZING), spacing)
                u, contact = padded(u, g.size), padded(contact, g.size)
                law.grow(g.size)
            if d >= deepest:
                deepest, born = d, int(np.searchsorted(g, d, side="right"))
                contact[n:born], n = True, max(n, born)
            # An element that d has passed since the last step begins with the rest of that step.
            touching, displacement = contact[:n], u[:n]
            growth = d - g[:n] - displacement
            displacement += growth
            law.advance(displacement, growth, step)
            # The dashpots and the velocity of the target depend on each other, and both are linear.
            recoil, drag = 2.0 * spacing * self.admittance, self.series.parallel_viscosity
            elastic = float(law.line_load(displacement, 0.0) @ touching) if recoil else 0.0
            rate = (v - recoil * elastic) / (1.0 + recoil * drag * int(np.count_nonzero(touching)))
            line_load = law.line_load(displacement, rate)
            leaving = touching & (line_load < 0.0)
            if leaving.any():
                touching &= ~leaving
                stored += 2.0 * spacing * float(law.energy(displacement) @ leaving)
            force = 2.0 * spacing * float(line_load @ touching)
            rate = v - self.admittance * force
            dissipated += 2.0 * spacing * step * float(law.dissipation(displacement, rate) @ touching)
            radius = spacing * int(np.count_nonzero(touching))
            if snapshots is not None and len(rows) % every == 0:
                columns = {"displacement": displacement.copy(), "force": spacing * line_load, **law.inner(n)}
                snapshots.append((len(rows), touching.copy(), columns))
            rows.append((d, rate, force, radius))
            if n > 0 and radius == 0.0:
                status = Status.SEPARATED
                break
            returns = self.load > 0.0 and rate > 0.0 and d < deepest
            if returns or (may_rest and self.is_over(len(rows) * step, radius)):
                status = Status.CAPTURED if returns or not self.series.is_liquid else Status.SINKS_IN
                stored += 2.0 * spacing * float(law.energy(displacement) @ touching)
                break
            if len(rows) > MAX_STEPS:
                rule = f"must be longer: the contact needs more than {MAX_STEPS} steps; or use method 'exact'"
                raise InputError("time_step", step, rule, "s")
            d, v = d + step * rate, v + step * (self.load - force) / self.mass
        return self._solution(rows, step, status, dissipated, stored)

    def _solution(
        self, rows: list[tuple[float, float, float, float]], step: float, status: Status, dissipated: float,
        stored: float,
    ) -> SampledSolution:  # fmt: skip
        """Return the solution whose rows are depth, rate, force and contact radius at each step."""
        depths, velocities, forces, radii = np.array(rows).T
        e = max(0.0, -float(velocities[-1]) / self.velocity)
        fades = self.load == 0.0 and (self.series.is_liquid or self.admittance > 0.0)
        if status is Status.SEPARATED and fades and e < LEAST_RESTITUTION:
            status = Status.SINKS_IN if self.series.is_liquid else Status.CAPTURED
        left, time = status is Status.SEPARATED, step * np.arange(depths.size)
        return SampledSolution(
            time, depths, velocities, forces, radii,
            restitution_coefficient=e if left else 0.0,
            contact_time=float(time[-1]) if left else math.inf,
            max_indentation_depth=float(depths.max()),
            max_force=float(forces.max()),
            max_contact_radius=float(self.profile.contact_radius(depths.max())),
            residual_indentation_depth=float(depths[-1]), status=status, time_step=step,
            dissipated=dissipated, stored=stored, radiated=step * self.admittance * float(forces @ forces),
        )  # fmt: skip

    def _depths_of_touch(self, size: int, spacing: float) -> Array:
        """Return the depths [m] at which the first elements are touched; infinite beyond the end of the profile."""
        g, x = np.full(size, np.inf), (np.arange(size) + 0.5) * spacing
        described = x <= self.profile.max_contact_radius
        g[described] = self.profile.transform(x[described])
        return g

    def is_over(self, time: float, radius: float) -> bool:
        """Return whether 20 times the slowest decay has passed, after which 2e-9 of the transients is left."""
        if radius == 0.0:
            return False
        series, slowest = self.series, float(self.series.relaxation_times.max(initial=0.0))
        drag, stiffness = series.flow_viscosity, series.equilibrium_modulus
        if stiffness > 0.0:
            decay = (slowest * (stiffness + float(series.branch_moduli.sum())) + drag) / stiffness
            decay += math.sqrt(self.mass / (2.0 * stiffness * radius))
        else:
            decay = slowest + self.mass / (2.0 * drag * radius)
        return time > 20.0 * decay


class StandardSolidElement:
    """Equations (8) of the paper, for a standard solid in shear that is elastic in bulk; `u2 = u` for infinite k0."""

    def __init__(self, ginf: float, g1: float, eta: float, k0: float) -> None:
        self.ginf, self.g1, self.eta, self.k0 = ginf, g1, eta, k0
        self.u1 = self.u2 = self.u3 = np.zeros(0)

    def grow(self, size: int) -> None:
        """Make room for `size` elements; new ones are undeformed."""
        self.u1, self.u2, self.u3 = (padded(x, size) for x in (self.u1, self.u2, self.u3))

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Advance u1, u2, u3 by a step [s] to the displacements u [m], which have grown by du [m]."""
        ginf, g1, k0 = self.ginf, self.g1, self.k0
        u1, u2, u3 = self.u1[: u.size], self.u2[: u.size], self.u3[: u.size]
        # The first of (8) gives u3 = u2 + lag after the step, the second u1, and the third then u2.
        lag = u3 - u2 - (step * g1 / self.eta) * u3
        u1 += du - (step * g1 / self.eta) * (u1 - u2)
        if math.isinf(k0):
            u2[:] = u
        else:
            stiffness = g1 + ginf + (ginf / 3.0 + k0) + g1 / 3.0
            u2[:] = ((ginf / 3.0 + k0) * u + (g1 / 3.0) * u1 - g1 * lag) / stiffness
        u3[:] = u2 + lag

    def line_load(self, u: Array, v: float | Array) -> Array:
        """Force per length 4 (Ginf u2 + G1 u3) [N/m] at the displacements u [m] and the velocity v [m/s]."""
        return 4.0 * (self.ginf * self.u2[: u.size] + self.g1 * self.u3[: u.size])

    def dissipation(self, u: Array, v: float) -> Array:
        """Return the power per length [W/m] that the dashpots eta and eta/3 dissipate."""
        power = self.u3[: u.size] ** 2
        if not math.isinf(self.k0):
            power += (self.u1[: u.size] - self.u2[: u.size]) ** 2 / 3.0
        return (4.0 * self.g1**2 / self.eta) * power

    def energy(self, u: Array) -> Array:
        """Return the energy per length [J/m] of the five springs."""
        u1, u2, u3 = self.u1[: u.size], self.u2[: u.size], self.u3[: u.size]
        energy = self.g1 * u3**2 + self.ginf * u2**2
        if not math.isinf(self.k0):
            energy += (self.ginf / 3.0 + self.k0) * (u2 - u) ** 2 + (self.g1 / 3.0) * (u2 - u1) ** 2
        return 2.0 * energy

    def inner(self, n: int) -> dict[str, Array]:
        """Return the inner displacements [m] of the first n elements by name."""
        return {"u1": self.u1[:n].copy(), "u2": self.u2[:n].copy(), "u3": self.u3[:n].copy()}


class MaxwellElement:
    """Spring, dashpot and Maxwell branches: `F/dx = E_inf u + viscosity u' + sum E_k w_k`, `w_k' = u' - w_k/tau_k`."""

    def __init__(self, series: PronySeries) -> None:
        self.equilibrium, self.viscosity = series.equilibrium_modulus, series.parallel_viscosity
        self.moduli, self.times = series.branch_moduli, series.relaxation_times[:, None]
        self.w = np.zeros((self.moduli.size, 0))

    def grow(self, size: int) -> None:
        """Make room for `size` elements; new ones are undeformed."""
        self.w = padded(self.w, size)

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Advance w_k by a step [s] in which the displacements u grow by du [m]."""
        w = self.w[:, : u.size]
        w += du - (step / self.times) * w

    def line_load(self, u: Array, v: float | Array) -> Array:
        """Return the force per length [N/m] of spring, dashpot and branches."""
        return self.equilibrium * u + self.viscosity * v + self.moduli @ self.w[:, : u.size]

    def dissipation(self, u: Array, v: float) -> Array:
        """Return the power per length [W/m] that all dashpots dissipate."""
        return self.viscosity * v**2 + (self.moduli / self.times[:, 0]) @ self.w[:, : u.size] ** 2

    def energy(self, u: Array) -> Array:
        """Return the energy per length [J/m] of all springs."""
        return 0.5 * (self.equilibrium * u**2 + self.moduli @ self.w[:, : u.size] ** 2)

    def inner(self, n: int) -> dict[str, Array]:
        """Return nothing: only the paper's element has such displacements."""
        return {}


def element_law(
    material: Material, counter_material: Material | None, series: PronySeries
) -> StandardSolidElement | MaxwellElement:
    """Return the paper's element for the paper's material, and the element of the reduced modulus for any other."""
    shear, bulk = material.shear.simplified(), material.bulk
    rigid, relaxing = counter_material is None, isinstance(bulk, PronySeries) and not bulk.is_elastic
    if not rigid or relaxing or shear.n_branches != 1 or shear.parallel_viscosity > 0.0:
        return MaxwellElement(series)
    branch, time = float(shear.branch_moduli[0]), float(shear.relaxation_times[0])
    k0 = bulk.equilibrium_modulus if isinstance(bulk, PronySeries) else math.inf
    return StandardSolidElement(shear.equilibrium_modulus, branch, branch * time, k0)


def padded(array: NDArray[Any], size: int) -> NDArray[Any]:
    """Return the array with zeros added to its last axis up to `size`."""
    return np.pad(array, [(0, 0)] * (array.ndim - 1) + [(0, size - array.shape[-1])])
