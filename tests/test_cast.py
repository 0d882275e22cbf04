"""From a mesh to what is optimized and back: planes, precision, regions, what is declared."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from builders import in_space, mesh, octahedron, quad_grid, tet_grid, tri_grid
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.errors import BadMeshError, UnsupportedMeshError
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast, with_simplices
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.tags import MAX_LABELS, TAG_NAMES, regions_of
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.work.workspace import Workspace

# Where the two coordinates of a planar mesh go: two of the axes, and a height along the third.
AXIS_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2), "yx": (1, 0), "zx": (2, 0)}
every_axis_plane = pytest.mark.parametrize("axes", AXIS_PLANES.values(), ids=AXIS_PLANES)


def ints(*values):
    return np.array(values, dtype=np.int64)


def shaken(grid, seed=0):
    """A grid with its internal points moved, all cells positive still."""
    points = grid.points
    side = round(len(points) ** (1 / points.shape[1])) - 1
    inner = np.all((points > 1e-9) & (points < 1 - 1e-9), axis=1)
    generator = np.random.default_rng(seed)
    points[inner] += generator.uniform(-0.22, 0.22, (inner.sum(), points.shape[1])) / side
    return grid


def in_plane(flat, axes, height=0.0):
    """A mesh of two columns in a plane normal to an axis."""
    points = np.full((len(flat.points), 3), height, dtype=flat.points.dtype)
    points[:, axes] = flat.points
    return replace(flat, points=points)


def rotation(seed):
    """A random rotation, (3, 3)."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


def in_tilted_plane(flat, seed=0, shift=(0.3, -2.0, 5.0)):
    spatial = in_plane(flat, (0, 1))
    return replace(spatial, points=spatial.points @ rotation(seed).T + np.array(shift))


def turned(one):
    """The mesh with all its main cells listed the other way round."""
    blocks = [replace(b, cells=b.cells[:, [0, 2, 1, *range(3, b.cells.shape[1])]].copy())
              for b in one.blocks]  # fmt: skip
    return replace(one, blocks=blocks)


def single(one):
    return replace(one, points=one.points.astype(np.float32))


def areas(points, triangles):
    """Signed areas seen from above z = 0."""
    corners = points[triangles][:, :, :2]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2


def volumes(points, tets):
    corners = points[tets]
    edges = corners[:, 1:] - corners[:, :1]
    return np.linalg.det(edges) / 6


def moved(one, vertex, by):
    """A mesh, cast, after the work moved one vertex, and put together again."""
    before = cast(one)
    points = before.points.copy()
    points[vertex, : len(by)] += by
    worked = replace(before, points=points)
    return before, worked, with_simplices(one, worked, np.arange(len(points)), before)


def optimized(one, **request):
    """The mesh after a whole run."""
    plan = plan_for(Request(**request), one.dimension())
    return job.optimize(one, plan.pipeline, plan.measure).mesh


def worked_on(one, **request):
    """What a pipeline makes of a mesh: as cast, as worked on, and as put together again."""
    before = cast(one)
    plan = plan_for(Request(**request), before.dimension)
    worked, origin = plan.pipeline.run(Workspace(before, plan.measure.judge)).work.result()
    return before, worked, with_simplices(one, worked, origin, before)


def cells_of(one, kind):
    return np.concatenate([b.cells for b in one.blocks if b.type == kind])


def places(one, rows):
    """Cells as a multiset of sets of coordinates, so that numbering does not matter."""
    return Counter(frozenset(map(tuple, one.points[row].tolist())) for row in rows)


def facets(cells):
    """All facets of triangles or tets."""
    width = cells.shape[1]
    return np.concatenate([np.delete(cells, k, axis=1) for k in range(width)])


def edges(cells):
    width = cells.shape[1]
    return np.concatenate([cells[:, [i, j]] for i in range(width) for j in range(i)])


# Planes -----------------------------------------------------------------------------------


