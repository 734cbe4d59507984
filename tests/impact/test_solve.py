"""The exact solver against tables of other programs and closed forms; its invariances."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import restitution.contact.table
from cases import RUBBER
from checkout import DATA, rows
from refusals import named, refusal, warns
from restitution import Impact, Material, PronySeries, Tabulated, standard_solid
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone
from restitution.errors import InputError
from restitution.impact import closed_forms as cf
from restitution.impact.solve import solve, standard_solid_restitution
from restitution.impact.status import SolverError, Status
from scipy_oracle import solve_by_scipy
from strategies import logarithmic, materials, prony_series

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RTOL = 1e-9
TWO_BRANCHES = PronySeries(1.0, [2.0, 1.0], [0.1, 0.01])


def unit_impact(shear, bulk=math.inf, profile=None, **options) -> Impact:
    return Impact(Material(shear, bulk), profile or Parabola(1.0), 1.0, 1.0, **options)


def standard(nu: float, p2: float, p3: float, **options) -> Impact:
    """The paper's problem with m = R = v0 = Ginf = 1."""
    return Impact(standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu), Parabola(1.0), 1.0, 1.0, **options)


def tip_through(heights) -> Tabulated:
    """A tip with kinks at these heights."""
    return Tabulated(np.linspace(0.0, 3.0, len(heights)), heights)


def same_to(result, expected, rtol=RTOL) -> bool:
    """Whether two values of e agree within the sum of their tolerances."""
    return abs(result - expected) <= 2.0 * rtol * max(expected, 1e-3)


# Other programs


@pytest.mark.plain
@pytest.mark.parametrize("row", rows(DATA / "standard_solid.csv"), ids=lambda r: "{nu}-{p2}-{p3}".format(**r))
def test_tabulated_values(row):
    result = solve(standard(row["nu"], row["p2"], row["p3"]))
    assert result.status is Status.SEPARATED
    assert same_to(result.restitution_coefficient, row["restitution"])
    assert result.contact_time == pytest.approx(row["contact_time"], rel=1e-8)
    assert result.max_indentation_depth == pytest.approx(row["max_indentation"], rel=1e-9)
    # The force of the table is a maximum over samples.
    assert result.max_force == pytest.approx(row["max_force"], rel=1e-6)
    assert result.residual_indentation_depth == pytest.approx(
        row["residual_indentation"], abs=1e-8 * row["max_indentation"]
    )
    assert result.max_contact_radius == pytest.approx(row["max_indentation"] ** 0.5, rel=1e-9)


def test_whole_shared_table(shared_reference):
    table = rows(shared_reference / "standard_solid.csv")
    columns = {key: np.array([row[key] for row in table]) for key in table[0]}
    expected = columns["restitution"]
    for rtol in (1e-6, 1e-9):
        result = standard_solid_restitution(columns["nu"], columns["p2"], columns["p3"], rtol=rtol)
        assert np.all(np.abs(result - expected) <= 2.0 * rtol * np.maximum(expected, 1e-3))


@pytest.mark.parametrize("row", rows(DATA / "finite_element.csv"), ids=lambda r: "{nu}-{p2}-{p3}".format(**r))
def test_finite_elements(row):
    result = solve(standard(row["nu"], row["p2"], row["p3"]))
    assert result.restitution_coefficient == pytest.approx(row["restitution"], abs=row["restitution_error"])
    assert result.contact_time == pytest.approx(row["contact_time"], abs=row["contact_time_error"])
    assert result.max_indentation_depth == pytest.approx(row["max_indentation"], abs=row["max_indentation_error"])
    assert result.max_force == pytest.approx(row["max_force"], abs=row["max_force_error"])


@pytest.mark.plain
@pytest.mark.parametrize(("p3", "expected"), cf.KELVIN_VOIGT_RESTITUTION.items())
def test_kelvin_voigt(p3, expected):
    result = solve(unit_impact(PronySeries(1.0, parallel_viscosity=p3)))
    assert result.restitution_coefficient == pytest.approx(expected, abs=6e-8)


