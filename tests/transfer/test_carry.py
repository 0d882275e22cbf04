"""Point location, and what becomes of arrays."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block
from meshopt_cli.mesh.plane import with_depth
from meshopt_cli.mesh.tags import DIM_TAGS, GEOMETRICAL, MAX_LABELS, REF, with_regions
from meshopt_cli.transfer.places import cells_at
from support.edits import halves, shaken
from support.meshes import in_space, tet_grid, tri_grid
from support.runs import optimized
from support.samples import SAMPLES, sample
from support.settings import examples


def cells_and(mesh, name):
    """The cells of the greatest dimension, and an array on them."""
    kind = "tetra" if mesh.dimension() == 3 else "triangle"
    blocks = [b for b in mesh.blocks if b.type == kind and len(b.cells)]
    return (
        np.concatenate([b.cells for b in blocks]),
        np.concatenate([b.data[name] for b in blocks]),
    )


def comb(make, n=6):
    """A grid without every second layer of cells, but for a back that holds the teeth together."""
    mesh = make(n)
    block = mesh.blocks[0]
    middle = mesh.points[block.cells].mean(axis=1)
    tooth = (middle[:, 0] * n).astype(int) % 2 == 0
    block.cells = block.cells[tooth | (middle[:, 1] * n > n - 1)]
    return mesh


@cache
def located(name):
    """A mesh to look for points in."""
    if name == "comb":
        return cast(comb(tet_grid))
    if name == "flat comb":
        return cast(comb(tri_grid))
    if name == "halves":
        return cast(halves(shaken(tet_grid(4), 0.15, 3)))
    if name == "line of cells":
        thin = shaken(tet_grid(4), 0.15, 3)
        thin.points *= (1e3, 1.0, 1e-6)
        return cast(thin)
    return sample(name)


PLACES = ["comb", "flat comb", "halves", "line of cells", "quadtree.vtk", "plate.vtu",
          "two_regions.msh", "raw_ball.mesh"]  # fmt: skip


@pytest.mark.parametrize("name", PLACES)
@examples(10)
@given(seed=st.integers(0, 2**32 - 1))
def test_points_are_found_in_their_region(name, seed):
    """Non-convex domains too: the teeth of a comb are in each other's way (Remark 18.2)."""
    mesh = located(name)
    random = np.random.default_rng(seed)
    homes = random.integers(len(mesh.cells), size=200)
    shares = random.dirichlet(np.ones(mesh.cells.shape[1]), len(homes))
    points = np.einsum("ij,ijk->ik", shares, mesh.points[mesh.cells[homes]])
    found, weights = cells_at(mesh, points, mesh.region[homes])
    assert np.array_equal(mesh.region[found], mesh.region[homes])
    assert weights.min() >= -1e-6
    again = np.einsum("ij,ijk->ik", weights, mesh.points[mesh.cells[found]])
    extent = np.ptp(mesh.points, axis=0).max()
    np.testing.assert_allclose(again, points, rtol=0, atol=1e-14 * extent)
    # Far from the facets of its cell, a point can be in no other.
    clear = shares.min(axis=1) > 1e-3
    assert np.array_equal(found[clear], homes[clear])


def test_points_between_two_regions_are_found_in_the_one_asked_for():
    mesh = located("halves")
    facets, times = np.unique(np.sort(mesh.skin, axis=1), axis=0, return_counts=True)
    middle = mesh.points[facets[times == 2]].mean(axis=1)
    assert len(middle)
    for region in (0, 1):
        found, weights = cells_at(mesh, middle, np.full(len(middle), region))
        assert np.all(mesh.region[found] == region)
        assert weights.min() >= -1e-12


@pytest.mark.parametrize("name", PLACES)
def test_points_outside_get_the_nearest_place(name):
    mesh = located(name)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    corner = mesh.cells[np.argmax(mesh.points[mesh.cells].mean(axis=1).sum(axis=1))]
    far = (high + 10 * (high - low))[None]
    found, weights = cells_at(mesh, far, mesh.region[:1])
    assert weights.min() >= 0
    assert weights.sum() == pytest.approx(1)
    assert mesh.region[found[0]] == mesh.region[0]
    if name == "comb":
        assert set(mesh.cells[found[0]]) & set(corner)


def test_a_region_that_is_not_there():
    found, _ = cells_at(located("comb"), np.zeros((2, 3)), np.array([5, -1]))
    assert found.tolist() == [-1, -1]