@every_axis_plane
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    height=st.floats(-1e6, 1e6),
    scale=st.sampled_from([1e-9, 1.0, 3e7]),
    seed=st.integers(0, 99),
    clockwise=st.booleans(),
)
def test_an_axis_plane_loses_no_bit(axes, height, scale, seed, clockwise):
    flat = shaken(tri_grid(3), seed)
    flat.points *= scale
    one = in_plane(turned(flat) if clockwise else flat, axes, height)
    before = cast(one)
    assert np.all(before.points[:, 2] == 0.0)
    assert np.array_equal(before.frame.unflatten(one.points, before.points), one.points)
    for column in np.abs(before.points[:, :2]).T:
        assert any(np.array_equal(column, np.abs(other)) for other in flat.points.T)


@every_axis_plane
@pytest.mark.parametrize("clockwise", [False, True])
def test_only_the_moved_vertex_of_a_plane_changes(axes, clockwise):
    flat = shaken(tri_grid(4))
    one = in_plane(turned(flat) if clockwise else flat, axes, 0.1)
    before, worked, result = moved(one, 12, (0.01, 0.003))
    assert np.array_equal(np.delete(result.points, 12, axis=0), np.delete(one.points, 12, axis=0))
    assert np.any(result.points[12] != one.points[12])
    assert np.array_equal(before.frame.flatten(result.points), worked.points)


