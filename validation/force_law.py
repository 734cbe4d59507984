"""Force laws from finite elements of a disc, and from forces with noise.

Run as `python validation/force_law.py`; prints two tables and writes them to `force_law.md` beside this file. It takes
two minutes and needs scikit-fem (`pip install scikit-fem`).

The finite elements are static, axisymmetric, of second order. The pressure is piecewise linear between the nodes of
the surface, and a contact is known at the depth at which the pressure in the outermost node vanishes. That is the
solution of the discrete problem with p >= 0, because the contacts are nested.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad
from skfem.helpers import grad

import restitution as rs

POISSON_RATIO, HEIGHT = 0.45, 1.0
REACH, LAYER = 0.85, 0.12  # Where the mesh is finest: radius and depth.
SERIES = rs.PronySeries(1.0, [10.0], [0.1])
RUBBER = rs.Material(SERIES, SERIES.scaled(2 * (1 + POISSON_RATIO) / (3 * (1 - 2 * POISSON_RATIO))))
SOLID = rs.Material(SERIES, np.inf)
SHAPES = {
    "parabola": rs.Parabola(1.0),
    "cone": rs.Cone(1.2),
    "sphere": rs.Sphere(1.0),
    "flat punch": rs.FlatPunch(0.5),
    "truncated cone": rs.TruncatedCone(0.05, 1.4),
    "flat-ended parabola": rs.FlatEndedParabola(1.0, 0.1),
    "ellipse": rs.Ellipsoid(3.0, 0.5),
}
REPEATS = 25
# Radius of the disc, whether it is bonded, e of the impact by finite elements in time or of the exact infinite layer.
DISCS = [
    (1.16, True, 0.230926 - 7e-6),
    (1.16, False, 0.221920 + 1e-6),
    (15.0, True, 0.242202),
    (60.0, False, 0.227835),
]

TEXT = """\
## Force laws

`validation/force_law.py` makes these tables.

A ball (parabola, m = v0 = R = 1) strikes a rubber disc of height 1 with a free side on a rigid base:
$G = 1 + 10 e^{{-t/0.1}}$, a constant Poisson ratio of 0.45. The static force of an elastic twin comes from finite
elements, at as many depths as the surface has nodes; `rs.ForceLaw` makes the impact of it. It is compared with the
impact by finite elements in time of the design of this package, and for wide discs with the exact infinite layer.
Away from the contact the cells grow by the factor; the corner of the base and the side is a singularity of the bonded
disc. A frictionless layer feels a free side at 60 times its height.

{discs}

Forces at 40 to 400 random depths, with a noise of $10^{{-4}}$ of the largest force (constant) or of each force
(proportional). `error` is what `law.fit.error` states; the last two columns are the error of e over it.

