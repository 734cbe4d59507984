"""Indentation curves: recovery of a known material, errors against the Cramer-Rao bound, whole records, refusals."""

import math

import numpy as np
import pytest

import restitution as rs
from kernel.test_histories import run_depth
from restitution.identification.curves import baseline, first_approach, first_touch, white_noise
from restitution.identification.parameters import column
from restitution.indentation.records import Record, rates_of
from restitution.kernel.program import DONE
from restitution.material.prony import PronySeries

TIP = rs.Parabola(2.5e-6)
FIXED = {"poisson_ratio": 0.5}
# The setting of section 5 of the design: 1 um deep at 1 um/s, F_max 1.4 nN; E(0) = 1000 Pa, E(inf) = 200 Pa.
TRUTH = {"equilibrium_modulus": 200.0 / 3.0, "branch_modulus": 800.0 / 3.0, "viscosity": 80.0}
GEL = rs.standard_solid(**TRUTH, **FIXED)
CONTACT_POINT, SD = 0.4e-6, 1e-11
NOISE = rs.Noise(force=SD)
TIME = np.linspace(0.0, 2.8, 480)
DEPTH = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
FORCE = rs.indent(GEL, TIP, depth=DEPTH - CONTACT_POINT, time=TIME).force


def noisy(seed, force=FORCE):
    """Force with noise, an offset and a drift."""
    return force + np.random.default_rng(seed).normal(0.0, SD, force.size) + 3e-11 - 1e-11 * TIME[: force.size]


def curve(seed=0, part=slice(None), **options):
    options = {"profile": TIP, "noise": NOISE} | options
    return rs.IndentationCurve(TIME[part], DEPTH[part], noisy(seed)[part], **options)


def cramer_rao(time, depth, best):
    """Standard errors of the logarithms of the parameters and of the contact point, from single indentations."""

    def force(unknowns):
        values = dict(zip(TRUTH, np.exp(unknowns[:3]), strict=True))
        return rs.indent(rs.standard_solid(**values, **FIXED), TIP, depth=depth - unknowns[3], time=time).force

    best, steps = np.array([*np.log(best[:3]), best[3]]), np.array([1e-4, 1e-4, 1e-4, 1e-11])
    columns = [(force(best + step) - force(best - step)) / (2.0 * step.sum()) for step in np.diag(steps)]
    jacobian = np.stack([*columns, np.ones(time.size), time], axis=1) / SD
    return np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))[:4]


@pytest.mark.parametrize("part", [slice(None), slice(0, 240)], ids=["whole", "approach"])
def test_the_material_is_found_with_errors_of_the_cramer_rao_bound(part):
    fit = rs.identify(curve(1, part), rs.standard_solid, fixed=FIXED, profiles=False)
    estimates = [*fit.parameters.values(), fit.nuisances["contact_point"]]
    truth = [*TRUTH.values(), CONTACT_POINT]
    # The errors of the approach alone, 10 %, depend on the parameters at which they are computed.
    bound = cramer_rao(TIME[part], DEPTH[part], [estimate.value for estimate in estimates])
    for k, (estimate, value) in enumerate(zip(estimates, truth, strict=True)):
        stated = estimate.standard_error / (estimate.value if k < 3 else 1.0)
        assert 0.8 < stated / bound[k] < 1.3
        if k < 3:
            assert abs(math.log(estimate.value / value)) < 3.5 * bound[k]
        else:
            assert abs(estimate.value - value) < 3.5 * bound[k]
    assert fit.chi2 / fit.data[0].size == pytest.approx(1.0, abs=5.0 * math.sqrt(2.0 / fit.data[0].size))


def test_baseline_and_slope_are_found():
    nuisances = rs.identify(curve(2), rs.standard_solid, fixed=FIXED, profiles=False).nuisances
    assert nuisances["baseline"].value == pytest.approx(3e-11, abs=4e-12)
    assert nuisances["baseline_slope"].value == pytest.approx(-1e-11, abs=4e-12)