def test_two_columns_stay_two_columns():
    flat = shaken(tri_grid(4))
    _, worked, result = moved(flat, 12, (0.01, 0.003))
    assert result.points.shape == flat.points.shape
    assert np.array_equal(result.points, worked.points[:, :2])


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), clockwise=st.booleans())
def test_triangles_are_positive_in_every_plane(seed, clockwise):
    flat = shaken(tri_grid(3), seed)
    one = in_tilted_plane(turned(flat) if clockwise else flat, seed)
    before = cast(one)
    wanted = areas(flat.points, cells_of(flat, "triangle"))
    found = areas(before.points, before.cells)
    assert np.all(found > 0)
    assert found == pytest.approx(np.abs(wanted), rel=1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_a_tilted_plane_is_kept_to_rounding(seed):
    one = in_tilted_plane(shaken(tri_grid(4), seed), seed)
    _, _, result = moved(one, 12, (0.02, -0.01))
    assert np.array_equal(np.delete(result.points, 12, axis=0), np.delete(one.points, 12, axis=0))
    normal = rotation(seed)[:, 2]
    heights = (result.points - one.points[0]) @ normal
    assert np.max(np.abs(heights)) < 1e-13
    assert np.linalg.norm(result.points[12] - one.points[12]) == pytest.approx(np.hypot(0.02, 0.01))


@every_axis_plane
def test_heights_over_an_axis_plane_are_kept(axes):
    one = in_plane(shaken(tri_grid(4)), axes, 0.25)
    (across,) = {0, 1, 2} - set(axes)
    one.points[:, across] += np.random.default_rng(1).uniform(-2e-7, 2e-7, len(one.points))
    result = optimized(one, passes=("smooth",))
    assert len(result.points) == len(one.points)
    assert np.any(result.points != one.points)
    assert np.array_equal(result.points[:, across], one.points[:, across])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("clockwise", [False, True])
def test_a_run_keeps_a_tilted_plane_and_its_boundary(seed, clockwise):
    flat = shaken(tri_grid(6), seed)
    one = in_tilted_plane(turned(flat) if clockwise else flat, seed)
    result = optimized(one)
    normal = rotation(seed)[:, 2]
    assert np.max(np.abs((result.points - one.points[0]) @ normal)) < 1e-13
    rim = np.any((flat.points < 1e-9) | (flat.points > 1 - 1e-9), axis=1)
    assert set(map(tuple, one.points[rim])) <= set(map(tuple, result.points))
    assert np.any(~np.isin(result.points[:, 0], one.points[:, 0]))


def spiked(side=10):
    """Triangles that only a new vertex mends: a square around long cells without inner points."""
    ticks = np.linspace(0, 1, side + 1)[:-1]
    ring = np.concatenate([
        np.column_stack([ticks, 0 * ticks]),
        np.column_stack([1 + 0 * ticks, ticks]),
        np.column_stack([1 - ticks, 1 + 0 * ticks]),
        np.column_stack([0 * ticks, 1 - ticks]),
    ])  # fmt: skip
    points = np.concatenate([ring, [[0.42, 0.45]]])
    n = len(ring)
    return mesh(points, triangle=[[i, (i + 1) % n, n] for i in range(n)])


@every_axis_plane
@pytest.mark.parametrize("stray", [False, True])
def test_new_vertices_lie_in_the_plane(axes, stray):
    """Also when points that no cell uses do not."""
    one = in_plane(spiked(), axes, 0.25)
    if stray:
        one.points = np.concatenate([one.points, [[7.0, 8.0, 9.0]]])
    (across,) = {0, 1, 2} - set(axes)
    result = optimized(one, passes=("split", "smooth", "swap"))
    assert len(result.points) > len(one.points)
    used = result.points[np.unique(cells_of(result, "triangle"))]
    assert np.all(used[:, across] == 0.25)
    assert np.all((used[:, list(axes)] >= 0) & (used[:, list(axes)] <= 1))


@pytest.mark.parametrize("shift", [(5e5, 5.2e6, 120.0), (-1e7, 0.0, 0.0)])
def test_a_plane_far_from_the_origin(shift):
    """As in projected geographic coordinates."""
    flat = shaken(tri_grid(5))
    flat.points *= 100.0
    one = in_tilted_plane(flat, seed=2, shift=shift)
    result = optimized(one)
    normal = rotation(2)[:, 2]
    assert np.max(np.abs((result.points - one.points.mean(axis=0)) @ normal)) < 1e-7


@pytest.mark.parametrize("seed", range(3))
def test_single_precision_in_a_plane_far_from_the_origin(seed):
    """Coordinates are rounded to more than the usual tolerance there."""
    flat = shaken(tri_grid(5))
    one = in_tilted_plane(flat, seed=seed, shift=(700.0, -300.0, 500.0))
    one.points = one.points.astype(np.float32)
    normal = rotation(seed)[:, 2].astype(np.float64)
    heights = one.points.astype(np.float64) @ normal
    result = optimized(one)
    assert result.points.dtype == np.float32
    assert not np.array_equal(result.points, one.points)
    assert np.ptp(result.points.astype(np.float64) @ normal) <= 2 * np.ptp(heights)


@pytest.mark.parametrize("power", [-100, -30, 30, 100])
@pytest.mark.parametrize("make", [lambda: shaken(tet_grid(4)), lambda: shaken(tri_grid(6))])
def test_the_scale_does_not_matter(make, power):
    """Every tolerance is relative: a power of two changes exponents only."""
    one = make()
    plain = optimized(one)
    one.points = np.ldexp(one.points, power)
    result = optimized(one)
    assert np.array_equal(np.ldexp(plain.points, power), result.points)
    kind = "tetra" if one.dimension() == 3 else "triangle"
    assert np.array_equal(cells_of(plain, kind), cells_of(result, kind))


def test_a_bent_sheet_and_a_closed_surface_are_refused():
    bent = in_space(tri_grid(4))
    bent.points[:, 2] = 1e-3 * bent.points[:, 0] ** 2
    for surface in (bent, octahedron()):
        with pytest.raises(UnsupportedMeshError):
            cast(surface)


def test_other_cells_are_refused():
    with pytest.raises(UnsupportedMeshError, match="quad"):
        cast(quad_grid(2))
    both = tri_grid(2)
    both.blocks.append(Block("quad", ints([0, 1, 4, 3])))
    with pytest.raises(UnsupportedMeshError, match="quad"):
        cast(both)
    with pytest.raises(BadMeshError):
        cast(mesh([[0, 0], [1, 0]], line=[[0, 1]]))


# Orientation of tetrahedra ----------------------------------------------------------------


def test_tets_of_the_other_orientation_are_turned():
    grid = tet_grid(2)
    assert not cast(grid).turned
    before = cast(turned(grid))
    assert before.turned
    assert np.all(volumes(before.points, before.cells) > 0)
    result = optimized(turned(grid))
    assert np.all(volumes(result.points, cells_of(result, "tetra")) > 0)


# Precision --------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("preset", ["standard", "best"])
def test_coordinates_of_tets_are_written_as_they_were_worked_out(dtype, preset):
    one = shaken(tet_grid(4))
    one.points = one.points.astype(dtype)
    _, worked, result = worked_on(one, preset=preset)
    assert result.points.dtype == dtype
    assert np.array_equal(result.points.astype(np.float64), worked.points)
    assert np.any(~np.isin(result.points, one.points))


@every_axis_plane
@pytest.mark.parametrize("clockwise", [False, True])
def test_single_precision_in_a_plane_is_written_as_it_was_worked_out(axes, clockwise):
    flat = shaken(tri_grid(6))
    one = single(in_plane(turned(flat) if clockwise else flat, axes, 0.1))
    before, worked, result = worked_on(one)
    assert before.single
    assert result.points.dtype == np.float32
    assert np.array_equal(before.frame.flatten(result.points.astype(np.float64)), worked.points)
    assert np.any(result.points != one.points)


@pytest.mark.parametrize("seed", range(4))
def test_single_precision_in_a_tilted_plane(seed):
    one = single(in_tilted_plane(shaken(tri_grid(6), seed), seed))
    result = optimized(one)
    assert result.points.dtype == np.float32
    after = cast(result)
    assert np.all(areas(after.points, after.cells) > 0)


# Regions ----------------------------------------------------------------------------------


def tagged_cells(**data):
    n = len(next(iter(data.values())))
    return [Block("tetra", np.zeros((n, 4), np.int64), {k: np.asarray(v) for k, v in data.items()})]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(0, 2)), min_size=1, max_size=40))
