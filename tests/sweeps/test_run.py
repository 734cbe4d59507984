"""Sweeps in memory: every point equals the impact with its coordinates."""

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import cases
import checkout
import restitution as rs
from refusals import in_one_line, named, warns
from restitution import WLF, Cone, RestitutionWarning, Sphere, Tabulated, generalised_maxwell
from restitution.impact.batch import Batch
from restitution.quantities import ADHESION, DEFAULT_OUTPUTS, SWEEP_OUTPUTS, VALIDITY
from restitution.sweeps import plan
from restitution.sweeps.plan import describe
from restitution.sweeps.plan import hash_of as hash_of_plan

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RUBBER = replace(cases.RUBBER, name="rubber")
EPOXY = rs.Material(
    rs.PronySeries(1e6, [4e6, 2e6, 1e6], [1e-5, 1e-3, 1e-1]), 2e8, name="epoxy", shift=WLF(300.0, 10.0, 100.0)
)
STEEL = rs.Material(80e9, 160e9, name="steel")
BALL = replace(cases.BALL, material=RUBBER)
# The closed form of a standard solid and the general calculation differ by rounding.
ROUNDING = 1e-10


def check(result: xr.Dataset, impact: Callable[..., rs.Impact], rtol: float = ROUNDING) -> None:
    """Compare every point with the impact that `impact` builds from its coordinates."""
    dims = result.restitution_coefficient.dims
    for place in np.ndindex(*result.restitution_coefficient.shape):
        point = result.isel(dict(zip(dims, place, strict=True)))
        values = {str(name): point[name].values[()] for name in point.coords}
        single = rs.solve(impact(**values))
        for name in result.data_vars:
            if name in ("status", *DEFAULT_OUTPUTS):
                expected = float(getattr(single, str(name)))
                assert float(point[name]) == pytest.approx(expected, rel=rtol), (values, name)


def impact(material: rs.Material = RUBBER, radius: float = 0.01, **changes: Any) -> rs.Impact:
    return rs.Impact(material, rs.Parabola(radius), **({"mass": 0.005, "velocity": 1.0} | changes))


def test_quantities_of_the_body() -> None:
    axes = {
        "velocity": rs.Logarithmic(0.1, 10.0, 3),
        "radius": [0.005, 0.02],
        "mass": [0.01],
        "external_force": [0.0, 0.02],
    }
    check(rs.sweep(BALL, axes), impact, rtol=0.0)


def test_groups_of_the_paper() -> None:
    nu, p2, p3 = [-0.5, 0.3, 0.5], rs.Logarithmic(1e-3, 10.0, 4), np.array([0.1, 1.0, 10.0])
    result = rs.sweep(None, {"nu": nu, "p2": p2, "p3": p3})
    assert result.restitution_coefficient.dims == ("poisson_ratio", "p2", "p3")
    grid = np.meshgrid(nu, p2.values(0, 4), p3, indexing="ij")
    expected = rs.standard_solid_restitution(*grid)
    np.testing.assert_allclose(result.restitution_coefficient, expected, rtol=1e-12)
    single = rs.sweep(None, {"nu": 0.49, "p2": 1e-3, "p3": 10.0})
    assert single.restitution_coefficient.shape == ()
    assert float(single.restitution_coefficient) == pytest.approx(0.219706, abs=5e-7)


@pytest.mark.parametrize(("base", "others", "p2"), [(BALL, {}, 1e-320), (None, {"nu": 0.45, "p3": 1.0}, 1e308)])
def test_moduli_beyond_the_range_of_numbers_are_refused(base: Any, others: dict[str, Any], p2: float) -> None:
    # G1 = Ginf/p2 overflows, or the relaxation time eta/G1 does.
    error = in_one_line(lambda: rs.sweep(base, others | {"p2": [p2, 0.1]}, ["restitution_coefficient"]))
    assert error.field in ("relaxation_times", "branch_moduli")


