"""Impact of bodies on linear-viscoelastic ones: restitution, contact time, force, energy.

The public names are loaded on first use, so that importing the package costs nearly nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from restitution.case.file import Case as Case
    from restitution.case.file import read_case as read_case
    from restitution.citation.cite import cite as cite
    from restitution.contact.flat_ended import FlatEndedParabola as FlatEndedParabola
    from restitution.contact.flat_ended import TruncatedCone as TruncatedCone
    from restitution.contact.power_law import Cone as Cone
    from restitution.contact.power_law import FlatPunch as FlatPunch
    from restitution.contact.power_law import PowerLaw as PowerLaw
    from restitution.contact.profile import Parabola as Parabola
    from restitution.contact.sphere import Sphere as Sphere
    from restitution.contact.tabulated import Tabulated as Tabulated
    from restitution.impact.bounces import Bounces as Bounces
    from restitution.impact.bounces import bounces as bounces
    from restitution.impact.bounces import drop as drop
    from restitution.impact.collision import Body as Body
    from restitution.impact.collision import collision as collision
    from restitution.impact.problem import Impact as Impact
    from restitution.impact.result import ImpactResult as ImpactResult
    from restitution.impact.scaling import dimensionless_groups as dimensionless_groups
    from restitution.impact.solve import solve as solve
    from restitution.impact.solve import standard_solid_restitution as standard_solid_restitution
    from restitution.impact.status import SolverError as SolverError
    from restitution.impact.status import Status as Status
    from restitution.impact.window import for_contact as for_contact
    from restitution.indentation.history import History as History
    from restitution.indentation.history import hold as hold
    from restitution.indentation.history import ramp as ramp
    from restitution.indentation.history import sine_arch as sine_arch
    from restitution.indentation.history import triangle as triangle
    from restitution.indentation.result import IndentationResult as IndentationResult
    from restitution.indentation.result import IndentationStatus as IndentationStatus
    from restitution.indentation.solve import indent as indent
    from restitution.material import library as library
    from restitution.material import readers as _readers
    from restitution.material.classical import burgers as burgers
    from restitution.material.classical import elastic as elastic
    from restitution.material.classical import generalised_maxwell as generalised_maxwell
    from restitution.material.classical import kelvin_voigt as kelvin_voigt
    from restitution.material.classical import maxwell as maxwell
    from restitution.material.classical import standard_solid as standard_solid
    from restitution.material.conversion import shear_from_tension as shear_from_tension
    from restitution.material.conversion import tension_from_shear as tension_from_shear
    from restitution.material.fit import fit_prony as fit_prony
    from restitution.material.fractional import FractionalMaterial as FractionalMaterial
    from restitution.material.fractional import fractional_kelvin_voigt as fractional_kelvin_voigt
    from restitution.material.fractional import fractional_maxwell as fractional_maxwell
    from restitution.material.fractional import fractional_zener as fractional_zener
    from restitution.material.fractional import springpot as springpot
    from restitution.material.prony import PronySeries as PronySeries
    from restitution.material.reduced_modulus import reduced_modulus as reduced_modulus
    from restitution.material.shift import WLF as WLF
    from restitution.material.shift import Arrhenius as Arrhenius
    from restitution.material.shift import ShiftTable as ShiftTable
    from restitution.material.viscoelastic import Material as Material
    from restitution.surrogate.build import surrogate as surrogate
    from restitution.surrogate.standard_solid import standard_solid_surrogate as standard_solid_surrogate
    from restitution.surrogate.velocity import Surrogate as Surrogate
    from restitution.sweep.axis import Linear as Linear
    from restitution.sweep.axis import Logarithmic as Logarithmic
    from restitution.sweep.distribution import LogNormal as LogNormal
    from restitution.sweep.distribution import LogUniform as LogUniform
    from restitution.sweep.distribution import Normal as Normal
    from restitution.sweep.distribution import Uniform as Uniform
    from restitution.sweep.run import sweep as sweep
    from restitution.sweep.samples import Samples as Samples
    from restitution.sweep.store import open_sweep as open_sweep

    read_material = _readers.read

__version__ = "0.1.0"

_HOME = {
    "Arrhenius": "material.shift",
    "Body": "impact.collision",
    "Bounces": "impact.bounces",
    "Case": "case.file",
    "Cone": "contact.power_law",
    "FlatEndedParabola": "contact.flat_ended",
    "FlatPunch": "contact.power_law",
    "FractionalMaterial": "material.fractional",
    "History": "indentation.history",
    "Impact": "impact.problem",
    "ImpactResult": "impact.result",
    "IndentationResult": "indentation.result",
    "IndentationStatus": "indentation.result",
    "Linear": "sweep.axis",
    "LogNormal": "sweep.distribution",
    "LogUniform": "sweep.distribution",
    "Logarithmic": "sweep.axis",
    "Material": "material.viscoelastic",
    "Normal": "sweep.distribution",
    "Parabola": "contact.profile",
    "PowerLaw": "contact.power_law",
    "PronySeries": "material.prony",
    "Samples": "sweep.samples",
    "ShiftTable": "material.shift",
    "SolverError": "impact.status",
    "Sphere": "contact.sphere",
    "Status": "impact.status",
    "Surrogate": "surrogate.velocity",
    "Tabulated": "contact.tabulated",
    "TruncatedCone": "contact.flat_ended",
    "Uniform": "sweep.distribution",
    "WLF": "material.shift",
    "bounces": "impact.bounces",
    "burgers": "material.classical",
    "cite": "citation.cite",
    "closed_forms": "impact.closed_forms",
    "collision": "impact.collision",
    "dimensionless_groups": "impact.scaling",
    "drop": "impact.bounces",
    "elastic": "material.classical",
    "fit_prony": "material.fit",
    "for_contact": "impact.window",
    "fractional_kelvin_voigt": "material.fractional",
    "fractional_maxwell": "material.fractional",
    "fractional_zener": "material.fractional",
    "generalised_maxwell": "material.classical",
    "hold": "indentation.history",
    "indent": "indentation.solve",
    "kelvin_voigt": "material.classical",
    "library": "material.library",
    "maxwell": "material.classical",
    "open_sweep": "sweep.store",
    "ramp": "indentation.history",
    "read_case": "case.file",
    "read_material": "material.readers:read",
    "reduced_modulus": "material.reduced_modulus",
    "shear_from_tension": "material.conversion",
    "sine_arch": "indentation.history",
    "solve": "impact.solve",
    "springpot": "material.fractional",
    "standard_solid": "material.classical",
    "standard_solid_restitution": "impact.solve",
    "standard_solid_surrogate": "surrogate.standard_solid",
    "surrogate": "surrogate",
    "sweep": "sweep",
    "tension_from_shear": "material.conversion",
    "triangle": "indentation.history",
}
_MODULES = frozenset({"closed_forms", "library", "surrogate", "sweep"})

__all__ = ["__version__", *sorted(_HOME)]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'restitution' has no attribute '{name}'")
    home, _, own_name = _HOME[name].partition(":")
    module = import_module(f"restitution.{home}")
    value = module if name in _MODULES else getattr(module, own_name or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
