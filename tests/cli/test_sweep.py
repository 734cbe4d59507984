"""The commands sweep, plot and map: output, files and refusals."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from cases import BALL, FAST, case_file
from commands import done, refused, run

CASE = case_file(title="Rubber", material=FAST)
AXES = """
[axes]
velocity = { logarithmic = ["1 cm/s", "10 m/s"], n = 12 }
radius = ["5 mm", "10 mm"]
"""


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    Path("ball.toml").write_text(CASE)
    Path("sweep.toml").write_text(CASE + AXES)


def test_sweep_stores_reports_its_time_and_resumes() -> None:
    answer = done("sweep", "sweep.toml", "--out", "out.zarr")
    assert answer.stderr.startswith("warning: small strain: ")
    assert re.fullmatch(r"24 impacts in out\.zarr; took \d+\.\d s\n", answer.stdout)
    result = rs.open_sweep("out.zarr")
    single = rs.solve(replace(BALL, profile=rs.Parabola(0.005), velocity=0.01))
    assert float(result.restitution_coefficient[0, 0]) == pytest.approx(
        float(single.restitution_coefficient), rel=1e-10
    )
    assert result.attrs["case"] == CASE + AXES
    assert run("sweep", "sweep.toml", "--out", "out.zarr").stdout == "24 impacts in out.zarr, 24 of them from before\n"


def test_failed_impacts_are_counted() -> None:
    Path("tip.csv").write_text("r_mm,f_um\n0,0\n1,50\n2,200\n")
    text = CASE.replace("[material]", '[profile]\ntype = "tabulated"\nfile = "tip.csv"\n[material]')
    Path("deep.toml").write_text(text + "[axes]\nvelocity = [0.01, 20]\n")
    answer = done("sweep", "deep.toml", "--out", "out.zarr")
    assert answer.stderr.startswith("warning: 1 of 2 impacts failed and are NaN: 1 TOO_DEEP\n")


def test_another_sweep_is_refused() -> None:
    run("sweep", "sweep.toml", "--out", "out.zarr")
    Path("sweep.toml").write_text(CASE.replace("5 g", "6 g") + AXES)
    assert "out.zarr: holds a sweep already" in refused("sweep", "sweep.toml", "--out", "out.zarr")


@pytest.mark.parametrize(
    ("words", "picture"),
    [
        pytest.param("plot out.zarr", "out.png", marks=pytest.mark.slow),
        ("plot out.zarr --out curve.pdf --output max_force --at radius=0.005", "curve.pdf"),
        pytest.param("map ball.toml --x velocity=1cm/s:10m/s --y nu=0:0.5", "ball-map.png", marks=pytest.mark.slow),
        ("map --x p2=0.001:10 --y p3=0.01:100 --set nu=0.45", "map.png"),
        (
            "map ball.toml --x body.radius=5mm:20mm --y material.viscosity=100:1e4 --output contact_time "
            "--set impact.velocity=2m/s --out c.png",
            "c.png",
        ),
    ],
)
def test_plot_and_map_draw(words: str, picture: str) -> None:
    arguments = words.split()
    if arguments[0] == "plot":
        run("sweep", "sweep.toml", "--out", "out.zarr")
    else:
        arguments += ["--points", "4"]
    answer = run(*arguments)
    assert (answer.exit_code, answer.stdout) == (0, f"{picture}\n")
    assert all("; exceeded in " in line for line in answer.stderr.splitlines())
    if arguments[0] == "plot":
        assert "warning: small strain" in answer.stderr
    assert Path(picture).stat().st_size > 1000


def test_axes_of_maps_are_logarithmic_over_a_wide_range(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    draw = rs.plot_sweep
    monkeypatch.setattr(
        rs, "plot_sweep", lambda data, *rest, **named: (seen.append(data), draw(data, *rest, **named))[1]
    )
    run("map", "ball.toml", "--x", "radius=5 mm:2 cm", "--y", "velocity=1 cm/s:10 m/s", "--points", "4")
    (data,) = seen
    assert data.restitution_coefficient.dims == ("radius", "velocity")
    np.testing.assert_allclose(data.radius, np.linspace(0.005, 0.02, 4))
    np.testing.assert_allclose(data.velocity, np.geomspace(0.01, 10.0, 4))


def test_slices_are_chosen_with_units_and_named_in_the_title(monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.plot import style

    titles = []
    save = style.save_figure
    monkeypatch.setattr(
        style, "save_figure", lambda figure, path: (titles.append(figure.get_suptitle()), save(figure, path))
    )
    run("sweep", "sweep.toml", "--out", "out.zarr")
    run("plot", "out.zarr", "--at", "radius=5 mm", "--output", "contact_time")
    run("plot", "out.zarr", "--at", "radius=0.01", "--output", "contact_time")
    axes = ("--x", "velocity=1:2", "--y", "radius=1mm:2mm", "--points", "3")
    run("map", "ball.toml", *axes, "--set", "nu=0.3", "--set", "mass=2 g")
    assert titles == ["Rubber\n$R$ = 5 mm", "Rubber\n$R$ = 10 mm", "Rubber\n$\\nu$ = 0.3, $m$ = 2 g"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--at", "radius=99"), "at radius = 99"),
        (("--at", "velocity=nan"), "at velocity = nan"),
        (("--at", "radius=abc"), "--at radius = 'abc': "),
        (("--at", "radius=5 s"), "--at radius = '5 s': "),
        (("--at", "mass=5"), "at = 'mass': "),
        (("--x", "radius", "--y", "radius"), "y = 'radius': "),
    ],
)  # fmt: skip
def test_invalid_slices_are_refused(arguments: tuple[str, ...], message: str) -> None:
    run("sweep", "sweep.toml", "--out", "out.zarr")
    assert refused("plot", "out.zarr", *arguments).startswith(message)
    assert not Path("out.png").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("sweep", "ball.toml", "--out", "o.zarr"), "ball.toml: axes: "),
        (("sweep", "none.toml", "--out", "o.zarr"), "none.toml: "),
        (("sweep", "sweep.toml", "--out", "no/o.zarr"), "o.zarr: "),
        (("sweep", "sweep.toml", "--out", "o.zarr", "--dask", "here"), "cluster = 'here': "),
        (("plot", "none.zarr"), "none.zarr: "),
        (("plot", ".", "--out", "p.png"), ".: "),
        (("plot", "out.zarr", "--out", "p.txt"), "--out p.txt: "),
        (("map", "ball.toml", "--x", "velocity", "--y", "nu=0:0.5"), "--x velocity: must be a name, = and what it is"),
        (("map", "ball.toml", "--x", "velocity=1", "--y", "nu=0:0.5"), "--x velocity=1: must be LOW:HIGH"),
        (("map", "ball.toml", "--x", "velocity=1:2", "--y", "radus=1mm:2mm"), "--y radus: "),
        (
            ("map", "ball.toml", "--x", "velocity=1:2", "--y", "radius=1mm:2mm", "--set", "body.speed=1"),
            "ball.toml: body.speed = 1: ",
        ),
        (
            ("map", "ball.toml", "--x", "velocity=1 m/s:100 cm/s", "--y", "radius=1mm:2mm"),
            "--x velocity=1 m/s:100 cm/s: low and high must differ",
        ),
        (("map", "--x", "p2=1:2", "--y", "p2=1:2"), "--y p2=1:2: p2 is given twice"),
        (
            ("map", "ball.toml", "--x", "nu=0:0.5", "--y", "radius=1mm:2mm", "--set", "material.poisson_ratio=0"),
            "--set material.poisson_ratio=0: material.poisson_ratio is given twice",
        ),
        (("map", "--x", "p2=1:2", "--y", "p3=1:2"), "--set nu=0.45"),
        (
            ("map", "ball.toml", "--x", "velocity=1:2", "--y", "nu=0:0.5", "--output", "contact_tme"),
            "--output = 'contact_tme': is not known; did you mean contact_time?",
        ),
    ],
)
def test_invalid_input_is_refused(arguments: tuple[str, ...], message: str) -> None:
    assert message in refused(*arguments)
    assert not list(Path().glob("*.zarr"))


def test_a_table_instead_of_a_store() -> None:
    done("sweep", "sweep.toml", "--out", "ev.csv")
    head, *rows = Path("ev.csv").read_text().splitlines()
    assert {"velocity [m/s]", "radius [m]", "restitution_coefficient [1]"} <= set(head.split(","))
    assert len(rows) == 24
    assert refused("sweep", "sweep.toml", "--out", "ev.xlsx").startswith("--out ev.xlsx: must end in .zarr")
    assert not Path("ev.xlsx").exists()


def test_json_of_sweeps_and_pictures_has_the_validity_of_the_impacts() -> None:
    for arguments, counted in (
        (("sweep", "sweep.toml", "--out", "out.zarr"), 24),
        (("plot", "out.zarr", "--output", "max_force"), 24),
        (("map", "ball.toml", "--x", "velocity=1cm/s:10 m/s", "--y", "radius=5mm:10mm", "--points", "3"), 9),
    ):
        answer = run(*arguments, "--json")
        assert (answer.exit_code, answer.stderr) == (0, "")
        content = json.loads(answer.stdout)
        assert content["impacts"] == counted
        strain = content["validity"]["small_strain"]
        # a/R = sqrt(d/R) exceeds 0.2 where d > R/25: at 10 m/s, but not at 1 cm/s.
        assert strain["exceeded"]
        assert 0 < strain["exceeded_in"] < counted
        assert f"{strain['message']}. {strain['advice']}" in content["warnings"]
        assert content["version"] == rs.__version__
