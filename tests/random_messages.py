"""Random messages for the socket: requests with random inputs, damaged ones, and no requests at all."""

import base64
import json
import random
from typing import Any

from restitution.explorer.inputs import MOST_TERMS, inputs

KINDS = ("impact", "velocity", "surface", "bounces", "indentation", "tapping", "file", "download")
ODD: tuple[Any, ...] = (
    None, True, "", "x" * 300, -1, 0, 1e-300, 1e300, 1e309, 10**400, [], [1, None], {}, {"a": [{}]}, "\ud800", "NaN",
    "../../etc/passwd", [1e6] * 60, [[1.0]], "standard_solid",
)  # fmt: skip
TEXTS = (
    "t,E\ns,MPa\n1,30\n10,20\n100,15\n1000,14\n", "f,E',E''\nHz,MPa,MPa\n1,3,1\n10,4,2\n100,6,3\n1000,9,3\n",
    "[body]\nmass = 1\n", "*MATERIAL, NAME=a\n*ELASTIC\n1e6, 0.4\n", "\0", "", "a,b\n1,2\n",
    "[material]\nfile = '/etc/passwd'\n", "[profile]\nfile = '/etc/passwd'\n",
)  # fmt: skip


def value(rng: random.Random, key: str) -> Any:
    """A value of an input: on its slider mostly, at an end of its range, or of no use."""
    item, draw = inputs()[key], rng.random()
    if draw < 0.03:
        return rng.choice(ODD)
    if item.options:
        return rng.choice(item.options).value
    low, high = item.ends
    if item.slider is None:
        return [10.0 ** rng.uniform(-12, 12) for _ in range(rng.choice((1, 2, 5, MOST_TERMS)))]
    if draw < 0.1:
        return rng.choice((low, high))
    low, high = item.slider.low, item.slider.high
    return rng.uniform(low, high) if not item.slider.logarithmic else low * (high / low) ** rng.random()


def state(rng: random.Random) -> dict[str, Any]:
    """A random state; lists of one part have equal lengths."""
    keys = list(inputs())
    result = {key: value(rng, key) for key in rng.sample(keys, rng.randrange(len(keys)))}
    for part in ("shear", "bulk"):
        pair = [f"material.{part}.{name}" for name in ("branch_moduli", "relaxation_times")]
        if rng.random() < 0.8:
            n = rng.choice((1, 2, 5, MOST_TERMS))
            result |= {pair[0]: [10.0 ** rng.uniform(2, 10) for _ in range(n)]}
            result |= {pair[1]: sorted(10.0 ** rng.uniform(-9, 6) for _ in range(n))}
    if rng.random() < 0.02:
        result[rng.choice(("material.file", "nothing", "page.tab", "body", "", "\n"))] = rng.choice(ODD)
    return result


def request(rng: random.Random, number: int) -> dict[str, Any]:
    """A random request."""
    kind = rng.choice(KINDS)
    result: dict[str, Any] = {"id": number, "kind": kind, "state": state(rng)}
    if kind == "file":
        text = rng.choice(TEXTS)
        place = rng.randrange(len(text) + 1)
        text = (
            text if rng.random() < 0.5 else text[:place] + rng.choice((",", "\n", "x", "9", "-", '"')) + text[place:]
        )
        data = base64.b64encode(text.encode("utf-8", "replace")).decode()
        result["files"] = [{"name": rng.choice(("a.csv", "b.toml", "", "../c", "d\n.inp")), "data": data}]
        if rng.random() < 0.2:
            result["files"].append(
                {"name": rng.choice(("e.csv", "../f", "/etc/passwd", "dropped.toml")), "data": data}
            )
        if rng.random() < 0.5:
            result["answers"] = {"deformation": rng.choice(("shear", "tension", "torsion", ""))}
    if kind == "download":
        result["what"] = rng.choice(("case", "indentation", "tapping", "python", "tapping python", "else", None))
    return result


def message(rng: random.Random, number: int) -> str:
    """A random message, damaged now and then."""
    result = request(rng, number)
    if rng.random() < 0.05:
        result[rng.choice(("id", "kind", "state", "files", "answers", "what"))] = rng.choice(ODD)
    text = json.dumps(result)
    if rng.random() < 0.05:
        place = rng.randrange(len(text))
        text = text[:place] + rng.choice(('"', "{", "]", "\\", "e999", "NaN", "")) + text[place + rng.randrange(3) :]
    return text if rng.random() > 0.01 else rng.choice(("", "[" * 5000, "null", "1", '"x"', "{}", "[]", "\u0000"))