@pytest.mark.plain
@pytest.mark.parametrize(("ratio", "expected"), cf.MAXWELL_RESTITUTION.items())
def test_maxwell(ratio, expected):
    # The ratio is the Hertz time for E* = 4 G over tau.
    time = cf.elastic_contact_time(cf.elastic_max_indentation_depth(4.0, 1.0, 1.0, 1.0), 1.0)
    result = solve(unit_impact(PronySeries(0.0, [1.0], [time / ratio])))
    assert result.restitution_coefficient == pytest.approx(expected, abs=6e-9)


# Closed forms


@pytest.mark.plain
@pytest.mark.parametrize(
    ("profile", "coefficient", "exponent"),
    [
        (Parabola(0.04), 0.2, 1.0),
        (Cone(1.2), 2.0 * math.tan(1.2) / math.pi, 2.0),
        (FlatPunch(0.3), 0.3, 0.0),
        (PowerLaw(4.0, 2.0), None, 0.5),
    ],
    ids=["parabola", "cone", "flat punch", "power law"],
)
def test_elastic_impact(profile, coefficient, exponent):
    if coefficient is None:
        coefficient = float(profile.contact_radius(1.0))
    result = solve(Impact(Material(1.3, 2.1), profile, mass=0.7, velocity=1.9))
    modulus = 4.0 * 1.3 * (3.0 * 2.1 + 1.3) / (3.0 * 2.1 + 4.0 * 1.3)
    depth = cf.elastic_max_indentation_depth(modulus, coefficient, 0.7, 1.9, path_exponent=exponent)
    assert result.restitution_coefficient == pytest.approx(1.0, abs=RTOL)
    assert result.max_indentation_depth == pytest.approx(depth, rel=1e-9)
    assert result.contact_time == pytest.approx(cf.elastic_contact_time(depth, 1.9, path_exponent=exponent), rel=1e-8)
    assert result.max_force == pytest.approx(cf.elastic_max_force(depth, 0.7, 1.9, path_exponent=exponent), rel=1e-8)
    assert result.residual_indentation_depth == pytest.approx(0.0, abs=1e-8 * depth)


@pytest.mark.plain
@pytest.mark.parametrize("damping", [1e-3, 0.1, 0.5, 0.9, 1.0, 1.3, 3.0, 25.0])
def test_flat_punch_kelvin_voigt(damping):
    # F = 2 * 4 G a d: k = 8 and D = omega0 tau/2
    tau = 2.0 * damping / math.sqrt(8.0)
    result = solve(unit_impact(PronySeries(1.0, parallel_viscosity=tau), profile=FlatPunch(1.0)))
    assert same_to(result.restitution_coefficient, cf.flat_punch_kelvin_voigt_restitution(damping))


@pytest.mark.plain
@pytest.mark.parametrize("damping", [1e-3, 0.1, 0.5, 0.9])
def test_flat_punch_maxwell(damping):
    # D = 1/(2 omega0 tau)
    tau = 1.0 / (2.0 * damping * math.sqrt(8.0))
    result = solve(unit_impact(PronySeries(0.0, [1.0], [tau]), profile=FlatPunch(1.0)))
    assert same_to(result.restitution_coefficient, cf.flat_punch_maxwell_restitution(damping))


@settings(max_examples=100, deadline=None)
@given(p2=logarithmic(1e-5, 1e3), p3=logarithmic(1e-5, 1e5))
def test_no_bulk_stiffness_is_a_quarter_of_the_incompressible_modulus(p2, p3):
    without = standard_solid_restitution(-1.0, p2, p3)
    assert same_to(without, standard_solid_restitution(0.5, p2, cf.equivalent_incompressible_p3(p3)))


def test_exact_sphere_is_a_parabola_where_contact_is_small():
    # At a/R = 0.01 the forces differ by 1e-5 at equal depth, and e by less.
    parabola, sphere = (solve(Impact(RUBBER, profile(radius=0.01), 1e-6, 0.01)) for profile in (Parabola, Sphere))
    ratio = parabola.max_contact_radius / 0.01
    assert ratio < 0.02
    assert sphere.max_indentation_depth == pytest.approx(parabola.max_indentation_depth, rel=ratio**2)
    assert sphere.restitution_coefficient == pytest.approx(parabola.restitution_coefficient, rel=ratio**2)
    assert sphere.max_indentation_depth != parabola.max_indentation_depth


