"""Laws of LAMMPS, LIGGGHTS, MercuryDPM, YADE, Kratos and MuJoCo, from their documentation and sources."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from restitution.calibration.laws import Law, Setting, Typed, by_restitution, elastic, inverse
from restitution.calibration.oscillator import CONSTANT, LINEAR, VISCOELASTIC
from restitution.calibration.units import DURATION, NUMBER, PRESSURE, SPEED, Powers
from restitution.impact.closed_forms import mueller_poeschel_restitution


def coefficient_strength(e: float) -> float:
    """Damping -sqrt(5) ln e/sqrt(pi^2 + ln^2 e) with which a contact that may pull has the coefficient e.

    Exact (D. Antypov and J. A. Elliott, EPL 94 (2011) 50004).
    """
    return math.sqrt(5.0) * -math.log(e) / math.hypot(math.pi, math.log(e))


def tsuji_strength(e: float) -> float:
    """Damping alpha(e) by J. S. Marshall, J. Comput. Phys. 228 (2009) 1541, eq. 53.

    A fit to figure 3 of Y. Tsuji and others, Powder Technol. 71 (1992) 239. LAMMPS up to version 22Jul2025 takes it as
    it is, later ones multiply it by sqrt(2) (pull request 5113 of LAMMPS).
    """
    return float(np.polynomial.polynomial.polyval(e, (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)))


def thornton_strength(e: float) -> float:
    """Damping sqrt(6) gamma(e) with which a contact without a pull has the coefficient e.

    A fit (C. Thornton and others, Powder Technol. 233 (2013) 30, eqs. B6 and B7).
    """
    powers = (
        -6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757, -1489.915,
    )  # fmt: skip
    exponent = e * float(np.polynomial.polynomial.polyval(e, powers))
    return math.sqrt(6.0 * (1.0 / (1.0 - (1.0 + e) ** 2 * math.exp(exponent)) - 1.0))


def _lammps(damping: str, number: str) -> dict[str, Any]:
    """Parts that the models of damping of LAMMPS share; `number` is the name of theirs."""
    model = f"hertz/material {{E}} {{{number}}} {{nu}} tangential linear_nohistory 0 0 damping {damping} limit_damping"
    return {
        "name": f"lammps-{damping.replace('_', '-')}",
        "words": f"LAMMPS, pair_style granular, hertz/material, damping {damping} limit_damping",
        "source": "LAMMPS documentation (version 22Jul2025), pages pair_style granular and fix wall/gran",
        "naive_end": "overlap",
        "units": ("si", "cgs", "micro", "lj"),
        "pair": f"pair_style granular\npair_coeff * * {model}",
        "wall": f"fix wall all wall/gran granular {model} zplane 0 NULL",
    }


def _kelvin_voigt(setting: Setting) -> tuple[float, float]:
    """Storage modulus, and the loss tangent over the frequency as the time A [s]."""
    return setting.modulus, setting.retardation_time


def _eta_n0(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
    return elastic(modulus, setting) | {"eta_n0": Typed(strength, Powers(0, -1, -1), "damping coefficient")}


LAMMPS_VISCOELASTIC = Law(
    **_lammps("viscoelastic", "eta_n0"),
    shape=VISCOELASTIC,
    # eta_n = eta_n0 a m_eff, a = sqrt(R d).
    dashpot=lambda stiffness, mass, radius: mass * np.sqrt(radius),
    typed=_eta_n0,
    # c = (3/2) A k with the retardation time A.
    naive=lambda one: (one.modulus, 2.0 * one.modulus * one.retardation_time / one.mass),
    notes=("eta_n0 is inversely proportional to the mass of the balls",),
)

_TSUJI = Law(
    **_lammps("tsuji", "e"),
    **by_restitution(tsuji_strength, 0.0, 1.0),
    shape=CONSTANT,
    elastic=False,
    notes=("up to version 22Jul2025; later versions, which multiply the damping by sqrt(2), need e = {e_later}",),
)


def _tsuji_typed(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
    later = inverse(tsuji_strength, strength / math.sqrt(2.0), 0.0, 1.0)
    words = "in place of e in versions that multiply the damping by sqrt(2)"
    return _TSUJI.typed(modulus, strength, setting) | {"e_later": Typed(later, NUMBER, words)}


LAMMPS_TSUJI = replace(_TSUJI, typed=_tsuji_typed)

LAMMPS_COEFF_RESTITUTION = Law(
    **_lammps("coeff_restitution", "e"), **by_restitution(coefficient_strength, 1e-9, 1.0), shape=CONSTANT
)

_LIGGGHTS_PROPERTIES = """\
fix m1 all property/global youngsModulus peratomtype {E}
fix m2 all property/global poissonsRatio peratomtype {nu}
fix m3 all property/global coefficientRestitution peratomtypepair 1 {e}
fix m4 all property/global coefficientFriction peratomtypepair 1 0.0
pair_style gran model hertz tangential history limitForce on
pair_coeff * *"""

LIGGGHTS = Law(
    name="liggghts",
    words="LIGGGHTS, pair_style gran, model hertz, limitForce on",
    source="LIGGGHTS documentation, page gran model hertz",
    **by_restitution(coefficient_strength, 0.05 * (1.0 + 1e-9), 1.0),
    shape=CONSTANT,
    naive_end="overlap",
    units=("si", "cgs"),
    pair=_LIGGGHTS_PROPERTIES,
    wall=_LIGGGHTS_PROPERTIES
    + "\nfix wall all wall/gran model hertz tangential history primitive type 1 zplane 0.0 limitForce on",
    notes=("moduli below 5e6 Pa need the command: soft_particles yes; above 1e9 Pa: hard_particles yes",),
)

_MERCURY = """\
HertzianBSHPViscoelasticSpecies species;
species.setEffectiveElasticModulus({E_eff});
species.setDissipation({A});"""

MERCURY_BSHP = Law(
    name="mercury-bshp",
    words="MercuryDPM, HertzianBSHPViscoelasticSpecies",
    source="MercuryDPM sources, HertzianBSHPViscoelasticInteraction.cc",
    shape=VISCOELASTIC,
    dashpot=lambda stiffness, mass, radius: 1.5 * stiffness,
    typed=lambda modulus, strength, setting: {
        "E_eff": Typed(modulus, PRESSURE, "effective elastic modulus"),
        "A": Typed(strength, DURATION, "dissipation"),
    },
    naive=_kelvin_voigt,
    pair=_MERCURY,
    wall=_MERCURY,
    comment="// {}",
)


def _yade_typed(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
    # beta = vstar^2 vn^(-1/5), where en is the Pade approximant at vstar.
    en = float(mueller_poeschel_restitution(math.sqrt(strength * setting.velocity**0.2)))
    return elastic(modulus, setting) | {
        "en": Typed(en, NUMBER, "coefficient of restitution at vn"),
        "vn": Typed(setting.velocity, SPEED, "velocity of en"),
    }


def _yade_naive(setting: Setting) -> tuple[float, float]:
    root = inverse(lambda x: float(mueller_poeschel_restitution(x)), setting.restitution_coefficient, 0.0, 1e3)
    return setting.modulus, root**2 * setting.velocity**-0.2


_YADE = """\
material = FrictMat(young={E}, poisson={nu}, frictionAngle=0.0)
physics = Ip2_FrictMat_FrictMat_MindlinPhys(en={en}, vn={vn})
law = Law2_ScGeom_MindlinPhys_Mindlin()"""

YADE_MINDLIN = Law(
    name="yade-mindlin",
    words="YADE, MindlinPhys with en and vn",
    source="YADE sources, HertzMindlin.cpp (merge request 977)",
    shape=VISCOELASTIC,
    # c = (3/2) A k, A = (2/3) beta (k/m)^(-2/5): e does not depend on the size.
    dashpot=lambda stiffness, mass, radius: stiffness * (stiffness / mass) ** -0.4,
    typed=_yade_typed,
    naive=_yade_naive,
    pair=_YADE,
    wall=_YADE,
    notes=("needs a version with vn, newer than 2023.02a",),
)

_KRATOS = """\
"materials": [{{"material_name": "ball", "material_id": 1, "Variables": {{
    "YOUNG_MODULUS": {E}, "POISSON_RATIO": {nu}}}}}],
