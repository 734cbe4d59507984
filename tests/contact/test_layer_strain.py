"""Strain number of layers: against the strains of the elastic layer, closed forms of thin layers, and the half-space."""

import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.special import j0, j1

import restitution as rs
from restitution.validity import layer_strain_number, numbers


def compliance(z, nu):
    """Compliance K(z) of a bonded layer, or on a frictionless base for None: `docs/theory/layers.md`."""
    if nu is None:
        return 2 * np.sinh(z) ** 2 / (np.sinh(2 * z) + 2 * z)
    n = 3 - 4 * nu
    return (2 * n * np.sinh(2 * z) - 4 * z) / (2 * n * np.cosh(2 * z) + 1 + n * n + 4 * z * z)


def line_load(width, base_ratio):
    """Nodes, weights and line load under a parabola with g = x^2 at E* = 1, and the depth; lengths in thicknesses."""
    x, w = np.polynomial.legendre.leggauss(int(80 + 5 * width))
    x, w = (0.5 * width * (x + 1), 0.5 * width * w)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    cells = max(12, int(5 * width))
    z = (26 / cells * (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes)).ravel()
    missing = (1 - compliance(z, base_ratio)) * np.tile(13 / cells * weights, cells) * 2 / np.pi
    lines, edge = np.cos(np.outer(x, z)), np.cos(width * z)
    system = np.eye(x.size) - (lines * missing) @ lines.T * w
    punch, body = np.linalg.solve(system, np.stack([np.ones(x.size), x**2], 1)).T
    at_edge = (edge * missing) @ lines.T * w
    depth = (width**2 + at_edge @ body) / (1 + at_edge @ punch)
    return x, w, depth * punch - body, depth


def largest_shear(width, nu, bonded):
    """Largest principal shear strain over the depth in thicknesses, by Love's function in Hankel space, to 0.5 %."""
    x, w, load, depth = line_load(width, nu if bonded else None)
    last = 250 / width
    cells = int(np.ceil(last / min(4.8 / width, 2 * math.pi)))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    k = (last / cells * (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes)).ravel()
    measure = np.tile(0.5 * last / cells * weights, cells)
    # The pressure ends in a kink, whose short waves matter at the surface only.
    pressure = np.cos(np.outer(k, x)) @ (w * load) / np.pi * np.exp(-6 * (k / last) ** 2)

    def parts(z):
        a, b, s, t = np.exp(-k * z), np.exp(-k * (1 - z)), k * z, k * (1 - z)
        z0, z1, z2, z3 = (np.stack([(-1) ** n * a, (-1) ** n * (s - n) * a, b, (t - n) * b]) for n in range(4))
        normal, along = (1 - 2 * nu) * z2 - 2 * (1 - nu) * z0, z1
        stress, shear = (1 - nu) * z3 - (2 - nu) * z1, nu * z2 + (1 - nu) * z0
        return normal, along, stress, shear, (1 - 2 * nu) * z3 - 2 * (1 - nu) * z1, z2

    top, bottom = parts(0.0), parts(1.0)
    system = np.stack([top[2], top[3], bottom[0], bottom[1] if bonded else bottom[3]])
    right = np.zeros((4, k.size))
    right[0] = -pressure
    result = np.linalg.solve(np.moveaxis(system, 2, 0), right.T[..., None])[..., 0].T
    radii = np.linspace(1e-6, 1.05, 24) * width
    waves0, waves1, largest = j0(np.outer(radii, k)), j1(np.outer(radii, k)), 0.0
    for z in np.append(np.linspace(0.02, 1, 13), np.minimum(np.linspace(0.1, 1, 7) * width, 1)):
        normal, along, _, _, squeeze, turn = (np.einsum("bk,bk->k", item, result) * measure for item in parts(z))
        # 2 G = 1 - nu where E* = 1.
        ez, shear = waves0 @ (squeeze * k) / (1 - nu), waves1 @ ((turn - normal) * k) / (1 - nu)
        hoop = waves1 @ along / radii / (1 - nu)
        er = waves0 @ (along * k) / (1 - nu) - hoop
        middle, half = 0.5 * (ez + er), np.hypot(0.5 * (ez - er), 0.5 * shear)
        strains = np.stack([middle + half, middle - half, hoop])
        largest = max(largest, float(np.max(strains.max(axis=0) - strains.min(axis=0))))
    return largest / depth


def confinement(nu):
    return max(4 * nu / (1 - 2 * nu), 0.0) if nu < 0.5 else math.inf


@pytest.mark.parametrize("bonded", [True, False])
def test_number_against_the_strains_of_the_elastic_layer(bonded):
    rng = np.random.default_rng(21)
    for _ in range(5):
        width = 10 ** rng.uniform(-0.7, 1.3)
        nu = 0.5 - 10 ** rng.uniform(-4, -0.5)
        number = layer_strain_number(1.0, width, confinement(nu) if bonded else 0.0)
        # Within a fifth below and a half above for Poisson ratios from 0.18 on: the table of the page.
        assert 0.8 < 0.7 * number / largest_shear(width, nu, bonded) < 1.6


