"""Case files: a TOML text becomes an impact and the options of its solver."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from restitution.case.schema import CaseFile
from restitution.case.section import CaseError, explain
from restitution.impact.problem import Impact

if TYPE_CHECKING:
    from restitution.impact.bounces import Bounces
    from restitution.impact.result import ImpactResult


@dataclass(frozen=True)
class Case:
    """An impact as a case file describes it.

    Attributes
    ----------
    path : Path
        The file.
    title : str or None
        What the file says that it describes.
    impact : Impact
        The problem, in SI.
    options : dict
        Keyword arguments of `solve`.
    sections : CaseFile
        What the file says, checked.
    """

    path: Path
    title: str | None
    impact: Impact
    options: dict[str, Any]
    sections: CaseFile = field(repr=False)

    def solve(self) -> ImpactResult:
        """Solve the impact as the file asks.

        Raises
        ------
        CaseError
            If the method refuses an option of the file.
        SolverError
            If no trustworthy result came of it.
        """
        # The solver takes 0.3 s to import, which a faulty file need not wait for.
        from restitution.impact.solve import solve

        try:
            return solve(self.impact, **self.options)
        except ValueError as error:
            option = str(error).split(" = ")[0]
            section = "solver." if option in self.options else ""
            raise CaseError(f"{self.path}: {section}{error}") from None

    def bounces(self) -> Bounces:
        """Bounces of the body until it rests, its weight included unless the file says `weight = false`.

        Raises
        ------
        CaseError
            If the file asks for what a body that bounces cannot have.
        SolverError
            If the solve of a bounce fails.
        """
        from restitution.case.bounces import bounces_of

        return bounces_of(self)

    def notes(self, result: ImpactResult | Bounces) -> list[str]:
        """What should be known of the materials: what was assumed, and whether their data cover the contacts.

        Parameters
        ----------
        result
            What `solve` or `bounces` returned.
        """
        lines: list[str] = []
        impact = result.impact
        assert isinstance(impact, Impact)
        durations = np.atleast_1d(result.contact_time)
        for material in (impact.material, impact.counter_material):
            if material is None:
                continue
            name = material.name or "material"
            if material.assumptions:
                lines.append(f"{name}: {material.assumptions}")
            uncovered = [float(t) for t in durations if material.window and not _covers(material.window, t)]
            if material.window and uncovered:
                low, high = material.window
                # The first bounce is the shortest; one line is enough.
                lines.append(
                    f"{name}: meant for {low:.3g} s to {high:.3g} s, and the contact lasts {uncovered[0]:.3g} s"
                )
        return lines


def _covers(window: tuple[float, float], contact_time: float) -> bool:
    return not math.isfinite(contact_time) or window[0] <= contact_time <= window[1]


def read_case(path: str | Path) -> Case:
    """Read a case file.

    Parameters
    ----------
    path : str or Path
        A TOML file. A quantity is a plain number in SI or a text with a unit such as "10 mm".

    Returns
    -------
    Case

    Raises
    ------
    CaseError
        If the file cannot be read or describes no impact: one line that names the file, the key, its value
        and what is wanted instead.

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
    ... viscosity = "10 kPa s"
    ... poisson_ratio = 0.45
    ... [impact]
    ... velocity = "1 m/s"
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "ball.toml").write_text(text)
    ...     case = read_case(Path(folder, "ball.toml"))
    >>> case.impact.mass
    0.005
    """
    path = Path(path)
    data = read_toml(path)
    try:
        case = CaseFile.model_validate(data, context={"folder": path.parent})
    except ValidationError as error:
        raise CaseError(explain(path, data, error)) from None
    try:
        impact = case.build()
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    return Case(path, case.title, impact, case.solver.options, case)


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises
    ------
    CaseError
        If it cannot be read, in one line.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise CaseError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise CaseError(f"{path}: is a folder, not a case file") from None
    except OSError as error:
        raise CaseError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError:
        raise CaseError(f"{path}: cannot be read: not a text file in UTF-8") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, where = str(error), ""
        if match := re.fullmatch(
            r"(.*) \(at (?:line (\d+), column (\d+)|(end of document))\)", what, re.DOTALL
        ):
            what = match[1]
            where = (
                f"line {match[2]}, column {match[3]}: "
                if match[2]
                else f"line {len(text.splitlines())}, at the end: "
            )
        raise CaseError(f"{path}: {where}not valid TOML: {what[:1].lower()}{what[1:]}") from None
    except RecursionError:
        raise CaseError(f"{path}: not valid TOML: nested too deeply") from None
    except ValueError as error:
        raise CaseError(f"{path}: not valid TOML: {error}") from None
