"""The page of all keys of case files. It is made from the sections that read them."""

from __future__ import annotations

import textwrap
import typing
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from restitution.case import axes, identification, impact, indentation, material, oscillation, profile, sweep
from restitution.case.observations import KINDS
from restitution.case.quantity import Reader
from restitution.case.section import Section

DOCS = Path(__file__).parent

# Keys that are no registered quantity, or whose meaning depends on the section.
WORDS = {
    "name": "name of the material in messages and pictures",
    "temperature": "temperature of the impact, to which the shift takes the moduli",
    "density": "density; the density of a solid sphere replaces the mass of a body",
    "reference_temperature": "temperature of the given moduli, or of the master curve of several temperatures",
    "superposition": "shifts of a file with several temperatures: free for each, the default, or by a law",
    "shift": "section with the law of the time-temperature shift, or the name of a table of shift factors",
    "temperature_range": "lowest and highest temperature of the law, such as `\"[-20, 100] degC\"`",
    "library": "name of a material of the library; `restitution material --list` prints them",
    "file": "name of a file in the folder of the case file",
    "shear": "a modulus (if elastic) or a section with a Prony series",
    "bulk": "a constant modulus or a section with a Prony series",
    "terms": "CSV file of the terms with the header `relaxation_time_s,relative_modulus` or "
    "`relaxation_time_s,branch_modulus_MPa`",
    "model": "name of the model; without it, the standard solid",
    "material_name": "name of the material in a deck of several",
    "deformation": "kind of the moduli, if the header of the file does not state it",
    "liquid": "whether the fitted equilibrium modulus is zero",
    "type": "type of the profile; the default is a parabola, or a table if there is one",
    "base": "whether the layer sticks to its rigid base or slides on it; the default is bonded",
    "strict": "whether materials are refused on a bonded layer where they make the theory approximate: "
    "those whose Poisson ratio relaxes; the default is false",
    "material": "section as `[material]`; the default is `[counter_material]`, or else the material of the body",
    "method": "method of solution",
    "depth": "largest indentation depth, with `shape`; or a list over `time`",
    "force": "largest force, with `shape`; or a list over `time`",
    "shape": "history of the depth or force",
    "time": "times of a list of `depth` or `force`, connected by straight lines; the same time twice is a step",
    "loading_time": "loading time of a triangle",
    "unloading_time": "unloading time of a triangle; the default is the loading time",
    "hold_time": "time of a triangle at its peak; the default is 0",
    "duration": "duration of a ramp, a hold or a sine arch",
    "rise_time": "duration of the ramp before a hold; the default is 0",
    "rtol": "relative tolerance",
    "window": "shortest and longest time of the data of the material; commands refuse contacts beyond it",
    "undetermined": "constants that the data behind the material do not determine; results warn of them",
    "noise": "table of standard deviations, such as `{ restitution_coefficient = 0.005, contact_time = \"1 %\" }`; "
    "a list of two is added in quadrature",
    "outputs": "computed outputs; [sweeps](sweeps.md#outputs) lists the names",
    "chunk": "number of points of a chunk along every axis, or a table of such numbers by axis",
}  # fmt: skip