@pytest.mark.plain
def test_a_tabulated_parabola():
    r = np.linspace(0.0, 2e-3, 41)
    parabola, table = (
        solve(Impact(RUBBER, profile, 1e-4, 0.3)) for profile in (Parabola(0.01), Tabulated(r, r**2 / 0.02))
    )
    assert same_to(table.restitution_coefficient, parabola.restitution_coefficient)
    assert table.max_force == pytest.approx(parabola.max_force, rel=1e-8)


# Properties over the whole domain

NU = st.one_of(st.floats(-1.0, 0.5), st.sampled_from([-1.0, 0.5]), logarithmic(1e-12, 1e-1).map(lambda gap: 0.5 - gap))


@settings(max_examples=100, deadline=None)
@given(nu=NU, p2=logarithmic(1e-5, 1e3), p3=logarithmic(1e-5, 1e5))
@example(0.5, 1e-5, 1e-5)
@example(-1.0, 1e3, 1e5)
@example(0.49, 1e-3, 10.0)
def test_restitution_is_between_zero_and_one(nu, p2, p3):
    # The loss may be smaller than the tolerance.
    assert 0.0 < standard_solid_restitution(nu, p2, p3) <= 1.0 + RTOL


@settings(max_examples=60, deadline=None)
@given(nu=NU, p2=logarithmic(1e-5, 1e3), p3=logarithmic(1e-5, 1e5))
@example(-0.22526294986531514, 7.202585894344116e-05, 1.3069662818136623)
@example(-0.33996806579083305, 0.0006767245444354463, 0.2640353726034497)
@example(0.40734827196837410, 0.000429524809645296, 0.28311881522494364)
def test_energy_is_conserved(nu, p2, p3):
    result = solve(standard(nu, p2, p3))
    assert abs(result.energy.residual) < 10.0 * RTOL
    assert result.energy.dissipated > 0.0
    assert result.energy.stored > 0.0
    assert result.energy.kinetic_in == 0.5
    assert result.energy.kinetic_out == pytest.approx(0.5 * result.restitution_coefficient**2, rel=1e-15)


@settings(max_examples=60, deadline=None)
@given(
    nu=st.floats(-1.0, 0.5),
    p2=logarithmic(1e-4, 1e2),
    p3=logarithmic(1e-3, 1e3),
    mass=logarithmic(1e-9, 1e6),
    radius=logarithmic(1e-9, 1e3),
    velocity=logarithmic(1e-6, 1e3),
    modulus=logarithmic(1e2, 1e12),
)
def test_only_the_three_groups_matter(nu, p2, p3, mass, radius, velocity, modulus):
    time = (mass**2 / (radius * velocity * modulus**2)) ** 0.2
    material = standard_solid(modulus, modulus / p2, p3 * modulus * time, poisson_ratio=nu)
    result = solve(Impact(material, Parabola(radius), mass, velocity))
    expected = solve(standard(nu, p2, p3))
    assert same_to(result.restitution_coefficient, expected.restitution_coefficient)
    assert result.contact_time == pytest.approx(expected.contact_time * time, rel=1e-7)
    length = velocity * time
    assert result.max_indentation_depth == pytest.approx(expected.max_indentation_depth * length, rel=1e-8)
    assert result.max_force == pytest.approx(expected.max_force * mass * velocity / time, rel=1e-7)
    assert result.max_contact_radius == pytest.approx(
        expected.max_contact_radius * math.sqrt(length * radius), rel=1e-8
    )


PROFILES = st.one_of(
    logarithmic(1e-2, 1e2).map(Parabola),
    st.floats(0.2, 1.5).map(Cone),
    logarithmic(1e-2, 1e2).map(FlatPunch),
    st.builds(PowerLaw, st.sampled_from([1.0, 2.0, 4.0]), logarithmic(1e-2, 1e2)),
    st.builds(TruncatedCone, logarithmic(1e-2, 1e2), st.floats(0.2, 1.5)),
    st.builds(FlatEndedParabola, logarithmic(1e-2, 1e2), logarithmic(1e-2, 1e2)),
)


@settings(max_examples=60, deadline=None)
@given(material=materials(), profile=PROFILES, mass=logarithmic(1e-3, 1e3), velocity=logarithmic(1e-3, 1e3))
def test_any_solid_and_profile(material, profile, mass, velocity):
    """1 to 25 branches over twelve decades in shear and bulk: e lies in (0, 1] and energy is conserved."""
    result = solve(Impact(material, profile, mass, velocity))
    assert result.status is Status.SEPARATED
    assert 0.0 < result.restitution_coefficient <= 1.0 + RTOL
    assert abs(result.energy.residual) < 10.0 * RTOL