"material_relations": [{{"material_names_list": ["ball", "ball"], "material_ids_list": [1, 1], "Variables": {{
    "DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME": "DEM_D_Hertz_viscous_Coulomb",
    "COEFFICIENT_OF_RESTITUTION": {e},
    "STATIC_FRICTION": 0.0, "DYNAMIC_FRICTION": 0.0, "FRICTION_DECAY": 500.0}}}}]"""

KRATOS_DEM = Law(
    name="kratos-dem",
    words="Kratos DEMApplication, DEM_D_Hertz_viscous_Coulomb",
    source="Kratos sources, DEM_D_Hertz_viscous_Coulomb_CL.cpp and sphere_strategy.py",
    **by_restitution(thornton_strength, 1e-3, 0.999),
    shape=CONSTANT,
    pair=_KRATOS,
    wall=_KRATOS,
    comment="// {}",
)

_MUJOCO = (
    '<pair geom1="ball" geom2="other" condim="1" solref="-{stiffness} -{damping}" solimp="0.9999 0.9999 0.001 0.5 2"/>'
)

MUJOCO_SOLREF = Law(
    name="mujoco-solref",
    words="MuJoCo, solref in the direct format",
    source="MuJoCo documentation, Modeling, section Solver parameters",
    shape=LINEAR,
    dashpot=lambda stiffness, mass, radius: mass,
    typed=lambda modulus, strength, setting: {
        "stiffness": Typed(modulus, Powers(0, 0, -2), "stiffness per mass, typed with a minus"),
        "damping": Typed(strength, Powers(0, 0, -1), "damping per mass, typed with a minus"),
    },
    # The default solref is "0.02 1": time constant [s] and damping ratio.
    naive=lambda setting: (0.02**-2, 2.0 / 0.02),
    pair=_MUJOCO,
    wall=_MUJOCO,
    comment="<!-- {} -->",
    notes=("the impedance of 0.9999 cancels gravity while the bodies touch",),
)

LAWS = {
    law.name: law
    for law in (
        LAMMPS_VISCOELASTIC, LAMMPS_TSUJI, LAMMPS_COEFF_RESTITUTION, MERCURY_BSHP, YADE_MINDLIN, LIGGGHTS, KRATOS_DEM,
        MUJOCO_SOLREF,
    )
}  # fmt: skip
"""Laws by the name of the target."""