def test_groups_of_a_dimensional_impact() -> None:
    axes = {"p2": [0.01, 0.1], "p3": [0.5, 5.0], "nu": [0.2, 0.5], "velocity": [0.3, 2.0], "radius": [0.01, 0.05]}
    result = rs.sweep(BALL, axes)
    for name in ("velocity", "radius"):
        spread = result.restitution_coefficient.max(name) - result.restitution_coefficient.min(name)
        assert float(spread.max()) < 1e-9
    groups = result.isel(velocity=0, radius=0)
    for place in np.ndindex(2, 2, 2):
        point = groups.isel(dict(zip(("p2", "p3", "poisson_ratio"), place, strict=True)))
        expected = rs.standard_solid_restitution(float(point.poisson_ratio), float(point.p2), float(point.p3))
        assert float(point.restitution_coefficient) == pytest.approx(expected, rel=ROUNDING)


def solid(**values: float) -> rs.Material:
    """RUBBER with other constants."""
    constants = {"equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e3} | values
    if "p2" in constants:
        constants["branch_modulus"] = constants["equilibrium_modulus"] / constants.pop("p2")
    if "relaxation_time" in constants:
        constants["viscosity"] = constants["branch_modulus"] * constants.pop("relaxation_time")
    if "equilibrium_modulus" in values:
        constants.setdefault("bulk_modulus", 29e6 / 3.0)
    return rs.standard_solid(
        **constants, **({} if {"poisson_ratio", "bulk_modulus"} & constants.keys() else {"poisson_ratio": 0.45})
    )


@pytest.mark.parametrize(
    "axes",
    [
        {"branch_modulus": [1e6, 3e7]},
        {"viscosity": [1e2, 1e4]},
        {"relaxation_time": [1e-5, 1e-3]},
        {"nu": [-1.0, 0.0, 0.5]},
        {"bulk_modulus": [0.0, 1e5, 1e9, math.inf]},
        {"p2": [0.01, 1.0]},
        {"equilibrium_modulus": [2e5, 4e6]},
        # There is no closed form for an equilibrium modulus of zero.
        {"equilibrium_modulus": [0.0, 1e6]},
        {"nu": [0.2, 0.4], "branch_modulus": [1e6, 3e7], "viscosity": [1e2, 1e3]},
    ],
    ids="-".join,
)
def test_constants_of_a_standard_solid(axes: dict[str, Any]) -> None:
    check(rs.sweep(BALL, axes), lambda **values: impact(solid(**values)))
    # Two deformable bodies need the general calculation.
    pair = rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, 1.0, counter_material=STEEL)
    check(rs.sweep(pair, axes), lambda **values: impact(solid(**values), counter_material=STEEL))


def test_the_poisson_ratio_may_be_kept_constant() -> None:
    axes = {"equilibrium_modulus": [2e5, 4e6]}
    result = rs.sweep(BALL, axes, held="poisson_ratio")
    check(
        result,
        lambda equilibrium_modulus: impact(rs.standard_solid(equilibrium_modulus, 1e7, 1e3, poisson_ratio=0.45)),
    )


def test_moduli_and_times_of_a_general_material() -> None:
    def material(**values: float) -> rs.Material:
        times = [1e-5, values["relaxation_times[1]"], 1e-1]
        moduli = [4e6, 2e6, values.get("branch_moduli[2]", 1e6)]
        return rs.Material(rs.PronySeries(1e6, moduli, times), 2e8)

    axes = {"relaxation_times[1]": [1e-4, 1e-2], "branch_moduli[2]": [0.0, 1e7], "velocity": [0.1, 1.0]}
    result = rs.sweep(impact(EPOXY), axes)
    check(result, lambda velocity, **values: impact(material(**values), velocity=velocity))


