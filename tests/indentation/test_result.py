"""Results of an indentation: history, largest values, work, validity and picture."""

import math
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import restitution as rs
from restitution import IndentationStatus, InputError, Material, PronySeries, hold, indent, sine_arch, triangle
from restitution.contact.profiles import Cone, FlatPunch, Parabola, Sphere

GEL = Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), math.inf)
TIP = Parabola(2.5e-6)
# Instantaneous and equilibrium reduced modulus of the gel.
GLASS, RUBBER = 4.0 / 3.0 * 1000.0, 4.0 / 3.0 * 200.0


def pressed(**options):
    return indent(GEL, TIP, depth=triangle(1e-6, 1.0), **options)


def test_history_is_a_dataset_with_units():
    result = pressed()
    history = result.history
    assert history.indentation_depth.attrs["units"] == "m"
    assert history.indentation_velocity.attrs["units"] == "m/s"
    assert history.force.attrs["units"] == "N"
    assert history.time.attrs["units"] == "s"
    assert history.attrs["prescribed"] == "depth"
    assert history.sizes["time"] == result.time.size > 400
    assert history.force.values is result.force or np.array_equal(history.force, result.force)
    # The times include touch, turning point, end of contact and end of the history.
    for moment in (0.0, 1.0, result.contact_end_time, 2.0):
        assert moment in history.time


def test_samples_agree_with_the_columns_in_any_order():
    result = pressed()
    order = np.random.default_rng(2).permutation(result.time.size)
    sample = result.sample(result.time[order])
    for name in ("indentation_depth", "indentation_velocity", "force", "contact_radius"):
        np.testing.assert_array_equal(sample[name], getattr(result, name)[order])
    assert result.sample(n_points=11).sizes["time"] == 12
    for field, value, options in (("n_points", 1, {"n_points": 1}), ("time", 2.5, {"times": [2.5]})):
        with pytest.raises(InputError) as caught:
            result.sample(**options)
        assert (caught.value.field, caught.value.value) == (field, value)


def test_threads_may_sample_at_once():
    result = pressed()
    times = np.linspace(0.0, 2.0, 5001)
    expected = result.sample(times).force.values
    with ThreadPoolExecutor(4) as pool:
        for forces in pool.map(lambda _: result.sample(times).force.values, range(8)):
            np.testing.assert_array_equal(forces, expected)


def test_results_can_be_kept():
    result = pressed()
    again = pickle.loads(pickle.dumps(result))
    assert again.max_force == result.max_force
    np.testing.assert_array_equal(again.sample([0.5, 1.2]).force, result.sample([0.5, 1.2]).force)


def test_velocity_is_the_rate_of_the_depth():
    result = indent(GEL, TIP, force=triangle(1e-9, 1.0), rtol=1e-11)
    for t in (0.3, 0.99, 1.3, 1.9):
        step = 1e-5
        depth = result.sample([t - step, t + step]).indentation_depth.values
        assert result.sample([t]).indentation_velocity.item() == pytest.approx(
            (depth[1] - depth[0]) / (2 * step), rel=1e-6
        )


def test_before_and_behind_a_step():
    result = indent(GEL, TIP, force=[0.0, 1e-9, 1e-9, 0.0, 0.0], time=[0.0, 0.0, 1.0, 1.0, 3.0])
    assert result.force == pytest.approx([0.0, 1e-9, 1e-9, 0.0, 0.0])
    # Without force the surface springs back at once and then creeps to zero.
    glass = (0.75 * 2.5e-6 * 1e-9 / GLASS) ** (1 / 3)
    assert result.contact_radius == pytest.approx([0.0, glass, result.max_contact_radius, 0.0, 0.0], rel=1e-12)
    before, behind = (result.sample([1.0], before=x).indentation_depth.item() for x in (True, False))
    assert result.indentation_depth[2:4] == pytest.approx([before, behind], rel=1e-14)
    assert before == pytest.approx(result.max_indentation_depth, rel=1e-13)
    assert result.residual_indentation_depth == pytest.approx(behind, rel=1e-14)
    # Without load, the surface of the gel recovers with the retardation time tau E0/Einf.
    assert result.indentation_depth[4] == pytest.approx(behind * math.exp(-2.0 / 1.5), rel=1e-9)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("history", [{"depth": triangle(1e-6, 1.0)}, {"force": triangle(1e-9, 1.0)}])