@pytest.mark.parametrize("viscosity", [0.0, 0.1])
@pytest.mark.parametrize("exponent", [1.3, 2.5, 4.0, 10.0])
def test_energy_under_blunt_and_sharp_tips(exponent, viscosity):
    # a = s^(2/n) has an infinite slope at both ends of the contact of a blunt tip, where a plain quadrature fails.
    solid = PronySeries(1.0, [2.0], [0.1], parallel_viscosity=viscosity)
    result = solve(Impact(Material(solid, math.inf), PowerLaw(exponent, 1.0), 1.0, 1.0))
    assert abs(result.energy.residual) < 10.0 * RTOL


@pytest.mark.parametrize(
    ("series", "profile"),
    [
        (PronySeries(2e-6, [5.0], [0.09]), Cone(math.atan(math.pi / 2.0))),
        (PronySeries(1e-8, parallel_viscosity=0.6), Cone(math.atan(math.pi / 2.0))),
    ],
    ids=["fast branch", "dashpot"],
)
@pytest.mark.parametrize("rtol", [1e-8, 1e-11])
def test_tiny_restitution_after_a_very_long_contact(series, profile, rtol):
    """After a contact of a thousand stopping times, the time has fewer digits than its increments."""
    impact = Impact(Material(series, math.inf), profile, 1.0, 1.0)
    result = solve(impact, rtol=rtol)
    assert 0.0 < result.restitution_coefficient < 1e-5
    assert result.restitution_coefficient == pytest.approx(
        solve(impact, rtol=1e-9).restitution_coefficient, abs=1e-3 * (rtol + 1e-9)
    )
    assert abs(result.energy.residual) < 1e-12


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_liquid_that_gives_back_less_than_a_millionth_holds_the_body(rtol):
    """The status is the same at every tolerance."""
    liquid = Material(PronySeries(0.0, [4e5, 7e-13], [2e-7, 200.0]), math.inf)
    result = solve(Impact(liquid, Parabola(1.0), 1.0, 1.0), rtol=rtol)
    assert result.status is Status.SINKS_IN
    assert result.restitution_coefficient == 0.0
    assert result.residual_indentation_depth == pytest.approx(result.max_indentation_depth, rel=1e-3)


@pytest.mark.parametrize("rtol", [1e-9, 1e-12])
@pytest.mark.parametrize(("viscosity", "fast", "slow"), [(0.08, 2e-7, 7e-13), (1.0, 2e-5, 1e-13), (10.0, 2e-7, 3e-10)])
def test_no_rounding_of_a_liquid_that_holds_the_body_is_refused(viscosity, fast, slow, rtol):
    """The velocity around the turning point is 1e-18 of the initial one, below the rounding of the latter."""
    units = np.arange(-100.0, 101.0)
    moduli = np.stack([viscosity / fast * (1.0 + 2.3e-16 * units), slow * (1.0 + 3e-15 * units)], axis=-1)
    liquid = Material(PronySeries(0.0, moduli, [fast, 200.0]), math.inf)
    result = solve(Impact(liquid, Parabola(1.0), 1.0, 1.0), rtol=rtol)
    assert np.all(result.status == Status.SINKS_IN)


@pytest.mark.parametrize(
    ("option", "value"),
    [("workers", 0), ("workers", 1.5), ("errors", "ignore"), ("progress", True), ("method", "reference"),
     ("rtol", 1e-13), ("rtol", math.nan)],
)  # fmt: skip
def test_options_out_of_range(option, value):
    kind = TypeError if option == "progress" else InputError
    several = Impact(RUBBER, Parabola(1.0), 1.0, [1.0, 2.0])
    for call in (
        partial(standard_solid_restitution, 0.3, [0.1, 0.2], 1.0),
        partial(solve, several),
        partial(solve, standard(0.3, 0.1, 1.0)),
    ):
        assert named(partial(call, **{option: value}), kind) == (option, value)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-10])
