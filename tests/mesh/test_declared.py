"""What a file declares stays."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block
from support.edits import shaken
from support.meshes import tet_grid, tri_grid
from support.places import cells_of, edges, facets, places
from support.runs import optimized


def lost(one, rows_of, **request):
    """Facets or edges inside a mesh that a run without declarations does away with."""
    result = optimized(one, **request)
    kind = "tetra" if one.dimension() == 3 else "triangle"
    left = places(result, rows_of(cells_of(result, kind)))
    rows = np.unique(np.sort(rows_of(cells_of(one, kind)), axis=1), axis=0)
    return np.array([row for row in rows if not places(one, [row]) & left])


@pytest.fixture(scope="module")
def ball(samples):
    return formats.read(samples / "raw_ball.mesh")[0]


@pytest.fixture(scope="module")
def plate(samples):
    return formats.read(samples / "plate.vtu")[0]


def with_block(one, kind, rows):
    """The mesh with one more block, without arrays."""
    blocks = [replace(b, data={}) for b in one.blocks]
    return replace(one, blocks=[*blocks, Block(kind, np.asarray(rows))])


def test_a_declared_triangle_inside_survives(ball):
    wanted = lost(ball, facets, preset="fast")[::10]
    assert len(wanted) > 3
    result = optimized(with_block(ball, "triangle", wanted), preset="fast")
    assert places(result, cells_of(result, "triangle")) == places(ball, wanted)
    shared = places(result, facets(cells_of(result, "tetra")))
    assert all(shared[facet] == 2 for facet in places(ball, wanted))


def test_a_declared_line_inside_tets_survives(ball):
    wanted = lost(ball, edges, preset="fast")[::10]
    assert len(wanted) > 3
    result = optimized(with_block(ball, "line", wanted), preset="fast")
    assert places(result, cells_of(result, "line")) == places(ball, wanted)
    assert places(ball, wanted).keys() <= places(result, edges(cells_of(result, "tetra"))).keys()


def test_a_declared_line_inside_triangles_survives(plate):
    wanted = lost(plate, edges, preset="best")[::10]
    assert len(wanted) > 3
    result = optimized(with_block(plate, "line", wanted), preset="best")
    assert places(result, cells_of(result, "line")) == places(plate, wanted)
    shared = places(result, edges(cells_of(result, "triangle")))
    assert all(shared[edge] == 2 for edge in places(plate, wanted))


@pytest.mark.parametrize("make", [lambda: shaken(tet_grid(4)), lambda: shaken(tri_grid(6))])
def test_declared_vertices_stay_where_they_are(make):
    one = make()
    free = optimized(one)
    gone = set(map(tuple, one.points)) - set(map(tuple, free.points))
    assert len(gone) > 5
    wanted = [k for k, point in enumerate(one.points) if tuple(point) in gone][::4]
    result = optimized(with_block(one, "vertex", [[k] for k in wanted]))
    assert set(map(tuple, one.points[wanted])) <= set(map(tuple, result.points))
    assert np.array_equal(result.points[cells_of(result, "vertex")[:, 0]], one.points[wanted])
    assert set(map(tuple, result.points)) != set(map(tuple, one.points))


@pytest.mark.parametrize("n_unused", [0, 2])
def test_vertices_declared_everywhere_are_ignored(n_unused):
    one = shaken(tet_grid(4))
    one.points = np.concatenate([one.points, 3.0 + np.arange(3 * n_unused).reshape(-1, 3)])
    everywhere = with_block(one, "vertex", np.arange(len(one.points))[:, None])
    assert not np.any(cast(everywhere).fixed)
    plain, result = optimized(one), optimized(everywhere)
    assert np.array_equal(result.points, plain.points)
    assert len(cells_of(result, "vertex")) == len(result.points)


@pytest.mark.parametrize("name", ["medit:required", "medit:corner"])
@pytest.mark.parametrize("make", [lambda: shaken(tet_grid(4)), lambda: shaken(tri_grid(6))])
def test_required_vertices_stay_where_they_are(make, name):
    one = make()
    gone = set(map(tuple, one.points)) - set(map(tuple, optimized(one).points))
    wanted = np.array([tuple(point) in gone for point in one.points])
    wanted &= np.cumsum(wanted) % 4 == 1
    one.point_data = {name: wanted.astype(np.uint8)}
    result = optimized(one)
    flags = result.point_data[name] == 1
    assert np.array_equal(result.points[flags], one.points[wanted])
    assert set(map(tuple, result.points)) != set(map(tuple, one.points))


def test_required_triangles_of_a_plane_stay():
    one = shaken(tri_grid(8))
    (block,) = one.blocks
    free = optimized(one)
    lost = places(one, block.cells) - places(free, cells_of(free, "triangle"))
    assert len(lost) > 5
    wanted = np.array([bool(places(one, [cell]) & lost) for cell in block.cells])
    wanted &= np.cumsum(wanted) % 5 == 1
    block.data = {"medit:required": wanted.astype(np.uint8)}
    result = optimized(one)
    (after,) = result.blocks
    flags = after.data["medit:required"] == 1
    assert places(result, after.cells[flags]) == places(one, block.cells[wanted])
    assert not np.array_equal(result.points, one.points)


def test_declared_cells_are_what_is_fixed():
    one = with_block(with_block(tet_grid(2), "line", [[0, 13]]), "vertex", [[13]])
    before = cast(one)
    assert np.flatnonzero(before.fixed).tolist() == [13]
    assert before.edges.tolist() == [[0, 13]]
    assert before.facets.shape == (0, 3)
    flat = cast(with_block(tri_grid(2), "line", [[0, 4]]))
    assert flat.facets.tolist() == [[0, 4]]
    assert flat.edges.shape == (0, 2)
