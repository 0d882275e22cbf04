"""A mesh as it is looked at."""

import numpy as np
import pytest

from meshopt_cli.mesh.sizes import area_vectors
from meshopt_cli.pictures.cut import Cut
from meshopt_cli.pictures.drawing import BESIDE, ISOMETRIC, MARK, close_up, paint_of, views, whole
from meshopt_cli.pictures.scene import PLANE, SPACE, SURFACE
from meshopt_cli.quality.measures import DEFAULT_MEASURE, MEASURES
from support.corners import tri_quad_grid, wedge_grid
from support.edits import shaken, transformed
from support.meshes import hex_grid, in_space, mesh, octahedron, quad_grid, tet_grid, tri_grid
from support.pictures import scene

MEASURE = MEASURES[DEFAULT_MEASURE]


@pytest.mark.parametrize(
    ("one", "kind"),
    [
        (tri_grid(2), PLANE),
        (in_space(tri_quad_grid(2), 3.0), PLANE),
        (octahedron(), SURFACE),
        (tet_grid(1), SPACE),
        (wedge_grid(1), SPACE),
    ],
)
def test_kinds(one, kind):
    seen = scene(one)
    assert seen.kind == kind
    for family, cells in seen.cells.items():
        assert len(seen.values[family]) == len(seen.signs[family]) == len(cells)
        assert (seen.signs[family] == 1.0).all()
        assert np.isfinite(seen.values[family]).all()


@pytest.mark.parametrize("one", [tri_grid(3), quad_grid(3)], ids=["triangles", "quads"])
def test_a_plane_is_seen_upright(one):
    """Also where all cells run clockwise: x goes to the right and y upwards."""
    for cells in (one.blocks[0].cells, one.blocks[0].cells[:, ::-1].copy()):
        given = in_space(mesh(one.points, **{one.blocks[0].type: cells}), 2.0)
        seen = scene(given)
        assert seen.axes[:2] == ("x", "y")
        assert seen.points[:, :2] == pytest.approx(one.points)
    upright = transformed(in_space(tri_grid(2)), lambda points: points[:, [0, 2, 1]])
    assert set(scene(upright).axes[:2]) == {"x", "z"}
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    inclined = scene(transformed(in_space(tri_grid(2)), lambda points: points @ turn))
    assert inclined.axes[:2] == ("u", "v")


def test_negative_and_flat_cells_are_told():
    one = tri_grid(2)
    one.blocks[0].cells[3] = one.blocks[0].cells[3, ::-1]
    one.blocks[0].cells[5, 2] = one.blocks[0].cells[5, 1]
    signs = scene(one).signs["triangle"]
    assert np.flatnonzero(signs < 0.0).tolist() == [3]
    assert np.flatnonzero(signs == 0.0).tolist() == [5]
    assert np.isinf(scene(one).values["triangle"][[3, 5]]).all()


def test_a_hexahedron_with_a_negative_corner_is_negative():
    one = hex_grid(2)
    centre = np.flatnonzero((one.points == 0.5).all(axis=1))
    one.points[centre] = [0.95, 0.95, 0.95]
    signs = scene(one).signs["hexahedron"]
    beyond = (one.points[one.blocks[0].cells].mean(axis=1) > 0.6).all(axis=1)
    assert (signs[beyond] < 0.0).all()


@pytest.mark.parametrize("axis", [None, 0, 1, 2])
def test_all_that_is_drawn_is_in_the_picture(axis):
    seen = scene(shaken(tet_grid(3)))
    cut = None if axis is None else Cut(axis, 0.5)
    drawing = whole(seen, paint_of(seen, MEASURE, False), cut, 0.8)
    view = ISOMETRIC if axis is None else BESIDE[axis]
    assert np.cross(drawing.direction, view[0]) == pytest.approx(np.zeros(3), abs=1e-12)
    right = np.cross(drawing.up, drawing.direction)
    for layer in drawing.layers:
        for corners in layer.corners:
            places = layer.points[corners] - drawing.centre
            assert (np.abs(places @ right) <= drawing.half[0] + 1e-12).all()
            assert (np.abs(places @ drawing.up) <= drawing.half[1] + 1e-12).all()


@pytest.mark.parametrize(
    "one", [shaken(tri_grid(4)), tri_quad_grid(3), octahedron(), shaken(tet_grid(2)), hex_grid(2)]
)
@pytest.mark.parametrize("negative", [False, True])
def test_a_close_up_shows_all_of_its_cell(one, negative):
    seen = scene(one)
    family = next(iter(seen.cells))
    drawing = close_up(seen, paint_of(seen, MEASURE, negative), family, 1, "a cell")
    corners = seen.points[seen.cells[family][1]] - drawing.centre
    right = np.cross(drawing.up, drawing.direction)
    assert np.linalg.norm(drawing.direction) == pytest.approx(1.0)
    assert (np.abs(corners @ right) < drawing.half[0] * np.sqrt(3)).all()
    assert (np.abs(corners @ drawing.up) < drawing.half[1] * np.sqrt(3)).all()
    assert drawing.title == "a cell"
    assert drawing.is_flat == (seen.kind == PLANE)
    assert drawing.layers[-1].colours is None


def test_a_close_up_of_a_cell_in_one_place():
    one = tri_grid(2)
    one.points[one.blocks[0].cells[0]] = 0.25
    seen = scene(one)
    drawing = close_up(seen, paint_of(seen, MEASURE, False), "triangle", 0)
    assert (drawing.half > 0.0).all()


def test_bad_facets_of_a_surface_are_marked():
    one = octahedron()
    good = scene(one)
    assert all(layer.line != MARK for layer in drawn(good).layers)
    one.points[4] = [0.5, 0.5, 0.001]
    seen = scene(one)
    bad = int(np.count_nonzero(seen.values["triangle"] > 10.0))
    (marks,) = [layer for layer in drawn(seen).layers if layer.line == MARK]
    assert marks.count == bad > 0
    assert marks.colours is None


def drawn(seen):
    return whole(seen, paint_of(seen, MEASURE, False), None, 1.0)


def test_a_surface_is_seen_from_both_sides_unless_it_is_cut():
    seen = scene(octahedron())
    paint = paint_of(seen, MEASURE, False)
    one, other = views(seen, paint, None, 1.0)
    assert one.direction[:2] == pytest.approx(-other.direction[:2])
    assert one.title != other.title
    assert len(views(seen, paint, Cut(0, 0.5), 1.0)) == 1
    for family, row in (("triangle", 0), ("triangle", 5)):
        normal = area_vectors(seen.points, seen.cells[family][row : row + 1])[0]
        assert close_up(seen, paint, family, row).direction @ normal > 0.0


def test_negative_solids_are_drawn_wherever_they_are():
    one = tet_grid(4)
    inside = int(np.argmin(np.abs(one.points[one.blocks[0].cells].mean(axis=1) - 0.5).sum(axis=1)))
    one.blocks[0].cells[inside] = one.blocks[0].cells[inside, [1, 0, 2, 3]]
    seen = scene(one)
    drawing = whole(seen, paint_of(seen, MEASURE, True), None, 1.0)
    outline, bad = drawing.layers
    assert outline.colours is None
    assert bad.count == 4
    beside = scene(tet_grid(2))
    assert len(whole(beside, paint_of(beside, MEASURE, True), None, 1.0).layers) == 1
