"""The files, figures and claims of the reproduction."""

import json
import re
from pathlib import Path

import further_figures
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh

from checkout import ROOT, blocks, run
from refusals import named
from restitution import Impact, Parabola, solve, standard_solid, standard_solid_restitution
from restitution.paper import claims, figures, reproduction
from restitution.paper.figures import BODIES, Computation, instantaneous_poisson_ratio
from restitution.paper.reproduction import Resolution, reproduce
from restitution.plot.style import new_figure

FIGURES = ("figure_3", "figure_4", "figure_5", "figure_6")
FURTHER = ("figure_incompressibility", "figure_collapse", "figure_examples", "figure_relaxation_times")
TINY = Resolution(plane=9, curve=9, collapse=3, draws=2)


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduction, "QUICK", TINY)


@pytest.fixture(scope="module")
def steps() -> list[tuple[int, int]]:
    return []


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory, steps: list[tuple[int, int]]):
    def progress(done: int, total: int) -> None:
        steps.append((done, total))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reproduction, "QUICK", TINY)
        return reproduce(tmp_path_factory.mktemp("reproduction"), quick=True, seed=11, progress=progress)


@pytest.fixture(scope="module")
def collapse() -> xr.Dataset:
    return claims.compute_collapse(Computation(seed=11), TINY.collapse, TINY.draws)


def read(path: Path) -> xr.Dataset:
    return xr.load_dataset(path, engine="h5netcdf")


def test_full_resolution_is_at_least_that_of_the_paper() -> None:
    assert reproduction.FULL.plane >= 161
    assert (figures.LOG_P2_RANGE, figures.LOG_P3_RANGE) == ((-3.0, 1.0), (-2.0, 2.0))
    assert figures.POISSON_RATIOS == (-1.0, -0.5, 0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499)
    assert figures.CURVES == {5: -2.0, 6: -3.0}


def test_every_figure_has_picture_page_and_data(outcome) -> None:
    expected = {f"{figure}{suffix}" for figure in FIGURES for suffix in (".nc", ".png", ".pdf")}
    assert {path.name for path in outcome.folder.iterdir()} == expected | {"claims.md", "claims.json"}
    assert {path.name for path in outcome.files} == expected | {"claims.md", "claims.json"}
    for figure in FIGURES:
        assert (outcome.folder / f"{figure}.png").read_bytes().startswith(b"\x89PNG")
        assert (outcome.folder / f"{figure}.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("figure", FIGURES)
def test_data_files_contain_units_version_seed_and_tolerance(outcome, figure: str) -> None:
    _has_units_version_seed_and_tolerance(read(outcome.folder / f"{figure}.nc"))


def _has_units_version_seed_and_tolerance(dataset: xr.Dataset) -> None:
    assert (dataset.attrs["seed"], dataset.attrs["rtol"]) == (11, 1e-9)
    assert dataset.attrs["version"]
    for name in dataset.variables:
        assert {"units", "long_name"} <= set(dataset[name].attrs), name


def test_data_files_contain_the_computed_values(outcome) -> None:
    computed = figures.compute_plane(Computation(seed=11), 3, 9)
    xr.testing.assert_identical(read(outcome.folder / "figure_3.nc"), computed)


@pytest.mark.parametrize("draw", [0, 1])
@pytest.mark.parametrize("nu", [0.45, 0.5])
def test_any_point_can_be_solved_again_from_its_stored_inputs(collapse, draw: int, nu: float) -> None:
    point = collapse.isel(p2=1, p3=2, draw=draw).sel(poisson_ratio=nu)
    mass, radius, velocity, modulus = (float(point[name]) for name in BODIES)
    material = standard_solid(modulus, modulus / float(point["p2"]), float(point["viscosity"]), poisson_ratio=nu)
    impact = Impact(material=material, profile=Parabola(radius=radius), mass=mass, velocity=velocity)
    restitution = float(solve(impact).restitution_coefficient)
    # Both values have an error within the tolerance.
    assert restitution == pytest.approx(float(point["restitution_coefficient"]), rel=2e-9, abs=2e-12)


def test_random_draws_collapse(collapse) -> None:
    e = collapse["restitution_coefficient"]
    assert e.sizes["draw"] == 2
    assert float(collapse["mass"].std("draw").min()) > 0.0
    assert float(abs(e.isel(draw=0) - e.isel(draw=1)).max()) <= 1e-9


@pytest.mark.slow
def test_the_study_writes_the_further_figures_with_their_data(tmp_path: Path) -> None:
    files = further_figures.write(tmp_path, TINY, seed=11)
    assert files == [tmp_path / f"{name}{end}" for name in FURTHER for end in (".nc", ".png", ".pdf")]
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in files}
    for path in files[::3]:
        _has_units_version_seed_and_tolerance(read(path))
    # The axes of the study are those of the figure, the draws those of the claim.
    collapse = claims.compute_collapse(Computation(seed=11), TINY.collapse, TINY.draws)
    xr.testing.assert_identical(read(tmp_path / "figure_collapse.nc"), collapse)


