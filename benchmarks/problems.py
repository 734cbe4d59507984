"""Random impacts for the measurement of speed, from the domains with a stated target."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from restitution import (
    Impact,
    Material,
    Parabola,
    PronySeries,
    solve,
    standard_solid,
    standard_solid_restitution,
)
from restitution.contact.profiles import Profile
from restitution.errors import RestitutionWarning

Array = NDArray[np.float64]


class Problems(Protocol):
    """Impacts for a public array call."""

    @property
    def size(self) -> int:
        """Number of impacts."""
        ...

    def solve(self, rtol: float, workers: int = 1) -> Array:
        """Restitution coefficients."""
        ...

    def copies(self, n: int, count: int) -> Problems:
        """Impact n, `count` times."""
        ...


@dataclass(frozen=True)
class StandardSolids:
    """The paper's problem for arrays of its three dimensionless groups."""

    nu: Array
    p2: Array
    p3: Array

    @property
    def size(self) -> int:
        """Number of impacts."""
        return self.nu.size

    def solve(self, rtol: float, workers: int = 1) -> Array:
        """Restitution coefficients, in one call."""
        return standard_solid_restitution(self.nu, self.p2, self.p3, rtol=rtol, workers=workers)

    def copies(self, n: int, count: int) -> StandardSolids:
        """Impact n, `count` times."""
        return StandardSolids(*(np.full(count, column[n]) for column in (self.nu, self.p2, self.p3)))

    def first(self, count: int) -> StandardSolids:
        """Return the first `count` points."""
        return StandardSolids(self.nu[:count], self.p2[:count], self.p3[:count])


@dataclass(frozen=True)
class Impacts:
    """Arrays of impacts, each of one material and one profile."""

    arrays: tuple[Impact, ...]

    @cached_property
    def _ends(self) -> Array:
        return np.cumsum([math.prod(impact.shape) for impact in self.arrays])

    @property
    def size(self) -> int:
        """Number of impacts."""
        return int(self._ends[-1])

    def solve(self, rtol: float, workers: int = 1) -> Array:
        """Restitution coefficients, in one call for each array."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RestitutionWarning)  # random bodies exceed the limits of the theory
            results = [solve(impact, rtol=rtol, workers=workers) for impact in self.arrays]
        return np.concatenate([np.asarray(result.restitution_coefficient) for result in results])

    def copies(self, n: int, count: int) -> Impacts:
        """Impact n, `count` times."""
        place = int(np.searchsorted(self._ends, n, side="right"))
        impact = self.arrays[place]
        masses = np.asarray(impact.mass)
        mass = np.full(count, masses[n - int(self._ends[place]) + masses.size])
        return Impacts((Impact(impact.material, impact.profile, mass=mass, velocity=impact.velocity),))

    def prepared(self) -> Impacts:
        """Return the same impacts with computed reduced moduli."""
        for impact in self.arrays:
            # The impact caches it.
            _ = impact.reduced_modulus
        return self


def plane(size: int, seed: int = 1) -> StandardSolids:
    """Points of the plane of the paper's figures: nu in [-0.9, 0.5], p2 1e-3 to 10, p3 1e-2 to 1e2."""
    return _standard_solids(size, seed, (-3.0, 1.0), (-2.0, 2.0))


def wide(size: int, seed: int = 2) -> StandardSolids:
    """Points of a wide domain: nu in [-0.9, 0.5], p2 1e-5 to 1e2, p3 1e-4 to 1e4."""
    return _standard_solids(size, seed, (-5.0, 2.0), (-4.0, 4.0))


def _standard_solids(size: int, seed: int, p2: tuple[float, float], p3: tuple[float, float]) -> StandardSolids:
    random = np.random.default_rng(seed)
    nu = random.uniform(-0.9, 0.5, size)
    # Every third point is incompressible, the limit of the paper, with one mode fewer.
    nu[::3] = 0.5
    return StandardSolids(nu, 10.0 ** random.uniform(*p2, size), 10.0 ** random.uniform(*p3, size))


def random_prony(materials: int, masses: int, terms: tuple[int, int] = (10, 20), seed: int = 3) -> Impacts:
    """Impacts on incompressible materials of random Prony series over ten decades of relaxation time.

    The elastic contact time is of the order of the middle of those decades.
    """
    random = np.random.default_rng(seed)

    def impacts() -> Iterable[Impact]:
        for _ in range(materials):
            count = random.integers(*terms, endpoint=True)
            times = 10.0 ** random.uniform(-5.0, 5.0, count)
            series = PronySeries(1.0, 10.0 ** random.uniform(-2.0, 1.0, count), times)
            mass = 10.0 ** random.uniform(-2.0, 2.0, masses)
            yield Impact(Material(series, math.inf), Parabola(1.0), mass=mass, velocity=1.0)

    return Impacts(tuple(impacts())).prepared()


def even_prony(terms: int, masses: int, seed: int = 4) -> Impacts:
    """Impacts on a material whose relaxation times are spread evenly over ten decades."""
    mass = 10.0 ** np.random.default_rng(seed).uniform(-2.0, 2.0, masses)
    times = np.logspace(-5.0, 5.0, terms) if terms > 1 else np.ones(1)
    series = PronySeries(1.0, np.full(terms, 10.0 / terms), times)
    return Impacts((Impact(Material(series, math.inf), Parabola(1.0), mass=mass, velocity=1.0),)).prepared()


def of_profile(profile: Profile, materials: int, masses: int, seed: int = 5) -> Impacts:
    """Impacts of a body of any profile [m] on materials of the paper's plane.

    The masses give depths of L = 0.3 to 3 m: `m v0^2 = Ginf a(L) L^2`. p3 = eta v0/(Ginf L), as for the parabola, is
    drawn as in the plane.
    """
    random = np.random.default_rng(seed)

    def impacts() -> Iterable[Impact]:
        for n in range(materials):
            nu = 0.5 if n % 3 == 0 else random.uniform(-0.9, 0.5)
            branch, viscosity = 10.0 ** random.uniform(-1.0, 3.0), 10.0 ** random.uniform(-2.0, 2.0)
            depth = 10.0 ** random.uniform(-0.5, 0.5, masses)
            mass = profile.contact_radius(depth) * depth**2
            solid = standard_solid(1.0, branch, viscosity, poisson_ratio=nu)
            yield Impact(solid, profile, mass=mass, velocity=1.0)

    return Impacts(tuple(impacts())).prepared()
