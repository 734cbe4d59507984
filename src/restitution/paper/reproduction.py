"""The whole paper in one call: figures, their data, and the claims."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from restitution.checks import whole, within
from restitution.errors import InputError
from restitution.files import whole_file, write_netcdf, write_text
from restitution.paper import claims as claims_of
from restitution.paper import figures
from restitution.paper.claims import Claim
from restitution.paper.figures import Computation
from restitution.plot.style import save_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DEFAULT_SEED = 2024
_FIGURES = 4


class Resolution(NamedTuple):
    """Resolution of the figures: points along each axis of a plane, of a curve and of the collapse, and its draws."""

    plane: int
    curve: int
    collapse: int
    draws: int

    @property
    def solves(self) -> int:
        """Total number of impacts."""
        of_paper = len(figures.CURVES) * (len(figures.POISSON_RATIOS) + 1)
        curves = of_paper + 2 * len(claims_of.TERMS)
        collapse = 2 * self.collapse**2 * self.draws
        return 2 * self.plane**2 + curves * self.curve + collapse + claims_of.number_of_solves()


FULL = Resolution(plane=161, curve=241, collapse=33, draws=6)
QUICK = Resolution(plane=33, curve=61, collapse=11, draws=3)


class Reproduction(NamedTuple):
    """Result of a reproduction of the paper: folder, files as written, claims, number and time of solves."""

    folder: Path
    files: tuple[Path, ...]
    claims: tuple[Claim, ...]
    solves: int
    seconds: float


@dataclass
class _Output:
    """The folder of results; keeps the record of files and of the work done."""

    folder: Path
    total: int
    progress: Callable[[int, int], None] | None
    drawing: int
    done: int = 0
    files: list[Path] = field(default_factory=list)

    def advance(self, units: int) -> None:
        self.done += units
        if self.progress is not None:
            self.progress(self.done, self.total)

    def text(self, name: str, content: str) -> None:
        self.files.append(write_text(self.folder / name, content))

    def figure(self, name: str, dataset: xr.Dataset, draw: Callable[[xr.Dataset], Figure]) -> xr.Dataset:
        """Write the data and the picture, and return the data."""
        path = self.folder / f"{name}.nc"
        write_netcdf(dataset, path)
        self.files.append(path)
        picture = draw(dataset)
        self.files.append(save_figure(picture, path.with_suffix(".png")))
        # The page keeps the layout of the picture; a new layout takes as long as all other drawing.
        picture.set_layout_engine("none")
        self.files.append(save_figure(picture, path.with_suffix(".pdf")))
        self.advance(self.drawing)
        return dataset


def reproduce(
    out: Path | str,
    *,
    quick: bool = False,
    seed: int = DEFAULT_SEED,
    workers: int | None = None,
    rtol: float = 1e-9,
    progress: Callable[[int, int], None] | None = None,
) -> Reproduction:
    """Compute and draw figures 3 to 6 of the paper, and judge its claims.

    Each figure is written as PNG, as PDF and as NetCDF data; the claims as `claims.md` and `claims.json`.
    Every file is complete or absent at any moment, and finished files stay if the run is interrupted.

    Parameters
    ----------
    out : path-like
        Folder for the results; made if absent, files of an earlier run in it are replaced.
    quick : bool
        Coarse grids, for a first look.
    seed : int
        Seed of the random dimensional inputs, >= 0.
    workers : int, optional
        Threads of the solver, >= 1; all cores by default. The results do not depend on it.
    rtol : float
        Relative tolerance of the restitution coefficient.
    progress : callable, optional
        Called with (done, total), in units of about one solved impact; drawing counts too.

    Returns
    -------
    Reproduction
        Folder, files, claims, number of solves and time [s].

    Raises
    ------
    InputError
        If `out` is a file, or a number is out of range.
    OSError
        If the folder cannot be written to.
    SolverError
        If an impact cannot be solved to `rtol`.

    Examples
    --------
    >>> import tempfile
    >>> from restitution.paper.reproduction import reproduce
    >>> with tempfile.TemporaryDirectory() as folder:  # doctest: +SKIP
    ...     [claim.holds for claim in reproduce(folder, quick=True).claims]
    [True, True, True, True, True, True, True]
    """
    started = time.perf_counter()
    seed = whole("seed", seed, 0)
    if workers is not None:
        workers = whole("workers", workers, 1)
    within("rtol", rtol, 1e-12, 1e-3)
    resolution = QUICK if quick else FULL
    # Drawing a figure takes as long as a twelfth of all solves and is counted so, for the estimate of the time left.
    drawing = resolution.solves // 12
    output = _Output(_folder(out), resolution.solves + _FIGURES * drawing, progress, drawing)
    computation = Computation(seed, rtol, workers, output.advance)

    planes = {
        n: output.figure(f"figure_{n}", figures.compute_plane(computation, n, resolution.plane), figures.draw_plane)
        for n in figures.PLANES
    }
    curves = {
        n: output.figure(f"figure_{n}", figures.compute_curves(computation, n, resolution.curve), figures.draw_curves)
        for n in figures.CURVES
    }
    draws = claims_of.compute_collapse(computation, resolution.collapse, resolution.draws)
    terms = claims_of.compute_terms(computation, resolution.curve)
    comparison = claims_of.compare(planes[3], planes[4])

    claims = (
        claims_of.three_groups(draws),
        claims_of.matters_where_small(comparison),
        claims_of.usually_underestimates(comparison, curves),
        claims_of.large_near_half(computation),
        claims_of.stiffer(),
        claims_of.several_times(terms),
        claims_of.two_spheres(computation),
    )
    output.text("claims.json", claims_of.as_json(claims, computation.attributes()))
    output.text("claims.md", claims_of.as_markdown(claims, computation.attributes()))
    seconds = time.perf_counter() - started
    return Reproduction(output.folder, tuple(output.files), claims, resolution.solves, seconds)


def _folder(out: Path | str) -> Path:
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InputError("out", str(folder), "must be a folder, and is a file")
    folder.mkdir(parents=True, exist_ok=True)
    # Refuse a folder without write permission now, not after the first figure.
    with whole_file(folder / "claims.md.probe") as partial:
        partial.touch()
    (folder / "claims.md.probe").unlink()
    return folder