INTRODUCTION = """# Case files

A case file is a [TOML](https://toml.io) file. A quantity is a plain number in SI units or a string with a unit:
`radius = "10 mm"`. A list holds numbers or such strings; it may also be one string: `"[1, 2, 3] ms"`. Moduli are shear
moduli unless the key contains `bulk` or `youngs`. Unknown keys are refused. The folder `examples/` has examples.

| file | sections | command |
|---|---|---|
| impact | `[body]`, `[material]`, `[impact]`; others are optional | `restitution solve`, `surrogate`, `map` |
| bounces | the same; also `[bounces]` | `restitution bounce` |
| indentation | `[profile]`, `[material]`, `[indentation]`; others are optional | `restitution indent` |
| oscillation | `[profile]`, `[material]`, `[oscillation]`; others, e.g. `[axes]`, optional | `restitution oscillate` |
| tapping | `[profile]`, `[material]`, `[tapping]`; others are optional | `restitution tap` |
| identification | `[identification]`, `[[data]]` | `restitution identify` |
| design | `[material]`, `[design]` | `restitution design` |
| sweep | an impact with `[axes]` or `[samples]`; also `[sweep]` | `restitution sweep` |

Without `[counter_body]` the body hits a half-space. `[material]` and `[counter_material]` are then the materials of
the body and the half-space in any order. Without `[counter_material]` one of the two is rigid. The order changes no
result. Only the warning of elastic waves depends on it: `material_of = "body"` in `[impact]` states that the body is
of `[material]`, and that its size, not that of the target, holds the waves.

With `friction` in `[impact]` the impact is oblique: it takes a `tangential_velocity` or an `angle`, and a `spin`. The
angle keeps the normal `velocity`; with `speed` in place of it, that of the centre.
"""
UNCERTAINTY = """
## Standard deviations

A number of an impact may have a standard deviation behind its value: `"10 +- 0.5 MPa"`, `"(10 ± 0.5) MPa"` or
`"10 MPa +- 5 %"`, and in a list `"[4 +- 0.2, 3 +- 0.1] MPa"`. `restitution solve` takes them to the outputs; see
[error bars](error_bars.md). Bounces, standard tests, exports and surrogates take the values alone; other files refuse
them. A percentage is written `"(45 +- 1) %"`. The deviation of a temperature is a difference: `"20 +- 0.5 degC"`.
"""
AXES = """## `[axes]` and `[samples]`

A key of `[axes]` is a key of the case, such as `body.radius` or `material.density`, or one of these short names:
{names}.
Its value is a list, one value, or a table such as `{{ linear = [0.1, 1.0], n = 10 }}` or
`{{ logarithmic = ["1 cm/s", "10 m/s"], n = 50 }}`. `[axes]` with only `nu`, `p2` and `p3` is the problem of the paper.

`[samples]` has `n`, optionally `method` and `seed`, and a table for each random key: `uniform`, `loguniform`, `normal`
or `lognormal` with two numbers, such as `mass = {{ normal = ["5 g", "0.1 g"] }}`. See [sweeps](sweeps.md).
"""


def readers(annotation: Any) -> Iterator[Reader]:
    """Yield the readers of quantities within an annotation."""
    if isinstance(annotation, Reader):
        yield annotation
    for part in (*typing.get_args(annotation), *getattr(annotation, "__metadata__", ())):
        yield from readers(part)


def row(key: str, section: type[Section]) -> str:
    """Row of the table of a section."""
    field = section.model_fields[key]
    result = next((each for each in (*field.metadata, *readers(field.annotation)) if isinstance(each, Reader)), None)
    choices = [f'`"{value}"`' for part in (field.annotation, *typing.get_args(field.annotation))
               for value in typing.get_args(part) if isinstance(value, str)]  # fmt: skip
    words = field.description or WORDS.get(key) or (result.quantity.words if result else "")
    if len(choices) > 1:
        words += ": " + ", ".join(choices)
    unit = "" if result is None else result.quantity.unit or "-"
    if not field.is_required() and field.default is not None and isinstance(field.default, (int, float, str)):
        words += f"; the default is {field.default}" if not isinstance(field.default, bool) else ""
    return f"| `{key}`{' (required)' if field.is_required() else ''} | {unit} | {words} |"


def table(title: str, section: type[Section], keys: Iterable[str] = ()) -> list[str]:
    """Lines of the table of a section."""
    chosen = list(keys) or list(section.model_fields)
    return [
        "",
        f"## {title}",
        "",
        "| key | unit | meaning |",
        "|---|---|---|",
        *(row(key, section) for key in chosen),
    ]