def test_claims_of_json_and_page_agree(outcome) -> None:
    written = json.loads((outcome.folder / "claims.json").read_text())["claims"]
    assert [claim["name"] for claim in written] == [claim.name for claim in outcome.claims]
    page = (outcome.folder / "claims.md").read_text()
    for claim in written:
        assert claim["finding"] in page
        assert claim["statement"] in page


def test_progress_grows_steadily_to_its_total(outcome, steps: list[tuple[int, int]]) -> None:
    done, totals = zip(*steps, strict=True)
    assert len(set(totals)) == 1
    assert list(done) == sorted(set(done))
    assert done[-1] == totals[0]
    assert outcome.solves < totals[0]


@pytest.mark.slow
def test_same_seed_gives_the_same_bytes_and_workers_do_not_matter(outcome, tmp_path: Path) -> None:
    again = reproduce(tmp_path, quick=True, seed=11, workers=1)
    for path in again.files:
        if path.suffix != ".nc":
            assert path.read_bytes() == (outcome.folder / path.name).read_bytes(), path.name
        else:
            xr.testing.assert_identical(read(path), read(outcome.folder / path.name))


@pytest.mark.parametrize("at", [1, 4])
def test_interrupted_run_leaves_whole_files(outcome, tmp_path: Path, at: int) -> None:
    calls = 0

    def interrupt(done: int, total: int) -> None:
        nonlocal calls
        calls += 1
        if calls == at:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path, quick=True, seed=11, progress=interrupt)
    left = sorted(tmp_path.iterdir())
    assert all(not path.name.startswith(".") for path in left)
    assert len(left) == 3 * (at // 2)
    for path in left:
        if path.suffix == ".nc":
            xr.testing.assert_identical(read(path), read(outcome.folder / path.name))
        else:
            assert path.read_bytes() == (outcome.folder / path.name).read_bytes()


def test_interrupt_while_data_are_written_leaves_no_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(path: Path, content: object) -> None:
        path.write_text("the first of it")
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path, quick=True)
    assert list(tmp_path.iterdir()) == []


def test_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(ValueError, match=r"out.*must be a folder"):
        reproduce(tmp_path / "out", quick=True)


@pytest.mark.parametrize(("option", "value"), [("seed", -1), ("seed", 1.5), ("workers", 0), ("rtol", 0.1)])
def test_bad_options_are_named_before_anything_is_made(tmp_path: Path, option, value) -> None:
    assert named(lambda: reproduce(tmp_path / "out", quick=True, **{option: value})) == (option, value)
    assert not (tmp_path / "out").exists()


def texts(ax) -> set[str]:
    return {text.get_text() for text in ax.texts}


@pytest.mark.parametrize("number", [3, 4])
def test_planes_name_their_groups_and_label_every_isoline(number: int) -> None:
    dataset = figures.compute_plane(Computation(seed=1), number, 81)
    ax, bar = figures.draw_plane(dataset).axes
    assert r"\log_{10}\,p_2" in ax.get_xlabel()
    assert r"p_2 = G_\infty\,/\,G_1" in ax.get_xlabel()
    assert r"\log_{10}\,p_3" in ax.get_ylabel()
    assert ("incompressible" if number == 4 else r"\nu = 0.45") in ax.get_title()
    assert "restitution" in bar.get_ylabel()
    e = dataset["restitution_coefficient"]
    reached = {f"{level:g}" for level in figures.LEVELS if float(e.min()) < level < float(e.max())}
    assert reached <= texts(ax)