@pytest.mark.parametrize(
    "profile",
    [PowerLaw(4.85, 0.41), Parabola(1.0), FlatPunch(0.5), TruncatedCone(0.02, 1.0), FlatEndedParabola(2.0, 0.02)],
    ids=lambda profile: type(profile).__name__,
)
def test_bodies_sink_into_nearly_newtonian_liquids(profile, rtol):
    """One relaxation time of 1e-9 and less: m dv/dt = -2 eta* a v has no turning point."""
    for tau in (1e-9, 1e-12):
        liquid = Material(PronySeries(0.0, [1.0 / tau], [tau]), math.inf)
        assert solve(Impact(liquid, profile, 1.0, 1.0), rtol=rtol).status is Status.SINKS_IN


def test_shallow_impacts_beside_deep_ones():
    """All impacts share one table of the tip, whose error belongs to the deepest one."""
    tip, material = tip_through(KINKS[1]), Material(TWO_BRANCHES, math.inf)
    velocity = np.logspace(-5.0, 0.0, 6)
    together = solve(Impact(material, tip, 1.0, velocity), rtol=1e-8, errors="raise").restitution_coefficient
    for e, v in zip(together, velocity, strict=True):
        assert e == pytest.approx(solve(Impact(material, tip, 1.0, v), rtol=1e-8).restitution_coefficient, rel=2e-8)


@pytest.mark.plain
def test_kinks_that_a_table_does_not_resolve(monkeypatch):
    monkeypatch.setattr(restitution.contact.table, "_MOST_HALVINGS", 0)
    impact = unit_impact(TWO_BRANCHES, profile=tip_through([0.0, 0.25, 1.1, 1.9, 3.2]))
    assert solve(impact, rtol=1e-2).status is Status.SEPARATED
    with pytest.raises(SolverError, match="NOT_ACCURATE"):
        solve(impact)


@pytest.mark.parametrize("profile", [FlatPunch(0.3), TruncatedCone(0.3, 1.0), FlatEndedParabola(1.0, 0.3)])
def test_flat_face_on_a_dashpot(profile):
    # F = 2 eta* a v, with eta* = 4 eta for an incompressible half-space.
    viscous = Material(PronySeries(1.0, parallel_viscosity=0.1), math.inf)
    result = solve(Impact(viscous, profile, 1.0, 1.0))
    assert result.sample(0.0).force.item() == pytest.approx(2.0 * 0.4 * 0.3, rel=1e-12)
    early = result.sample(np.linspace(0.0, 0.02, 7) * result.contact_time)
    # The loss of momentum is the impulse, by Simpson's rule.
    weights = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0]) * float(early.time[1]) / 3.0
    assert 1.0 - float(early.indentation_velocity[-1]) == pytest.approx(float(weights @ early.force.values), rel=1e-6)


def hard(shear, profile, *tolerances, **options):
    """An impact at tolerances."""
    name = "-".join([type(profile).__name__, *map(str, options.values())])
    return pytest.param(unit_impact(shear, profile=profile, **options), tolerances, id=name)


# The dashpot acts at once on a moving face, and the response of the branches decays with their own times.
WEAK_BRANCHES = PronySeries(2e-4, [1e-4, 0.04, 0.01], [1e-4, 0.07, 3.0], parallel_viscosity=0.9)
FOUR_BRANCHES = PronySeries(1.0, [109.0, 14.3, 16.4, 10.5], [1.9e-6, 1.1e-5, 0.8, 2.0])
KINKS = [
    [0.0, 0.1542, 0.7352, 1.1925, 1.9567, 2.9081],
    [0.0, 0.088, 0.2871, 0.4757, 0.7853, 1.0492, 1.3765, 1.7804],
    [0.0, 0.0747, 0.1971, 0.3332, 0.5257, 0.8955, 1.2493, 1.5525, 1.8146, 2.5426, 3.1069],
]
FACES = FlatPunch(0.6), TruncatedCone(0.3, 1.0), Parabola(1.0), FlatEndedParabola(1.0, 0.3)
FAST = ([0.96, 6.8], [1.5e-5, 0.12]), ([8.1, 8.1], [1.3e-4, 0.1]), ([0.39, 2.5], [2.3e-4, 0.14])
# The work of the weight is as large as the kinetic energy, or much larger.
WEIGHTS = (FlatPunch(0.7), 17.0), (Parabola(0.7), 5.0), (Parabola(0.7), 9.0)


