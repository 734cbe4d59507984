"""Single elements followed alone under a depth of straight lines, and equal elements under a force.

Closed exponentials; events are bracketed, or lie within a step.

Shares no code with the kernel. An element of E*(t) = Einf + sum E_k exp(-t/tau_k), with a dashpot eta or without, is
named by the depth s at which the virgin surface is touched. In contact its branches obey l_k' = E_k d' - l_k/tau_k;
free, they relax under zero load.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq

_PLACES = np.linspace(0.0, 1.0, 65)


@dataclass
class Element:
    """State of an element at a time, and the straight line of the depth from there on."""

    follower: "Follower"
    s: float
    loads: Any
    displacement: float
    is_touched: bool
    depth: float
    rate: float

    def after(self, elapsed: float) -> tuple[Any, float]:
        """Return loads and displacement after a time, in the same state."""
        parent, x = self.follower, self.follower.rates * elapsed
        if self.is_touched:
            loads = self.loads * np.exp(-x) + parent.moduli * self.rate * -np.expm1(-x) / parent.rates
            return loads, self.depth + self.rate * elapsed - self.s
        z = parent.values * elapsed
        if parent.viscosity > 0.0:
            state = parent.modes @ (np.exp(z) * (parent.inverse @ np.append(self.loads, self.displacement)))
            return state[:-1], float(state[-1])
        parts = parent.inverse @ self.loads
        loads = parent.modes @ (np.exp(z) * parts)
        if parent.equilibrium > 0.0:
            return loads, -loads.sum() / parent.equilibrium
        # A liquid: W' = sum l_k/(tau_k E0), integrated mode by mode; one eigenvalue is zero.
        steps = np.where(np.abs(z) < 1e-12, elapsed, np.expm1(z) / np.where(parent.values == 0.0, 1.0, parent.values))
        return loads, self.displacement + float(parent.rates @ parent.modes @ (parts * steps)) / parent.moduli.sum()

    def margin(self, elapsed: float) -> float:
        """Return the load in contact, the gap of a free element: what must not be negative."""
        loads, displacement = self.after(elapsed)
        if self.is_touched:
            parent = self.follower
            return float(parent.equilibrium * displacement + loads.sum() + parent.viscosity * self.rate)
        return float(displacement + self.s - self.depth - self.rate * elapsed)

    def advance(self, elapsed: float) -> float:
        """Move to the end of the line, or to the next change of state; return the time that has passed."""
        margins = np.array([self.margin(elapsed * place) for place in _PLACES])
        bad = np.flatnonzero(margins[1:] < -1e-14 * max(1.0, np.abs(margins).max()))
        passed = elapsed
        if bad.size:
            low, high = elapsed * _PLACES[bad[0]], elapsed * _PLACES[bad[0] + 1]
            passed = brentq(self.margin, low, high, xtol=1e-15, rtol=8.9e-16) if self.margin(low) > 0.0 else low
        self.loads, self.displacement = self.after(passed)
        self.depth += self.rate * passed
        self.is_touched ^= bool(bad.size)
        return passed


class Follower:
    """Elements of one material under a depth of straight lines through points."""

    def __init__(
        self, equilibrium: float, moduli: Any, times: Any, knots: Any, depths: Any, viscosity: float = 0.0
    ) -> None:
        self.equilibrium, self.viscosity = equilibrium, viscosity
        self.moduli, self.rates = np.array(moduli, float), 1.0 / np.array(times, float)
        self.knots, self.depths = np.array(knots, float), np.array(depths, float)
        # Free: E0 W' = sum l_k/tau_k, so that l' is linear in l.
        glass = equilibrium + self.moduli.sum()
        change = np.outer(self.moduli, self.rates) / glass - np.diag(self.rates)
        if viscosity > 0.0:
            # Free: eta W' = -(Einf W + sum l_k), with W as one more number of the state.
            slope = -np.append(np.ones(self.moduli.size), equilibrium) / viscosity
            change = np.outer(np.append(self.moduli, 1.0), slope) - np.diag(np.append(self.rates, 0.0))
        values, modes = np.linalg.eig(change)
        self.values, self.modes, self.inverse = values.real, modes.real, np.linalg.inv(modes).real
        if equilibrium == 0.0:
            self.values[np.argmin(np.abs(self.values))] = 0.0

    def load(self, s: float, time: float) -> float:
        """Return the line load of the element s at a time."""
        element = Element(self, s, np.zeros(self.moduli.size), 0.0, False, 0.0, 0.0)
        for n in range(self.knots.size - 1):
            now, stop = self.knots[n], min(self.knots[n + 1], time)
            element.depth = self.depths[n]
            element.rate = (self.depths[n + 1] - self.depths[n]) / (self.knots[n + 1] - self.knots[n])
            while now < stop:
                now += element.advance(stop - now)
        return element.margin(0.0) if element.is_touched else 0.0


def program(rng, size, lowest=-0.3):
    """Random straight lines of the depth with holds, from the surface on."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, size))])
    depths = np.concatenate([[0.0, rng.uniform(0.5, 1.0)], rng.uniform(lowest, 1.0, size - 1)])
    for n in 2 + np.flatnonzero(rng.random(size - 2) < 0.2):
        depths[n] = depths[n - 1]
    return times, depths


