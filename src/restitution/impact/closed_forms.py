"""Exact and asymptotic solutions of the impact problem, against which solvers can be checked.

The contact radius is `a = c d^(p/2)` with the path exponent p: 1 for a parabola (`c = sqrt(R)`), 2 for a cone
(`c = 2/(pi tan(alpha))` with the angle alpha between cone and surface), 0 for a flat punch (`c = a`), 2/n for
`g = (x/c)^n`. Below, `P = p/2`, B is the beta function, E* the reduced modulus, m the mass, v0 the impact velocity and
d_m the largest indentation depth. Each function raises an `InputError` for an input outside the stated range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from restitution.checks import Numeric, nonnegative, plain, positive, within
from restitution.material.conversion import bulk_factor
from restitution.quantities import check

HERTZ_TIME_FACTOR = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
"""Contact time of an elastic sphere over d_m/v0 [-], 2.9432751843 (Hertz 1882)."""

SMALL_LOSS_FACTOR = math.sqrt(math.pi) * math.gamma(0.6) / (2**0.2 * 5**0.4 * math.gamma(2.1))
"""C1 [-] of viscoelastic spheres, `e = 1 - C1 b + ...`, 1.1534488581 (Schwager and Poeschel 1998)."""

MAXWELL_RESTITUTION: Mapping[float, float] = MappingProxyType(
    {0.01: 0.99556671, 0.1: 0.95664831, 1.0: 0.64644129, 5.0: 0.08510394}
)
"""e [-] of a parabola on a Maxwell half-space over T0/tau [-].

T0 is the Hertz contact time at the instantaneous modulus. Eight digits, from two programs independent of this package.
"""

KELVIN_VOIGT_RESTITUTION: Mapping[float, float] = MappingProxyType(
    {0.01: 0.9671134, 0.1: 0.7362166, 1.0: 0.1622468, 3.0: 0.0402024}
)
"""e [-] of a parabola on an incompressible Kelvin-Voigt half-space over p3 [-].