def test_work_is_the_area_of_the_loop(history, rtol):
    result = indent(GEL, TIP, rtol=rtol, **history)
    end = min(result.contact_end_time, 2.0)
    nodes, weights = np.polynomial.legendre.leggauss(30)
    total = 0.0
    # Panels shrink towards touch, turning point and end, where the integrand has roots.
    half = 0.5 * 2.0 ** -np.arange(40.0)[::-1]
    edges = np.concatenate([[0.0], half, 1.0 - half[-2::-1], [1.0]])
    for low, high in ((0.0, 1.0), (1.0, result.turning_time), (max(1.0, result.turning_time), end)):
        if high > low:
            places = low + (high - low) * edges
            width = 0.5 * np.diff(places)
            t = places[:-1, None] + width[:, None] * (1.0 + nodes)
            sample = result.sample(np.clip(t.ravel(), low, high))
            total += np.sum(
                (width[:, None] * weights).ravel() * sample.force.values * sample.indentation_velocity.values
            )
    assert result.work == pytest.approx(total, abs=10 * rtol * result.max_force * result.max_indentation_depth)
    if "depth" in history:
        assert 0.0 < result.stored < result.work
        assert result.dissipated == result.work - result.stored


def test_work_of_steps():
    """In a step the gel has its instantaneous modulus; a held depth does no work."""
    result = indent(GEL, TIP, depth=hold(1e-6, 3.0))
    glass = 2.0 * GLASS * (4.0 / 15.0) * math.sqrt(2.5e-6) * (1e-6) ** 2.5
    assert result.work == pytest.approx(glass, rel=1e-9)
    # After half a second the depth jumps back to zero: only the elastic part of the work is recovered.
    punch = indent(GEL, FlatPunch(1e-6), depth=[0, 1e-6, 1e-6, 0.0, 0.0], time=[0, 0, 0.5, 0.5, 1.0])
    stiffness = 2.0 * 1e-6
    force = stiffness * (RUBBER + (GLASS - RUBBER) * math.exp(-0.5 / 0.3)) * 1e-6
    inward = 0.5 * stiffness * GLASS * (1e-6) ** 2
    outward = 0.5 * force**2 / (stiffness * GLASS)
    assert punch.contact_end_time == pytest.approx(0.5, rel=1e-14)
    assert punch.work == pytest.approx(inward - outward, rel=1e-9)


def test_largest_values_do_not_depend_on_the_output_times():
    result = indent(GEL, TIP, depth=sine_arch(1e-6, 2.0), time=[0.0, 0.1, 2.0])
    dense = result.sample(np.linspace(0.0, 2.0, 200001))
    assert result.max_force == pytest.approx(float(dense.force.max()), rel=1e-9)
    assert result.max_force >= float(dense.force.max()) * (1.0 - 1e-14)
    assert result.max_indentation_depth == pytest.approx(1e-6, rel=1e-11)
    assert result.max_contact_radius == pytest.approx(math.sqrt(2.5e-12), rel=1e-11)
    # A creeping gel reaches its largest depth after the largest force.
    creeping = indent(GEL, TIP, force=triangle(1e-9, 1.0))
    dense = creeping.sample(np.linspace(0.0, 2.0, 200001))
    assert 1.0 < creeping.turning_time < 2.0
    assert creeping.max_indentation_depth == pytest.approx(float(dense.indentation_depth.max()), rel=1e-9)
    assert creeping.max_contact_radius == pytest.approx(float(dense.contact_radius.max()), rel=1e-9)


