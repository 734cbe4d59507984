"""Classical models of springs and dashpots as materials."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from restitution.checks import Numeric
from restitution.material import models
from restitution.material.conversion import series_connection, shear_from_tension, static_bulk_modulus
from restitution.material.models import ONE_BULK, material_model
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_series
from restitution.quantities import CONSTANTS


def one_branch(equilibrium_modulus: Numeric, branch_modulus: Numeric, viscosity: Numeric) -> PronySeries:
    """Return a spring beside one Maxwell branch, given by its spring and its dashpot."""
    modulus, dashpot = np.asarray(branch_modulus), np.asarray(viscosity)
    # The series refuses a time that overflows.
    with np.errstate(over="ignore"):
        time = dashpot / modulus
    # A quotient of positive numbers may underflow.
    build = PronySeries.of_positive if np.all(time > 0.0) else PronySeries
    return build(equilibrium_modulus, modulus[..., None], time[..., None])


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
    """Return the standard solid in shear, G(t) = G_inf + G_1 exp(-G_1 t/eta), elastic in bulk.

    Parameters
    ----------
    equilibrium_modulus, branch_modulus
        G_inf >= 0 and G_1 > 0 [Pa].
    viscosity
        eta > 0 [Pa s] of the dashpot in series with G_1; the relaxation time is eta/G_1.
    poisson_ratio
        Static Poisson ratio nu in [-1, 0.5]; 0.5 means incompressible. Exactly one of this and `bulk_modulus`.
    bulk_modulus
        K >= 0 [Pa], may be infinite.
    density, name
        Mass density [kg/m^3] and name of the material.

    Raises
    ------
    InputError
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
    shear = one_branch(equilibrium_modulus, branch_modulus, viscosity)
    bulk = static_bulk_modulus(shear.equilibrium_modulus, poisson_ratio, bulk_modulus)
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
    """Return the elastic material, from a modulus and one more constant; G = E/(2(1 + nu)) = 3KE/(9K - E).

    Parameters
    ----------
    shear_modulus, youngs_modulus
        G > 0 or E > 0 [Pa], exactly one of them.
    poisson_ratio, bulk_modulus, density, name
        As in `standard_solid`; with `youngs_modulus`, nu > -1 and K > E/9.

    Notes
    -----
    Landau and Lifshitz, *Theory of Elasticity*, section 5.

    Examples
    --------
    >>> steel = elastic(youngs_modulus=210e9, poisson_ratio=0.25)
    >>> steel.shear
    PronySeries(84000000000.0)
    """
    if shear_modulus is not None:
        shear = PronySeries(shear_modulus)
    else:
        assert youngs_modulus is not None
        shear = shear_from_tension(PronySeries(youngs_modulus), bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    bulk = static_bulk_modulus(shear.equilibrium_modulus, poisson_ratio, bulk_modulus)
    return Material(shear, bulk, density=density, name=name)


@material_model()
def maxwell(
    shear_modulus: models.ShearModulus,
    viscosity: models.Viscosity,
    *,
    bulk_modulus: models.BulkModulus,
    density: models.Density | None = None,
    name: str | None = None,
) -> Material:
    """Maxwell liquid in shear, G(t) = G exp(-G t/eta), elastic in bulk; its static Poisson ratio is 0.5.

    Parameters
    ----------
    shear_modulus, viscosity
        G > 0 [Pa] and eta > 0 [Pa s].
    bulk_modulus, density, name
        As in `standard_solid`.

    Examples
    --------
    >>> maxwell(2.0, 6.0, bulk_modulus=10.0).shear
    PronySeries(0.0, [2.0], [3.0])
    """
    shear = one_branch(0.0, shear_modulus, viscosity)
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

    The reduced modulus has a dashpot and, unless the material is incompressible, one Prony term.

    Parameters
    ----------
    shear_modulus, viscosity
        G >= 0 [Pa] and eta > 0 [Pa s].
    bulk_viscosity
        Viscosity in bulk >= 0 [Pa s], without effect if incompressible.
    poisson_ratio, bulk_modulus, density, name
        As in `standard_solid`.

    Examples
    --------
    >>> kelvin_voigt(2.0, 6.0, poisson_ratio=0.5).shear
    PronySeries(2.0, parallel_viscosity=6.0)
    """
    shear = PronySeries(shear_modulus, parallel_viscosity=viscosity)
    bulk = static_bulk_modulus(shear_modulus, poisson_ratio, bulk_modulus)
    return Material(shear, bulk_series(bulk, bulk_viscosity), density=density, name=name)


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

    The creep compliance is J(t) = 1/G_M + t/eta_M + (1 - exp(-t G_K/eta_K))/G_K; G(t) has two branches.

    Parameters
    ----------
    maxwell_modulus, kelvin_modulus
        G_M, G_K > 0 [Pa].
    maxwell_viscosity, kelvin_viscosity
        eta_M, eta_K > 0 [Pa s].
    bulk_modulus, density, name
        As in `standard_solid`.

    Notes
    -----
    Findley, Lai, Onaran, *Creep and Relaxation of Nonlinear Viscoelastic Materials* (1976), section 5.6.

    Examples
    --------
    >>> ice = burgers(2.0, 6.0, 1.0, 1.0, bulk_modulus=10.0)
    >>> print(ice.shear.n_branches, round(float(ice.shear.creep_compliance(3.0)), 6))
    2 1.950213
    """
    maxwell_part = one_branch(0.0, maxwell_modulus, maxwell_viscosity)
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
    """Return the generalised Maxwell material in shear, G(t) = G_inf + sum G_k exp(-t/tau_k), elastic in bulk.

    Parameters
    ----------
    equilibrium_modulus
        G_inf >= 0 [Pa].
    branch_moduli, relaxation_times
        G_k >= 0 [Pa] and tau_k > 0 [s], shape (n_branch,) each.
    poisson_ratio, bulk_modulus, density, name
        As in `standard_solid`.

    Examples
    --------
    >>> generalised_maxwell(1.0, [2.0, 3.0], [0.1, 10.0], poisson_ratio=0.3).shear.n_branches
    2
    """
    branches = np.atleast_1d(branch_moduli), np.atleast_1d(relaxation_times)
    shear = PronySeries.of_positive(equilibrium_modulus, *branches)
    bulk = static_bulk_modulus(shear.equilibrium_modulus, poisson_ratio, bulk_modulus)
    return Material(shear, bulk, density=density, name=name)