{noise}
"""


def edges(n: int, far: float, near: float, factor: float) -> Any:
    """Edges of n equal cells from 0 to `near`, which then grow by a factor up to `far`."""
    result = list(np.linspace(0.0, near, n + 1))
    step = result[1]
    while result[-1] < far:
        step *= factor
        result.append(result[-1] + step)
    places = np.array(result)
    tail = places > near
    places[tail] = near + (places[tail] - near) * (far - near) / (places[-1] - near)
    return places


def elastic_forces(radius: float, bonded: bool, n: int, factor: float) -> tuple[Any, Any]:
    """Depths and forces under a parabola of radius 1, for Young's modulus 1."""
    lame = POISSON_RATIO / ((1 + POISSON_RATIO) * (1 - 2 * POISSON_RATIO))
    shear = 0.5 / (1 + POISSON_RATIO)
    r = edges(n, radius, REACH, factor)
    mesh = MeshQuad.init_tensor(r, HEIGHT - edges(max(n // 6, 6), HEIGHT, LAYER, factor)[::-1])
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)

    def strains(u: Any, place: Any) -> tuple[Any, Any, Any, Any]:
        g = grad(u)
        return g[0, 0], g[1, 1], u[0] / place, 0.5 * (g[0, 1] + g[1, 0])

    def energy(u: Any, v: Any, w: Any) -> Any:
        (a, b, c, s), (p, q, t, z) = strains(u, w.x[0]), strains(v, w.x[0])
        products = a * p + b * q + c * t + 2 * s * z
        return (lame * (a + b + c) * (p + q + t) + 2 * shear * products) * 2 * np.pi * w.x[0]

    stiffness = BilinearForm(energy).assemble(basis).tocsc()
    base, axis = (basis.get_dofs(lambda x, i=i: np.isclose(x[i], 0.0)) for i in (1, 0))
    fixed = np.concatenate([axis.all(["u^1"]), base.all() if bonded else base.all(["u^2"])])
    free = np.setdiff1d(np.arange(stiffness.shape[0]), fixed)
    top = mesh.facets_satisfying(lambda x: np.isclose(x[1], HEIGHT) & (x[0] < REACH + 1e-9))
    surface = FacetBasis(mesh, ElementVector(ElementQuad2()), facets=top, intorder=5)
    hats, nodes = np.eye(n + 1), r[: n + 1]
    loads = [
        LinearForm(lambda v, w, hat=hat: np.interp(w.x[0], nodes, hat) * v[1] * 2 * np.pi * w.x[0]).assemble(surface)
        for hat in hats
    ]
    load = np.stack(loads, axis=1)[free]
    compliance = load.T @ splu(stiffness[free][:, free]).solve(load)
    x, weights = np.polynomial.legendre.leggauss(5)
    places = (0.5 * (nodes[1:] + nodes[:-1])[:, None] + 0.5 * np.diff(nodes)[:, None] * x).ravel()
    rings = 2 * np.pi * places * (0.5 * np.diff(nodes)[:, None] * weights).ravel()
    averages = np.stack([np.interp(places, nodes, hat) for hat in hats])
    area, gap = averages @ rings, averages @ (rings * 0.5 * places**2)
    results = []
    for k in range(3, n + 1):
        punch, body = (np.linalg.solve(compliance[:k, :k], side[:k]) for side in (area, gap))
        depth = body[-1] / punch[-1]
        results.append((depth, area[:k] @ (depth * punch - body)))
    depths, forces = np.array(results).T
    return depths, forces


def disc_lines() -> list[str]:
    """Rows of the discs."""
    rows = ["| radius | base | nodes | factor | e | difference | fit: p, degree | misfit | error |", "|---" * 9 + "|"]
    for radius, bonded, expected in DISCS:
        for n, factor in ((60, 1.25), (60, 1.12), (60, 1.06), (120, 1.06)):
            law = rs.ForceLaw(*elastic_forces(radius, bonded, n, factor), modulus=1.0, poisson_ratio=POISSON_RATIO)
            e = rs.solve(rs.Impact(RUBBER, law, mass=1.0, velocity=1.0)).restitution_coefficient
            base = "bonded" if bonded else "frictionless"
            rows.append(
                f"| {radius:g} | {base} | {n} | {factor} | {e:.7f} | {e - expected:.1e} "
                f"| {law.fit.exponent:.4g}, {law.fit.degree} | {law.fit.misfit:.0e} | {law.fit.error:.0e} |"
            )
            print(rows[-1], flush=True)
    return rows


def noise_lines() -> list[str]:
    """Rows of the forces with noise."""
    random = np.random.default_rng(20261122)
    rows = [
        "| body | noise | largest error of e | median error stated | median ratio | largest ratio |",
        "|---" * 6 + "|",
    ]
    for name, body in SHAPES.items():
        exact = rs.solve(rs.Impact(SOLID, body, mass=1.0, velocity=1.0), rtol=1e-11)
        for proportional in (False, True):
            off, stated = [], []
            for _ in range(REPEATS):
                n = int(random.integers(40, 401))
                depth = random.uniform(0.0, 1.0, n)
                depth *= random.uniform(1.1, 2.0) * exact.max_indentation_depth / depth.max()
                force = 8.0 * body.force_integral_at_depth(depth)
                force = force + 1e-4 * random.standard_normal(n) * (force if proportional else force.max())
                law = rs.ForceLaw(depth, force, modulus=3.0, poisson_ratio=0.5)
                e = rs.solve(rs.Impact(SOLID, law, mass=1.0, velocity=1.0), rtol=1e-10).restitution_coefficient
                off.append(abs(e / exact.restitution_coefficient - 1.0))
                stated.append(law.fit.error)
            ratio = np.array(off) / stated
            rows.append(
                f"| {name} | {'proportional' if proportional else 'constant'} | {max(off):.1e} "
                f"| {np.median(stated):.1e} | {np.median(ratio):.2f} | {ratio.max():.2f} |"
            )
            print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Write `force_law.md`."""
    # The impacts are deep: only the numbers count.
    warnings.simplefilter("ignore")
    text = TEXT.format(discs="\n".join(disc_lines()), noise="\n".join(noise_lines()))
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
