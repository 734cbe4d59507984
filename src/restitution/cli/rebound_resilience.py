"""The command `resilience`."""

from __future__ import annotations

from typing import Annotated, Any

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import completed, option, quantity
from restitution.units import LENGTH, MASS, TEMPERATURE

# Times for which a fractional material holds: rebound tests last 1 to 20 ms.
_WINDOW = (1e-8, 1.0)


_STANDARDS = "ISO 4662, DIN 53512, ASTM D7121, ASTM D2632, ISO 8307 or ASTM D3574"


def resilience(
    case: cli.CaseFile,
    standard: Annotated[
        str,
        option(
            f"Standard of the test, by default the first: {_STANDARDS}.",
            "NAME",
            autocompletion=completed("resilience.STANDARDS"),
        ),
    ] = "ISO 4662",
    temperature: Annotated[
        list[float] | None, quantity("--temperature", TEMPERATURE, 'Temperature, e.g. "23 degC"; may be repeated.')
    ] = None,
    base: Annotated[
        list[str] | None,
        option(
            "Hold of the pad: bonded, frictionless or half-space, all if not given; may be repeated.",
            "BASE",
        ),
    ] = None,
    thickness: Annotated[
        float | None, quantity("--thickness", LENGTH, "Thickness of the pad in place of that of the standard.")
    ] = None,
    tip_radius: Annotated[
        float | None, quantity("--tip-radius", LENGTH, "Radius of the indentor in place of that of the standard.")
    ] = None,
    mass: Annotated[
        float | None, quantity("--mass", MASS, "Mass of the indentor in place of that of the standard.")
    ] = None,
    measured: Annotated[
        float | None, option("Measured resilience in per cent, 1 to 99.5; prints the loss tangent that it means.", "R")
    ] = None,
    json: cli.Json = False,
    plot: cli.Plot = None,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Rebound resilience of the material of a case file in a standard test.

    Example: restitution resilience examples/rubber_pad.toml --standard "DIN 53512" --temperature "23 degC"
    """
    with cli.user_input():
        from restitution.impact.window import require_known_times
        from restitution.material.fractional import Window

        problem = rs.read_case(case)
        material = problem.sections.material.build(Window(*_WINDOW))
        with cli.compilation():
            result = rs.resilience(
                material, standard, temperature=temperature or None, base=base or None, thickness=thickness,
                tip_radius=tip_radius, mass=mass,
            )  # fmt: skip
            require_known_times(result.validity["window"], extrapolate=extrapolate)
            implied = None if measured is None else rs.implied_loss_tangent(measured)
    lines, more = list[str](), dict[str, Any]()
    if implied is not None:
        more["implied_loss_tangent"] = implied
        where = " to ".join(dict.fromkeys(f"{rate:.3g}" for rate in (result.frequency.min(), result.frequency.max())))
        lines.append(
            f"{measured:g} % means a loss tangent of {implied.loss_tangent:.3g} ({implied.low:.3g} to "
            f"{implied.high:.3g}) at the frequency of the contact, here {where} Hz"
        )
    tables.answer(result, "", *lines, json=json, plot=plot, notes=problem.notes(problem.impact), **more)