def test_a_region_is_a_combination_of_tags(rows):
    one, other = zip(*rows, strict=True)
    blocks = tagged_cells(**{"medit:ref": one, "material": other, "stress": np.ones(len(rows))})
    region = regions_of(blocks)
    assert set(region) == set(range(len(set(rows))))
    assert len(set(zip(rows, region.tolist(), strict=True))) == len(set(rows))


@pytest.mark.parametrize("dtype", [np.uint8, np.int32, np.uint64])
def test_integers_of_any_width_are_tags(dtype):
    region = regions_of(tagged_cells(part=np.array([7, 7, 200], dtype)))
    assert region[0] == region[1] != region[2]


@pytest.mark.parametrize(
    "values",
    [
        np.arange(MAX_LABELS + 1),
        np.linspace(0, 1, 200),
        np.arange(200, dtype=np.float64) % 2,
        np.arange(400).reshape(200, 2) % 2,
    ],
    ids=["too many values", "reals", "whole reals", "two columns"],
)
def test_an_array_that_is_no_tag_makes_no_regions(values):
    blocks = tagged_cells(array=values)
    assert not np.any(regions_of(blocks))


def test_as_many_values_as_labels_are_allowed_make_regions():
    assert len(set(regions_of(tagged_cells(array=np.arange(MAX_LABELS))))) == MAX_LABELS


@pytest.mark.parametrize("name", TAG_NAMES)
def test_tags_by_name_may_have_any_number_of_values(name):
    values = np.arange(10 * MAX_LABELS)
    assert np.array_equal(regions_of(tagged_cells(**{name: values})), values)


def test_an_array_of_some_blocks_only_makes_no_regions():
    blocks = tagged_cells(part=[1, 2], own=[1, 1]) + tagged_cells(own=[1, 1])
    assert not np.any(regions_of(blocks))


def test_blocks_of_the_same_tags_are_one_region():
    blocks = tagged_cells(part=[1, 1]) + tagged_cells(part=[2]) + tagged_cells(part=[1])
    assert regions_of(blocks).tolist() == [0, 0, 1, 0]


def layered(cut=0.5):
    """A shaken grid of tets in two layers, the tag in an array; the layers share a plane."""
    grid = tet_grid(4)
    cells = grid.blocks[0].cells
    upper = grid.points[cells].mean(axis=1)[:, 2] > cut
    free = np.all((grid.points > 1e-9) & (grid.points < 1 - 1e-9), axis=1)
    free &= np.abs(grid.points[:, 2] - cut) > 1e-9
    grid.points[free] += np.random.default_rng(3).uniform(-0.05, 0.05, (free.sum(), 3))
    grid.blocks[0].data["layer"] = np.where(upper, 9, -4).astype(np.int32)
    return grid


@pytest.mark.parametrize("preset", ["standard", "best"])
def test_cells_keep_the_tag_of_their_place(preset):
    one = layered()
    result = optimized(one, preset=preset)
    (block,) = result.blocks
    assert block.data["layer"].dtype == np.int32
    assert not np.array_equal(result.points, one.points)
    height = result.points[block.cells].mean(axis=1)[:, 2]
    assert np.array_equal(block.data["layer"] == 9, height > 0.5)


