"""What of a mesh is drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.sizes import contents, flux
from meshopt_cli.pictures.cut import (
    Cut,
    around,
    cut_of,
    exposed_rows,
    kept_rows,
    middle,
    polygons_of,
)
from support.corners import pyramid_grid, tri_quad_grid, wedge_grid
from support.edits import shaken, transformed
from support.meshes import hex_grid, in_space, mesh, quad_grid, tet_grid, tri_grid
from support.pictures import scene

SOLIDS = {
    "tets": shaken(tet_grid(3)),
    "hexahedra": shaken(hex_grid(3), 0.1),
    "wedges": wedge_grid(3),
    "pyramids": pyramid_grid(3),
}
FLAT = {"triangles": tri_grid(4), "quads": quad_grid(4), "both": tri_quad_grid(4)}
solids = pytest.mark.parametrize("one", SOLIDS.values(), ids=list(SOLIDS))
any_cells = pytest.mark.parametrize("one", [*SOLIDS.values(), *FLAT.values()], ids=[*SOLIDS, *FLAT])


@pytest.mark.parametrize(
    ("text", "cut"),
    [
        ("x=0.5", Cut(0, 0.5)),
        (" y = -1.5e3 ", Cut(1, -1500.0)),
        ("z=50%", Cut(2, 50.0, True)),
        ("x=.25", Cut(0, 0.25)),
        ("none", None),
    ],
)
def test_cuts(text, cut):
    assert cut_of(text) == cut


@pytest.mark.parametrize("text", ["", "x", "x=", "=1", "w=1", "x=nan", "x=1e999", "x=1 y=2", "x=٣"])
def test_what_is_no_cut_is_said(text):
    with pytest.raises(ConfigError, match="--cut"):
        cut_of(text)


@any_cells
@pytest.mark.parametrize("axis", range(2))
def test_whole_cells_below_a_cut_are_kept(one, axis):
    seen = scene(one)
    kept = kept_rows(seen, Cut(axis, 40.0, True))
    place = seen.ranges()[:, axis] @ [0.6, 0.4]
    for family, rows in kept.items():
        is_below = seen.centres(family)[:, axis] <= place
        assert np.flatnonzero(is_below).tolist() == rows.tolist()
    assert 0 < sum(map(len, kept.values())) < len(seen.every_value())
    assert sum(map(len, kept_rows(seen, None).values())) == len(seen.every_value())


def test_cuts_of_planes_are_by_the_coordinates_of_the_file():
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for change in (lambda points: points[:, [0, 2, 1]], lambda points: points @ turn):
        one = transformed(in_space(tri_grid(4)), change)
        for axis in range(3):
            if np.ptp(one.points[:, axis]) > 0.1:
                (rows,) = kept_rows(scene(one), Cut(axis, 50.0, True)).values()
                centres = one.points[one.blocks[0].cells].mean(axis=1)[:, axis]
                limit = (one.points[:, axis].min() + one.points[:, axis].max()) / 2
                assert rows.tolist() == np.flatnonzero(centres <= limit).tolist()


def test_a_cut_that_leaves_nothing_is_said():
    with pytest.raises(ConfigError, match="x goes from 0 to 1"):
        kept_rows(scene(tet_grid(1)), Cut(0, -3.0))


def test_the_middle_is_across_the_shortest_way():
    for axis in range(3):
        sides = np.ones(3)
        sides[axis] = 0.5
        flat = transformed(tet_grid(2), lambda points, by=sides: points * by)
        assert middle(scene(flat)) == Cut(axis, 50.0, True)
    assert middle(scene(tet_grid(2))).axis == 0
    one = mesh([[1, 0, 0], [1, 1, 0], [1, 0, 1], [0, 0, 0]], tetra=[[0, 1, 2, 3]])
    turned = transformed(one, lambda points: points * [1.0, 9.0, 9.0])
    assert middle(scene(turned)) is None


@any_cells
@given(shrink=st.floats(0.05, 1.0))
def test_polygons_hold_what_their_cells_do(one, shrink):
    """By the flux through the facets of solids, or the areas of faces, cell by cell."""
    seen = scene(one)
    rows = kept_rows(seen, Cut(0, 60.0, True))
    found = polygons_of(seen, rows, shrink)
    total, n_cells = 0.0, sum(map(len, rows.values()))
    for corners, owners in zip(found.corners, found.owners, strict=True):
        assert owners.max() < n_cells
        if seen.dimension == 3:
            total += flux(found.points[corners]).sum()
        else:
            kind = {3: "triangle", 4: "quad"}[corners.shape[1]]
            total += contents(found.points[:, :2], corners, kind).sum()
    expected = sum(
        contents(seen.points[:, : seen.dimension], seen.cells[family][some], family).sum()
        for family, some in rows.items()
    )
    assert total == pytest.approx(shrink**seen.dimension * expected, rel=1e-9)


@any_cells
def test_shrunk_cells_have_vertices_of_their_own(one):
    seen = scene(one)
    rows = kept_rows(seen, None)
    found = polygons_of(seen, rows, 0.5)
    assert len(found.points) == sum(len(c) * c.shape[1] for c in seen.cells.values())
    n = sum(
        len(c) * (sum(map(len, FAMILIES[f].facets)) if seen.dimension == 3 else 1)
        for f, c in seen.cells.items()
    )
    assert found.count == n


@solids
def test_cells_that_others_surround_are_left_out(one):
    seen = scene(one)
    rows = kept_rows(seen, Cut(2, 70.0, True))
    exposed = exposed_rows(seen, rows)
    hull, of_these = polygons_of(seen, rows), polygons_of(seen, exposed)
    outer = {tuple(sorted(c)) for corners in hull.corners for c in corners.tolist()}
    theirs = {tuple(sorted(c)) for corners in of_these.corners for c in corners.tolist()}
    assert outer <= theirs
    for family, some in exposed.items():
        assert set(some.tolist()) <= set(rows[family].tolist())


def test_the_inside_of_a_grid_is_not_drawn():
    seen = scene(hex_grid(5))
    exposed = exposed_rows(seen, kept_rows(seen, None))
    assert len(exposed["hexahedron"]) == 5**3 - 3**3


@any_cells
def test_around_a_cell_are_those_that_have_one_of_its_vertices(one):
    seen = scene(one)
    family = next(iter(seen.cells))
    row = len(seen.cells[family]) // 2
    mine = set(seen.cells[family][row].tolist())
    found = around(seen, family, row)
    assert sum(map(len, found.values())) > 0
    for name, cells in seen.cells.items():
        near = {i for i, cell in enumerate(cells.tolist()) if mine & set(cell)}
        assert set(found[name].tolist()) == near - ({row} if name == family else set())