def test_dictionary_and_status():
    result = pressed()
    numbers = result.to_dict()
    assert numbers["max_force"] == result.max_force
    assert numbers["status"] is IndentationStatus.SEPARATED
    assert (numbers["prescribed"], numbers["rtol"], numbers["error"]) == ("depth", 1e-8, 1e-8)
    assert numbers["residual_indentation_depth"] == pytest.approx(2e-6 - 1e-6 * result.contact_end_time, rel=1e-9)
    assert IndentationStatus.IN_CONTACT.message.startswith("the bodies were still in contact")


def test_assumptions_and_their_limits():
    """a^2 = R d, c^2 = G/rho; limits as on the page about limits."""
    deep = pressed()
    assert deep.validity["small_strain"].exceeded
    assert deep.validity["small_strain"].value == pytest.approx(math.sqrt(1.0 / 2.5), rel=1e-9)
    assert deep.warnings == [deep.validity["small_strain"].warning]
    shallow = indent(GEL, TIP, depth=triangle(1e-8, 1.0))
    assert shallow.warnings == []
    dense = Material(GEL.shear, math.inf, density=1000.0)
    # The modulus lies between 200/3 and 1000/3 Pa.
    fast = indent(dense, TIP, depth=triangle(1e-8, 1e-6)).validity["waves"]
    assert fast.exceeded
    assert 0.01 / math.sqrt(1.0 / 3.0) <= fast.value <= 0.01 / math.sqrt(0.2 / 3.0)
    assert indent(dense, TIP, force=hold(1e-15, 1.0)).warnings == []


def test_a_history_outside_the_window_of_the_material_is_doubtful():
    """A springpot, approximated for times up to a millisecond, under a triangle of two seconds."""
    springpot = rs.FractionalMaterial(rs.springpot(100.0, 0.3), math.inf)
    short, long = (springpot.within(window) for window in ((1e-6, 1e-3), (1e-3, 10.0)))
    depth = triangle(1e-8, 1.0)
    assert indent(short, TIP, depth=depth).validity["window"].exceeded
    assert not indent(long, TIP, depth=depth).validity["window"].exceeded
    # Time without contact does not count.
    waiting = [-1e-6, 0.0, 1e-8, -1e-8], [0.0, 100.0, 101.0, 103.0]
    assert not indent(long, TIP, depth=waiting[0], time=waiting[1]).validity["window"].exceeded


def test_pictures_show_the_whole_loop():
    for result in (
        pressed(time=[0.0, 2.0]),
        indent(GEL, TIP, force=hold(1e-9, 1.0)),
        indent(GEL, TIP, force=[0.0, 1e-9, 1e-9, 0.0, 0.0], time=[0.0, 0.0, 1.0, 1.0, 3.0]),
    ):
        figure = result.plot()
        labels = [ax.get_ylabel() for ax in figure.axes]
        assert [label.split(" $")[0] for label in labels] == [
            "indentation depth",
            "normal force",
            "contact radius",
            "normal force",
        ]
        (line,) = (line for line in figure.axes[1].get_lines() if len(line.get_xdata()) > 2)
        # The line contains the step and the peak, whatever the output times.
        assert max(line.get_ydata()) == pytest.approx(result.max_force * 1e9, rel=1e-6)
        filled = bool(figure.axes[3].patches)
        assert filled == (result.prescribed == "depth")
        assert f"prescribed {result.prescribed}" in figure.get_suptitle()


def test_pictures_show_the_ends_of_all_contacts():
    depth = [0.0, 8e-8, 2e-8, 9e-8, 0.0, 0.0, 8e-8, 0.0]
    result = indent(GEL, TIP, depth=depth, time=[0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 5.0, 6.0])
    assert len(result.contact_intervals) == 3
    figure = result.plot()
    dashed = [line.get_xdata()[0] for line in figure.axes[1].get_lines() if line.get_linestyle() == "--"]
    assert dashed == pytest.approx(result.contact_intervals[:, 1], rel=1e-12)
    # The area of several loops is not the energy lost.
    assert not figure.axes[3].patches