# What the file declares -------------------------------------------------------------------


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


# All the rest -----------------------------------------------------------------------------


def test_unused_points_stay():
    one = shaken(tet_grid(4))
    extra = np.array([[9.0, 9, 9], [0.51, 0.52, 0.53], [-1, 0, 0]])
    one.points = np.concatenate([extra[:2], one.points, extra[2:]])
    one.blocks[0].cells += 2
    result = optimized(one)
    assert np.array_equal(result.points[:2], extra[:2])
    used = np.zeros(len(result.points), bool)
    used[cells_of(result, "tetra")] = True
    assert np.array_equal(result.points[~used], extra)
    assert np.all(volumes(result.points, cells_of(result, "tetra")) > 0)


def patchwork():
    """A mesh with cells of every dimension in a deliberate order, and all kinds of arrays."""
    one = layered()
    (block,) = one.blocks
    layer = block.data["layer"]
    rim = np.sort(facets(block.cells), axis=1)
    rim, times = np.unique(rim, axis=0, return_counts=True)
    rim = rim[times == 1]
    parts = [block.cells[layer == 9], block.cells[layer == -4]]

    def part(kind, cells, ref):
        return Block(kind, np.asarray(cells), {"medit:ref": np.full(len(cells), ref)})

    blocks = [
        part("vertex", [[0], [124]], 1),
        part("tetra", parts[0][::2], 9),
        part("triangle", rim[::2], 5),
        part("tetra", parts[1], -4),
        part("line", rim[:7, :2], 8),
        part("tetra", parts[0][1::2], 9),
        part("triangle", rim[1::2], 6),
    ]
    names = {"upper": (9, 3), "lower": (-4, 3), "skin": (5, 2)}
    data = {"medit:ref": np.arange(len(one.points)), "T": np.linspace(0, 1, len(one.points))}
    return Mesh(one.points, blocks, data, names)


def test_blocks_keep_their_order_and_their_cells():
    one = patchwork()
    result = optimized(one)
    kinds = [b.type for b in result.blocks]
    # A region in two blocks may come back in one.
    assert [k for k in kinds if k != "tetra"] == [b.type for b in one.blocks if b.type != "tetra"]
    assert kinds[:5] == [b.type for b in one.blocks[:5]]
    for kind in ("vertex", "line", "triangle"):
        old = [b for b in one.blocks if b.type == kind]
        new = [b for b in result.blocks if b.type == kind]
        for a, b in zip(old, new, strict=True):
            assert places(one, a.cells) == places(result, b.cells)
            assert np.array_equal(a.data["medit:ref"], b.data["medit:ref"])
    tets = [b for b in result.blocks if b.type == "tetra"]
    assert [len(set(b.data["medit:ref"])) for b in tets] == [1] * len(tets)
    assert {int(b.data["medit:ref"][0]) for b in tets} == {9, -4}


def test_names_and_whole_numbers_of_points_are_kept():
    one = patchwork()
    result = optimized(one)
    assert result.names == one.names
    assert set(result.point_data) == {"medit:ref", "T"}
    number = {tuple(point): k for k, point in enumerate(one.points)}
    known = [k for k, point in enumerate(result.points) if tuple(point) in number]
    assert len(known) >= 5**3 - 3**3
    for k in known:
        assert result.point_data["medit:ref"][k] == number[tuple(result.points[k])]


def test_the_input_is_left_as_it_is():
    one = patchwork()
    points, cells = one.points.copy(), [b.cells.copy() for b in one.blocks]
    optimized(one)
    assert np.array_equal(one.points, points)
    assert all(np.array_equal(b.cells, c) for b, c in zip(one.blocks, cells, strict=True))


def test_empty_blocks_do_no_harm():
    one = shaken(tet_grid(3))
    for kind, width in (("tetra", 4), ("quad", 4), ("triangle", 3), ("vertex", 1)):
        one.blocks.append(Block(kind, np.empty((0, width), np.int64)))
    result = optimized(one)
    assert len(cells_of(result, "tetra"))
    assert all(not len(b.cells) for b in result.blocks if b.type != "tetra")