def test_poisson_ratio_of_a_general_material() -> None:
    series = rs.PronySeries(1e6, [4e6, 2e6], [1e-5, 1e-3])
    result = rs.sweep(impact(rs.Material(series, 1e8)), {"nu": [0.0, 0.3, 0.5]})
    check(
        result,
        lambda poisson_ratio: impact(generalised_maxwell(1e6, [4e6, 2e6], [1e-5, 1e-3], poisson_ratio=poisson_ratio)),
    )
    # A relaxing bulk modulus is scaled as a whole.
    relaxing = rs.Material(series, rs.PronySeries(1e7, [2e7], [1e-4]))
    result = rs.sweep(impact(relaxing), {"bulk_modulus": [1e7, 3e7]})
    check(
        result,
        lambda bulk_modulus: impact(
            rs.Material(series, rs.PronySeries(1e7, [2e7], [1e-4]).scaled(bulk_modulus / 1e7))
        ),
    )


@pytest.mark.parametrize("counter", [None, STEEL, EPOXY])
def test_temperature(counter: rs.Material | None) -> None:
    base = impact(EPOXY, counter_material=counter)
    result = rs.sweep(base, {"temperature": [290.0, 300.0, 330.0], "velocity": [0.1, 1.0]})

    def at(temperature: float, velocity: float) -> rs.Impact:
        other = counter.at(temperature) if counter is not None and counter.shift else counter
        return impact(EPOXY.at(temperature), velocity=velocity, counter_material=other)

    check(result, at)


def test_materials_from_a_list() -> None:
    result = rs.sweep(BALL, {"material": [RUBBER, EPOXY], "velocity": [0.1, 1.0], "counter_material": [STEEL]})
    assert result.material.values.tolist() == ["rubber", "epoxy"]
    materials = {"rubber": RUBBER, "epoxy": EPOXY}
    check(
        result,
        lambda material, velocity, counter_material: impact(
            materials[str(material)], velocity=velocity, counter_material=STEEL
        ),
    )
    solids = rs.sweep(
        BALL, {"material": [RUBBER, rs.standard_solid(1e6, 1e6, 1.0, poisson_ratio=0.1)], "nu": [0.3, 0.5]}
    )
    assert float(solids.restitution_coefficient[0, 0]) == pytest.approx(
        float(rs.sweep(BALL, {"nu": 0.3}).restitution_coefficient), rel=ROUNDING
    )


@pytest.mark.parametrize(
    ("profile", "field", "values"), [(Cone, "half_angle", [1.0, 1.2]), (Sphere, "radius", [0.005, 0.02])]
)
def test_other_profiles(profile: Any, field: str, values: list[float]) -> None:
    base = rs.Impact(EPOXY, profile(values[0]), mass=0.005, velocity=1.0)
    result = rs.sweep(base, {field: values, "velocity": [0.1, 0.5], "branch_moduli[0]": [1e6, 4e6]})

    def single(velocity: float, **numbers: float) -> rs.Impact:
        material = rs.Material(
            rs.PronySeries(1e6, [numbers.pop("branch_moduli[0]"), 2e6, 1e6], [1e-5, 1e-3, 1e-1]), 2e8
        )
        return rs.Impact(material, profile(**numbers), mass=0.005, velocity=velocity)

    # All velocities of a profile share a table with an error of 1e-12.
    check(result, single, rtol=1e-9)


@pytest.mark.parametrize(
    "profile", [rs.Parabola(0.01), Cone(1.2), Sphere(0.01), rs.PowerLaw(3.0, 1e4)], ids=lambda p: type(p).__name__
)
def test_each_coordinate_enters_its_impact(profile: Any) -> None:
    outputs = ("restitution_coefficient", "max_indentation_depth", "max_force")
    axes = {"mass": [0.002, 0.02], "velocity": [0.3, 2.0], "external_force": [0.0, 0.4]}
    table = rs.sweep(rs.Impact(RUBBER, profile, 0.005, 1.0), axes, outputs)
    expected = rs.solve(
        rs.Impact(
            RUBBER,
            profile,
            np.array(axes["mass"])[:, None, None],
            np.array(axes["velocity"])[:, None],
            external_force=axes["external_force"],
        )
    )
    for name in outputs:
        np.testing.assert_allclose(table[name], getattr(expected, name), rtol=1e-9, err_msg=name)
    # All three coordinates matter.
    e = expected.restitution_coefficient
    for axis in range(3):
        assert np.all(np.abs(np.diff(e, axis=axis)) > 1e-6)


