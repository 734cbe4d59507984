"""Classical models of springs and dashpots as materials."""

from __future__ import annotations

from restitution.kernel.validation import nonnegative, positive
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, bulk_from_poisson_ratio


def standard_solid(
    equilibrium_modulus: float,
    branch_modulus: float,
    viscosity: float,
    *,
    poisson_ratio: float | None = None,
    bulk_modulus: float | None = None,
    density: float | None = None,
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
        What to call the material.

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
    equilibrium = float(nonnegative("equilibrium_modulus", equilibrium_modulus, "Pa"))
    branch = float(positive("branch_modulus", branch_modulus, "Pa"))
    time = float(positive("viscosity", viscosity, "Pa s")) / branch
    bulk = _elastic_bulk(equilibrium, poisson_ratio, bulk_modulus)
    return Material(PronySeries(equilibrium, [branch], [time]), bulk, density=density, name=name)


def _elastic_bulk(shear_modulus: float, poisson_ratio: float | None, bulk_modulus: float | None) -> float:
    if (poisson_ratio is None) == (bulk_modulus is None):
        raise ValueError(
            f"poisson_ratio = {poisson_ratio}, bulk_modulus = {bulk_modulus}: exactly one must be given"
        )
    if poisson_ratio is not None:
        return bulk_from_poisson_ratio(shear_modulus, poisson_ratio)
    assert bulk_modulus is not None
    return bulk_modulus
