"""Named materials, each with its source, its window of time and the assumptions made beyond the source.

The density of an unnamed polymer is None; that of a named one is typical, and so an assumption. Each material is
also an attribute of this module: `library.epoxy` is `library.get("epoxy")`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from importlib.resources import files

from restitution import quantities
from restitution.material.classical import elastic
from restitution.material.conversion import shear_from_tension
from restitution.material.deck import PronyTerms
from restitution.material.prony import PronySeries
from restitution.material.readers import MaterialFile, parse
from restitution.material.shift import WLF, ShiftTable
from restitution.material.viscoelastic import Material

__all__ = ["get", "names"]

_REDUCED = "the window consists of reduced times of a master curve"
_PYVISCO = (
    "from the verification data of pyvisco, National Renewable Energy Laboratory (BSD-3-Clause), fitted by fit_prony"
)
_KAYE_LABY = "Kaye and Laby, Tables of Physical and Chemical Constants, 16th ed. (1995), section 2.2.2"
_CRC = "density: CRC Handbook of Chemistry and Physics"


def names() -> list[str]:
    """Names of all materials, in alphabetical order.

    Examples
    --------
    >>> "epoxy" in names()
    True
    """
    return sorted(_LIBRARY)


def get(name: str) -> Material:
    """Material of that name, with its `source`, `window` and `assumptions`.

    Parameters
    ----------
    name
        One of `names()`.

    Raises
    ------
    InputError
        If there is no such material; the message names the nearest one, or all.

    Examples
    --------
    >>> material = get("polyisobutylene")
    >>> material.shear.n_branches, material.shear.is_liquid, material.temperature
    (30, True, 298.0)
    >>> print(round(material.at(273.15).shear.relaxation_times[0] / material.shear.relaxation_times[0], 3))
    16.55
    """
    quantities.known("material", name, names())
    return _build(name)


def __getattr__(name: str) -> Material:
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return get(name)
    except ValueError as error:
        raise AttributeError(str(error)) from None


def __dir__() -> list[str]:
    return sorted([*__all__, *_LIBRARY])


@cache
def _build(name: str) -> Material:
    return replace(_LIBRARY[name](), name=name)


def _file(name: str) -> MaterialFile:
    path = files("restitution.material").joinpath("data", f"{name}.csv")
    return parse(path.read_text(encoding="utf-8"), name)


def _terms(name: str) -> tuple[PronySeries, tuple[float, float]]:
    """Prony series of a file, and its shortest and longest relaxation time."""
    terms = _file(name)
    assert isinstance(terms, PronyTerms)
    assert terms.window is not None
    return terms.series(), terms.window


def _polyisobutylene() -> Material:
    tension, window = _terms("polyisobutylene")
    return Material(
        shear_from_tension(tension, bulk_modulus=3e9),
        3e9,
        density=920.0,
        shift=WLF(298.0, 8.61, 200.4, temperature_range=(202.0, 400.0)),
        window=window,
        source="NBS polyisobutylene, master curve of Catsiff and Tobolsky, J. Colloid Sci. 10 (1955) 375, in "
        "30 terms printed in Brinson and Brinson, Polymer Engineering Science and Viscoelasticity (2008), as "
        "carried by the project TappingMode_Simulations (MIT licence); shift factors: Ferry, Viscoelastic "
        "Properties of Polymers, 3rd ed. (1980), table 11-II",
        assumptions="the terms are moduli in tension (by their magnitude, the source does not say) at 298 K; "
        "constant bulk modulus of 3 GPa; no equilibrium modulus, so it flows; shift valid from the glass "
        f"transition at 202 K to about 400 K; {_REDUCED}; density: typical of the polymer",
    )


def _epoxy() -> Material:
    shear, window = _terms("epoxy")
    return Material(
        shear,
        3e9,
        density=1200.0,
        window=window,
        source="cured commercial epoxy, shear; Simon, McKenna and Sindt, J. Appl. Polym. Sci. 76 (2000) 495",
        assumptions="the relative moduli are shares of the difference of the glassy (891 MPa) and the rubbery "
        "modulus (4.9 MPa); constant bulk modulus of 3 GPa; near its glass transition, as half of the modulus "
        f"relaxes within 10 ms; the reference temperature is unknown; {_REDUCED}; density: typical of cured "
        "epoxy, 1150 to 1250 kg/m3",
    )


def _dma_polymer() -> Material:
    tension, _ = _terms("dma_polymer")
    shift = _file("dma_polymer_shift")
    assert isinstance(shift, ShiftTable)
    return Material(
        shear_from_tension(tension, bulk_modulus=10e9),
        10e9,
        shift=shift,
        window=(1.591549e-15, 1.591549e11),
        source=f"unnamed polymer, dynamic moduli in tension and shift factors {_PYVISCO}",
        assumptions="constant bulk modulus of 10 GPa, chosen for a Poisson ratio of 0.33 in the glass and not "
        "measured: with an instantaneous modulus of 10 GPa in tension the polymer is filled or stiffer than "
        "most, whose bulk moduli are 2 to 5 GPa; relative misfit of the complex modulus 0.07, as storage and "
        f"loss modulus contradict each other; {_REDUCED}; the density is unknown",
    )


def _relaxation_polymer() -> Material:
    tension, _ = _terms("relaxation_polymer")
    return Material(
        shear_from_tension(tension, bulk_modulus=2e9),
        2e9,
        window=(2.81764e-3, 1.39e28),
        source=f"unnamed polymer, relaxation modulus in tension {_PYVISCO}",
        assumptions="constant bulk modulus of 2 GPa, a Poisson ratio of 0.36 in the glass; relative misfit "
        f"0.0017; the reference temperature and the density are unknown; {_REDUCED} and begins after the "
        "duration of most impacts",
    )


def _ice() -> Material:
    return Material(
        3.463e9,
        8.899e9,
        density=917.0,
        temperature=257.15,
        window=(1e-10, 1.0),
        source="polycrystalline ice Ih at -16 C, Voigt-Reuss-Hill average of the single crystal of Gammon, "
        f"Kiefte, Clouter and Denner, J. Glaciol. 29 (1983) 433; {_CRC}",
        assumptions="elastic part alone: creep, which matters in loads of seconds, is left out",
    )


def _elastic(youngs_modulus: float, poisson_ratio: float, density: float, source: str) -> Callable[[], Material]:
    assumptions = "elastic at any rate and room temperature; no yielding"
    solid = partial(elastic, youngs_modulus=youngs_modulus, poisson_ratio=poisson_ratio, density=density)
    return lambda: replace(solid(), source=source, assumptions=assumptions)


_LIBRARY: dict[str, Callable[[], Material]] = {
    "aluminium": _elastic(70e9, 0.3, 2700.0, "EN 1999-1-1 (Eurocode 9), clause 3.2.5"),
    "brass": _elastic(
        100.6e9,
        0.350,
        8530.0,
        f"70 Cu 30 Zn; {_KAYE_LABY}; density: Copper Development Association, alloy C26000",
    ),
    "copper": _elastic(129.8e9, 0.343, 8960.0, f"{_KAYE_LABY}; {_CRC}"),
    "dma_polymer": _dma_polymer,
    "epoxy": _epoxy,
    "fused_silica": _elastic(73.1e9, 0.170, 2200.0, f"fused quartz; {_KAYE_LABY}; {_CRC}"),
    "ice": _ice,
    "polyisobutylene": _polyisobutylene,
    "relaxation_polymer": _relaxation_polymer,
    "soda_lime_glass": _elastic(70e9, 0.2, 2500.0, "EN 572-1, table of general properties"),
    "steel": _elastic(210e9, 0.3, 7850.0, "EN 1993-1-1 (Eurocode 3), clause 3.2.6; density: EN 1993-1-2, 3.2.2"),
    "tungsten": _elastic(411.0e9, 0.280, 19300.0, f"{_KAYE_LABY}; {_CRC}"),
}