@pytest.mark.parametrize(
    ("impact", "tolerances"),
    [
        *(hard(WEAK_BRANCHES, face, 1e-6, 1e-8, 1e-9, 1e-10) for face in FACES),
        # Pressed beyond the equator.
        *(hard(FOUR_BRANCHES, Sphere(radius), 1e-7, 1e-8, 1e-9, 1e-10) for radius in (0.265, 0.05)),
        *(hard(TWO_BRANCHES, tip_through(heights), 1e-4, 1e-6, 1e-8, 1e-9) for heights in KINKS),
        *(hard(PronySeries(1.0, *branches), FlatPunch(1.0), 1e-9) for branches in FAST),
        *(hard(PronySeries(6.0, [1.2], [1.4]), tip, 1e-6, 1e-8, 1e-9, external_force=w) for tip, w in WEIGHTS),
    ],
)
def test_tolerance_is_kept_in_hard_cases(impact, tolerances):
    fine = solve(impact, rtol=1e-12).restitution_coefficient
    for rtol in tolerances:
        result = solve(impact, rtol=rtol)
        assert abs(result.restitution_coefficient - fine) <= rtol * max(fine, 1e-3)
        assert abs(result.energy.residual) < 10.0 * rtol


@settings(max_examples=60, deadline=None)
@given(
    series=prony_series(min_branches=1, max_branches=8, times=(1e-4, 1e4), moduli=(1e-2, 1e2)),
    share=st.floats(0.05, 0.95),
    data=st.data(),
)
def test_split_branches_and_zero_branches_change_nothing(series, share, data):
    k = data.draw(st.integers(0, series.n_branches - 1))
    moduli, times = series.branch_moduli, series.relaxation_times
    pieces = np.append(moduli, [share * moduli[k], 0.0])
    pieces[k] = (1.0 - share) * moduli[k]
    split = PronySeries(series.equilibrium_modulus, pieces, np.append(times, [times[k], 0.3]))
    whole, parted = solve(unit_impact(series)), solve(unit_impact(split))
    assert parted.status is whole.status
    assert same_to(parted.restitution_coefficient, whole.restitution_coefficient)


def test_infinitely_fast_and_slow_branches_are_a_dashpot_and_a_spring():
    limit = solve(unit_impact(PronySeries(1.5, [2.0], [0.5], parallel_viscosity=0.3)))
    branches = solve(unit_impact(PronySeries(1.0, [2.0, 0.3e9, 0.5], [0.5, 1e-9, 1e9])))
    # The deviation is of the order of the ratios of times.
    assert branches.restitution_coefficient == pytest.approx(limit.restitution_coefficient, rel=1e-7)


@pytest.mark.parametrize(
    # Elements: first order in their number, 800.
    ("other_method", "tolerance"), [(solve_by_scipy, 1e-8), (partial(solve, method="elements"), 3e-3)]
)  # fmt: skip
def test_methods_agree(other_method, tolerance):
    impact = Impact(RUBBER, Parabola(0.01), 0.005, 1.0, counter_material=Material(1e7, math.inf), external_force=0.05)
    exact, other = solve(impact), other_method(impact)
    for name in ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force"):
        assert getattr(other, name) == pytest.approx(getattr(exact, name), rel=tolerance), name


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
def test_tolerance_is_kept(rtol):
    rng = np.random.default_rng(5)
    nu, p2, p3 = rng.uniform(-1.0, 0.5, 400), 10 ** rng.uniform(-4, 2, 400), 10 ** rng.uniform(-3, 3, 400)
    fine = standard_solid_restitution(nu, p2, p3, rtol=1e-12)
    error = np.abs(standard_solid_restitution(nu, p2, p3, rtol=rtol) - fine)
    assert np.all(error <= rtol * np.maximum(fine, 1e-3))


# Bodies that stay


DASHPOT, SPRINGY = PronySeries(0.0, parallel_viscosity=0.5), PronySeries(1.0, [3.0], [0.5])
OVERDAMPED = PronySeries(1.0, parallel_viscosity=6.0 / math.sqrt(8.0))


