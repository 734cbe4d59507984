"""Files of observations: their kind, units, standard deviations, and refusals with the line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from restitution import InputError, Rebounds
from restitution.case.observations import KINDS, read_observations
from restitution.identification.observations import Moduli

BALLS = """# measured on Monday
radius [mm];mass_g;velocity [cm/s];e [%];contact time [ms];sd_e
10;33;50;82;2.0;0.01
10;33;100;79;1,8;0.02
"""


pytestmark = pytest.mark.usefixtures("folder")


def written(text: str, name: str = "data.csv") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def test_rebounds_in_any_units() -> None:
    observations = read_observations(written(BALLS), noise={"contact_time": "1 %"})
    assert isinstance(observations, Rebounds)
    np.testing.assert_allclose(observations.velocity, [0.5, 1.0])
    np.testing.assert_allclose(observations.mass, 0.033)
    np.testing.assert_allclose(observations.restitution_coefficient, [0.82, 0.79])
    np.testing.assert_allclose(observations.measured["contact_time"], [2e-3, 1.8e-3])
    deviation = observations.noise.of("restitution_coefficient", observations.restitution_coefficient)
    assert deviation is not None
    np.testing.assert_allclose(deviation, [0.01, 0.02])
    assert (observations.label, observations.size) == ("data.csv", 4)


@pytest.mark.parametrize(
    "header", ["sd_e", "e_std", "std e", "restitution_coefficient_error", "err_restitution_coefficient", "e_sigma [-]"]
)
def test_standard_deviations_have_many_names(header: str) -> None:
    observations = read_observations(written(BALLS.replace("sd_e", header)), noise={"contact_time": "1 %"})
    assert isinstance(observations, Rebounds)
    deviation = observations.noise.of("restitution_coefficient", observations.restitution_coefficient)
    assert deviation is not None
    np.testing.assert_allclose(deviation, [0.01, 0.02])


def test_what_no_column_has_is_given_by_name() -> None:
    text = "velocity [m/s],e\n1.0,0.8\n2.0,0.7\n"
    observations = read_observations(written(text), radius=0.01, mass=0.03)
    assert isinstance(observations, Rebounds)
    np.testing.assert_array_equal(observations.mass, [0.03, 0.03])
    with pytest.raises(InputError, match="mass: is missing"):
        read_observations("data.csv", radius=0.01)
    with pytest.raises(InputError, match="line 2: column 'radius' is given twice"):
        read_observations(written(BALLS), radius=0.01, noise={"contact_time": "1 %"})


def test_a_temperature_in_degrees_is_in_kelvin() -> None:
    observations = read_observations(written("velocity,e,temperature [degC]\n1.0,0.8,20\n"), radius=0.01, mass=0.03)
    assert isinstance(observations, Rebounds)
    assert observations.temperature == pytest.approx([293.15])


def test_a_relaxation_is_no_series_of_bounces() -> None:
    observations = read_observations(written("time [s],G [MPa]\n0.1,5\n1,4\n10,3\n"))
    assert isinstance(observations, Moduli)
    assert observations.size == 3
    with pytest.raises(InputError, match="line 4: G = 'three'"):
        read_observations(written("time [s],G [MPa]\n0.1,5\n1,4\n10,three\n"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("velocity [m/s],e\n1,0.8\n2,1.7\n", r"line 3: restitution_coefficient = 1\.7: must be in \(0, 1\]"),
        ("velocity [m/s],e\n1,0.8\n-2,0.7\n", r"line 3: velocity = -2 m/s"),
        ("velocity [m/s],e\n1,0.8\n2,high\n", r"line 3: e = 'high'"),
        ("velocity [m/s],e\n1,0.8\n2\n", r"line 3: 1 values"),
        ("velocity [kg],e\n1,0.8\n", r"line 1: unit 'kg' of velocity"),
        ("velocity [m/s],e,contact_tme [ms]\n1,0.8,2\n", r"line 1: unknown column 'contact_tme'; did you mean"),
        (
            "velocity [m/s],contact_time [ms]\n1,2\n",
            r"line 1: must have the columns velocity and restitution_coefficient, or drop_height and rebound_height",
        ),
        ("v_in [cm/s],v_out\n100,0.8\n-200,0.7\n", r"line 3: velocity = -2 m/s: must be finite and > 0"),
        ("time,depth [nm]\n1,2\n", r"line 1: must have the columns time, depth, force"),
        ("", "is empty$"),
    ],
)
def test_wrong_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"^data\.csv: {message}"):
        read_observations(written(text), radius=0.01, mass=0.03)


@pytest.mark.parametrize("name", ["absent.csv", "absent.toml"])
def test_a_file_that_is_absent_is_named_once(name: str) -> None:
    with pytest.raises(InputError, match=rf"^{name}: no such file$"):
        read_observations(name, kind="rebounds")


def test_a_file_of_another_kind_is_refused() -> None:
    written(BALLS)
    for kind in set(KINDS) - {"rebounds", "moduli"}:
        with pytest.raises(InputError, match=r"^data.csv: line 2: "):
            read_observations("data.csv", kind=kind)
    Path("balls.toml").touch()
    with pytest.raises(InputError, match=r"^balls\.toml: is a case file"):
        read_observations("balls.toml")
    with pytest.raises(InputError, match="kind = 'rebound': must be one of"):
        read_observations("data.csv", kind="rebound")
    with pytest.raises(InputError, match="foo = 1: does not go with rebounds"):
        read_observations("data.csv", foo=1, noise={"contact_time": "1 %"})


def test_a_column_of_times_may_have_a_blank_before_its_unit() -> None:
    from restitution.case.quantity import read_columns
    from restitution.quantities import FORCE, TIME

    columns = read_columns(".", written("time [ms]  force [mN]\n1  2\n3  4\n"), {"time": TIME, "force": FORCE})
    np.testing.assert_allclose(columns["time"], [1e-3, 3e-3])
    np.testing.assert_allclose(columns["force"], [2e-3, 4e-3])


@pytest.mark.parametrize("change", [str.capitalize, str.upper, str.title])
def test_names_of_columns_may_have_capitals(change: Callable[[str], str]) -> None:
    head, *rows = "velocity;restitution coefficient;contact time [ms]\n0.5;0.8;2.0\n1.0;0.7;1.8\n".splitlines()
    names, unit = head.rsplit(" ", 1)
    header = ";".join(map(change, names.split(";")))
    balls = read_observations(written("\n".join([f"{header} {unit}", *rows])), radius=0.01, mass=0.03)
    assert isinstance(balls, Rebounds)
    np.testing.assert_allclose(balls.measured["contact_time"], [2e-3, 1.8e-3])
    with pytest.raises(InputError, match="line 1: unit 'counts' of velocity: is a dimensionless number"):
        read_observations(written("Velocity [counts],e\n0.5,0.8\n"), radius=0.01, mass=0.03)
