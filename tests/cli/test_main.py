"""The commands solve, standard-solid and reproduce; exit codes; the program in its own process."""

import json
import math
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from cases import case_file
from commands import done, refused, run
from restitution import ImpactResult, SolverError, Status, read_case
from restitution.cli import terminal
from restitution.impact import band, bounces
from restitution.impact import solve as solver
from restitution.impact.solution import Sampled, Trajectory
from restitution.paper import reproduction
from restitution.plot import rebounds

# These take the solver by its name, and must be loaded before a test replaces it.
LOADED = (band, bounces, rebounds)
KEYS = [
    "restitution_coefficient", "contact_time", "max_indentation_depth", "max_force", "max_contact_radius",
    "max_pressure", "max_semi_axes", "residual_indentation_depth", "rebound_velocity", "zero_overlap_time", "energy",
    "energy_residual", "status", "method", "rtol", "warnings", "validity", "version",
]  # fmt: skip
ANSI = re.compile(r"\x1b\[[0-9;]*m")


@pytest.fixture
def ball(folder: Path) -> Path:
    case_file("ball.toml", title="A [bold] ball")
    return folder


def result(**changes: Any) -> ImpactResult:
    """Made-up result with numbers that are easy to recognise."""
    times = np.array([0.0, 1e-3, 2e-3])
    motion = Trajectory(
        times, np.array([0.0, 2e-3, 1e-3]), np.array([1.0, 0.0, -0.5]), np.array([0.0, 0.1 + 0.2, 0.0]),
        np.array([0.0, 4e-3, 0.0]), stored_energy=np.array([0.0, 2e-3, 7.5e-5]),
        dissipated_energy=np.array([0.0, 5e-4, 1.8e-3]),
    )  # fmt: skip
    values: dict[str, Any] = {
        "restitution_coefficient": 0.5,
        "contact_time": 1.234567891e-3,
        "max_indentation_depth": 2e-3,
        "max_force": 12.5,
        "max_contact_radius": 4e-3,
        "residual_indentation_depth": 1e-3,
        "status": Status.SEPARATED,
        "impact": read_case("ball.toml").impact,
        "method": "exact",
        "rtol": 1e-9,
        "_solution": Sampled(motion, 1.8e-3, 7.5e-5, 0.0),
    }
    impact_result = ImpactResult(**(values | changes))
    # The largest pressure is made up, too.
    vars(impact_result)["max_pressure"] = 2e6
    return impact_result