def test_a_function_of_some_axes_and_columns_for_the_others() -> None:
    calls: list[float] = []

    def sphere_of(radius: float, density: float = 1100.0) -> rs.Impact:
        calls.append(radius)
        return impact(radius=radius, mass=density * 4.0 / 3.0 * math.pi * radius**3)

    result = rs.sweep(sphere_of, {"velocity": rs.Logarithmic(0.1, 10.0, 50), "radius": [0.005, 0.01]}, workers=1)
    check(
        result.isel(velocity=[0, 49]),
        lambda velocity, radius: impact(
            radius=radius, mass=1100.0 * 4.0 / 3.0 * math.pi * radius**3, velocity=velocity
        ),
    )
    # The function is called for each radius and not for each of the hundred points.
    assert len(calls) <= 4


def test_every_output() -> None:
    rough = impact(friction=0.3, tangential_velocity=0.05)
    # Those of adhesion are in test_adhesion.
    names_of_it = [name for name in SWEEP_OUTPUTS if name not in ADHESION]
    result = rs.sweep(rough, {"velocity": [0.1, 1.0]}, names_of_it)
    for n, velocity in enumerate((0.1, 1.0)):
        single = rs.solve(rs.vary(rough, {"velocity": velocity}))
        for name in set(names_of_it) - set(VALIDITY):
            names = {
                "kinetic_energy_in": "kinetic_in", "kinetic_energy_out": "kinetic_out",
                "dissipated_energy": "dissipated", "stored_energy": "stored", "energy_residual": "residual",
                "radiated_energy": "radiated",
            }  # fmt: skip
            expected = getattr(single.energy, names[name]) if name in names else getattr(single, name)
            assert float(result[name][n]) == expected, name


def test_attributes_of_the_result() -> None:
    result = rs.sweep(BALL, {"velocity": rs.Logarithmic(0.1, 1.0, 3), "external_force": 0.0}, title="Rubber")
    assert result.velocity.attrs == {
        "units": "m/s",
        "long_name": "impact velocity",
        "symbol": "$v_0$",
        "scale": "logarithmic",
    }
    assert result.contact_time.attrs["units"] == "s"
    assert float(result.external_force) == 0.0
    assert result.status.attrs["flag_meanings"].split()[:2] == ["separated", "sinks_in"]
    assert result.attrs["version"] == rs.__version__
    assert result.attrs["title"] == "Rubber"
    assert len(result.attrs["hash"]) == 64
    assert '"radius":0.01' in result.attrs["sweep"]
    names = ["restitution_coefficient", "contact_time", "max_indentation_depth", "max_force", "status"]
    assert list(result.data_vars) == names


def test_the_hash_depends_on_the_numbers_only() -> None:
    def hash_of(base: Any = BALL, axes: Any = None, **options: Any) -> str:
        return rs.sweep(base, axes or {"velocity": [1.0, 2.0]}, **options).attrs["hash"]

    first = hash_of()
    assert first == hash_of(impact(), workers=2, title="other words")
    others = [
        hash_of(impact(mass=0.006)),
        hash_of(impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=np.nextafter(0.45, 1.0)))),
        hash_of(axes={"velocity": [1.0, np.nextafter(2.0, 3.0)]}),
        hash_of(outputs=["max_force"]),
        hash_of(rtol=1e-8),
        hash_of(chunk=1),
        hash_of(held="poisson_ratio"),
        hash_of(lambda: BALL),
        hash_of(lambda: impact(mass=0.006)),
    ]
    assert len({first, *others}) == 10