def test_noise_of_unknown_size_is_estimated():
    unknown = rs.identify(curve(3, noise=None), rs.standard_solid, fixed=FIXED, profiles=False)
    reference = rs.identify(curve(3), rs.standard_solid, fixed=FIXED, profiles=False)
    for name, estimate in reference.parameters.items():
        assert unknown.parameters[name].value == pytest.approx(estimate.value, rel=1e-5)
        assert unknown.parameters[name].standard_error == pytest.approx(estimate.standard_error, rel=0.15)


@pytest.mark.parametrize("off", [-20e-9, 20e-9])
def test_a_wrong_contact_point_increases_chi2(off):
    """20 nm in 1 um: chi2/n is 1.35 (the design), and the error of E(inf) 9 to 15 %."""
    curves = [curve(seed) for seed in range(30)]
    for data in curves:
        place = CONTACT_POINT + off
        data.nuisances = (data.nuisances[0]._replace(start=place, low=place - 1e-13, high=place + 1e-13),)
    fit = rs.identify_map(curves, rs.standard_solid, fixed=FIXED, workers=1, progress=False)
    assert float(fit["chi2"].mean()) / TIME.size == pytest.approx(1.35, abs=0.1)
    bias = float(fit["equilibrium_modulus"].mean()) / TRUTH["equilibrium_modulus"] - 1.0
    assert 0.08 < bias * math.copysign(1.0, off) < 0.16


def test_a_power_law_with_a_hold():
    """E(1 s) and the exponent of a springpot."""
    time = np.linspace(0.0, 3.0, 300)
    depth = np.interp(time, [0.0, 0.8, 2.0, 3.0], [0.0, 1.2e-6, 1.2e-6, 0.2e-6])
    solid = rs.FractionalMaterial(rs.springpot(400.0, 0.25), bulk=math.inf, rtol=1e-6).within((1e-4, 30.0))
    force = rs.indent(solid, TIP, depth=depth - 0.3e-6, time=time).force
    force += np.random.default_rng(4).normal(0.0, SD, time.size)
    data = rs.IndentationCurve(time, depth, force, profile=TIP, noise=NOISE)
    fit = rs.identify(data, rs.springpot, fixed=FIXED, profiles=False)
    for name, value in (("coefficient", 400.0), ("exponent", 0.25)):
        estimate = fit.parameters[name]
        assert abs(estimate.value - value) < 3.5 * estimate.standard_error
        assert estimate.standard_error < 0.01 * value
    assert fit.nuisances["contact_point"].value == pytest.approx(0.3e-6, abs=5e-9)


def force_of_soft_cantilever(stiffness):
    """Force of a tip at the height of the base less F/k, by damped iteration."""
    tip = DEPTH.copy()
    for _ in range(60):
        force = rs.indent(GEL, TIP, depth=tip - CONTACT_POINT, time=TIME).force
        step = DEPTH - force / stiffness - tip
        tip = tip + 0.7 * step
        if np.abs(step).max() < 1e-14:
            return force
    raise AssertionError


def test_the_compliance_of_a_soft_cantilever_leaves_no_bias():
    """0.01 N/m and a deflection of 115 nm; E(0) is wrong by a third if it is ignored."""
    force = force_of_soft_cantilever(0.01)
    biases = []
    for seed in range(6):
        data = rs.IndentationCurve(TIME, DEPTH, noisy(seed, force), profile=TIP, spring_constant=0.01, noise=NOISE)
        biases.append(rs.identify(data, rs.standard_solid, fixed=FIXED, profiles=False).parameters)
    for name, value in TRUTH.items():
        z = [(estimate[name].value - value) / estimate[name].standard_error for estimate in biases]
        assert abs(np.mean(z)) < 4.0 / math.sqrt(len(z))
    stiff = rs.IndentationCurve(TIME, DEPTH, noisy(0, force), profile=TIP, noise=NOISE)
    ignored = rs.identify(stiff, rs.standard_solid, fixed=FIXED, profiles=False).parameters
    glass = ignored["equilibrium_modulus"].value + ignored["branch_modulus"].value
    assert glass * 3.0 < 0.8 * 1000.0