@pytest.mark.parametrize("nu", [0.2, 0.45, 0.49])
def test_the_edge_of_negative_glassy_poisson_ratios(nu: float) -> None:
    ax = new_figure().add_subplot()
    figures.mark_negative_glass(ax, nu)
    p2 = 10.0 ** ax.lines[0].get_xdata()[0]
    if p2 < 10.0:
        assert instantaneous_poisson_ratio(nu, p2) == pytest.approx(0.0, abs=1e-12)
    # Ratios of the material on both sides of the edge.
    for factor, sign in ((0.9, -1.0), (1.1, 1.0)):
        at = factor * (1.0 - 2.0 * nu) / (3.0 * nu)
        material = standard_solid(1.0, 1.0 / at, 1.0, poisson_ratio=nu)
        assert material.instantaneous_poisson_ratio == pytest.approx(instantaneous_poisson_ratio(nu, at), abs=1e-12)
        assert sign * material.instantaneous_poisson_ratio > 0.0


def test_the_legend_has_both_poisson_ratios_and_auxetic_curves_are_thin() -> None:
    figure = figures.draw_curves(figures.compute_curves(Computation(seed=1), 5, 41))
    figure.draw_without_rendering()
    (ax,) = figure.axes
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert len(words) == len(figures.POISSON_RATIOS) + 1
    assert words[-2] == r"$\nu = 0.499$  ($\nu_0 = 0.41$)"
    assert not legend.get_window_extent().overlaps(ax.get_window_extent())
    assert "p_3" in ax.get_xlabel()
    widths = [line.get_linewidth() for line in ax.lines]
    assert widths[-2] > max(widths[:-2])
    assert {"0.49", "0.45", "\u22121"} <= texts(ax)


def test_incompressibility_shows_both_measures_of_the_error() -> None:
    planes = [figures.compute_plane(Computation(seed=1), figure, 41) for figure in (3, 4)]
    left, right, *bars = further_figures.draw_error(claims.compare(*planes)).axes
    assert r"(e_\mathrm{inc} - e)\,/\,e$" in bars[0].get_ylabel()
    assert r"(e - e_\mathrm{inc})\,/\,e_\mathrm{inc}$" in bars[1].get_ylabel()
    assert {"\u221210", "\u221290", "30"} <= texts(left)
    assert {"100", "1000"} <= texts(right)
    # The shading continues to negative excess, so that there are no steps along the edge.
    (shading,) = [part for part in right.collections if isinstance(part, QuadMesh)]
    assert np.asarray(shading.get_array()).min() < 0.0
    assert not np.ma.is_masked(shading.norm(shading.get_array()))


def test_examples_have_the_values_of_the_claim() -> None:
    first, second = further_figures.draw_examples(further_figures.compute_examples(Computation(seed=1), 41)).axes
    # Six digits of the paper's example from two independent programs.
    assert {"0.2197", "0.0066"} <= texts(first)
    for nu, shown in ((0.499, texts(second)), (0.5, texts(second))):
        assert f"{standard_solid_restitution(nu, 4.5e-3, 6.0):.4f}" in shown


def test_one_relaxation_time_is_the_material_of_the_paper() -> None:
    dataset = claims.compute_terms(Computation(seed=1), 7)
    for nu in (0.45, 0.5):
        e = dataset["restitution_coefficient"].sel(poisson_ratio=nu, terms=1)
        expected = standard_solid_restitution(nu, float(dataset["p2"]), dataset["p3"].values)
        assert e.values == pytest.approx(expected, rel=2e-9)


def test_collapse_shows_spread_against_tolerance() -> None:
    figure = further_figures.draw_collapse(claims.compute_collapse(Computation(seed=1), 5, 2))
    viscosity, p3, spread = figure.axes
    assert viscosity.get_xlabel() == r"viscosity $\eta$ [Pa s]"
    assert "p_3" in p3.get_xlabel()
    for x, y in np.vstack([line.get_xydata() for line in p3.lines]):
        # Points of 3.5 pt lie completely within the frame.
        assert p3.get_window_extent().padded(-1.75 / 72.0 * figure.dpi).contains(*p3.transData.transform((x, y)))
    assert "spread" in spread.get_xlabel()
    assert "tolerance" in [text.get_text() for text in spread.get_legend().get_texts()]


def test_the_page_of_the_documents_runs_and_shows_every_figure(capsys: pytest.CaptureFixture[str]) -> None:
    docs = ROOT / "docs"
    page = (docs / "reproduction.md").read_text(encoding="utf-8")
    run("docs/reproduction.md")
    assert [capsys.readouterr().out] == blocks("docs/reproduction.md", "text")
    drawn = re.findall(r"_static/(figure_\w+)\.(?:png|svg)$", page.replace("\r", ""), flags=re.MULTILINE)
    assert set(drawn) == {*FIGURES, *FURTHER, "figure_1", "figure_2"}
    for name in re.findall(r"_static/[\w.]+", page):
        assert (docs / name).is_file(), name