@pytest.mark.plain
@pytest.mark.parametrize(
    ("shear", "profile", "force", "status"),
    [
        # Flat punch on Kelvin-Voigt without spring, F = 8 eta v: v never turns.
        (DASHPOT, FlatPunch(1.0), 0.0, Status.SINKS_IN),
        # A weight sinks into a liquid for ever.
        (PronySeries(0.0, [10.0], [0.1]), Sphere(2.0), 10.0, Status.SINKS_IN),
        # F = 8 (d + tau v), D = omega0 tau/2 = 3: the depth creeps to w/8 without a turning point.
        (OVERDAMPED, FlatPunch(1.0), 8.0, Status.CAPTURED),
        # The contact grows again before separation, as in the SciPy solution.
        *((SPRINGY, Parabola(1.0), weight, Status.CAPTURED) for weight in (2.0, 3.0, 30.0)),
        (SPRINGY, Parabola(1.0), 0.3, Status.SEPARATED),
    ],
)
def test_bodies_that_stay(shear, profile, force, status):
    result, free = (solve(unit_impact(shear, profile=profile, external_force=w)) for w in (force, 0.0))
    assert result.status is status
    separates = status is Status.SEPARATED
    assert math.isfinite(result.contact_time) is separates
    assert (result.restitution_coefficient > 0.0) is separates
    if force > 0.0 and status is not Status.SINKS_IN and free.status is Status.SEPARATED:
        assert result.restitution_coefficient < free.restitution_coefficient
        assert result.max_indentation_depth > free.max_indentation_depth
    # Under a weight in a liquid there is no largest depth.
    sinks = status is Status.SINKS_IN and force > 0.0
    assert math.isfinite(result.max_indentation_depth) is not sinks
    assert math.isinf(result.residual_indentation_depth) is sinks


@pytest.mark.parametrize(("damping", "status"), [(0.9, Status.SEPARATED), (1.2, Status.SINKS_IN)])
def test_maxwell_punch_turns_only_below_critical_damping(damping, status):
    tau = 1.0 / (2.0 * damping * math.sqrt(8.0))
    result = solve(unit_impact(PronySeries(0.0, [1.0], [tau]), profile=FlatPunch(1.0)))
    assert result.status is status
    assert (result.restitution_coefficient > 0.0) is (status is Status.SEPARATED)


@pytest.mark.plain
def test_viscous_half_space_stops_the_body():
    # F = 8 eta a v, a = sqrt(d): m v0 = 8 eta (2/3) d^(3/2). Parabola on a Newtonian half-space.
    result = solve(unit_impact(PronySeries(0.0, parallel_viscosity=0.25)))
    assert result.status is Status.SINKS_IN
    assert result.restitution_coefficient == 0.0
    assert result.max_indentation_depth == pytest.approx(0.75 ** (2.0 / 3.0), rel=1e-12)
    assert result.residual_indentation_depth == result.max_indentation_depth
    assert result.max_contact_radius == pytest.approx(0.75 ** (1.0 / 3.0), rel=1e-12)
    # F = 2 s (1 - (4/3) s^3) is largest at s^3 = 3/16.
    s = (3.0 / 16.0) ** (1.0 / 3.0)
    assert result.max_force == pytest.approx(2.0 * s * 0.75, rel=1e-9)


# The glass of the second is a thousand times stiffer: captured on its way back, the body creeps on, far deeper than the
# impact did.
CREEPING = [(PronySeries(1.0, parallel_viscosity=8.0), 1.0, 0.3), (PronySeries(1e4, [1e7], [1.0]), 4e-3, 4e-3 * 9.81)]


@pytest.mark.plain
@pytest.mark.parametrize("kind", [Parabola, Sphere])
@pytest.mark.parametrize(("shear", "mass", "weight"), CREEPING)
def test_body_that_creeps_to_rest_under_its_weight(shear, mass, weight, kind):
    profile, velocity = (kind(1.0), 1.0) if mass == 1.0 else (kind(5e-3), 1e-4)
    result = solve(Impact(Material(shear, math.inf), profile, mass, velocity, external_force=weight))
    assert result.status is Status.CAPTURED
    # At rest F = 2 E* Pi(d) carries the weight; E* = 4 G.
    force = 8.0 * shear.equilibrium_modulus * profile.force_integral_at_depth(result.max_indentation_depth)
    assert force == pytest.approx(weight, rel=1e-12)
    assert result.residual_indentation_depth == result.max_indentation_depth
    assert result.max_contact_radius == pytest.approx(profile.contact_radius(result.max_indentation_depth), rel=1e-12)
    assert result.max_force > weight