@pytest.mark.parametrize(
    ("text", "first", "second"),
    [
        ("f = lambda radius: make(radius, mass)", {"mass": 0.005}, {"mass": 0.006}),
        ("f = lambda radius, mass=given: make(radius, mass)", {"given": 0.005}, {"given": 0.006}),
        ("f = partial(make, mass=given)", {"given": 0.005}, {"given": 0.006}),
        ("f = lambda radius: make(radius, VALUE)", {"VALUE": "0.005"}, {"VALUE": "0.006"}),
    ],
)  # fmt: skip
def test_the_hash_of_a_function_includes_the_values_that_it_uses(
    text: str, first: dict[str, Any], second: dict[str, Any]
) -> None:
    def hash_of(**values: Any) -> str:
        names: dict[str, Any] = {"partial": partial, "make": lambda radius, mass: impact(radius=radius, mass=mass)}
        source = text.replace("VALUE", values.pop("VALUE", ""))
        exec(source, names | values, scope := {})
        return hash_of_plan(describe(scope["f"]))

    assert hash_of(**first) == hash_of(**first)
    assert hash_of(**first) != hash_of(**second)


def test_draws() -> None:
    draws = rs.Samples(64, {"mass": rs.LogNormal(0.005, 0.2), "branch_modulus": rs.Normal(1e7, 1e6)}, rng=4)
    result = rs.sweep(BALL, {"velocity": [0.5, 1.0], "draw": draws})
    assert result.restitution_coefficient.dims == ("velocity", "draw")
    assert result.mass.dims == result.branch_modulus.dims == ("draw",)
    check(
        result.isel(draw=[0, 17, 63]),
        lambda velocity, mass, branch_modulus: impact(
            rs.standard_solid(1e6, branch_modulus, 1e3, poisson_ratio=0.45), mass=mass, velocity=velocity
        ),
    )


def test_workers_chunks_and_neighbours_do_not_change_a_bit() -> None:
    """Compressible and incompressible rows, with and without a force, and some that fail."""
    seed = int(np.random.SeedSequence().generate_state(1)[0])
    random = np.random.default_rng(seed)
    ratios = random.permutation([-1.0, 0.5, 0.5, *random.uniform(-1.0, 0.5, random.integers(4, 12))])
    axes = {
        "velocity": np.exp(random.uniform(-5.0, 3.0, 2 * random.integers(3, 12) + 1)),
        "nu": ratios,
        "external_force": random.permutation([0.0, 0.0, 0.05, 50.0]),
    }
    whole = rs.sweep(BALL, axes, workers=1)
    for workers in (2, 3):
        chunk = {name: int(random.integers(1, 9)) for name in whole.restitution_coefficient.dims}
        other = rs.sweep(BALL, axes, chunk=chunk, workers=workers)
        xr.testing.assert_identical(other.drop_attrs(), whole.drop_attrs())
    order = [random.permutation(n)[: random.integers(1, n + 1)] for n in whole.restitution_coefficient.shape]
    some = {name: np.asarray(values)[places] for (name, values), places in zip(axes.items(), order, strict=True)}
    part = rs.sweep(BALL, some)
    at = whole.isel(dict(zip(whole.restitution_coefficient.dims, order, strict=True)))
    for name in part.data_vars:
        np.testing.assert_array_equal(part[name], at[name], err_msg=f"seed {seed}")


def test_progress_counts_up_to_all() -> None:
    seen: list[tuple[int, int]] = []
    thread = threading.get_ident()

    def progress(done: int, total: int) -> None:
        assert threading.get_ident() == thread
        seen.append((done, total))

    rs.sweep(BALL, {"velocity": rs.Linear(0.1, 1.0, 3000)}, progress=progress, chunk=500)
    counts = [done for done, _ in seen]
    assert counts[0] == 0
    assert counts == sorted(counts)
    assert seen[-1] == (3000, 3000)


def test_a_failed_point_is_nan_and_counted_and_affects_no_other() -> None:
    radius = np.linspace(0.0, 0.002, 50)
    tip = rs.Impact(RUBBER, Tabulated(radius, radius**2 / 0.02), 0.005, 1.0)
    with warns("failed"):
        result = rs.sweep(tip, {"velocity": [0.01, 5.0, 0.1]})
    assert result.status.values.tolist() == [0, 7, 0]
    assert np.isnan(result.max_force.values).tolist() == [False, True, False]