def fake(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    monkeypatch.setattr(solver, "solve", lambda impact, **options: result(**changes))


def test_json_has_the_attributes_in_si(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch)
    answer = done("solve", "ball.toml", "--json")
    assert answer.stderr == ""
    content = json.loads(answer.stdout)
    assert sorted(content) == sorted(KEYS)
    assert content["contact_time"] == 1.234567891e-3
    assert content["max_pressure"] == 2e6
    assert content["max_semi_axes"] == [content["max_contact_radius"]] * 2
    # After the contact the body travels 1 mm at 0.5 m/s.
    assert content["zero_overlap_time"] == pytest.approx(3.234567891e-3, rel=1e-14)
    assert content["energy"] == {
        "kinetic_in": 2.5e-3,
        "kinetic_out": 6.25e-4,
        "dissipated": 1.8e-3,
        "stored": 7.5e-5,
        "radiated": 0.0,
        "residual": 0.0,
    }
    assert content["energy_residual"] == 0.0
    assert content["status"] == "SEPARATED"
    assert content["validity"]["small_strain"]["value"] == pytest.approx(0.5)
    assert content["warnings"][0].startswith(content["validity"]["small_strain"]["message"])


def test_json_has_no_infinite_numbers(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch, contact_time=math.inf, residual_indentation_depth=math.nan)
    content = json.loads(done("solve", "ball.toml", "--json").stdout)
    assert content["contact_time"] is None
    assert content["residual_indentation_depth"] is None


def test_the_table_of_an_elliptical_contact_has_its_semi_axes(ball: Path) -> None:
    gap = 'type = "ellipsoid"\nradius_1 = "20 mm"\nradius_2 = "5 mm"'
    case_file("roller.toml", body='mass = "5 g"', profile=gap)
    shown = [line for line in done("solve", "roller.toml").stdout.splitlines() if "semi-axis" in line]
    content = json.loads(done("solve", "roller.toml", "--json").stdout)
    long, short = content["max_semi_axes"]
    assert ["long " in line for line in shown] == [True, False]
    assert long * short == pytest.approx(content["max_contact_radius"] ** 2)
    for line, axis in zip(shown, (long, short), strict=True):
        assert f"{1e3 * axis:.4g}"[:4] in line
    assert "semi-axis" not in run("solve", "ball.toml").stdout


@pytest.mark.parametrize("columns", ["20", "300"])
def test_the_table_is_complete_at_any_width(ball: Path, monkeypatch: pytest.MonkeyPatch, columns: str) -> None:
    fake(monkeypatch)
    monkeypatch.setenv("COLUMNS", columns)
    answer = done("solve", "ball.toml")
    words = [line.split() for line in answer.stdout.splitlines()]
    assert words[0] == ["A", "[bold]", "ball"]
    assert ["contact", "time", "T", "1.23457", "ms"] in words
    assert ["largest", "normal", "force", "F_max", "12.5", "N"] in words
    assert ["largest", "contact", "pressure", "p_max", "2", "MPa"] in words
    assert ["restitution", "coefficient", "e", "0.5"] in words
    assert ["energy", "still", "stored", "E_s", "75", "µJ"] in words
    assert answer.stderr.startswith("warning: small strain: max(a/R, d/a) is 0.5, above the limit 0.2")


def test_the_papers_own_example(ball: Path) -> None:
    # Theory section 1 (Willert et al., Fig. 6): nu = 0.49, log10 p2 = -3, p3 = 10.
    content = json.loads(done("standard-solid", "--nu", "0.49", "--p2", "1e-3", "--p3", "10", "--json").stdout)
    assert sorted(content) == sorted(KEYS)
    assert content["restitution_coefficient"] == pytest.approx(0.219706, abs=5e-7)
    assert (content["method"], content["rtol"]) == ("exact", 1e-9)
    answer = run("standard-solid", "--nu", "0.5", "--p2", "1e-3", "--p3", "10", "--rtol", "1e-6")
    shown = next(line.split() for line in answer.stdout.splitlines() if line.split()[:1] == ["restitution"])
    assert float(shown[-1]) == pytest.approx(0.006553, abs=5e-7)
    assert "rtol 1e-06" in answer.stdout


def test_a_case_is_solved(ball: Path) -> None:
    # The same numbers through the dimensionless groups: p2 = 0.1, p3 = eta (v0 R/(m^2 Ginf^3))^(1/5).
    p3 = 1e4 * (0.01 / (0.005**2 * 1e18)) ** 0.2
    expected = solver.standard_solid_restitution(0.45, 0.1, p3)
    content = json.loads(done("solve", "ball.toml", "--json").stdout)
    assert content["restitution_coefficient"] == pytest.approx(expected, rel=1e-8)
    assert content["rebound_velocity"] == content["restitution_coefficient"]
    assert content["energy"]["kinetic_in"] == pytest.approx(0.0025, rel=1e-15)
    assert abs(content["energy_residual"]) < 1e-8


def test_a_captured_body(ball: Path) -> None:
    # Incompressible Maxwell half-space, far slower than its relaxation: it flows like a liquid.
    liquid = "equilibrium_modulus = 0\nbranch_modulus = 1e4\nviscosity = 1\nbulk_modulus = inf"
    case_file("ball.toml", material=liquid, impact='velocity = "0.5 mm/s"')
    content = json.loads(done("solve", "ball.toml", "--json").stdout)
    assert (content["status"], content["restitution_coefficient"]) == ("SINKS_IN", 0.0)
    assert content["contact_time"] is None
    assert done("solve", "ball.toml").stderr == f"warning: {Status.SINKS_IN.message}\n"
    for option, name in (("--history", "h.csv"), ("--plot", "p.png")):
        answer = run("solve", "ball.toml", "--json", option, name)
        message = f"error: {option} {name}: there is no whole contact to show: {Status.SINKS_IN.message}\n"
        assert (answer.exit_code, answer.stderr) == (2, message)
    assert os.listdir() == ["ball.toml"]


def test_the_note_of_the_kernel_looks_like_other_notes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from restitution.kernel import compile as compiler

    monkeypatch.setenv("FORCE_COLOR", "1")
    with terminal.compilation():
        compiler.write_note("compiling")
    compiler.write_note("compiling")
    coloured, plain = capsys.readouterr().err.splitlines()
    assert ANSI.sub("", coloured) == plain == "note: compiling"
    assert coloured != plain


def test_history_as_csv_and_netcdf(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch)
    done("solve", "ball.toml", "--history", "h.csv")
    done("solve", "ball.toml", "--history", "h.nc")
    lines = Path("h.csv").read_text().splitlines()
    columns = "time [s],indentation_depth [m],indentation_velocity [m/s],force [N],contact_radius [m]"
    assert lines[0] == columns + ",kinetic_energy [J],stored_energy [J],dissipated_energy [J]"
    # The file has enough digits to restore the number exactly.
    np.testing.assert_array_equal(np.array(lines[2].split(",")[:5], dtype=float), [1e-3, 2e-3, 0.0, 0.1 + 0.2, 4e-3])
    with xr.open_dataset("h.nc", engine="h5netcdf") as stored:
        assert stored.equals(result().history)
        assert {"title", "version", "mass", "velocity", "material", "profile"} <= set(stored.attrs)
    assert sorted(os.listdir()) == ["ball.toml", "h.csv", "h.nc"]


@pytest.mark.parametrize(
    "suffix", ["pdf", *(pytest.param(suffix, marks=pytest.mark.slow) for suffix in ("png", "svg"))]
)
def test_plot(ball: Path, suffix: str) -> None:
    done("solve", "ball.toml", "--plot", f"p.{suffix}")
    start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[suffix]
    assert Path(f"p.{suffix}").read_bytes().startswith(start)


def test_the_option_pressure_adds_the_picture(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.plot import impact as pictures

    drawn: list[Any] = []
    monkeypatch.setattr(pictures, "overview", lambda result, times, **_: drawn.append(times))
    monkeypatch.setattr("restitution.plot.style.save_figure", lambda figure, path: None)
    fake(monkeypatch)
    at = ("--pressure-at", "0.5 ms", "--pressure-at", "1e-3")
    done("solve", "ball.toml", "--plot", "p.png", *at)
    done("solve", "ball.toml", "--plot", "p.png")
    assert drawn == [[5e-4, 1e-3], None]
    assert refused("solve", "ball.toml", *at) == "--pressure-at: give --plot FILE as well"
    message = refused("solve", "ball.toml", "--plot", "p.png", "--pressure-at", "2 m")
    assert message.startswith('--pressure-at "2 m": ')


def test_times_outside_the_contact_are_refused(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch)
    message = refused("solve", "ball.toml", "--plot", "p.png", "--pressure-at", "1 s", "--json")
    assert message == "--pressure-at 1 s: must be within the contact, which lasts 0.00123457 s"


def test_a_file_that_cannot_be_finished_leaves_nothing_behind(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path, content: Any) -> None:
        path.write_text("half")
        raise OSError(28, "No space left on device")

    fake(monkeypatch)
    monkeypatch.setattr(Path, "write_bytes", full)
    answer = run("solve", "ball.toml", "--json", "--history", "h.nc")
    assert (answer.exit_code, answer.stderr) == (2, "error: h.nc: No space left on device\n")
    assert os.listdir() == ["ball.toml"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["solve", "none.toml"], "none.toml: no such file"),
        (["solve", "ball.toml", "--plot", "p.txt"], "--plot p.txt: must end in .png, .pdf or .svg"),
        (["solve", "ball.toml", "--history", "no/h.nc"], "--history no/h.nc: no such folder: no"),
        (["bounce"], "Missing argument 'CASE.toml'. (see: restitution bounce --help)"),
        (["standard-solid", "--nu", "0", "--p2", "0", "--p3", "1"], "p2 = 0: "),
    ],
)
def test_bad_input_ends_with_2_and_one_line(ball: Path, arguments: list[str], message: str) -> None:
    assert refused(*arguments).startswith(message)