def page() -> str:
    """Return the page as MyST Markdown."""
    shared = list(material.MaterialSection.model_fields)
    lines = [
        INTRODUCTION.rstrip(),
        "",
        "A modulus in mPa (0.001 Pa) is refused, because it is nearly always a slip for MPa. Write so small a",
        "modulus in Pa. A viscosity in mPa s is read.",
        "",
        "A case file has at most 20 million characters, and so has a saved surrogate. Longer tables belong in CSV",
        "files, which have at most 20 MB; see [materials](materials.md#files).",
    ]
    lines += ["", "The key `title` at the top of the file is printed above the results."]
    lines += [
        "",
        "Names of files in a case file may lead to any place that you may read. A service that runs the files of",
    ]
    lines += ["others has to confine them."]
    lines += table("`[body]`", impact.BodySection)
    lines += table("`[counter_body]`: a second, free body", impact.CounterBodySection)
    lines += ["", "## `[profile]`", "", "| type | keys |", "|---|---|"]
    for name, kind in sorted(profile.sections().items()):
        shown = [key for key in kind.model_fields if key != "type" and key not in profile.LAYER]
        keys = ", ".join(f"`{key}`{_unit(kind, key)}" for key in shown)
        lines.append(f"| `\"{name}\"` | {keys} |")  # fmt: skip
    lines += [
        "",
        "The default `radius` of a parabola, a sphere and a flat-ended parabola is that of the body.",
    ]
    lines += [
        "The lists `r` and `f` of a table are radii and heights. `file` is a CSV file with these columns instead.",
        "A force law has the columns `depth` and `force`.",
    ]
    lines += table("`[profile]` of an axisymmetric body: a layer", profile.sections()["parabola"], profile.LAYER)
    lines += table("`[material]` and `[counter_material]`: all forms", material.MaterialSection, shared)
    lines += ["", "## `[material]` by a model", "", "| model | keys |", "|---|---|"]
    for name, model in material.models().items():
        shown = [key for key in model.model_fields if key not in shared and key != "model"]
        lines.append(f"| `\"{name}\"` | {', '.join(f'`{key}`{_unit(model, key)}' for key in shown)} |")  # fmt: skip
    lines += [
        "",
        "Give one of `poisson_ratio` and `bulk_modulus`, and one of `shear_modulus` and `youngs_modulus`.",
    ]
    lines += ["An incompressible material has `poisson_ratio = 0.5` or `bulk_modulus = "
    "\"incompressible\"`."]  # fmt: skip
    for title, section in (
        ("`[material]` by its relaxation", material.GeneralSection),
        ("`[material]` from the library", material.LibrarySection),
        ("`[material]` from a file", material.FileSection),
    ):
        lines += table(title, section, [key for key in section.model_fields if key not in shared])
    lines += table("`[material.shear]`, `[material.bulk]`: a Prony series", material.PronySection)
    lines += table("`[material.shift]`: Williams, Landel and Ferry", material.WLFSection)
    lines += table("`[material.shift]`: Arrhenius", material.ArrheniusSection)
    lines += [*table("`[impact]`", impact.ImpactSection), *table("`[bounces]`", impact.BouncesSection)]
    lines += table("`[adhesion]` of an impact or an indentation", impact.AdhesionSection)
    lines += table("`[solver]` of an impact", impact.SolverSection)
    lines += [*UNCERTAINTY.rstrip().split("\n"), *table("`[uncertainty]` of an impact", impact.UncertaintySection)]
    lines += table("`[indentation]`", indentation.IndentationSection)
    lines += table("`[oscillation]`", oscillation.OscillationSection)
    lines += table("`[tapping]`", oscillation.TappingSection) + table("`[[tapping.modes]]`", oscillation.ModeSection)
    lines += table("`[solver]` of an indentation", impact.AccuracySection)
    lines += table("`[identification]`", identification.IdentificationSection)
    lines += [
        "",
        "## `[[data]]`",
        "",
        "One section for each set of data: `kind`, `file`, `noise`, and the keys of its kind.",
    ]
    lines += ["", "| kind | columns of the file | keys |", "|---|---|---|"]
    for name, columns_of in KINDS.items():
        section = identification.data_section(name)
        shown = [key for key in section.model_fields if key not in identification.DataSection.model_fields]
        columns = ", ".join(f"`{column}`" for column in columns_of.required) or "as `material.file`"
        more = f"; also {', '.join(f'`{column}`' for column in columns_of.optional)}" if columns_of.optional else ""
        keys = ", ".join(f"`{key}`{_unit(section, key)}" for key in shown)
        lines.append(f'| `"{name}"` | {columns}{more} | {keys} |')
    lines += [
        "",
        "A column of standard deviations has the prefix `sd_`, or one of `std`, `err`, `error`, `sigma` before or "
        "behind its",
        "name. The header has the units, as in `velocity [m/s]`.",
        '`counter_material` is a section as `[material]`, but no fractional model, or `"same"` for the unknown',
        "material; without it the other body is rigid.",
    ]
    lines += table("`[design]`", identification.DesignSection)
    names = ", ".join(f"`{name}`" for name in axes.SHORT_NAMES)
    names = textwrap.fill(names, 116, break_long_words=False, break_on_hyphens=False)
    lines += ["", AXES.format(names=names).rstrip()]
    lines += table("`[sweep]`", sweep.SweepSection)
    return "\n".join(lines) + "\n"


def _unit(section: type[Section], key: str) -> str:
    field = section.model_fields[key]
    result = next((each for each in (*field.metadata, *readers(field.annotation)) if isinstance(each, Reader)), None)
    return f" [{result.quantity.unit}]" if result is not None and result.quantity.unit else ""


def write() -> None:
    """Write the page, if it is not the same already."""
    file, text = DOCS / "case_files.md", page()
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write()