def test_rounding_of_the_last_time_is_harmless():
    """Start plus duration may round to a time beyond the end; results do not depend on the start."""
    rng = np.random.default_rng(4)
    count = 0
    while count < 10:
        time = np.cumsum(rng.uniform(0.0, 1.0, 3)) - rng.uniform()
        if time[0] + (time[2] - time[0]) <= time[2]:
            continue
        count += 1
        for name, values in (("depth", [0.0, 0.9, 1.0]), ("force", [0.0, 1.0, 0.5])):
            result, expected = (indent(GEL, Parabola(1.0), time=t, **{name: values}) for t in (time, time - time[0]))
            for quantity in ("max_force", "max_indentation_depth", "work"):
                assert getattr(result, quantity) == pytest.approx(getattr(expected, quantity), rel=1e-9)


def test_work_where_the_rate_is_infinite_at_touch():
    """Dashpot in parallel: a^3 = (3 R/4) int J dF with J = (1 - exp(-E t/eta))/E; d grows as t^(4/3) at touch."""
    body = Material(PronySeries(0.5, parallel_viscosity=0.75), math.inf)
    for start in (0.0, 0.3, 7.0):
        result = indent(
            body, FlatPunch(0.5), force=[0.0, 0.0, 1e-3, 1e-3], time=start + np.array([-1.0, 0.0, 1e-9, 5.0])
        )
        # A punch of radius a: 2 a E d + 2 a eta d' = F.
        depth = 1e-3 / (2.0 * 0.5 * 2.0) * -math.expm1(-5.0 * 2.0 / 3.0)
        assert result.work == pytest.approx(1e-3 * depth, rel=1e-6)
        for profile in (Parabola(0.5), Sphere(20.0)):
            result = indent(body, profile, force=triangle(1e-3, 1.0), rtol=1e-10)
            late = indent(body, profile, force=[0.0, 1e-3, 0.0], time=start + np.array([0.0, 1.0, 2.0]), rtol=1e-10)
            assert late.work == pytest.approx(result.work, rel=1e-9)


def test_work_while_a_fast_term_relaxes_behind_a_kink():
    """A punch of E* = 1 + 300 exp(-t/tau): `F/(2 a) = d + 300 h`, with h' = d' - h/tau, up to 1 and back to 0.95."""
    tau, modulus, a = 1e-4, 300.0, 0.5
    body = Material(PronySeries(0.25, [0.25 * modulus], [tau]), math.inf)
    result = indent(body, FlatPunch(a), depth=[0.0, 1.0, 0.95], time=[0.0, 1.0, 11.0])

    def share(height, rate, duration):
        """Return the integral of h over a line, and h at its end."""
        decayed = tau * -math.expm1(-duration / tau)
        return height * decayed + rate * tau * (duration - decayed), height + (rate * tau - height) * decayed / tau

    up, height = share(0.0, 1.0, 1.0)
    down, _ = share(height, -0.005, 10.0)
    expected = 2.0 * a * (0.5 * 0.95**2 + modulus * (up - 0.005 * down))
    assert result.contact_end_time == math.inf
    assert result.work == pytest.approx(expected, rel=1e-9)


def test_work_of_a_force_that_is_held_on_a_dashpot():
    """The rate of a cone is infinite at first; the work is F d, and `d^2 = F/(E c) (1 - exp(-E t/eta))`, a = c d."""
    body, cone = Material(PronySeries(0.5, parallel_viscosity=0.75), math.inf), Cone(1.2)
    # The times have few digits behind the touch.
    result = indent(body, cone, force=3e-3, time=[1e6, 1e6 + 4.0])
    c = float(cone.contact_radius(1.0))
    depth = math.sqrt(3e-3 / (2.0 * c) * -math.expm1(-4.0 * 2.0 / 3.0))
    assert result.work == pytest.approx(3e-3 * depth, rel=1e-9)
