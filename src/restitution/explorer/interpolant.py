"""The interpolant of the paper's restitution coefficient as JSON, for its evaluation by the page."""

from __future__ import annotations

import base64
import json
from functools import cache
from importlib.resources import as_file, files

import numpy as np

from restitution.surrogates import standard_solid
from restitution.surrogates.evaluation import TERMS


@cache
def as_json() -> str:
    """Return the boxes of the interpolant; the coefficients are 32-bit floats, little-endian, in base64."""
    source = files("restitution.surrogates") / "data" / "standard_solid.npz"
    with as_file(source) as path, np.load(path) as data:
        levels, places = data["levels"].astype(int).tolist(), data["places"].astype(int).tolist()
        coefficients = base64.b64encode(data["coefficients"].astype("<f4").tobytes()).decode("ascii")
    low, high = (corner.tolist() for corner in standard_solid.corners())
    content = {
        "nu": [-1.0, 0.5], "p2": standard_solid.P2, "p3": standard_solid.P3, "error": standard_solid.STATED_ERROR,
        "terms": TERMS, "low": low, "high": high, "levels": levels, "places": places, "coefficients": coefficients,
    }  # fmt: skip
    return json.dumps(content, separators=(",", ":"))