@pytest.mark.parametrize("count", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_random_contact_points_give_the_force_of_a_history_that_starts_at_touch(count):
    rng = np.random.default_rng(6)
    places = rng.uniform(0.01e-6, 1.35e-6, count)
    data = curve()
    forces = data.forces(column([GEL] * count), places[:, None])
    for place, force in zip(places, forces, strict=True):
        touch, above = place / 1e-6, place < DEPTH
        time, depth = [touch, *TIME[above], 2.8 - touch], [0.0, *(DEPTH[above] - place), 0.0]
        history = rs.History.from_points(time, depth)
        inside = (touch < TIME) & (2.8 - touch > TIME)
        reference = rs.indent(GEL, TIP, depth=history, time=TIME[inside])
        # One element for each sample: of second order in their number.
        share = 1e-5 + 1.0 / max(inside.sum(), 1) ** 2
        assert np.abs(force[inside] - reference.force).max() < share * reference.max_force
        assert not np.any(force[~inside])


def test_units_do_not_change_the_fit():
    """The moduli stay the same if lengths are multiplied by 1e3 and forces by 1e6."""
    small = rs.identify(curve(7), rs.standard_solid, fixed=FIXED, profiles=False)
    data = rs.IndentationCurve(
        TIME, 1e3 * DEPTH, 1e6 * noisy(7), profile=rs.Parabola(2.5e-3), noise=rs.Noise(force=1e6 * SD)
    )
    large = rs.identify(data, rs.standard_solid, fixed=FIXED, profiles=False)
    for name, estimate in small.parameters.items():
        assert large.parameters[name].value == pytest.approx(estimate.value, rel=1e-5)


def test_effective_moduli_are_those_of_the_material():
    table = curve(8).effective_moduli()
    exact = rs.reduced_modulus(GEL).carson_transform(1j * table.angular_frequency)
    assert np.abs(np.log(np.hypot(table.storage_modulus, table.loss_modulus) / np.abs(exact))).max() < math.log(2.0)


def changed(column, place, value):
    columns = {"time": TIME.copy(), "depth": DEPTH.copy(), "force": noisy(9)}
    columns[column][place] = value
    return columns


RADII = np.linspace(0.0, 1.2e-6, 9)


WRONG = {
    "order": (changed("time", 7, 0.0), {}, r"time\[7\].*must be ascending"),
    "nan": (changed("force", 7, math.nan), {}, "force.*finite"),
    "lengths": ({"time": TIME, "depth": DEPTH, "force": FORCE[1:]}, {}, "equal length"),
    "saturated": ({"time": TIME, "depth": DEPTH, "force": np.minimum(FORCE, 7e-10)}, {}, "saturated"),
    "sign": ({"time": TIME, "depth": DEPTH, "force": -noisy(9)}, {}, "push positive"),
    "falling": ({"time": TIME, "depth": -DEPTH, "force": noisy(9)}, {}, "depth: falls.*-height"),
    "falling approach": (
        {"time": TIME[:240], "depth": 2e-6 - DEPTH[:240], "force": noisy(9)[:240]},
        {},
        "depth: falls.*-height",
    ),
    "pull": (
        changed("force", slice(400, 430), -2e-10),
        {},
        'force = -2.*pull on the way out: give adhesion=True.*segment="approach"',
    ),
    "segment": (changed("time", 0, 0.0), {"segment": "retract"}, "segment"),
    "end of the profile": (
        changed("time", 0, 0.0),
        {"profile": rs.Tabulated(RADII, RADII**2 / 5e-6)},
        "depth = .*must be <= 5.76e-07 m, where the profile ends",
    ),
    "jump": (changed("force", slice(300, 480), 2e-9), {}, "jumps"),
    "rest": ({"time": TIME, "depth": DEPTH * 0.0, "force": noisy(9)}, {}, "must change"),
    "baseline": ({"time": TIME[65:], "depth": DEPTH[65:], "force": noisy(9)[65:]}, {}, "10 points before"),
    "spring": (changed("time", 0, 0.0), {"spring_constant": -1.0}, "spring_constant"),
    "tip": (changed("time", 0, 0.0), {"profile": 2.5e-6}, "profile"),
    "noise": (changed("time", 0, 0.0), {"noise": rs.Noise(force=-1.0)}, "noise.force"),
}


@pytest.mark.parametrize(("columns", "options", "message"), WRONG.values(), ids=WRONG)
def test_wrong_curves_are_refused(columns, options, message):
    with pytest.raises(rs.InputError, match=message):
        rs.IndentationCurve(**columns, **({"profile": TIP} | options))


@pytest.mark.parametrize("free", [0, 1])
def test_the_baseline_of_a_tip_that_touches_at_the_start_is_its_first_force(free):
    # The curve is refused afterwards.
    assert np.all(baseline(TIME, FORCE, np.arange(TIME.size) < free) == FORCE[0])


def damaged(rng, columns):
    """Damage one column as instruments and their users do."""
    column = columns[rng.integers(0, 3)]
    place, other = rng.integers(0, column.size, 2)
    span = np.ptp(column)
    damages = (
        lambda: column.__setitem__(place, math.nan),
        lambda: column.__setitem__(place, column[place] * rng.choice([-1.0, 0.0, 1e3, 1e30])),
        lambda: column.__setitem__(slice(None), column[::-1].copy()),
        lambda: rng.shuffle(column),
        lambda: column.__imul__(10.0 ** rng.integers(-200, 200)),
        lambda: column.__setitem__(slice(min(place, other), max(place, other)), column[place]),
        lambda: column.__iadd__(rng.normal(0.0, span * 10.0 ** rng.uniform(-6.0, 0.0), column.size)),
        lambda: np.minimum(column, column.max() * rng.uniform(0.1, 1.0), out=column),
        lambda: column.__iadd__(span * rng.uniform(-10.0, 10.0)),
        lambda: column[place:].__iadd__(span * rng.uniform(-1.0, 1.0)),
        lambda: column.__setitem__(slice(None), np.round(10.0 * column / span) * span / 10.0),
    )
    damages[rng.integers(0, len(damages))]()
    part = slice(*sorted(rng.integers(0, column.size, 2))) if rng.random() < 0.2 else slice(None)
    return [column[part] for column in columns]


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning", "ignore::RuntimeWarning")
@pytest.mark.parametrize("count", [30, pytest.param(1500, marks=pytest.mark.slow)])
def test_damaged_curves_are_fitted_or_refused_in_one_line(count):
    rng, refusals = np.random.default_rng(11), []
    for _ in range(count):
        part = slice(None, None, int(rng.choice([1, 2, 8, 15])))
        time, depth, force = damaged(rng, [TIME[part].copy(), DEPTH[part].copy(), noisy(9)[part].copy()])
        stiffness = None if rng.random() < 0.7 else 10.0 ** rng.uniform(-3.0, 1.0)
        try:
            data = rs.IndentationCurve(time, depth, force, profile=TIP, spring_constant=stiffness)
            rs.identify_map([data], rs.standard_solid, fixed=FIXED, workers=1)
        except rs.InputError as error:
            refusals.append(str(error))
    assert 0.3 * count < len(refusals) < count
    assert "\n" not in "".join(refusals)


@pytest.mark.parametrize("factor", [1e-18, 1e18])
def test_a_slip_of_units_is_refused(factor):
    data = rs.IndentationCurve(TIME, DEPTH, factor * noisy(9), profile=TIP)
    with pytest.raises(rs.InputError, match="check the units"):
        rs.identify(data, rs.standard_solid, fixed=FIXED)


def record_with_drift(rng, pull):
    """Depth, force and time of a record of any drift and noise, with a pull [share] on the way out."""
    size, stay, end = int(rng.integers(200, 500)), rng.uniform(0.1, 4.0), rng.choice([0.0, 0.2])
    time = np.linspace(0.0, 2.0 + stay, size)
    depth = np.interp(time, [0.0, 1.0, 1.0 + stay, 2.0 + stay], [0.0, 1e-6, rng.uniform(0.8, 1.0) * 1e-6, end * 1e-6])
    touch = rng.uniform(0.25, 0.4) * 1e-6
    force = rs.indent(GEL, TIP, depth=depth - touch, time=time).force
    out = (time > 1.0 + stay) & (depth < 1.1 * touch) & (depth > 0.85 * touch)
    force = force / force.max() - pull * out + 0.1 * rng.normal() * time / time[-1]
    return time, depth, 1e-9 * (force + rng.normal(0.0, 10.0 ** rng.uniform(-3.0, -1.8), size)), end


@pytest.mark.parametrize("count", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_drift_is_no_pull(count):
    """The baseline is known before first touch alone where the record ends in contact or near it."""
    rng = np.random.default_rng(6)
    for _ in range(count):
        assert rs.IndentationCurve(*record_with_drift(rng, 0.0)[:3], profile=TIP).size
    refused = 0
    for _ in range(count):
        *columns, end = record_with_drift(rng, 0.15)
        try:
            rs.IndentationCurve(*columns, profile=TIP)
        except rs.InputError as error:
            refused += "adhesion=True" in str(error)
            continue
        # Only a record that does not leave the surface far enough may hide a pull.
        assert end > 0.0
    assert refused > 0.7 * count


def test_first_touch_is_close():
    errors = [first_touch(TIME, DEPTH, noisy(seed), 1.5).depth - CONTACT_POINT for seed in range(20)]
    assert np.abs(errors).max() < 60e-9


def test_first_touch_is_found_behind_a_long_way():
    """Nine tenths of the way are free; the contact is 1 um deep."""
    time = np.linspace(0.0, 10.4, 1500)
    depth = np.interp(time, [0.0, 9.4, 10.4], [0.0, 9.4e-6, 8.4e-6])
    force = rs.indent(GEL, TIP, depth=depth - 8.4e-6, time=time).force
    for seed in range(5):
        noise = np.random.default_rng(seed).normal(0.0, SD, time.size)
        assert first_touch(time, depth, force + noise, 1.5).depth == pytest.approx(8.4e-6, abs=60e-9)


# Records with a hold and with several cycles, at 2 kHz with 20 pN of noise, and noise of the depth.

FAST = rs.standard_solid(132.4, 93.2, 13.8, **FIXED)
PROGRAMS = {
    "hold": ([0.0, 0.54, 1.04, 1.58], [-1.5, 1.2, 1.2, -1.5]),
    "cycles": ([0.0, 0.5, 0.7, 0.8, 0.9, 1.0, 1.5], [-1.0, 1.0, 1.0, 0.4, 0.8, -0.1, -1.0]),
    "two approaches": ([0.0, 0.4, 0.7, 1.0, 1.4], [-1.0, 0.8, -0.2, 1.0, -1.0]),
}


def record_of(program, depth_noise, seed, force_noise=2e-11):
    """Force by panels of elements, the kernel of order ten, which shares no step with that of the curves."""
    times, depths = (np.array(column) for column in PROGRAMS[program])
    time = np.arange(0.0, times[-1], 1.0 / 2000.0)
    touch = times[0] + (times[1] - times[0]) * -depths[0] / (depths[1] - depths[0])
    knots, heights = np.append(touch, times[1:]), np.append(0.0, depths[1:]) * 1e-6
    series = rs.reduced_modulus(FAST)
    scaled = PronySeries(
        series.equilibrium_modulus / 1e3, series.branch_moduli / 1e3, series.relaxation_times / (knots[-1] - touch)
    )
    panels = run_depth(scaled, ((knots - touch) / (knots[-1] - touch), heights / 1e-6), 1e-7, 1.0)
    assert panels.outcome == DONE
    force = np.zeros(time.size)
    inside = time > touch
    force[inside] = 2.0 * panels.sample((time[inside] - touch) / (knots[-1] - touch), 2)
    # a = sqrt(R d): half of the force is the modulus times sqrt(R) depth^(3/2).
    force *= 1e3 * 1e-6 * math.sqrt(2.5e-6 * 1e-6)
    rng = np.random.default_rng(seed)
    depth = np.interp(time, times, depths) * 1e-6 + 2e-6
    return time, depth + depth_noise * rng.normal(size=time.size), force + force_noise * rng.normal(size=time.size)


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize(
    "depth_noise",
    [0.0, 3e-9, *(pytest.param(noise, marks=pytest.mark.slow) for noise in (0.05e-9, 0.1e-9, 0.3e-9, 1e-9))],
)
def test_whole_records_with_noise_of_the_depth_are_identified(program, depth_noise):
    data = rs.IndentationCurve(*record_of(program, depth_noise, 7), profile=TIP, noise=rs.Noise(force=2e-11))
    assert data.depth_deviations[0] == pytest.approx(depth_noise, abs=1e-13, rel=0.1)
    fit = rs.identify(data, rs.standard_solid, fixed=FIXED, profiles=False)
    for estimate, value in zip(fit.parameters.values(), (132.4, 93.2, 13.8), strict=True):
        assert abs(estimate.value - value) < 3.5 * estimate.standard_error
        assert estimate.standard_error < 0.02 * value
    touch = fit.nuisances["contact_point"]
    assert abs(touch.value - 2e-6) < 3.5 * touch.standard_error < 10e-9
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=5.0 * math.sqrt(2.0 / data.size))
    assert fit.warnings == ()


@pytest.mark.slow
def test_a_depth_noise_leaves_no_bias():
    """3 nm of it move the force more than its own noise; weights by the stiffness of the trial keep the modulus."""
    time, depth, force = record_of("hold", 0.0, 0, 0.0)
    rng, z = np.random.default_rng(3), []
    for _ in range(12):
        noises = 3e-9 * rng.normal(size=time.size), 2e-11 * rng.normal(size=time.size)
        data = rs.IndentationCurve(
            time, depth + noises[0], force + noises[1], profile=TIP, noise=rs.Noise(force=2e-11, depth=3e-9)
        )
        fit = rs.identify(data, rs.standard_solid, fixed=FIXED, profiles=False).parameters
        z.append([(fit[name].value - value) / fit[name].standard_error
                  for name, value in zip(TRUTH, (132.4, 93.2, 13.8), strict=True)])  # fmt: skip
    assert np.all(np.abs(np.mean(z, axis=0)) < 4.0 / math.sqrt(len(z)))
    assert np.all(np.sqrt(np.mean(np.square(z), axis=0)) < 1.8)


def test_an_approach_alone_ends_where_the_retraction_begins():
    time, depth, force = record_of("hold", 1e-9, 1)
    pulled = force - np.where((time > 1.28) & (time < 1.4), 3e-10, 0.0)
    with pytest.raises(rs.InputError, match=r"adhesion.*segment=\"approach\""):
        rs.IndentationCurve(time, depth, pulled, profile=TIP)
    data = rs.IndentationCurve(time, depth, pulled, profile=TIP, segment="approach", noise=rs.Noise(force=2e-11))
    # The depth falls by 3 nm in a sample.
    assert data.time[-1] == pytest.approx(1.04, abs=0.005)
    fit = rs.identify(data, rs.standard_solid, fixed=FIXED, profiles=False).parameters
    for estimate, value in zip(fit.values(), (132.4, 93.2, 13.8), strict=True):
        assert abs(estimate.value - value) < 3.5 * estimate.standard_error


@pytest.mark.parametrize("program", PROGRAMS)
def test_the_first_approach_ends_at_the_first_retraction(program):
    times, depths = PROGRAMS[program]
    time, depth, force = record_of(program, 1e-9, 2)
    first, end = first_approach(depth, force)
    assert time[first] == pytest.approx(0.0, abs=0.01)
    retraction = int(np.argmax(np.diff(depths) < 0.0))
    assert times[retraction] <= time[end] < times[retraction] + 0.1


def test_white_noise_is_that_about_neighbours():
    rng = np.random.default_rng(8)
    time = np.cumsum(rng.uniform(0.5, 1.5, 4000))
    values = np.sin(time / 300.0) + rng.normal(0.0, 0.01, time.size)
    assert white_noise(time, values) == pytest.approx(0.01, rel=0.06)


def test_a_coarse_record_is_doubted():
    """Eighty samples of a force without noise: the steps of the depth are not resolved to its noise."""
    time = np.linspace(0.0, 2.8, 80)
    depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    force = rs.indent(GEL, TIP, depth=depth - CONTACT_POINT, time=time).force
    data = rs.IndentationCurve(time[:-1], depth[:-1], force[:-1], profile=TIP, noise=rs.Noise(force=1e-17))
    materials, place = column([GEL]), np.array([[CONTACT_POINT]])
    stated, true = (
        data.discretisation_error(materials, place)[0],
        np.abs(data.forces(materials, place)[0] - force[:-1]),
    )
    assert 0.5 * true.max() < stated.max() < 2.0 * true.max()
    assert "too far apart" in data.doubts(materials, place)[0]
    assert rs.IndentationCurve(time, depth, force, profile=TIP, noise=NOISE).doubts(materials, place) == []


@pytest.mark.parametrize("depth_noise", [0.3e-9, 3e-9])
def test_a_dashpot_does_not_feel_the_noise_of_the_depth(depth_noise):
    """Its rate would be as large as that of the motion, 5 um/s; kinks of the motion are kept."""
    solid = rs.kelvin_voigt(300.0, 10.0, **FIXED)
    time = np.arange(0.0, 1.58, 1.0 / 2000.0)
    depth = 1e-6 * np.interp(time, *PROGRAMS["hold"])
    force = rs.indent(solid, TIP, depth=depth, time=time).force
    rng = np.random.default_rng(12)
    measured = depth + depth_noise * rng.normal(size=time.size)
    data = rs.IndentationCurve(time, measured, force + 2e-11 * rng.normal(size=time.size), profile=TIP)
    fit = rs.identify(data, rs.kelvin_voigt, fixed=FIXED, profiles=False).parameters
    assert fit["shear_modulus"].value == pytest.approx(300.0, rel=0.005)
    assert fit["viscosity"].value == pytest.approx(10.0, rel=0.015)


def test_rates_are_those_of_the_motion():
    time = np.linspace(0.0, 1.0, 2000)
    depth = 1e-6 * np.interp(time, [0.0, 0.4, 0.7, 1.0], [0.0, 2.0, 2.0, 0.0])
    exact, behind, gains = rates_of(Record(time, depth))
    assert exact[1:] == pytest.approx(np.diff(depth) / np.diff(time))
    assert np.array_equal(behind[:-1], exact[1:])
    assert gains[1:] == pytest.approx(math.sqrt(2.0) * 1999.0)
    noise = 2e-9 * np.random.default_rng(13).normal(size=time.size)
    rates, _, gains = rates_of(Record(time, depth + noise, 0.0, 2e-9))
    off, beside = rates - exact, np.abs(time[:, None] - [0.0, 0.4, 0.7, 1.0]).min(axis=1) > 0.004
    assert np.std(off[beside]) == pytest.approx(2e-9 * np.median(gains), rel=0.4)
    assert np.std(off[beside]) < 0.04 * exact.max()
