"""Settings, colours and file formats of figures."""

import struct
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from restitution.plot import style
from restitution.quantities import HISTORY


def settings() -> dict:
    return {name: value for name, value in matplotlib.rcParams.items() if name != "backend"}


@pytest.fixture
def figure():
    with style.context():
        picture = style.new_figure(3.0, 2.0)
        ax = picture.add_subplot()
        ax.plot([0.0, 1.0], [0.0, 1.0])
        ax.set_xlabel(r"time $t$ [µs]")
    return picture


def test_context_restores_the_users_settings_even_after_an_error() -> None:
    before = settings()
    with pytest.raises(KeyError, match="42"), style.context():
        raise KeyError(matplotlib.rcParams["pdf.fonttype"])
    assert settings() == before


def test_use_sets_the_look_for_all_figures() -> None:
    with matplotlib.rc_context():
        style.use()
        assert matplotlib.rcParams["font.size"] == 9.0


def test_context_overrides_the_users_own_style() -> None:
    with matplotlib.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "red"}), style.context():
        assert matplotlib.rcParams["lines.linewidth"] == 1.3
        assert matplotlib.rcParams["axes.facecolor"] == "white"


def test_pdf_embeds_truetype_fonts_only(figure, tmp_path: Path) -> None:
    content = style.save_figure(figure, tmp_path / "picture.pdf").read_bytes()
    assert b"/FontFile2" in content
    assert b"/Type3" not in content


@pytest.mark.parametrize("suffix", ["pdf", "png", "svg"])
def test_same_figure_gives_the_same_bytes(figure, tmp_path: Path, suffix: str, monkeypatch) -> None:
    first = style.save_figure(figure, tmp_path / f"first.{suffix}").read_bytes()
    # With this variable the date of the second file would differ.
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    second = style.save_figure(figure, tmp_path / f"second.{suffix}").read_bytes()
    assert first == second


def test_unknown_formats_are_refused(figure, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"path.*\.pdf, "):
        style.save_figure(figure, tmp_path / "picture.xyz")
    assert list(tmp_path.iterdir()) == []


def test_interrupted_save_leaves_the_old_file(figure, tmp_path: Path, monkeypatch) -> None:
    path = style.save_figure(figure, tmp_path / "picture.png")
    before = path.read_bytes()

    def interrupted(partial: Path, **_: object) -> None:
        Path(partial).write_bytes(b"half a pic")
        raise KeyboardInterrupt

    monkeypatch.setattr(figure, "savefig", interrupted)
    with pytest.raises(KeyboardInterrupt):
        style.save_figure(figure, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_notebook_shows_a_figure_that_is_the_value_of_a_cell(figure) -> None:
    # IPython calls this method. The resolution is that of a screen, not of the printed page.
    picture = figure._repr_png_()
    assert picture.startswith(b"\x89PNG")
    width, height = struct.unpack(">II", picture[16:24])
    assert (width, height) == (300, 200)


@pytest.mark.usefixtures("figure")
def test_figures_are_unknown_to_pyplot() -> None:
    import matplotlib.pyplot as plt

    assert plt.get_fignums() == []


def luminance(color: str) -> float:
    channel = np.array(matplotlib.colors.to_rgb(color))
    linear = np.where(channel <= 0.04045, channel / 12.92, ((channel + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_family_colors_grow_lighter_and_stay_visible_on_white() -> None:
    from restitution.plot.style import family_colors

    values = [luminance(matplotlib.colors.to_hex(color)) for color in family_colors(9)]
    assert np.all(np.diff(values) > 0)
    # Contrast to white by WCAG; a line of 1.5 points is hard to see below 1.5.
    assert 1.05 / (values[-1] + 0.05) > 1.5


def test_curves_that_share_axes_share_their_units() -> None:
    """A second curve of another size, or of zeros, has the unit of the first; another quantity has its own."""
    ax = style.new_figure().add_subplot()
    time, radius, force = (HISTORY[name] for name in ("time", "contact_radius", "force"))
    for top in (2e-3, 3e-6, 0.0, 5.0):
        style.draw(ax, (time, [0.0, 1e-3]), (radius, [0.0, top]))
        assert "[mm]" in ax.get_ylabel()
        assert ax.lines[-1].get_ydata()[1] == pytest.approx(1e3 * top, rel=1e-15)
    style.draw(ax, (time, [0.0, 1e-3]), (force, [0.0, 2e3]))
    assert "[kN]" in ax.get_ylabel()
    ax.clear()
    style.draw(ax, (time, [0.0, 1e-3]), (radius, [0.0, 1e-6]))
    assert "[µm]" in ax.get_ylabel()
