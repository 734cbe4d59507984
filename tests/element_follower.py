"""Single elements followed alone through a program of straight lines: closed exponentials, bracketed events.

Shares no code with the kernel. An element of E*(t) = Einf + sum E_k exp(-t/tau_k) is named by the depth s at which the
virgin surface is touched. In contact its branches obey l' = E d' - l/tau; free, the branches relax under zero load.
"""

import math

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq


class Follower:
    """Elements of one material under a depth of straight lines through points."""

    def __init__(self, equilibrium, moduli, times, knots, depths):
        self.equilibrium, self.moduli = equilibrium, np.asarray(moduli, float)
        self.rates = 1.0 / np.asarray(times, float)
        self.knots, self.depths = np.asarray(knots, float), np.asarray(depths, float)
        glass = equilibrium + self.moduli.sum()
        # Free: 0 = Einf W + sum l, so E0 W' = sum l/tau and l_k' = E_k W' - l_k/tau_k: a linear system in l.
        self.system = np.outer(self.moduli, self.rates) / glass - np.diag(self.rates)
        values, vectors = np.linalg.eig(self.system)
        assert np.abs(values.imag).max() < 1e-9
        self.modes, self.values, self.inverse = vectors.real, values.real, np.linalg.inv(vectors).real

    def free(self, loads, elapsed):
        """Return the loads of the branches of a free element after a time."""
        return self.modes @ (np.exp(self.values * elapsed) * (self.inverse @ loads))

    def surface(self, loads, displacement, elapsed):
        """Return the displacement of a free element: E0 dW = sum over branches of what relaxed."""
        if self.equilibrium > 0.0:
            return -self.free(loads, elapsed).sum() / self.equilibrium
        # A liquid: W' = sum l/(tau E0), integrated in the modes; a mode with eigenvalue 0 carries nothing.
        weights = (self.rates @ self.modes) / self.moduli.sum()
        parts = self.inverse @ loads
        x = self.values * elapsed
        growth = np.where(np.abs(x) < 1e-12, elapsed, np.expm1(x) / np.where(self.values == 0.0, 1.0, self.values))
        return displacement + float(weights @ (parts * growth))

    def contact(self, loads, rate, elapsed):
        """Return the loads of the branches in contact after a time at a constant rate of depth."""
        x = self.rates * elapsed
        return loads * np.exp(-x) + self.moduli * rate * -np.expm1(-x) / self.rates

    def load(self, s, time):
        """Return the line load q of the element s at a time."""
        loads, touching, displacement = np.zeros(self.moduli.size), False, 0.0
        for n in range(self.knots.size - 1):
            now, stop = self.knots[n], min(self.knots[n + 1], time)
            if stop <= now:
                break
            rate = (self.depths[n + 1] - self.depths[n]) / (self.knots[n + 1] - self.knots[n])
            start = now
            depth_at = lambda t, n=n, rate=rate: self.depths[n] + rate * (t - self.knots[n])  # noqa: E731
            while now < stop:
                grid = now + (stop - now) * np.linspace(0.0, 1.0, 65)
                if touching:
                    f = lambda e, l=loads, t=now: (  # noqa: E731
                        self.equilibrium * (depth_at(t + e) - s) + self.contact(l, rate, e).sum()
                    )
                else:
                    f = lambda e, l=loads, t=now, w=displacement: self.surface(l, w, e) + s - depth_at(t + e)  # noqa: E731
                values = np.array([f(t - now) for t in grid])
                scale = 1e-14 * max(1.0, np.abs(values).max())
                bad = np.flatnonzero(values[1:] < -scale)
                if bad.size == 0:
                    if touching:
                        loads = self.contact(loads, rate, stop - now)
                        displacement = depth_at(stop) - s
                    else:
                        displacement = self.surface(loads, displacement, stop - now)
                        loads = self.free(loads, stop - now)
                    now = stop
                    continue
                i = int(bad[0])
                low, high = grid[i] - now, grid[i + 1] - now
                e = brentq(f, low, high, xtol=1e-15, rtol=8.9e-16) if f(low) > 0.0 else low
                if touching:
                    loads = self.contact(loads, rate, e)
                    displacement = depth_at(now + e) - s
                else:
                    displacement = self.surface(loads, displacement, e)
                    loads = self.free(loads, e)
                now += e
                touching = not touching
            del start
        return self.equilibrium * (displacement) + loads.sum() if touching else 0.0