def fields_of(mesh):
    """Linear fields of all widths, and their values at any points."""
    places = with_depth(mesh.points)
    centre, extent = places.mean(axis=0), np.ptp(places, axis=0).max()
    slopes = {"T": np.array([1.0, -2.0, 3.0]), "u": np.arange(9.0).reshape(3, 3) - 4}
    slopes["sigma"] = np.linspace(-1, 1, 27).reshape(3, 9)

    def at(points):
        return {n: (with_depth(points) - centre) / extent @ s + 7 for n, s in slopes.items()}

    return at


def with_data(mesh):
    """A mesh with fields on points, and on each cell its number, as no number."""
    mesh.point_data |= fields_of(mesh)(mesh.points)
    mesh.point_data["place"] = (np.arange(len(mesh.points)) // 2).astype(np.int16)
    kind, first = "tetra" if mesh.dimension() == 3 else "triangle", 0
    for block in mesh.blocks:
        if block.type == kind:
            block.data["donor"] = np.arange(first, first + len(block.cells)) + 0.5
            block.data["flow"] = np.sqrt(with_depth(mesh.points)[block.cells].mean(axis=1) + 2)
            first += len(block.cells)
    return mesh


def stretched(mesh):
    mesh.points = mesh.points * (1, 1, 1e-3) + 5.0
    return mesh


def rounded(mesh):
    mesh.points = mesh.points * 1e-9 + 1e-7
    return mesh


MESHES = {
    "ball": lambda: formats.read(SAMPLES / "raw_ball.mesh")[0],
    "regions": lambda: formats.read(SAMPLES / "two_regions.msh")[0],
    "grid": lambda: formats.read(SAMPLES / "grid.vtk")[0],
    "comb": lambda: comb(lambda n: shaken(tet_grid(n), 0.3, 3)),
    "flat": lambda: stretched(shaken(tet_grid(4), 0.3, 3)),
    "tiny": lambda: rounded(shaken(tet_grid(4), 0.3, 3)),
    "plate": lambda: formats.read(SAMPLES / "plate.vtu")[0],
    "plane": lambda: in_space(shaken(tri_grid(8), 0.3, 3), 2.5),
}


@pytest.fixture(scope="module", params=MESHES)
def pair(request):
    """A mesh with arrays, and what an optimization makes of it."""
    mesh = with_data(MESHES[request.param]())
    result = optimized(mesh)
    assert not np.array_equal(result.points, mesh.points)
    return mesh, result


def test_linear_fields_are_exact(pair):
    mesh, result = pair
    for name, wanted in fields_of(mesh)(result.points).items():
        values = result.point_data[name]
        assert values.dtype == np.float64
        assert np.abs(values - wanted).max() <= 1e-12 * np.ptp(wanted)


def test_no_value_is_invented(pair):
    mesh, result = pair
    assert set(result.point_data["place"]) <= set(mesh.point_data["place"])
    assert result.point_data["place"].dtype == np.int16
    _, numbers = cells_and(mesh, "donor")
    after, carried = cells_and(result, "donor")
    assert set(carried) <= set(numbers)
    carried = np.floor(carried).astype(int)
    # All arrays of a cell come from one.
    assert np.array_equal(cells_and(result, "flow")[1], cells_and(mesh, "flow")[1][carried])
    # It is the one that holds the centre.
    source = cast(mesh)
    centres = with_depth(result.points)[after].mean(axis=1)
    if source.frame is not None:
        centres = source.frame.flatten(centres)
    rows = np.arange(len(carried))
    donors = replace(source, cells=source.cells[carried], region=rows)
    _, weights = cells_at(donors, centres, rows)
    assert weights.min() >= -1e-9


def test_what_stays_keeps_every_bit(pair):
    mesh, result = pair
    old = {point.tobytes(): k for k, point in enumerate(mesh.points)}
    stay = [(k, old[p.tobytes()]) for k, p in enumerate(result.points) if p.tobytes() in old]
    assert len(stay) > 10
    new, known = np.transpose(stay)
    for name, values in mesh.point_data.items():
        if name != DIM_TAGS:
            assert result.point_data[name][new].tobytes() == values[known].tobytes()
    number = np.full(len(result.points), -1)
    number[new] = known
    (before, numbers), (after, carried) = cells_and(mesh, "donor"), cells_and(result, "donor")
    home = {tuple(sorted(cell)): n for cell, n in zip(before.tolist(), numbers, strict=True)}
    same = [(home.get(tuple(sorted(c))), n) for c, n in zip(number[after].tolist(), carried,
                                                            strict=True)]  # fmt: skip
    kept = [(one, other) for one, other in same if one is not None]
    assert all(one == other for one, other in kept)


def test_arrays_keep_their_order_and_kind(pair):
    mesh, result = pair
    assert list(result.point_data) == list(mesh.point_data)
    kind = "tetra" if mesh.dimension() == 3 else "triangle"
    old, new = (next(b for b in m.blocks if b.type == kind) for m in pair)
    assert {n: a.dtype for n, a in old.data.items()} == {n: a.dtype for n, a in new.data.items()}
    assert list(old.data) == list(new.data)


def test_single_precision_stays():
    mesh = with_data(shaken(tet_grid(4), 0.3, 3))
    mesh.point_data = {n: a.astype(np.float32) for n, a in mesh.point_data.items()}
    assert {a.dtype for a in optimized(mesh).point_data.values()} == {np.dtype(np.float32)}


def test_without_data_only_tags_are_left():
    mesh = with_data(formats.read(SAMPLES / "two_regions.msh")[0])
    result = optimized(mesh, with_data=False)
    assert set(result.point_data) <= {DIM_TAGS, REF}
    assert {n for b in result.blocks for n in b.data} <= {"gmsh:physical", GEOMETRICAL, REF}


def test_new_points_lie_on_the_entity_of_their_cells():
    mesh = formats.read(SAMPLES / "raw_ball.mesh")[0]
    mesh.blocks[-1].data[GEOMETRICAL] = np.full(len(mesh.blocks[-1].cells), 7)
    n = len(mesh.points)
    mesh.point_data = {DIM_TAGS: np.full((n, 2), (2, 5)), REF: np.arange(1, n + 1)}
    result = optimized(mesh)
    new = np.flatnonzero(result.point_data[REF] == 0)
    assert len(new)
    assert set(map(tuple, result.point_data[DIM_TAGS][new])) == {(3, 7)}
    assert set(map(tuple, np.delete(result.point_data[DIM_TAGS], new, axis=0))) == {(2, 5)}


def test_arrays_on_a_part_of_the_cells(caplog):
    mesh = shaken(tet_grid(4), 0.3, 3)
    cells = mesh.blocks[0].cells
    low = mesh.points[cells].mean(axis=1)[:, 0] < 0.5
    tags = [{"part": np.full(n, i)} for i, n in enumerate((np.sum(low), np.sum(~low)))]
    halves = zip((low, ~low), tags, strict=True)
    mesh.blocks = [Block("tetra", cells[rows], data) for rows, data in halves]
    mesh.blocks[0].data["x"] = np.linspace(1, 2, low.sum())
    mesh.blocks[0].data["n"] = np.arange(low.sum()) // 2
    mesh.blocks[1].data["pair"] = np.zeros(((~low).sum(), 2))
    mesh.blocks[0].data["pair"] = np.zeros((low.sum(), 3))
    first, second = optimized(mesh).blocks
    assert set(first.data) == {"part", "x", "n"}
    assert set(second.data) == {"part"}
    assert set(first.data["x"]) <= set(mesh.blocks[0].data["x"])
    (message,) = [r.getMessage() for r in caplog.records if "dropped" in r.getMessage()]
    assert message.endswith(": pair")


def test_numbers_of_which_few_are_left_make_no_regions():
    """65 values are no tags; when one of them is gone, the others would pass for tags."""
    mesh = with_data(shaken(tet_grid(4), 0.3, 3))
    data = mesh.blocks[0].data
    gone = set(data["donor"]) - set(cells_and(optimized(mesh), "donor")[1])
    assert gone
    data["number"] = np.arange(len(data["donor"])) % MAX_LABELS
    data["number"][int(min(gone))] = MAX_LABELS
    left = cells_and(optimized(mesh), "number")[1]
    assert set(left) <= set(range(MAX_LABELS))


def test_only_the_arrays_asked_for_make_regions():
    mesh = halves(shaken(tet_grid(4), 0.3, 3))
    (block,) = mesh.blocks
    (tag,) = block.data
    block.data["stripe"] = (mesh.points[block.cells].mean(axis=1)[:, 1] > 0.5).astype(int)
    assert len(set(cast(mesh).region)) == 4
    assert len(set(cast(with_regions(mesh, ("stripe",))).region)) == 2
    result = optimized(with_regions(mesh, ("stripe",)))
    cells, stripe = cells_and(result, "stripe")
    assert np.array_equal(stripe == 1, result.points[cells].mean(axis=1)[:, 1] > 0.5)
    assert set(cells_and(result, tag)[1]) == set(block.data[tag])


def test_arrays_that_cannot_make_regions():
    mesh = with_data(tet_grid(1))
    mesh.blocks[0].data["text"] = np.array(["a"] * len(mesh.blocks[0].cells))
    for name in ("none", "text"):
        with pytest.raises(ConfigError, match=rf"{name}.*choose from donor, flow"):
            with_regions(mesh, (name,))