@pytest.mark.parametrize(
    "arguments",
    [
        ["solv"],
        ["solve", "ball.toml", "--jsn"],
        ["standard-solid", "--nu", "a lot", "--p2", "1", "--p3", "1"],
        ["standard-solid", "--nu", "0", "--p2", "1"],
        ["standard-solid", "--nu", "0", "--p2", "1", "--p3", "1", "--method", "guess"],
        ["reproduce", "--workers", "0"],
        ["reproduce", "--seed", "-1"],
        ["reproduce", "--out", "ball.toml"],
    ],
)
def test_bad_command_lines_end_with_2_and_one_line(ball: Path, arguments: list[str]) -> None:
    # The wording comes from typer and depends on its version.
    assert refused(*arguments)


def test_a_case_that_the_solver_refuses(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(impact: Any, **options: Any) -> None:
        raise ValueError("rtol = 1e-30: must be in [1e-12, 1e-2]")

    monkeypatch.setattr(solver, "solve", refuse)
    assert refused("solve", "ball.toml") == "ball.toml: rtol = 1e-30: must be in [1e-12, 1e-2]"


def test_a_solver_that_fails_ends_with_3(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(impact: Any, **options: Any) -> None:
        raise SolverError(Status.NOT_ACCURATE)

    # In this order: the public name is loaded on its first use, and would stay the patched one.
    monkeypatch.setattr("restitution.solve", fail)
    monkeypatch.setattr(solver, "solve", fail)
    for arguments in (["solve", "ball.toml"], ["standard-solid", "--nu", "0", "--p2", "1", "--p3", "1"]):
        assert refused(*arguments, exit_code=3) == f"NOT_ACCURATE: {Status.NOT_ACCURATE.message}"


def test_an_interrupt_ends_with_130(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(impact: Any, **options: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(solver, "solve", interrupt)
    assert refused("solve", "ball.toml", exit_code=130) == "interrupted; every file written is whole"


def test_reproduce_passes_its_options_on(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}

    def reproduce(out: Path, **options: Any) -> SimpleNamespace:
        seen.update(out=out, **options)
        options["progress"](1, 2)
        claim = SimpleNamespace(holds=True, statement="Three numbers are enough.")
        return SimpleNamespace(claims=[claim], solves=7, files=["a", "b"], folder=out, seconds=1.25)

    monkeypatch.setattr(reproduction, "reproduce", reproduce)
    answer = done("reproduce", "--out", "there", "--quick", "--seed", "5", "--workers", "2")
    assert answer.stdout == "holds: Three numbers are enough.\n7 impacts, 2 files in there, 1.2 s\n"
    del seen["progress"]
    assert seen == {"out": Path("there"), "quick": True, "seed": 5, "workers": 2}
    run("reproduce")
    del seen["progress"]
    assert seen == {"out": Path("reproduction"), "quick": False, "seed": reproduction.DEFAULT_SEED, "workers": None}


# The program in its own process


def python(code: str, *arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **options)


def program(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return python("from restitution.cli.main import main; main()", *arguments, **options)


def test_version_and_help() -> None:
    answer = program("--version")
    assert (answer.returncode, answer.stderr) == (0, "")
    assert re.fullmatch(r"restitution \d+\.\d+\.\d+\n", answer.stdout)
    answer = program("--help")
    assert answer.returncode == 0
    for command in ("standard-solid", "solve", "reproduce", "--install-completion", "130"):
        assert command in answer.stdout


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; sys.argv = ['restitution', '--help']\n"
        "from restitution.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'numba', 'pint', 'xarray', 'matplotlib', 'pydantic'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    answer = python(code)
    assert answer.returncode == 0, answer.stderr


def test_no_command_shows_the_help_and_is_a_usage_error() -> None:
    answer = program()
    assert answer.returncode == 2
    assert "standard-solid" in answer.stdout + answer.stderr


def test_bad_input_gives_no_traceback_also_on_an_ascii_terminal(tmp_path: Path) -> None:
    case = tmp_path / "ball.toml"
    case_file(case, body='mass = "5 g"\nradius = "10 ä"')
    answer = program("solve", str(case), env=os.environ | {"PYTHONIOENCODING": "ascii"})
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr == (
        f'error: {case}: body.radius = "10 \\xe4": unknown unit \'\\xe4\'; write e.g. "10 mm", or a plain number in m\n'
    )


def test_ctrl_c_ends_with_the_signal_and_one_line(ball: Path) -> None:
    code = (
        "import signal, sys, time; sys.argv = ['restitution', 'solve', 'ball.toml']\n"
        # A shell that runs the tests in the background makes its children ignore the signal.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from restitution.impact import solve\n"
        "solve.solve = lambda impact, **options: (print('solving', flush=True), time.sleep(60))\n"
        "from restitution.cli.main import main; main()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "solving\n"
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=30)
    assert process.returncode == -signal.SIGINT
    assert stderr == "error: interrupted; every file written is whole\n"


@pytest.mark.parametrize("argument", ["--help", "--version"])
def test_a_reader_that_stops_early_is_no_error(argument: str) -> None:
    code = f"import sys; sys.stdin.read(); sys.argv = ['restitution', '{argument}']\n"
    code += "from restitution.cli.main import main; main()"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], **pipes) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        process.stdin.close()
        stderr = process.stderr.read()
    assert (process.returncode, stderr) == (0, b"")


def test_warnings_of_the_libraries_are_one_line_each() -> None:
    code = (
        "import sys, warnings; sys.argv = ['restitution', '--version']\n"
        "from restitution.cli import main, tables\n"
        "tables.version = lambda: warnings.warn('careful') or '1'\n"
        "main.main()"
    )
    answer = python(code)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "restitution 1\n", "warning: careful\n")


def test_a_case_of_another_command_is_refused_with_its_name(ball: Path) -> None:
    Path("tip.toml").write_text('[indentation]\ndepth = "1 um"\n')
    message = refused("solve", "tip.toml")
    assert message == (
        "tip.toml: indentation: does not belong here; a prescribed indentation is for `restitution indent`"
    )
    answer = run("indent", "ball.toml")
    assert answer.exit_code == 2
    assert answer.stderr.startswith("error: ball.toml: ")
    assert answer.stderr.endswith(": does not belong here; an impact is for `restitution solve`\n")


def test_a_file_of_another_command_is_refused_with_its_name(ball: Path) -> None:
    Path("tip.toml").write_text(
        '[profile]\nradius = 1\n[material]\nlibrary = "steel"\n[indentation]\ndepth = "1 um"\n'
    )
    for command in ("tap", "oscillate", "solve"):
        assert "indentation: does not belong here; a prescribed indentation is for" in refused(command, "tip.toml")
    Path("e.csv").write_text("t,E\n1,2\n")
    Path("e.wav").write_bytes(b"RIFF\xff\xff")
    assert "--material" in refused("solve", "e.csv")
    assert "`restitution bounces`" in refused("bounce", "e.wav")
    assert "`restitution bounce` " in refused("bounces", "ball.toml", "--radius", "1cm")
    assert refused("solve", "none.csv") == "none.csv: no such file"


def test_without_dimensions_only_the_poisson_ratio_is_checked() -> None:
    assert done("standard-solid", "--nu", "0.45", "--p2", "1", "--p3", "1").stderr == ""
    answer = run("standard-solid", "--nu", "0.45", "--p2", "0.01", "--p3", "1")
    assert answer.stderr.startswith("warning: Poisson ratio: the instantaneous one is -0.665, below the limit 0;")
    assert answer.stderr.count("\n") == 1
    content = json.loads(done("standard-solid", "--nu", "0.45", "--p2", "0.01", "--p3", "1", "--json").stdout)
    assert list(content["validity"]) == ["poisson_ratio"]
    assert len(content["warnings"]) == 1
