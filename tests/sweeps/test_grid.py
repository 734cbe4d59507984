"""The product of axes: chunks of the requested size cover every point once, without a list of chunks."""

import tracemalloc

import numpy as np
import pytest

from restitution.sweeps.grid import Grid, Linear, Samples, Uniform, boxes, lengths, make_grid, part_of


def every_point(grid: Grid, block: int) -> dict[str, np.ndarray]:
    """All points, assembled from chunks and parts of chunks."""
    arrays = {name: np.full(grid.shape, np.nan) for name in grid.names}
    for index in grid.chunks():
        chunk, region = grid.values(index), grid.region(index)
        for part in boxes(tuple(slice(0, n) for n in lengths(region)), block):
            for name, values in part_of(chunk, part).items():
                filled = arrays[name][region][part]
                assert np.isnan(filled).all()
                filled[...] = values
    return arrays


@pytest.mark.parametrize("chunk", [None, 1, 5, 7, 1000, {"velocity": 2, "draw": 3}])
def test_chunks_cover_every_point_once(chunk: object) -> None:
    velocities, masses = np.array([0.1, 0.2, 0.5, 1.0, 2.0]), Linear(1.0, 2.0, 3)
    draws = Samples(8, {"radius": Uniform(1.0, 2.0), "nu": Uniform(0.1, 0.4)}, rng=1)
    grid = make_grid({"velocity": velocities, "external_force": 0.5, "mass": masses, "draw": draws}, chunk)  # type: ignore[arg-type]
    assert (grid.dimensions, grid.shape, grid.n_points) == (("velocity", "mass", "draw"), (5, 3, 8), 120)
    assert sum(grid.size(index) for index in grid.chunks()) == 120
    arrays = every_point(grid, 4)
    drawn = draws.columns("draw", 0, 8)
    v, m, r = np.meshgrid(velocities, masses.values(0, 3), drawn["radius"], indexing="ij")
    nu = np.meshgrid(velocities, masses.values(0, 3), drawn["poisson_ratio"], indexing="ij")[2]
    for name, expected in (
        ("velocity", v),
        ("mass", m),
        ("radius", r),
        ("poisson_ratio", nu),
        ("external_force", 0.5 + 0 * v),
    ):
        np.testing.assert_array_equal(arrays[name], expected)


@pytest.mark.parametrize(
    ("shape", "chunk", "expected"),
    [
        ((100, 1000), 3000, (54, 55)),
        ((100, 1000), 300, (17, 17)),
        ((10, 10, 10), 1000, (10, 10, 10)),
        ((10, 10, 10), 250, (6, 6, 6)),
        ((4,), None, (4,)),
        ((10_000, 10_000), None, (256, 256)),
        ((31_623, 31_623), None, (256, 256)),
        ((10**6, 3, 10**4), None, (148, 3, 147)),
        ((5, 10**6), 1000, (5, 200)),
        ((10**8,), None, (65536,)),
    ],
)
def test_chunks_have_the_requested_size(shape: tuple[int, ...], chunk: int | None, expected: tuple[int, ...]) -> None:
    names = ("velocity", "mass", "radius")
    grid = make_grid({name: Linear(1.0, 2.0, n) for name, n in zip(names, shape, strict=False)}, chunk)
    assert grid.chunk_shape == expected


def test_random_chunks_are_nearly_square() -> None:
    """A chunk has at most the requested points, and nearly as many along each axis that it does not span."""
    rng = np.random.default_rng()
    for _ in range(200):
        shape = tuple(int(10.0 ** rng.uniform(0.0, 6.0)) for _ in range(rng.integers(1, 5)))
        room = int(10.0 ** rng.uniform(0.0, 5.0))
        names = ("velocity", "mass", "radius", "nu")
        axes = {name: Linear(0.1, 0.2, n) for name, n in zip(names, shape, strict=False)}
        parts = make_grid(axes, room).chunk_shape
        assert np.prod(parts) <= room
        cut = [part for part, n in zip(parts, shape, strict=True) if part < n]
        # Each part is rounded down, and the last one takes what the others leave.
        assert not cut or (max(cut) <= 4 * min(cut) and 4 * np.prod(parts) > room)


def test_a_grid_without_axes_is_one_point() -> None:
    grid = make_grid({"velocity": 1.0})
    assert (grid.shape, grid.n_points, list(grid.chunks())) == ((), 1, [()])
    assert part_of(grid.values(()), ()) == {"velocity": 1.0}


@pytest.mark.parametrize(
    ("axes", "chunk", "message"),
    [
        ({"nu": [0.3], "poisson_ratio": [0.4]}, None, "axes: poisson_ratio is set by another axis too"),
        ({"mass": [1.0], "draw": Samples(2, {"mass": Uniform(1.0, 2.0)})}, None, "axes: mass is set by another"),
        ({"contact_time": [1.0]}, None, "axes: contact_time is an output"),
        ({"mass": [1.0]}, 0, "chunk = 0"),
        ({"mass": [1.0]}, {"velocity": 3}, "chunk = 'velocity': must name a dimension; there are mass"),
        ({"mass": [1.0]}, {"mass": -3}, "chunk.mass = -3"),
        ({"nu": [0.3, 0.6]}, None, r"poisson_ratio\[1\] = 0.6"),
    ],
)
def test_invalid_chunks_are_refused(axes: dict[str, object], chunk: object, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        make_grid(axes, chunk)  # type: ignore[arg-type]


def test_chunks_of_long_axes_are_not_listed_in_memory() -> None:
    grid = make_grid(
        {"velocity": Linear(1.0, 2.0, 10**8), "mass": Linear(1.0, 2.0, 10**6)}, {"velocity": 1, "mass": 1000}
    )
    assert grid.n_chunks == 10**11
    tracemalloc.start()
    try:
        chunks = grid.chunks()
        first = [next(chunks) for _ in range(1001)]
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (first[0], first[999], first[1000]) == ((0, 0), (0, 999), (1, 0))
    assert most < 1e6
