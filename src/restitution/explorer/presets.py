"""States to begin with."""

from __future__ import annotations

from typing import Any

PRESETS: dict[str, tuple[str, dict[str, Any]]] = {
    "rubber": ("steel ball on hard rubber", {}),
    "paper": (
        "the paper's example: nu = 0.49, p2 = 0.001, p3 = 10",
        {"entry": "groups", "groups.nu": 0.49, "groups.p2": 1e-3, "groups.p3": 10.0},
    ),
    "glass": (
        "a plausible glass: nu = 0.499, p2 = 0.0045, p3 = 6",
        {"entry": "groups", "groups.nu": 0.499, "groups.p2": 4.5e-3, "groups.p3": 6.0},
    ),
    "polyisobutylene": (
        "steel ball on polyisobutylene at 25 °C",
        {"material.model": "library", "material.library": "polyisobutylene", "material.temperature": 298.15},
    ),
    "steel": (
        "steel ball on steel: no loss",
        {"material.model": "library", "material.library": "steel", "impact.velocity": 0.1},
    ),
    "gel": (
        "AFM bead on a gel",
        {
            "material.model": "standard_solid", "material.equilibrium_modulus": 300.0,
            "material.branch_modulus": 1200.0, "material.viscosity": 300.0, "material.poisson_ratio": 0.5,
            "bulk": "poisson_ratio", "indentation.radius": 2.5e-6, "indentation.depth": 5e-7,
            "indentation.loading_time": 1.0, "indentation.unloading_time": 1.0,
        },
    ),
}  # fmt: skip
"""Words and state of each by name; the first is that of the defaults."""
