"""The same impacts by this package and by other methods, with pytest-benchmark: `pytest benchmarks/test_speed.py`.

`--benchmark-save` and `--benchmark-compare` compare two versions of the code. `run.py` makes the tables of the page
on benchmarks.
"""

import numpy as np
import pytest
from problems import StandardSolids, even_prony, of_profile, plane, random_prony, wide

import restitution as rs

RTOL = 1e-8
POINTS = 2000
DOMAINS = {
    "plane": lambda: plane(POINTS),
    "wide": lambda: wide(POINTS),
    "10 to 20 terms": lambda: random_prony(10, POINTS // 20),
}
R = np.linspace(0.0, 12.0, 241)
PROFILES = {
    "parabola": rs.Parabola(1.0),
    "cone": rs.Cone(np.pi / 4),
    "n = 4": rs.PowerLaw(4.0, 1.0),
    "n = 1.5": rs.PowerLaw(1.5, 1.0),
    "tabulated": rs.Tabulated(R, 0.5 * R**2),
    "sphere": rs.Sphere(20.0),
}
FEW = StandardSolids(np.array([0.3, 0.45, 0.5]), np.array([0.1, 0.01, 1.0]), np.array([1.0, 0.5, 2.0]))
"""Impacts for slow methods; none are stiff."""
EXACT = FEW.solve(1e-12)


@pytest.mark.parametrize("name", DOMAINS)
@pytest.mark.benchmark(group=f"domains, {POINTS} impacts")
def test_domain(benchmark, name):
    problems = DOMAINS[name]()
    exact = problems.solve(1e-11)
    result = benchmark(problems.solve, RTOL)
    assert np.all(np.abs(result - exact) < RTOL * np.maximum(exact, 1e-3))


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.benchmark(group="profiles, 2000 impacts")
def test_profile(benchmark, name):
    problems = of_profile(PROFILES[name], 4, 500)
    exact = problems.solve(1e-11)
    result = benchmark(problems.solve, RTOL)
    assert np.all(np.abs(result - exact) < RTOL * np.maximum(exact, 1e-3))


@pytest.mark.parametrize("terms", [1, 10, 100])
@pytest.mark.benchmark(group="terms, 200 impacts")
def test_terms(benchmark, terms):
    assert np.all(benchmark(even_prony(terms, 200).solve, RTOL) > 0.0)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.benchmark(group=f"tolerances, {POINTS} impacts")
def test_tolerance(benchmark, rtol):
    problems = plane(POINTS)
    exact = problems.solve(1e-12)
    result = benchmark(problems.solve, rtol)
    assert np.all(np.abs(result - exact) < rtol * np.maximum(exact, 1e-3) + 1e-12)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.benchmark(group="threads, 20 000 impacts")
def test_threads(benchmark, workers):
    problems = plane(20_000)
    result = benchmark(problems.solve, RTOL, workers)
    assert np.array_equal(result, problems.solve(RTOL))


@pytest.mark.parametrize(("method", "rtol", "error"), [("exact", 1e-8, 1e-8), ("elements", 1e-9, 2e-3)])
@pytest.mark.benchmark(group="methods, 3 impacts")
def test_method(benchmark, method, rtol, error):
    def solve():
        return rs.standard_solid_restitution(FEW.nu, FEW.p2, FEW.p3, method=method, rtol=rtol)

    result = benchmark.pedantic(solve, rounds=20 if method == "exact" else 1, warmup_rounds=0)
    assert np.abs(result - EXACT).max() < error
