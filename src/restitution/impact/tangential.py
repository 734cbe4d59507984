"""Tangential motion of one impact: full sliding recognised, no slip by collocation, else elements to a tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.impact.solution import D_, H_, S_, T_, V_, Solution
from restitution.impact.sticking import Spectrum, solve_sticking
from restitution.material.prony import PronySeries
from restitution.numerics.richardson import Richardson

# Steps in each half of the coarsest and of the finest march.
FEWEST, MOST = 25, 3200
# Steps in each half of a march from which the contact counts as sliding throughout if no element ever stuck.
_SURE = 200
# Numbers of a march that are extrapolated.
_EXTRAPOLATED = ("restitution", "friction", "viscous", "stored")
# Slopes below the first have a slipping rim so thin that e_t is linear; it is interpolated from the second on.
_THIN, _NEAR = 0.01, 0.02
# Columns of `motion`.
MOTION = ("time", "velocity", "force", "stick_radius", "slip_velocity")


class Tangential(NamedTuple):
    """Tangential half of an impact, scaled by the normal one, for a direction in which the contact point first moves.

    Velocities are over that of the contact point at first touch, energies over its energy `v^2/(2 mobility)`.
    `restitution` is e_t, `error` the estimate of its error. `motion` has the columns `MOTION`.
    """

    restitution: float
    error: float
    friction: float
    viscous: float
    stored: float
    motion: Array
    gaps: float  # share of the contact time in which elements slip within the radius that sticks


@dataclass(frozen=True, eq=False)
class Slider:
    """Solver of the tangential half on the stored normal solution of one impact.

    Parameters
    ----------
    solution : Solution
        The normal impact.
    spectrum : PronySeries
        Reduced shear modulus G*(t) [Pa].
    modulus : PronySeries
        Reduced modulus E*(t) [Pa] of the solution.
    ratios : tuple of float, optional
        Instantaneous and static E*/G*, between which the ratio rises all the time; None where this is not known.
    """

    solution: Solution
    spectrum: PronySeries
    modulus: PronySeries
    ratios: tuple[float, float] | None = None

    @property
    def scaled(self) -> Spectrum:
        """The reduced shear modulus in the units of the solution."""
        units, modulus, series = self.solution.units, self.modulus, self.spectrum
        glass = float(modulus.equilibrium_modulus) + float(modulus.branch_moduli.sum())
        if glass > 0.0:
            factor = (units.equilibrium + float(units.moduli.sum())) / glass
        else:
            factor = units.viscosity * units.time / float(modulus.parallel_viscosity)
        times = np.asarray(series.relaxation_times) / units.time
        moduli = np.asarray(series.branch_moduli) * factor
        drag = float(series.parallel_viscosity) * factor / units.time
        return Spectrum(float(series.equilibrium_modulus) * factor, drag, moduli[moduli > 0.0], times[moduli > 0.0])

    @property
    def impulse(self) -> float:
        """Impulse of the normal force over m v0, with that of a constant force."""
        rebound = -float(self.solution.stored.work.rebound[-1, V_, -1])
        return 1.0 + rebound + self.solution.units.external_force * self.solution.end

    def slides(self, slope: float, mobility: float) -> bool:
        """Return whether the whole contact slides to the end, at a slope `v_c0/(mu v0)`; False where it may not.

        In full sliding `v_c/(mu v0) = slope - mobility J` with the impulse J, and no element moves faster than
        ``mu (R_0 v + (R_inf - R_0) v0)`` with the ratio R of the moduli. Both are linear in the velocity v.
        """
        if self.ratios is None or self.solution.units.external_force > 0.0:
            return False
        glass, static = self.ratios
        spread = static - glass
        e = self.impulse - 1.0
        return slope >= static and slope - mobility * (1.0 + e) >= spread - glass * e

    def solve(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """Return the motion for ``slope = v_c0/(mu v0)``, 0 without slip, infinite without friction."""
        if slope == 0.0:
            return self._stick(mobility, rtol)
        if self.slides(slope, mobility) or math.isinf(slope):
            return self._slide(slope, mobility)
        thin = self._thin(slope, mobility, rtol) if slope < _THIN else None
        return thin if thin is not None and thin.error <= rtol else self._march(slope, mobility, rtol)

    def _thin(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """Interpolate between no slip and a march at a larger slope, as elements do not resolve a thin rim.

        e_t is linear in the slope there; the march at twice that slope shows how far. Parts of the energy have other
        values without slip, where elements leave with what a slipping rim loses, and are those of both marches.
        """
        rest = self._stick(mobility, rtol)
        near, far = (self._march(factor * _NEAR, mobility, rtol) for factor in (1.0, 2.0))
        first, second = ((each.restitution - rest.restitution) / (n * _NEAR) for n, each in ((1.0, near), (2.0, far)))
        error = rest.error + slope * (near.error / _NEAR + abs(second - first))
        share = slope / _NEAR - 1.0
        names = ("friction", "viscous", "stored")
        parts = {name: getattr(near, name) + share * (getattr(far, name) - getattr(near, name)) for name in names}
        return rest._replace(restitution=rest.restitution + slope * first, error=error, gaps=near.gaps, **parts)

    def _stick(self, mobility: float, rtol: float) -> Tangential:
        """Solve without slip."""
        sticking = solve_sticking(self.solution, self.scaled, mobility, 1e-3 * rtol)
        unit = 2.0 * mobility
        motion = np.zeros((sticking.motion.shape[0], len(MOTION)))
        motion[:, :3] = sticking.motion
        times = np.minimum(sticking.motion[:, 0], self.solution.end) * self.solution.units.time
        motion[:, 3] = self.solution.at(times).contact_radius / self.solution.units.radius
        return Tangential(
            -sticking.velocity, sticking.error, 0.0, unit * sticking.dissipated, unit * sticking.stored, motion, 0.0
        )  # fmt: skip

    def _slide(self, slope: float, mobility: float) -> Tangential:
        """Return the closed form of full sliding; the energies and the motion are those of marches."""
        e_t = -1.0 if math.isinf(slope) else -1.0 + mobility * self.impulse / slope
        if math.isinf(slope):
            motion = np.zeros((2, len(MOTION)))
            motion[:, 0], motion[:, 1], motion[:, 4] = (0.0, self.solution.end), 1.0, 1.0
            return Tangential(e_t, 0.0, 0.0, 0.0, 0.0, motion, 0.0)
        coarse, fine = (self._step(slope, mobility, count) for count in (2 * FEWEST, 4 * FEWEST))
        series = Richardson()
        _added(series, coarse)
        return _added(series, fine)._replace(restitution=e_t, error=0.0)

    def _march(self, slope: float, mobility: float, rtol: float) -> Tangential:
        """March with more and more steps until the extrapolated e_t is known to `rtol`."""
        count, series = FEWEST, Richardson()
        _added(series, self._step(slope, mobility, count))
        while True:
            count *= 2
            fine = _added(series, self._step(slope, mobility, count))
            sticks = fine.motion[:, 3].any()
            if count >= _SURE and not sticks:
                return fine._replace(restitution=-1.0 + mobility * self.impulse / slope, error=0.0)
            if (fine.error <= rtol and (sticks or count >= _SURE)) or count >= MOST:
                return fine

    def _step(self, slope: float, mobility: float, count: int) -> Tangential:
        """March with a number of steps in each half."""
        from restitution.kernel.tangential import GAPS_, Modes, Normal, allocate_room, march

        solution, units, tangential = self.solution, self.solution.units, self.scaled
        normal = _on_grid(solution, count)
        room = allocate_room(count, tangential.times.size, units.times.size)
        march(
            Normal(*normal), Modes(*tangential), Modes(units.equilibrium, units.viscosity, units.moduli, units.times),
            mobility, 1.0, slope, room,
        )  # fmt: skip
        energy = slope * slope / (2.0 * mobility)
        friction, viscous, stored = (float(each) / energy for each in room.sums[:3])
        motion = np.column_stack([normal[0], room.motion]) / np.array([1.0, slope, slope, 1.0, slope])
        gaps = float(room.sums[GAPS_]) / solution.end
        return Tangential(-float(motion[-1, 1]), math.inf, friction, viscous, stored, motion, gaps)


def _added(series: Richardson, march: Tangential) -> Tangential:
    """Return a march with the numbers that it and those before it extrapolate to, and the error of e_t."""
    values, errors = series.add([getattr(march, name) for name in _EXTRAPOLATED])
    return march._replace(error=float(errors[0]), **dict(zip(_EXTRAPOLATED, values.tolist(), strict=True)))


def _on_grid(solution: Solution, count: int) -> tuple[Array, ...]:
    """Return times, velocities, depths, memory, radii and depths of touch at equal steps of both halves."""
    places = solution.sigma_m * (np.arange(count + 1) / count)
    coming = solution.approach_at(places)
    element, inside = solution.places(solution.rebound, places[1:])
    columns = np.concatenate([coming, solution.interpolate(solution.rebound.columns, element, inside)])
    # First touch is exact.
    columns[0] = 0.0
    columns[0, V_] = 1.0
    roots = np.maximum(columns[: count + 1, S_], 0.0)
    memory = np.ascontiguousarray(columns[:, H_ + 1 :].T)
    times = np.maximum.accumulate(columns[:, T_])
    return times, columns[:, V_].copy(), columns[:, D_].copy(), memory, solution.radius(roots), roots * roots
