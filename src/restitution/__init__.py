"""Impact of bodies on linear-viscoelastic ones: restitution, contact time, force, energy.

The public names are loaded on first use, so that importing the package costs nearly nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from restitution.contact.profile import Parabola as Parabola
    from restitution.impact.problem import Impact as Impact
    from restitution.impact.result import ImpactResult as ImpactResult
    from restitution.impact.scaling import dimensionless_groups as dimensionless_groups
    from restitution.impact.solve import solve as solve
    from restitution.impact.solve import standard_solid_restitution as standard_solid_restitution
    from restitution.impact.status import SolverError as SolverError
    from restitution.impact.status import Status as Status
    from restitution.material.classical import standard_solid as standard_solid
    from restitution.material.prony import PronySeries as PronySeries
    from restitution.material.reduced_modulus import reduced_modulus as reduced_modulus
    from restitution.material.viscoelastic import Material as Material
    from restitution.sweep.axis import Linear as Linear
    from restitution.sweep.axis import Logarithmic as Logarithmic
    from restitution.sweep.axis import Samples as Samples
    from restitution.sweep.distribution import LogNormal as LogNormal
    from restitution.sweep.distribution import LogUniform as LogUniform
    from restitution.sweep.distribution import Normal as Normal
    from restitution.sweep.distribution import Uniform as Uniform
    from restitution.sweep.run import sweep as sweep
    from restitution.sweep.store import open_sweep as open_sweep

__version__ = "0.1.0"

_HOME = {
    "Impact": "impact.problem",
    "ImpactResult": "impact.result",
    "Linear": "sweep.axis",
    "LogNormal": "sweep.distribution",
    "LogUniform": "sweep.distribution",
    "Logarithmic": "sweep.axis",
    "Material": "material.viscoelastic",
    "Normal": "sweep.distribution",
    "Parabola": "contact.profile",
    "PronySeries": "material.prony",
    "Samples": "sweep.axis",
    "SolverError": "impact.status",
    "Status": "impact.status",
    "Uniform": "sweep.distribution",
    "closed_forms": "impact.closed_forms",
    "dimensionless_groups": "impact.scaling",
    "open_sweep": "sweep.store",
    "reduced_modulus": "material.reduced_modulus",
    "solve": "impact.solve",
    "standard_solid": "material.classical",
    "standard_solid_restitution": "impact.solve",
    "sweep": "sweep",
}
_MODULES = frozenset({"closed_forms", "sweep"})

__all__ = ["__version__", *sorted(_HOME)]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'restitution' has no attribute '{name}'")
    module = import_module(f"restitution.{_HOME[name]}")
    value = module if name in _MODULES else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
