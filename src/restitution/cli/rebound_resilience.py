"""The command `resilience`."""

from __future__ import annotations

from typing import Annotated

from restitution.cli import tables
from restitution.cli.options import CaseFile, Extrapolate, Json, Plot, option
from restitution.cli.terminal import compilation, report, user_input

# Times for which a fractional material holds: rebound tests last 1 to 20 ms.
_WINDOW = (1e-8, 1.0)


_STANDARDS = "ISO 4662, DIN 53512, ASTM D7121, ASTM D2632, ISO 8307 or ASTM D3574"


def _standards(incomplete: str) -> list[str]:
    from restitution.rebound_resilience.standards import STANDARDS

    return [name for name in STANDARDS if name.startswith(incomplete)]


def resilience(
    case: CaseFile,
    standard: Annotated[
        str, option(f"Standard of the test: {_STANDARDS}.", metavar="NAME", autocompletion=_standards)
    ] = "ISO 4662",
    temperature: Annotated[
        list[str] | None, option('Temperature, e.g. "23 degC"; may be repeated.', metavar="TEMPERATURE")
    ] = None,
    base: Annotated[
        list[str] | None,
        option("Hold of the pad: bonded, frictionless or half-space; may be repeated.", metavar="BASE"),
    ] = None,
    thickness: Annotated[
        str | None, option("Thickness of the pad in place of that of the standard.", metavar="LENGTH")
    ] = None,
    tip_radius: Annotated[
        str | None, option("Radius of the indentor in place of that of the standard.", metavar="LENGTH")
    ] = None,
    mass: Annotated[
        str | None, option("Mass of the indentor in place of that of the standard.", metavar="MASS")
    ] = None,
    measured: Annotated[
        float | None, option("Measured resilience in per cent; prints the loss tangent that it means.", metavar="R")
    ] = None,
    json: Json = False,
    plot: Plot = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Rebound resilience of the material of a case file in a standard test.

    Example: restitution resilience examples/rubber_pad.toml --standard "DIN 53512" --temperature "23 degC"
    """
    with user_input():
        from restitution.case.impact import read_case
        from restitution.impact.window import require_known_times
        from restitution.material.fractional import Window
        from restitution.quantities import LENGTH, MASS, TEMPERATURE
        from restitution.rebound_resilience.loss import implied_loss_tangent
        from restitution.rebound_resilience.resilience import resilience as of_standard

        kelvin = [tables.read_quantity("--temperature", text, TEMPERATURE) for text in temperature or []]
        replaced = {
            name: tables.read_quantity(f"--{name.replace('_', '-')}", text, unit)
            for name, text, unit in (
                ("thickness", thickness, LENGTH),
                ("tip_radius", tip_radius, LENGTH),
                ("mass", mass, MASS),
            )
            if text is not None
        }
        problem = read_case(case)
        material = problem.sections.material.build(Window(*_WINDOW))
        with compilation():
            found = of_standard(material, standard, temperature=kelvin or None, base=base or None, **replaced)
            require_known_times(found.validity["window"], extrapolate=extrapolate)
            implied = None if measured is None else implied_loss_tangent(measured)
    if json:
        tables.write_json(found.to_dict() | ({} if implied is None else {"implied_loss_tangent": implied._asdict()}))
    else:
        lines: list[str] = []
        if implied is not None:
            where = " to ".join(dict.fromkeys(f"{one:.3g}" for one in (found.frequency.min(), found.frequency.max())))
            lines.append(
                f"{measured:g} % means a loss tangent of {implied.loss_tangent:.3g} ({implied.low:.3g} to "
                f"{implied.high:.3g}) at the frequency of the contact, here {where} Hz"
            )
        tables.show(found.summary(), *lines)
        report("note", *problem.notes(problem.impact))
    if plot is not None:
        tables.save_picture(found.plot(), plot)