def test_shear_of_a_thin_bonded_incompressible_layer():
    # Flow between the body and the base (Reynolds): the shear at the base is d a/(sqrt(3) h^2) under a parabola.
    width = 40.0
    assert largest_shear(width, 0.5, True) / width == pytest.approx(1 / math.sqrt(3), rel=0.06)
    assert 0.7 * layer_strain_number(1.0, width, math.inf) / width == pytest.approx(1 / math.sqrt(3), rel=0.25)


def test_shear_of_a_thin_compressible_layer():
    # Springs: d/h where the base holds the layer, and d/h (1 + nu/(2 (1 - nu))) where it slides.
    assert largest_shear(20.0, 0.3, True) == pytest.approx(1.0, rel=0.01)
    assert largest_shear(20.0, 0.3, False) == pytest.approx(1 + 0.3 / 1.4, rel=0.01)
    for item in (confinement(0.3), 0.0):
        assert 1.0 < 0.7 * layer_strain_number(1.0, 200.0, item) < 1.5


def test_a_thick_layer_has_the_number_of_the_half_space():
    material: Any = rs.Material(1e6, math.inf)
    ball: Any = {"mass": 0.005, "velocity": 1.0}
    half_space = rs.solve(rs.Impact(material, rs.Parabola(0.01), **ball)).validity["small_strain"]
    thick = rs.solve(rs.Impact(material, rs.Layer(rs.Parabola(0.01), 100.0), **ball)).validity["small_strain"]
    assert thick.value == pytest.approx(half_space.value, rel=1e-3)
    # An incompressible half-space under a parabola.
    assert 0.05 * largest_shear(0.05, 0.5, True) == pytest.approx(0.7, rel=0.02)


def squeezed(velocity=3.0, **options):
    rubber = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    return rs.Impact(rubber, rs.Layer(rs.Parabola(0.01), 1e-4, **options), mass=0.005, velocity=velocity)


def test_a_layer_that_is_squeezed_by_half_of_its_thickness_warns():
    result = rs.solve(squeezed())
    check = result.validity["small_strain"]
    share = result.max_indentation_depth / 1e-4
    assert share > 0.5
    assert result.max_contact_radius / 0.01 < 0.2
    assert check.exceeded
    assert f"{100 * share:.2g} % of the thickness" in check.message
    assert result.warnings == [check.warning]
    assert rs.solve(squeezed(1e-3)).warnings == []


def test_every_result_warns_of_a_squeezed_layer():
    impact = squeezed()
    depth = rs.triangle(float(rs.solve(impact).max_indentation_depth), 1e-4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        table = rs.sweep(impact, {"velocity": [1e-3, 3.0]}, ["layer_strain", "strain_number"])
        result = [
            rs.solve(replace(impact, velocity=[1.0, 3.0])), rs.solve([impact, squeezed(1e-3)]),
            rs.bounces(impact, max_bounces=2), rs.surrogate(impact, (2.0, 3.0), 1e-3),
            rs.indent(impact.material, impact.profile, depth=depth), rs.solve(squeezed(base="frictionless")),
        ]  # fmt: skip
    assert all("% of the thickness" in item.warnings[0] for item in result)
    assert (table.strain_number > 0.2).to_numpy().tolist() == [False, True]
    assert float(table.layer_strain[1]) == pytest.approx(rs.solve(impact).max_indentation_depth / 1e-4, rel=1e-8)
    assert "exceeded in 1 of 2" in table.attrs["validity"]
    assert math.isnan(numbers(replace(impact, profile=rs.Parabola(0.01)).contact, max_contact_radius=1e-3,
                              max_indentation_depth=1e-4, velocity=1.0, contact_time=1.0).layer_strain[0])  # fmt: skip


def test_the_largest_poisson_ratio_in_time_counts():
    # Incompressible at rest, compressible when fast.
    solid = rs.standard_solid(1e6, 1e9, 1e3, poisson_ratio=0.4999)
    constant = rs.Material(solid.shear, solid.shear.scaled(2 / 3 * 1.4999 / 0.0002))
    arguments = {"max_contact_radius": 1e-3, "max_indentation_depth": 1e-6, "velocity": 1.0, "contact_time": 1.0}
    layer = rs.Layer(rs.Parabola(0.1), 1e-4)
    result = [
        numbers(rs.Impact(item, layer, 1.0, 1.0).contact, **arguments).strain_number[0] for item in (solid, constant)
    ]
    assert solid.instantaneous_poisson_ratio < 0.45
    assert result[0] == pytest.approx(result[1], rel=1e-6)
    assert result[0] == pytest.approx(layer_strain_number(0.01, 10.0, 4 * 0.4999 / 0.0002), rel=1e-6)
