"""Energy budget of the kernel: closed form for a Kelvin-Voigt punch, and the balance of all terms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from restitution.kernel.collocation import radau
from restitution.kernel.impact import solve_block
from restitution.kernel.outcome import OUTCOME, RESTITUTION, SEPARATED, STATUS
from restitution.kernel.path import power_path, several_paths
from restitution.kernel.stored import allocate_ledger, energy_budget
from restitution.kernel.workspace import Problem, Problems, allocate

ELEMENTS = 400


def _budget(problem):
    """Restitution coefficient, and energies dissipated, stored at the end and radiated, in units of m v0^2."""
    N = problem.moduli.size
    work, outcomes = allocate(N, ELEMENTS), np.empty((1, len(OUTCOME)))
    unit = np.ones(1)
    problems = Problems(
        unit, problem.equilibrium * unit, problem.viscosity * unit, 0.0 * unit, problem.admittance * unit, np.array([0, N]),
        problem.moduli, problem.times, several_paths(problem.path), np.zeros(1, np.intp),
    )  # fmt: skip
    solve_block(radau(8), 1e-11, 2e-14, problems, work, outcomes)
    assert outcomes[0, STATUS] == SEPARATED
    return outcomes[0, RESTITUTION], *energy_budget(problem, radau(8), work, allocate_ledger(N, ELEMENTS))


@pytest.mark.parametrize("damping", [0.02, 0.3, 0.9])
def test_kelvin_voigt_punch(damping):
    # d'' + 2 D d' + d = 0 with d = 0, d' = 1 at first; the contact ends where the force d + 2 D d' vanishes.
    frequency = math.sqrt(1.0 - damping**2)

    def depth(t):
        return math.exp(-damping * t) * math.sin(frequency * t) / frequency

    def velocity(t):
        return math.exp(-damping * t) * math.cos(frequency * t) - damping * depth(t)

    # The phase of the force, -d'': pi - 2 arcsin(D) lies between the first touch and its first zero.
    end = (math.pi - math.atan2(2.0 * damping * frequency, 1.0 - 2.0 * damping**2)) / frequency
    assert depth(end) + 2.0 * damping * velocity(end) == pytest.approx(0.0, abs=1e-15)
    lost = quad(lambda t: 2.0 * damping * velocity(t) ** 2, 0.0, end, epsabs=1e-13, epsrel=1e-13)[0]
    none = np.zeros(0)
    problem = Problem(1.0, none, none, 2.0 * damping, 0.0, 0.0, power_path(0.0))
    e, dissipated, stored, radiated = _budget(problem)
    assert radiated == 0.0
    assert e == pytest.approx(-velocity(end), rel=1e-10)
    assert dissipated == pytest.approx(lost, rel=1e-9)
    assert stored == pytest.approx(0.5 * depth(end) ** 2, rel=1e-9)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("seed", range(3))
def test_energies_sum_to_the_initial_kinetic_energy(exponent, seed):
    # 1/2 = e^2/2 + dissipated + stored + radiated, computed from the velocity, the modes, and the elements at separation.
    random = np.random.default_rng(seed)
    moduli, times = 10.0 ** random.uniform(-1.0, 0.5, 3), 10.0 ** random.uniform(-2.0, 1.0, 3)
    viscosity = 0.0 if seed == 0 else 10.0 ** random.uniform(-2.0, 0.0)
    admittance = 0.0 if seed == 1 else random.uniform(0.05, 0.3)
    problem = Problem(random.uniform(0.2, 2.0), moduli, times, viscosity, 0.0, admittance, power_path(exponent))
    e, dissipated, stored, radiated = _budget(problem)
    assert 0.0 < e < 1.0
    assert dissipated > 0.01
    assert stored >= 0.0
    assert (radiated > 0.0) == (admittance > 0.0)
    assert 0.5 * e**2 + dissipated + stored + radiated == pytest.approx(0.5, abs=1e-8)
