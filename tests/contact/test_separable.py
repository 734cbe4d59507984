"""Bonded layers whose Poisson ratio relaxes: the separable approximation."""

import warnings

import numpy as np
import pytest

import restitution as rs
from restitution.contact.layer.separable import effective_modulus
from restitution.errors import RestitutionWarning
from restitution.impact.batch import Batch
from restitution.material.viscoelastic import reduced_modulus

# Static Poisson ratio, p2, thickness, e by finite elements in time, and errors in per cent of e, of the contact time
# and of the largest force: with E*(t), and with the effective modulus. Independent programs; table of the theory page.
ROWS = [
    (0.45, 0.1, 0.9, 0.44074, (-11, -7.5, 8.0), (0.1, -0.4, 4.7)),
    (0.45, 0.1, 0.3, 0.57033, (-14, -20, 22), (-0.5, -4.1, 9.7)),
    (0.49, 0.1, 0.4, 0.47230, (-15, -9, 8), (-0.4, -1.2, 5.7)),
    (0.30, 0.1, 0.4, 0.44060, (0.9, -11, 9), (0.0, -2.5, 2.5)),
    (0.45, 1.0, 0.3, 0.93595, (-2.6, -6.7, 8.0), (-0.1, -1.3, 3.6)),
    (0.30, 1.0, 0.4, 0.91571, (-1.6, -4.2, 4.3), (-0.1, -0.7, 1.4)),
]


def solid(poisson_ratio, p2=0.1):
    return rs.standard_solid(1.0, 1.0 / p2, 1.0, poisson_ratio=poisson_ratio)


def on_layer(material, thickness=0.4, **body):
    layer = rs.Layer(rs.Parabola(1.0), thickness=thickness, strict=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RestitutionWarning)
        return rs.Impact(material, layer, **({"mass": 1.0, "velocity": 1.0} | body))


def punch_stiffness(size, poisson_ratio):
    """Stiffness kappa of a flat punch, by Gauss nodes over cosines: layers.md, section 2, with other quadratures."""
    x, w = np.polynomial.legendre.leggauss(int(40 + 8 * size))
    y, w = 0.5 * size * (x + 1.0), 0.5 * size * w
    cells = int(20 + 20 * size)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    z = (30.0 / cells * (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes)).ravel()
    n = 3.0 - 4.0 * poisson_ratio
    compliance = (2 * n * np.sinh(2 * z) - 4 * z) / (2 * n * np.cosh(2 * z) + 1 + n * n + 4 * z * z)
    lines = np.cos(np.outer(y, z))
    kernel = (2.0 / np.pi) * (lines * (np.tile(15.0 / cells * weights, cells) * (1.0 - compliance))) @ lines.T
    return float(w @ np.linalg.solve(np.eye(y.size) - kernel * w, np.ones(y.size))) / size


@pytest.mark.parametrize(("poisson_ratio", "p2", "thickness", "e", "first", "second"), ROWS)
def test_impacts_have_the_stated_differences_from_finite_elements(poisson_ratio, p2, thickness, e, first, second):
    impact = on_layer(solid(poisson_ratio, p2), thickness)
    result = rs.solve(impact)
    # The errors are printed to 0.1 %.
    assert result.restitution_coefficient == pytest.approx(e * (1.0 + 0.01 * second[0]), rel=7e-4)
    # E*(t) errs by whole per cent, which the finite elements link with the approximation.
    plain = Batch.from_impact(impact, reduced_modulus(impact.material)).solve(1e-9)
    for name, error, other in zip(
        ("restitution_coefficient", "contact_time", "max_force"), first, second, strict=True
    ):
        ratio = getattr(result, name) / plain[name][0]
        assert ratio == pytest.approx((1.0 + 0.01 * other) / (1.0 + 0.01 * error), rel=0.01)


def test_a_flat_punch_has_the_effective_modulus():
    rng = np.random.default_rng(8)
    for _ in range(4):
        material = rs.Material(
            rs.PronySeries(1.0, 10.0 ** rng.uniform(-1.0, 1.0, 2), 10.0 ** rng.uniform(-3.0, 0.0, 2)),
            rng.uniform(1.0, 30.0),
        )
        size, s = rng.uniform(0.1, 4.0), 10.0 ** rng.uniform(-2.0, 4.0)
        shear, bulk = material.shear.carson_transform(s), material.bulk.equilibrium_modulus
        ratio = (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)
        stiffness = [punch_stiffness(0.8 * size, one) for one in (ratio, material.poisson_ratio)]
        wanted = reduced_modulus(material).carson_transform(s) * stiffness[0] / stiffness[1]
        assert effective_modulus(material, size).carson_transform(s) == pytest.approx(wanted, rel=1e-3)


def test_a_constant_poisson_ratio_leaves_the_modulus_as_it_is():
    shear = rs.PronySeries(1.0, [5.0], [0.1])
    material = rs.Material(shear, shear.scaled(2.0))
    impact = on_layer(material)
    assert impact.profile.separable
    assert impact.reduced_modulus == reduced_modulus(material)
    # The approximation itself has the same limit.
    found = effective_modulus(rs.Material(shear, rs.PronySeries(2.0, [10.0 + 1e-7], [0.1])), 1.0)
    for s in (1e-2, 1.0, 10.0, 1e4):
        assert found.carson_transform(s) == pytest.approx(impact.reduced_modulus.carson_transform(s), rel=1e-6)


def test_the_approximation_is_named_and_strict_layers_refuse_it():
    material, profile = solid(0.3), rs.Parabola(1.0)
    with pytest.warns(RestitutionWarning, match=r"relaxes from -0\.443 to 0\.3, and a bonded layer is approximate"):
        rs.Impact(material, rs.Layer(profile, thickness=0.4), mass=1.0, velocity=1.0)
    with pytest.raises(rs.InputError, match=r"^material: must have a Poisson ratio that does not change"):
        rs.Impact(material, rs.Layer(profile, thickness=0.4, strict=True), mass=1.0, velocity=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rs.Impact(material, rs.Layer(profile, thickness=0.4, base="frictionless", strict=True), mass=1.0, velocity=1.0)


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
def test_what_needs_one_modulus_for_all_sizes_is_refused_in_one_line():
    material = solid(0.3)
    impact = on_layer(material)
    dashpot = rs.kelvin_voigt(1.0, 1.0, bulk_modulus=3.0)
    single = "impact: must be of single impacts, in a list, on a bonded layer"
    tries = [
        (single, lambda: rs.solve(on_layer(material, velocity=[1.0, 2.0]))),
        (single, lambda: rs.sweep(impact, {"velocity": [0.5, 1.0]})),
        (single, lambda: rs.sweep(impact, {"poisson_ratio": [0.3, 0.4]})),
        (single, lambda: rs.surrogate(impact, velocity=(0.5, 2.0))),
        ("material: has no reduced modulus", lambda: rs.indent(material, impact.profile, depth=rs.triangle(0.1, 1.0))),
        ("material: must have no parallel dashpot", lambda: rs.solve(on_layer(dashpot))),
    ]
    for words, action in tries:
        with pytest.raises(rs.InputError) as caught:
            action()
        assert str(caught.value).startswith(words)
        assert "\n" not in str(caught.value)
    # One by one they are solved, each with its own size.
    found = rs.solve([on_layer(material, velocity=v) for v in (1.0, 2.0)]).restitution_coefficient
    alone = [rs.solve(on_layer(material, velocity=v)).restitution_coefficient for v in (1.0, 2.0)]
    np.testing.assert_allclose(found, alone, rtol=2e-9)
