"""Case files of oblique impacts: those of an impact with a section on friction, spin and tangential velocity."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import model_validator

from restitution.case.impact import Case, CaseFile
from restitution.case.quantity import Reader
from restitution.case.section import Section, in_file, read_sections, read_toml, refuse
from restitution.files import path_of
from restitution.quantities import OBLIQUE_INPUTS

if TYPE_CHECKING:
    from restitution.impact.oblique import ObliqueResult


class ObliqueSection(Section):
    """Friction, spin, and the tangential velocity or the angle of incidence; the impact has the normal velocity."""

    friction: Annotated[float, Reader(OBLIQUE_INPUTS["friction"])]
    tangential_velocity: Annotated[float, Reader(OBLIQUE_INPUTS["tangential_velocity"])] | None = None
    angle: Annotated[float, Reader(OBLIQUE_INPUTS["angle"])] | None = None
    spin: Annotated[float, Reader(OBLIQUE_INPUTS["spin"])] = 0.0
    gyration: Annotated[float, Reader(OBLIQUE_INPUTS["gyration"])] = 0.4

    @model_validator(mode="after")
    def _check(self) -> ObliqueSection:
        self.one_of("tangential_velocity", "angle")
        return self

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `oblique`."""
        return self.model_dump(exclude_none=True)


class ObliqueFile(CaseFile):
    """A case file of an oblique impact."""

    elsewhere: ClassVar[dict[str, str]] = {
        name: advice for name, advice in CaseFile.elsewhere.items() if name != "oblique"
    }

    oblique: ObliqueSection

    @model_validator(mode="after")
    def _check_method(self) -> ObliqueFile:
        if self.solver.method != "exact":
            refuse('must be "exact" for an oblique impact', "solver.method", self.solver.method)
        return self


@dataclass(frozen=True)
class ObliqueCase:
    """An oblique impact as a case file describes it; `case` is that of its normal impact."""

    case: Case
    sections: ObliqueFile

    def solve(self) -> ObliqueResult:
        """Solve the impact; a `CaseError` refuses a number of the file, a `SolverError` reports a failure."""
        from restitution.impact.oblique import oblique

        with in_file(self.case.path, "oblique", rtol="solver", profile="", impedance="impact"):
            return oblique(self.case.impact, **self.sections.oblique.options, **self.case.options)


def read_oblique(path: str | Path) -> ObliqueCase:
    """Read a case file with the section `[oblique]`.

    Raises
    ------
    CaseError
        If the file cannot be read or describes no oblique impact, with a line for each mistake.

    Examples
    --------
    >>> import tempfile
    >>> text = '''
    ... [body]
    ... mass = "5 g"
    ... radius = "10 mm"
    ... [material]
    ... equilibrium_modulus = "1 MPa"
    ... branch_modulus = "10 MPa"
    ... viscosity = "1 kPa s"
    ... poisson_ratio = 0.5
    ... [impact]
    ... velocity = "1 m/s"
    ... [oblique]
    ... friction = 0.5
    ... tangential_velocity = "0.6 m/s"
    ... spin = "20 rad/s"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "ball.toml").write_text(text)
    ...     case = read_oblique(Path(folder, "ball.toml"))
    >>> print(round(case.solve().rebound_spin, 2))
    -43.3
    """
    path = path_of(path)
    sections = read_sections(ObliqueFile, path, read_toml(path))
    with in_file(path):
        impact = sections.build()
    options = {name: value for name, value in sections.solver.options.items() if name == "rtol"}
    return ObliqueCase(Case(path, sections.title, impact, options, sections), sections)