def test_a_point_that_is_not_admissible_fails_alone() -> None:
    # The normal distribution exceeds the temperature range of the shift.
    draws = rs.Samples(64, {"temperature": rs.Normal(300.0, 60.0)}, rng=1)
    with warns("failed"):
        result = rs.sweep(impact(EPOXY), {"draw": draws})

    def is_refused(temperature: float) -> bool:
        try:
            EPOXY.at(temperature)
        except ValueError:
            return True
        return False

    refused = [is_refused(temperature) for temperature in result.temperature.values]
    assert any(refused)
    np.testing.assert_array_equal(result.status.values, np.where(refused, rs.Status.INADMISSIBLE, rs.Status.SEPARATED))

    def build(radius: float) -> rs.Impact:
        if radius > 0.015:
            raise ValueError("radius: this one does not exist")
        return impact(radius=radius)

    with warns("failed"):
        result = rs.sweep(build, {"draw": rs.Samples(16, {"radius": rs.Uniform(0.01, 0.018)})})
    np.testing.assert_array_equal(np.isnan(result.contact_time.values), result.radius.values > 0.015)


@pytest.mark.parametrize(
    ("base", "axes", "options", "message"),
    [
        (BALL, {"qqq": [1.0]}, {}, "axes: the impact has no 'qqq'; known are mass, velocity, external_force"),
        (BALL, {"half_angle": [1.0]}, {}, "axes: the impact has no 'half_angle'"),
        (BALL, {"velocity": [1.0, -1.0]}, {}, r"velocity\[1\] = -1 m/s"),
        (BALL, {"p2": [1.0], "branch_modulus": [1e6]}, {}, "axes: p2 and branch_modulus set the same"),
        (BALL, {"nu": [0.1], "bulk_modulus": [1e6]}, {}, "axes: poisson_ratio and bulk_modulus set the same"),
        (BALL, {"temperature": [300.0]}, {}, "temperature = 300 K"),
        (BALL, {"branch_moduli[1]": [1e6]}, {}, r"axes: there is no branch_moduli\[1\]; the material has 1"),
        (impact(EPOXY), {"viscosity": [1e6]}, {}, "axes: branch_modulus, .* are of one branch"),
        (impact(EPOXY), {"p3": [1.0]}, {}, "axes: p3 belongs to a rigid parabola on a standard solid"),
        (impact(EPOXY), {"temperature": [300.0, 150.0]}, {}, "temperature = 150 K"),
        (impact(velocity=[1.0, 2.0]), {"mass": [1.0]}, {}, r"base: has shape \(2,\); must be a single"),
        (None, {"nu": 0.3, "p2": 1.0}, {}, "axes: must have p3 where no impact is given"),
        (lambda radius: BALL, {"velocity": [1.0]}, {}, "axes: must have 'radius', which the function takes"),
        (BALL, {"velocity": [1.0]}, {"outputs": ["e"]}, "outputs = 'e'"),
        (BALL, {"velocity": [1.0]}, {"outputs": ["max_forces"]}, "outputs = 'max_forces'"),
        (BALL, {"velocity": [1.0]}, {"outputs": []}, "outputs: must name at least one output"),
        (BALL, {"velocity": [1.0]}, {"rtol": 1.0}, "rtol = 1"),
        (BALL, {"velocity": [1.0]}, {"engine": "mpi"}, "engine = 'mpi'"),
        (BALL, {"velocity": [1.0]}, {"held": "nu"}, "held = 'nu'"),
        (BALL, {"velo": [1.0]}, {}, "axes: the impact has no 'velo'; did you mean velocity?"),
        (BALL, {"velocity": [1.0]}, {"workers": 0}, "workers = 0"),
        (BALL, {"velocity": [1.0]}, {"workers": "2"}, "workers = '2'"),
        (BALL, {"velocity": [1.0]}, {"outputs": [3]}, "outputs = 3"),
        # Each axis is short enough, but the product is too large.
        (
            BALL, {"velocity": rs.Linear(1.0, 2.0, 10**8), "mass": rs.Linear(1.0, 2.0, 10**7)}, {},
            r"axes: 1000000000000000 points take 3.3e\+07 GB, too much for the memory of this machine; give out=",
        ),
        (BALL, {"velocity": [1.0]}, {"engine": "dask", "cluster": "here"}, "cluster = 'here': must be"),
    ],
)  # fmt: skip
def test_invalid_input_is_refused(base: Any, axes: dict[str, Any], options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        rs.sweep(base, axes, **options)


def test_wrong_types_are_refused() -> None:
    with pytest.raises(TypeError, match=r"^base = 3: must be an Impact, a function that returns one, or None$"):
        rs.sweep(3, {"velocity": [1.0]})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="must return an Impact"):
        rs.sweep(lambda: 3, {"velocity": [1.0]})  # type: ignore[arg-type,return-value]
    with pytest.raises(TypeError, match=r"^axes = \['velocity'\]: must be a dict from names to values"):
        rs.sweep(BALL, ["velocity"])  # type: ignore[arg-type]
    for axes, options, expected in (
        ({3: [1.0]}, {}, ("axes", {3: [1.0]})),
        ({"velocity": "abc"}, {}, ("velocity", "abc")),
        ({"velocity": [1.0]}, {"out": 3}, ("out", 3)),
        ({"velocity": [1.0]}, {"outputs": 3}, ("outputs", 3)),
    ):
        assert named(partial(rs.sweep, BALL, axes, **options), TypeError) == expected