With the exact rebound (Graham 1967, Ting 1966): `F = (16/3) G sqrt(R) (d^1.5 + 1.5 tau d^0.5 d')` in the approach and
`F = (16/3) G sqrt(R) (d + tau d')^1.5` in the rebound; p3 = tau where m = R = v0 = G = 1. The law of Kuwabara and Kono
and of Brilliantov and others differs: it keeps the first formula in the rebound. Seven digits, from two programs
independent of this package.
"""


def elastic_max_indentation_depth(
    reduced_modulus: Any, path_coefficient: Any, mass: Any, velocity: Any, *, path_exponent: Any = 1.0
) -> Numeric:
    """Return the largest indentation depth d_m [m] of an elastic impact.

    Parameters
    ----------
    reduced_modulus, path_coefficient, mass, velocity : float or array
        E* [Pa], c [m^(1-p/2)], m [kg] and v0 [m/s], > 0.
    path_exponent : float or array
        p [-], >= 0.

    Returns
    -------
    float or array
        `d_m = [(1+P)(2+P) m v0^2/(4 E* c)]^(1/(2+P))`, from `m v0^2/2 = int_0^(d_m) 2 E* int_0^d a dd dd`; for the
        parabola `(15 m v0^2/(16 E* sqrt(R)))^(2/5)` (H. Hertz, J. reine angew. Math. 92 (1882) 156).

    Examples
    --------
    >>> round(elastic_max_indentation_depth(15 / 16, 1.0, 1.0, 1.0), 12)
    1.0
    """
    modulus = np.asarray(positive("reduced_modulus", reduced_modulus, "Pa"))
    coefficient = positive("path_coefficient", path_coefficient)
    energy = check("mass", mass) * np.asarray(check("velocity", velocity)) ** 2
    p = nonnegative("path_exponent", path_exponent) / 2
    return plain(((1 + p) * (2 + p) * energy / (4 * modulus * coefficient)) ** (1 / (2 + p)))


def elastic_contact_time(max_indentation_depth: Any, velocity: Any, *, path_exponent: Any = 1.0) -> Numeric:
    """Return the contact time T [s] of an elastic impact.

    Parameters
    ----------
    max_indentation_depth, velocity : float or array
        d_m [m] and v0 [m/s], > 0.
    path_exponent : float or array
        p [-], >= 0.

    Returns
    -------
    float or array
        `T = (2/(2+P)) B(1/(2+P), 1/2) d_m/v0`, from `v^2 = v0^2 [1 - (d/d_m)^(2+P)]`; 2.9432751843 d_m/v0 for the
        parabola, pi d_m/v0 for the flat punch.

    Examples
    --------
    >>> round(elastic_contact_time(1.0, 1.0), 10)
    2.9432751843
    """
    from scipy.special import beta

    p = nonnegative("path_exponent", path_exponent) / 2
    return plain(2 / (2 + p) * beta(1 / (2 + p), 0.5) * _time(max_indentation_depth, velocity))


def elastic_max_force(max_indentation_depth: Any, mass: Any, velocity: Any, *, path_exponent: Any = 1.0) -> Numeric:
    """Return the largest force F_max [N] of an elastic impact.

    Parameters
    ----------
    max_indentation_depth, mass, velocity : float or array
        d_m [m], m [kg] and v0 [m/s], > 0.
    path_exponent : float or array
        p [-], >= 0.

    Returns
    -------
    float or array
        `F_max = (1 + P/2) m v0^2/d_m`, as `F ~ d^(1+P)`; 5/4 m v0^2/d_m for the parabola.

    Examples
    --------
    >>> elastic_max_force(1.0, 1.0, 1.0)
    1.25
    """
    p = nonnegative("path_exponent", path_exponent) / 2
    energy = check("mass", mass) * np.asarray(check("velocity", velocity)) ** 2
    return plain((1 + p / 2) * energy / positive("max_indentation_depth", max_indentation_depth, "m"))


def kelvin_voigt_first_order_restitution(
    retardation_time: Any, max_indentation_depth: Any, velocity: Any, *, path_exponent: Any = 1.0
) -> Numeric:
    """Return the restitution coefficient e [-] on a Kelvin-Voigt half-space, to first order in small loss.

    Parameters
    ----------
    retardation_time : float or array
        tau [s] of the reduced modulus `E*(t) = E_inf [1 + tau delta(t)]`, >= 0.
    max_indentation_depth, velocity : float or array
        d_m [m] of the elastic impact at E_inf and v0 [m/s], > 0.
    path_exponent : float or array
        p [-], >= 0.

    Returns
    -------
    float or array
        `e = 1 - (1+P) B((1+P)/(2+P), 3/2) tau v0/d_m`, with an error of second order in `tau v0/d_m`.

    Notes
    -----
    To this order the exact rebound and the law of Kuwabara and Kono (Jpn. J. Appl. Phys. 26 (1987) 1230) agree. A
    Prony series whose relaxation times are all much shorter than the contact has this limit with
    `tau = sum E_k tau_k/E_inf`.

    Examples
    --------
    >>> round(kelvin_voigt_first_order_restitution(0.002, 1.0, 1.0, path_exponent=0.0), 9)  # 1 - 0.001 pi
    0.996858407
    """
    from scipy.special import beta

    p = nonnegative("path_exponent", path_exponent) / 2
    ratio = nonnegative("retardation_time", retardation_time, "s") / _time(max_indentation_depth, velocity)
    return plain(1 - (1 + p) * beta((1 + p) / (2 + p), 1.5) * ratio)


def hunter_restitution(
    equilibrium_modulus: Any, branch_moduli: Any, relaxation_times: Any, contact_time: Any, *,
    path_exponent: Any = 1.0,
) -> Numeric:  # fmt: skip
    """Return the restitution coefficient e [-] for relaxation much slower than the contact, to first order.

    Parameters
    ----------
    equilibrium_modulus : float
        E_inf [Pa] of the reduced modulus, >= 0.
    branch_moduli, relaxation_times : array, shape (n_branch,)
        E_k [Pa] of the reduced modulus, >= 0, and tau_k [s], > 0.
    contact_time : float or array
        Contact time T0 [s] of the elastic impact at `E_0 = E_inf + sum E_k`, > 0.
    path_exponent : float or array
        p [-], >= 0.

    Returns
    -------
    float or array
        `e = 1 - (2/(4+P)) T0 sum(E_k/tau_k)/E_0`, with an error of second order in T0/tau_k; the factor is 4/9 for the
        parabola (S. C. Hunter, J. Mech. Phys. Solids 8 (1960) 219).

    Examples
    --------
    >>> round(hunter_restitution(0.0, [1.0], [1000.0], 9.0), 12)
    0.996
    """
    moduli = np.atleast_1d(check("branch_moduli", branch_moduli))
    rates = 1 / np.atleast_1d(check("relaxation_times", relaxation_times))
    glass = check("equilibrium_modulus", equilibrium_modulus) + moduli.sum()
    loss = np.asarray(positive("contact_time", contact_time, "s")) * float(moduli @ rates) / glass
    p = nonnegative("path_exponent", path_exponent) / 2
    return plain(1 - 2 / (4 + p) * loss)


def flat_punch_kelvin_voigt_restitution(damping_ratio: Any) -> Numeric:
    """Return the restitution coefficient e [-] of a flat punch on a Kelvin-Voigt half-space.

    Parameters
    ----------
    damping_ratio : float or array
        `D = omega0 tau/2` [-] with `omega0^2 = 2 E_inf a/m` and `E*(t) = E_inf [1 + tau delta(t)]`, >= 0.

    Returns
    -------
    float or array
        `e = exp(-2 D acos(D)/sqrt(1-D^2))`, for `D > 1` with `acosh(D)/sqrt(D^2-1)`, `exp(-2)` at `D = 1`. Exact: a
        linear oscillator that leaves when its force is zero (T. Schwager and T. Poeschel, Granular Matter 9 (2007)
        465).

    Examples
    --------
    >>> round(flat_punch_kelvin_voigt_restitution(0.5), 9)  # exp(-2 pi/(3 sqrt(3)))
    0.298436059
    """
    d = np.asarray(nonnegative("damping_ratio", damping_ratio))
    # Smooth through D = 1, but 0/0 in floating point there.
    under, over = np.minimum(d, 1.0), np.maximum(d, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.where(d < 1.0, np.arccos(under) / np.sqrt(1 - under**2), np.arccosh(over) / np.sqrt(over**2 - 1))
    return plain(np.exp(-2 * d * np.where(np.abs(d - 1) < 1e-9, 1.0, angle)))


def flat_punch_maxwell_restitution(damping_ratio: Any) -> Numeric:
    """Return the restitution coefficient e [-] of a flat punch on a Maxwell half-space.

    Parameters
    ----------
    damping_ratio : float or array
        `D = 1/(2 omega0 tau)` [-] with `omega0^2 = 2 E_1 a/m` and `E*(t) = E_1 exp(-t/tau)`, >= 0.

    Returns
    -------
    float or array
        `e = exp(-pi D/sqrt(1-D^2))` for `D < 1`; 0 for `D >= 1`, where the punch sinks in and never turns. Exact: the
        force obeys `F'' + F'/tau + omega0^2 F = 0`, and the contact lasts half a period.

    Examples
    --------
    >>> round(flat_punch_maxwell_restitution(0.6), 9)  # exp(-0.75 pi)
    0.094780225
    """
    d = np.minimum(nonnegative("damping_ratio", damping_ratio), 1.0)
    with np.errstate(divide="ignore"):
        return plain(np.exp(-math.pi * np.divide(d, np.sqrt(1 - d**2))))


def standard_solid_small_p3_slope(nu: Any) -> Numeric:
    """Return the slope s [-] of `e = 1 - s p3 + ...` at small p3, for the paper's standard solid.

    Parameters
    ----------
    nu : float or array
        Static Poisson ratio p1 [-], in [-1, 0.5].

    Returns
    -------
    float or array
        `s = (3/2) C1 A (4 E/3)^(2/5)` with `C1 = SMALL_LOSS_FACTOR`; independent of p2. The retardation time
        `sum E_k tau_k/E_inf` of the reduced modulus is `A = (2/3)(1 - nu + nu^2)/(1 - nu)` times eta/Ginf, and
        `E = 2/(1 - nu)` is `E_inf/Ginf`. The error of e is of order p3^2.

    Examples
    --------
    >>> [round(float(s), 5) for s in standard_solid_small_p3_slope([0.0, 0.3, 0.45, 0.5])]
    [1.7076, 2.22267, 2.96746, 3.37979]
    """
    nu = np.asarray(within("nu", nu, -1.0, 0.5))
    dissipation, stiffness = (2 / 3) * (1 - nu + nu**2) / (1 - nu), 2 / (1 - nu)
    return plain(1.5 * SMALL_LOSS_FACTOR * dissipation * (4 * stiffness / 3) ** 0.4)


def standard_solid_large_p3_slope(nu: Any, p2: Any) -> Numeric:
    """Return the coefficient L [-] of `e = 1 - L/p3 + ...` at large p3, for the paper's standard solid.

    Parameters
    ----------
    nu, p2 : float or array
        Static Poisson ratio p1 [-], in [-1, 0.5], and Ginf/G1 [-], > 0.

    Returns
    -------
    float or array
        `L = (4/9) T0 sum(E_k p3/tau_k)/E_0`, from `hunter_restitution`; the error of e is of order (p2 p3)^-2.

    Notes
    -----
    In units of m = R = v0 = Ginf = 1, p3 is eta. T0 is the Hertz contact time at E_0. For the bulk modulus K,
    `G0 = 1 + 1/p2` and `beta = (3K + 4)/(3K + 4 G0)`, the branches of the reduced modulus are `E_1 = 1/p2` at `p2 p3`
    and `E_2 = (27 K^2/4)(1/(3K + 4) - 1/(3K + 4 G0))` at `p2 p3/beta`.

    Examples
    --------
    >>> slope = 4 / 9 * HERTZ_TIME_FACTOR * (15 / 128) ** 0.4 / 2  # of E_0 = 8 and E_1 = 4
    >>> round(standard_solid_large_p3_slope(0.5, 1.0) / slope, 12)
    1.0
    """
    nu = np.asarray(within("nu", nu, -1.0, 0.5))
    g1 = 1 / np.asarray(positive("p2", p2))
    # Finite for nu = 1/2; infinite for nu = -1, where there is no second branch.
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = 1 / (3 * bulk_factor(nu))
        soft, stiff = 1 + 4 * compliance, 1 + 4 * compliance * (1 + g1)
        second = np.where(nu > -1, 3 * g1 / (soft * stiff), 0.0)
        rate = np.where(nu > -1, soft / stiff, 0.0)
    glass = 2 / (1 - nu) + g1 + second
    return plain(4 / 9 * (HERTZ_TIME_FACTOR * (15 / (16 * glass)) ** 0.4) * g1 * (g1 + second * rate) / glass)


def equivalent_incompressible_p3(p3: Any) -> Numeric:
    """p3 [-] at which an incompressible half-space has the same e as a half-space with nu = -1 at the given p3.

    Parameters
    ----------
    p3 : float or array
        `eta (v0 R/(m^2 Ginf^3))^(1/5)` [-] of the half-space with nu = -1, > 0.

    Returns
    -------
    float or array
        `4^(-2/5) p3`, at the same p2. Exact: the reduced modulus is G(t) for K = 0 and 4 G(t) for nu = 1/2, so that
        only the time scale `(m^2/(R v0 E*^2))^(1/5)` of the impact differs, by 4^(2/5).

    Examples
    --------
    >>> round(equivalent_incompressible_p3(1.0), 9)
    0.574349177
    """
    return plain(0.25**0.4 * np.asarray(positive("p3", p3)))


def mueller_poeschel_restitution(reduced_velocity: Any) -> Numeric:
    """Return the restitution coefficient e [-] of viscoelastic spheres by the law of Brilliantov and others.

    Parameters
    ----------
    reduced_velocity : float or array
        `x = sqrt(b)` [-] with `b = (3/2) A (rho/m)^(2/5) v0^(1/5)`, >= 0, where the force is
        `F = rho (d^(3/2) + (3/2) A sqrt(d) d')`, rho in [N/m^1.5], A in [s].

    Returns
    -------
    float or array
        `e` of a [3/6] Pade approximant in x, within 1e-6 of the solution of the equation of motion up to x = 0.5 and
        within 7e-4 up to x = 3 (P. Mueller and T. Poeschel, Phys. Rev. E 84 (2011) 021302).

    Notes
    -----
    The exact rebound of a Kelvin-Voigt half-space (`KELVIN_VOIGT_RESTITUTION`) differs: this law keeps the formula of
    the approach, and the two agree to first order in b only, `e = 1 - 1.15345 b + ...`. On the incompressible
    Kelvin-Voigt half-space `rho = (16/3) G sqrt(R)` and `A = eta/G`, so that `b = (3/2) (16/3)^(2/5) p3`.

    Examples
    --------
    >>> mueller_poeschel_restitution(0.0)
    1.0
    """
    x = np.asarray(nonnegative("reduced_velocity", reduced_velocity))
    numerator = np.polynomial.polynomial.polyval(x, (1, 1.07232, 0.574198, 0.141552))
    denominator = np.polynomial.polynomial.polyval(x, (1, 1.07232, 1.72765, 1.37842, 1.19449, 0.467273, 0.235585))
    return plain(numerator / denominator)


def _time(depth: Any, velocity: Any) -> Any:
    return positive("max_indentation_depth", depth, "m") / np.asarray(check("velocity", velocity))