@pytest.mark.parametrize("force", [0.05, 10.0])
def test_weight_on_an_elastic_half_space_leaves_e_at_one(force):
    impact = unit_impact(1.0, external_force=force)
    result = solve(impact)
    assert result.restitution_coefficient == pytest.approx(1.0, abs=RTOL)
    assert solve(impact, rtol=1e-6).restitution_coefficient == pytest.approx(1.0, abs=1e-6)
    # m v0^2/2 + w d = (8/15) E* d^(5/2), E* = 4
    depth = result.max_indentation_depth
    assert 0.5 + force * depth == pytest.approx(8.0 / 15.0 * 4.0 * depth**2.5, rel=1e-9)


# Many at once


def test_shapes_follow_the_inputs():
    result = solve(Impact(RUBBER, Parabola([[0.01], [0.02]]), 0.005, [0.5, 1.0, 2.0]))
    assert result.restitution_coefficient.shape == (2, 3)
    assert result.status.shape == (2, 3)
    assert result.energy.residual.shape == (2, 3)
    alone = solve(Impact(RUBBER, Parabola(0.02), 0.005, 2.0))
    assert result.restitution_coefficient[1, 2] == alone.restitution_coefficient
    assert isinstance(alone.restitution_coefficient, float)
    assert standard_solid_restitution(0.3, [[0.1], [1.0]], [1.0, 2.0, 3.0]).shape == (2, 3)
    assert isinstance(standard_solid_restitution(0.3, 0.1, 1.0), float)


def test_interruption_stops_the_work():
    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(Impact(RUBBER, Parabola(0.01), 0.005, np.linspace(0.1, 1.0, 3000)), progress=interrupt)


# Options and failures


def test_bad_lists_and_options_of_another_method():
    good, several = standard(0.3, 0.1, 1.0), Impact(RUBBER, Parabola(0.01), 1.0, [1.0, 2.0])
    for call, message in (
        (lambda: solve([]), "impact: must hold at least one impact"),
        (lambda: solve([several]), "impact[0]: has shape (2,); a list takes single impacts"),
        (lambda: solve([good], method="elements"), "method = 'elements': must be 'exact' for a list"),
        (lambda: solve(several, method="elements"), "method = 'elements': must be 'exact' for an array of shape (2,)"),
        (lambda: solve(good, n_elements=9), "n_elements, time_step: belong to method 'elements', not to 'exact'"),
    ):
        assert str(refusal(call)).startswith(message)


@pytest.mark.parametrize(
    ("numbers", "field", "value"),
    [
        ((0.6, 1.0, 1.0), "nu", 0.6), ((-1.1, 1.0, 1.0), "nu", -1.1), ((0.3, 0.0, 1.0), "p2", 0.0),
        ((0.3, [1.0, -2.0], 1.0), "p2", -2.0), ((0.3, 1.0, math.inf), "p3", math.inf),
    ],
)  # fmt: skip
def test_groups_out_of_range(numbers, field, value):
    error = refusal(lambda: standard_solid_restitution(*numbers))
    assert (error.field, error.value, error.index) == (field, value, (1,) if value == -2.0 else ())


def test_standard_solid_restitution_by_other_methods():
    exact = standard_solid_restitution(0.3, 0.1, [2.0])
    # Elements: first order in their number, 800.
    assert standard_solid_restitution(0.3, 0.1, [2.0], method="elements") == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(
    ("impact", "status"),
    [
        (Impact(RUBBER, Parabola(0.01), 0.005, 1e300), Status.NOT_FINITE),
        (Impact(RUBBER, Parabola(0.01), 0.005, 1e-300), Status.NOT_FINITE),
        # The scale of the depth overflows.
        (Impact(Material(1e-99, math.inf), Parabola(1e-300), 1e300, 1e10), Status.NOT_FINITE),
    ],
)
def test_failure_of_a_single_impact_raises(impact, status):
    with pytest.raises(SolverError) as caught:
        solve(impact)
    assert caught.value.status is status
    assert status.failed
    with warns("failed"):
        result = solve(impact, errors="warn")
    assert math.isnan(result.restitution_coefficient)
    assert result.status.failed
