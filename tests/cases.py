"""The ball of the README as a case file, whose sections a test replaces, and a faster one as an impact."""

import os
from pathlib import Path

import numpy as np

import restitution as rs

BODY = 'mass = "5 g"\nradius = "10 mm"\n'
SOLID = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "10 MPa"\nviscosity = "10 kPa s"\npoisson_ratio = 0.45\n'
IMPACT = 'velocity = "1 m/s"\n'

# With a tenth of the viscosity, as text and as objects.
FAST = SOLID.replace("10 kPa", "1 kPa")
RUBBER = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
BALL = rs.Impact(RUBBER, rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)


def case_file(
    path: str | os.PathLike[str] | None = None, /, *, title: str | None = None, **sections: str | None
) -> str:
    """Text of a case, written to `path`; a section is the text of its lines, None leaves one of the ball out."""
    named = {"body": BODY, "material": SOLID, "impact": IMPACT} | sections
    head = "" if title is None else f'title = "{title}"\n'
    text = head + "".join(f"[{name}]\n{lines.strip()}\n" for name, lines in named.items() if lines is not None)
    if path is not None:
        Path(path).write_text(text, encoding="utf-8")
    return text


TRIANGLE = 'depth = "1 um"\nshape = "triangle"\nloading_time = "1 s"\n'


def press_file(path: str, /, *, title: str | None = "A gel", **sections: str | None) -> str:
    """Text of an indentation of a gel, written to `path`; sections as in `case_file`."""
    named: dict[str, str | None] = {"body": None, "impact": None, "profile": 'radius = "2.5 um"'}
    named["material"] = (
        'shear = { equilibrium_modulus = "60 Pa", branch_moduli = "[250] Pa", relaxation_times = "[300] ms" }\n'
        'bulk_modulus = "incompressible"'
    )
    return case_file(path, title=title, **named | {"indentation": TRIANGLE} | sections)


def fit_file(path: str | os.PathLike[str] | None = None, /, *, title: str | None = None, **sections: str) -> str:
    """Text of an identification from rebounds in `balls.csv`, written to `path`; sections as in `case_file`."""
    data = {"[data]": 'kind = "rebounds"\nfile = "balls.csv"\nradius = "10 mm"\n' + sections.pop("data")}
    return case_file(path, title=title, body=None, material=None, impact=None, **sections | data)


def isotherms_file(path: str) -> None:
    """Write dynamic moduli at four temperatures that obey WLF with C1 = 9 and C2 = 110 K at 20 °C."""
    law, series = rs.WLF(293.15, 9.0, 110.0), rs.PronySeries(1e6, [3e6, 9e6, 2e7, 4e7], [10.0, 0.1, 1e-3, 1e-5])
    omega = np.geomspace(0.1, 100.0, 16)
    lines = ["omega,G',G'',T", "rad/s,Pa,Pa,°C"]
    for celsius in (10.0, 20.0, 30.0, 40.0):
        reduced = omega * law.factor(celsius + 273.15)
        columns = np.stack([omega, series.storage_modulus(reduced), series.loss_modulus(reduced)], axis=1)
        lines += [f"{','.join(map(repr, row))},{celsius}" for row in columns.tolist()]
    Path(path).write_text("\n".join(lines), encoding="utf-8")