def followed_force(result, series, time):
    """Force by Gauss quadrature over elements followed alone.

    Between the radii of the contact at turnings and knots the load is smooth but for square roots at the ends, which
    y = low + (high - low) (3 z^2 - 2 z^3) removes.
    """
    knots = result.prescribed_history.knots
    knots = np.append(knots[knots < time], time)
    follower = Follower(series.equilibrium_modulus, series.branch_moduli, series.relaxation_times, knots,
                        result.prescribed_history(knots), series.parallel_viscosity)  # fmt: skip
    moments = np.concatenate([knots, result.turning_times[result.turning_times < time]])
    radii = np.concatenate([result.sample(moments, before=before).contact_radius.values for before in (True, False)])
    last = float(result.sample([time]).contact_radius[0])
    edges = np.unique(np.append(radii[(radii > 0.0) & (radii < last)].round(11), [0.0, last]))
    places, weights = legendre.leggauss(20)
    z, total = 0.5 * (1.0 + places), 0.0
    for low, high in pairwise(edges):
        if high - low > 1e-7:
            y, slope = low + (high - low) * (3.0 - 2.0 * z) * z * z, (high - low) * 6.0 * z * (1.0 - z)
            loads = np.array([follower.load(s, time) for s in y * y])
            total += float(0.5 * weights @ (loads * slope))
    return 2.0 * total


def pressed_elements(series, radius_of, times, forces, widest, count):
    """Return the depths of a tip under a force >= 0: elements equal in y, with one step between two times.

    Each element has W = max(d - y^2, W0) with the displacement W0 at which it has no load, and W is linear in a step;
    so `F = 2 sum K da max(d - y^2 - W0, 0)` is convex in d. Shares no code with the package.
    """
    edges = np.linspace(0.0, widest, count + 1)
    s, weights = (0.5 * (edges[1:] + edges[:-1])) ** 2, np.diff(radius_of(edges))
    rates, moduli = 1.0 / series.relaxation_times, series.branch_moduli
    surface, loads, result = np.zeros(count), np.zeros((rates.size, count)), [0.0]
    for n in range(times.size - 1):
        x = rates * (times[n + 1] - times[n])
        decay, gain = np.exp(-x), moduli * -np.expm1(-x) / x
        damping = series.parallel_viscosity / (times[n + 1] - times[n])
        stiffness = series.equilibrium_modulus + damping + gain.sum()
        free = ((damping + gain.sum()) * surface - decay @ loads) / stiffness
        # The lowest elements bear the force.
        order = np.argsort(s + free)
        levels, areas = (s + free)[order], np.cumsum(weights[order])
        sums = np.cumsum(weights[order] * levels)
        expected = forces[n + 1] / (2.0 * stiffness)
        k = int(np.searchsorted(areas * levels - sums, expected, side="right")) - 1
        result.append(levels[0] if expected <= 0.0 else (expected + sums[k]) / areas[k])
        after = np.maximum(result[-1] - s, free)
        loads, surface = decay[:, None] * loads + gain[:, None] * (after - surface), after
    return np.array(result)