def test_too_little_memory_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    full = np.full

    def refuse(shape: Any, *rest: Any, **named: Any) -> Any:
        if shape == (2,):
            raise MemoryError
        return full(shape, *rest, **named)

    monkeypatch.setattr(np, "full", refuse)
    assert named(lambda: rs.sweep(BALL, {"velocity": [1.0, 2.0]})) == ("axes",)


def test_a_long_sweep_in_memory_advises_a_store(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of 3 points is estimated before the sweep; a limit of 0 h stands for one of 10^9 points."""
    monkeypatch.setattr(plan, "_LONG", 0.0)
    with pytest.warns(RestitutionWarning, match=r"^3 points take .* GB and about .* h on .* cores, .*out="):
        rs.sweep(BALL, {"velocity": [0.01, 0.02, 0.03]})


def test_more_points_than_fit_in_memory_go_into_a_store(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(plan, "_memory", lambda: 1000.0)
    axes = {"velocity": rs.Linear(1.0, 2.0, 30)}
    assert named(lambda: rs.sweep(BALL, axes)) == ("axes",)
    assert int(rs.sweep(BALL, axes, out=tmp_path / "r.zarr").status.max()) == 0


def test_an_error_in_a_worker_ends_the_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> Any:
        raise MemoryError("no more")

    monkeypatch.setattr(Batch, "solve", fail)
    with pytest.raises(MemoryError):
        rs.sweep(BALL, {"velocity": rs.Linear(0.1, 1.0, 5000)}, chunk=100, workers=2)


def test_a_chunk_is_solved_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    largest = 0
    solve = Batch.solve

    def watched(batch: Batch, *options: Any, **named: Any) -> Any:
        nonlocal largest
        largest = max(largest, batch.size)
        return solve(batch, *options, **named)

    monkeypatch.setattr(Batch, "solve", watched)
    monkeypatch.setattr(plan, "_BLOCK", 256)
    rs.sweep(BALL, {"velocity": rs.Linear(0.1, 1.0, 2000)}, chunk=2000)
    assert 128 < largest <= 256


def test_python_of_the_documentation_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names = checkout.run("docs/sweeps.md")
    assert names["plane"].restitution_coefficient.shape == (60, 60)
    assert len(capsys.readouterr().out.splitlines()) >= 2


def test_the_documentation_names_every_output() -> None:
    page = (checkout.ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    assert [name for name in SWEEP_OUTPUTS if f"`{name}`" not in page] == []
