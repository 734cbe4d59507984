"""Classical models of springs and dashpots as materials."""

from __future__ import annotations

import math
from typing import Annotated

from restitution.material import models
from restitution.material.connection import series_connection
from restitution.material.conversion import shear_from_tension
from restitution.material.models import ONE_BULK, material_model
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio
from restitution.quantities import CONSTANTS

YoungsModulus = Annotated[float, CONSTANTS["youngs_modulus"]]


@material_model(ONE_BULK)
def standard_solid(
    equilibrium_modulus: models.EndModulus,
    branch_modulus: models.BranchModulus,
    viscosity: models.Viscosity,
    *,
    poisson_ratio: models.PoissonRatio | None = None,
    bulk_modulus: models.BulkModulus | None = None,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Standard solid in shear, G(t) = G_inf + G_1 exp(-G_1 t/eta), elastic in bulk.

    Parameters
    ----------
    equilibrium_modulus
        G_inf >= 0 [Pa].
    branch_modulus
        G_1 > 0 [Pa].
    viscosity
        eta > 0 [Pa s] of the dashpot in series with G_1; the relaxation time is eta/G_1.
    poisson_ratio
        Static Poisson ratio nu in [-1, 0.5]; 0.5 means incompressible. Exactly one of this and
        `bulk_modulus`.
    bulk_modulus
        K >= 0 [Pa], may be infinite.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Raises
    ------
    ValueError
        If a number is out of range, or not exactly one of `poisson_ratio` and `bulk_modulus` is given.

    Notes
    -----
    Willert, Leroy, Satora, Scholtyssek, eqs. (1) to (3).

    Examples
    --------
    >>> solid = standard_solid(1e6, 1e8, 1e4, poisson_ratio=0.45)
    >>> solid.shear
    PronySeries(1000000.0, [100000000.0], [0.0001])
    >>> print(round(solid.poisson_ratio, 12))
    0.45
    """
    shear = PronySeries(equilibrium_modulus, [branch_modulus], [viscosity / branch_modulus])
    bulk = _elastic_bulk(equilibrium_modulus, poisson_ratio, bulk_modulus)
    return Material(shear, bulk, density=density, name=name)


@material_model(("shear_modulus", "youngs_modulus"), ONE_BULK)
def elastic(
    *,
    shear_modulus: models.ShearModulus | None = None,
    youngs_modulus: YoungsModulus | None = None,
    poisson_ratio: models.PoissonRatio | None = None,
    bulk_modulus: models.BulkModulus | None = None,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Elastic material, from a modulus and one more constant.

    Parameters
    ----------
    shear_modulus
        G > 0 [Pa]. Exactly one of this and `youngs_modulus`.
    youngs_modulus
        E > 0 [Pa].
    poisson_ratio
        nu in [-1, 0.5] (above -1 with `youngs_modulus`). Exactly one of this and `bulk_modulus`.
    bulk_modulus
        K >= 0 [Pa] (above E/9 with `youngs_modulus`), may be infinite.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Raises
    ------
    ValueError
        If a number is out of range, or not exactly two constants are given.

    Notes
    -----
    G = E/(2(1 + nu)) = 3KE/(9K - E); Landau and Lifshitz, *Theory of Elasticity*, section 5.

    Examples
    --------
    >>> steel = elastic(youngs_modulus=210e9, poisson_ratio=0.25)
    >>> steel.shear
    PronySeries(84000000000.0)
    """
    if shear_modulus is None:
        assert youngs_modulus is not None
        tension = PronySeries(youngs_modulus)
        series = shear_from_tension(tension, bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
        shear = series.equilibrium_modulus
    else:
        shear = shear_modulus
    return Material(shear, _elastic_bulk(shear, poisson_ratio, bulk_modulus), density=density, name=name)


@material_model()
def maxwell(
    shear_modulus: models.ShearModulus,
    viscosity: models.Viscosity,
    *,
    bulk_modulus: models.BulkModulus,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Maxwell liquid in shear, G(t) = G exp(-G t/eta), elastic in bulk.

    Parameters
    ----------
    shear_modulus
        G > 0 [Pa].
    viscosity
        eta > 0 [Pa s].
    bulk_modulus
        K >= 0 [Pa], may be infinite. A static Poisson ratio cannot be given: it is 0.5 for any liquid.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Examples
    --------
    >>> maxwell(2.0, 6.0, bulk_modulus=10.0).shear
    PronySeries(0.0, [2.0], [3.0])
    """
    shear = PronySeries(0.0, [shear_modulus], [viscosity / shear_modulus])
    return Material(shear, bulk_modulus, density=density, name=name)


@material_model(ONE_BULK)
def kelvin_voigt(
    shear_modulus: models.EndModulus,
    viscosity: models.Viscosity,
    *,
    poisson_ratio: models.PoissonRatio | None = None,
    bulk_modulus: models.BulkModulus | None = None,
    bulk_viscosity: models.BulkViscosity = 0.0,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Kelvin-Voigt solid in shear, G(t) = G + eta delta(t), elastic or Kelvin-Voigt in bulk.

    Its reduced modulus is that of a dashpot with, unless incompressible, one Prony term.

    Parameters
    ----------
    shear_modulus
        G >= 0 [Pa].
    viscosity
        eta > 0 [Pa s].
    poisson_ratio
        Static Poisson ratio nu in [-1, 0.5]. Exactly one of this and `bulk_modulus`.
    bulk_modulus
        K >= 0 [Pa], may be infinite.
    bulk_viscosity
        Viscosity in bulk >= 0 [Pa s], without effect if incompressible.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Examples
    --------
    >>> kelvin_voigt(2.0, 6.0, poisson_ratio=0.5).shear
    PronySeries(2.0, parallel_viscosity=6.0)
    """
    shear = PronySeries(shear_modulus, parallel_viscosity=viscosity)
    constant = _elastic_bulk(shear_modulus, poisson_ratio, bulk_modulus)
    bulk = constant if constant == math.inf else PronySeries(constant, parallel_viscosity=bulk_viscosity)
    return Material(shear, bulk, density=density, name=name)


@material_model()
def burgers(
    maxwell_modulus: Annotated[float, CONSTANTS["maxwell_modulus"]],
    maxwell_viscosity: Annotated[float, CONSTANTS["maxwell_viscosity"]],
    kelvin_modulus: Annotated[float, CONSTANTS["kelvin_modulus"]],
    kelvin_viscosity: Annotated[float, CONSTANTS["kelvin_viscosity"]],
    *,
    bulk_modulus: models.BulkModulus,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Burgers liquid in shear: a Maxwell and a Kelvin-Voigt body in series; elastic in bulk.

    The creep compliance is J(t) = 1/G_M + t/eta_M + (1 - exp(-t G_K/eta_K))/G_K; G(t) has two
    branches.

    Parameters
    ----------
    maxwell_modulus, kelvin_modulus
        G_M, G_K > 0 [Pa].
    maxwell_viscosity, kelvin_viscosity
        eta_M, eta_K > 0 [Pa s].
    bulk_modulus
        K >= 0 [Pa], may be infinite.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Notes
    -----
    Findley, Lai, Onaran, *Creep and Relaxation of Nonlinear Viscoelastic Materials* (1976), section 5.6.

    Examples
    --------
    >>> ice = burgers(2.0, 6.0, 1.0, 1.0, bulk_modulus=10.0)
    >>> print(ice.shear.n_branches, round(float(ice.shear.creep_compliance(3.0)), 6))
    2 1.950213
    """
    maxwell_part = PronySeries(0.0, [maxwell_modulus], [maxwell_viscosity / maxwell_modulus])
    kelvin_part = PronySeries(kelvin_modulus, parallel_viscosity=kelvin_viscosity)
    shear = series_connection(maxwell_part, kelvin_part)
    return Material(shear, bulk_modulus, density=density, name=name)


@material_model(ONE_BULK)
def generalised_maxwell(
    equilibrium_modulus: models.EndModulus,
    branch_moduli: models.Moduli,
    relaxation_times: models.Times,
    *,
    poisson_ratio: models.PoissonRatio | None = None,
    bulk_modulus: models.BulkModulus | None = None,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Generalised Maxwell material in shear, G(t) = G_inf + sum G_k exp(-t/tau_k), elastic in bulk.

    Parameters
    ----------
    equilibrium_modulus
        G_inf >= 0 [Pa].
    branch_moduli
        G_k >= 0 [Pa], shape (n_branch,).
    relaxation_times
        tau_k > 0 [s], shape (n_branch,).
    poisson_ratio
        Static Poisson ratio nu in [-1, 0.5]. Exactly one of this and `bulk_modulus`.
    bulk_modulus
        K >= 0 [Pa], may be infinite.
    density
        Mass density [kg/m3].
    name
        Name of the material.

    Examples
    --------
    >>> generalised_maxwell(1.0, [2.0, 3.0], [0.1, 10.0], poisson_ratio=0.3).shear.n_branches
    2
    """
    shear = PronySeries(equilibrium_modulus, branch_moduli, relaxation_times)
    bulk = _elastic_bulk(shear.equilibrium_modulus, poisson_ratio, bulk_modulus)
    return Material(shear, bulk, density=density, name=name)


def _elastic_bulk(shear_modulus: float, poisson_ratio: float | None, bulk_modulus: float | None) -> float:
    if poisson_ratio is not None:
        return bulk_from_poisson_ratio(shear_modulus, poisson_ratio)
    assert bulk_modulus is not None
    return bulk_modulus
