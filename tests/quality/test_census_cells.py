"""Which cells a census finds obtuse or self-centered, and which cases of quads it tells apart."""

from collections import Counter
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given

from meshopt_cli.kernels.shape.classify import TetType
from meshopt_cli.mesh.quads import QuadCase
from meshopt_cli.mesh.sizes import dihedral_angles
from meshopt_cli.quality.census import census
from meshopt_cli.validity import check
from support import drivers
from support.broken import CORNER, SQUARE
from support.chapter18 import TET, TRIANGLE, corners_of_cell
from support.edits import shaken, transformed, with_cells
from support.meshes import hexagon, icosahedron, mesh, quad_grid, tet_grid, tri_grid
from support.planes import in_tilted_plane, rotation
from support.settings import examples

# Obtuse and self-centered simplices (18.4.3) -------------------------------------------------


def centred(points, cell):
    """Whether a simplex contains its circumcentre, by a system of equations."""
    corners = points[cell]
    edges = corners[1:] - corners[0]
    gram = edges @ edges.T
    weights = np.linalg.solve(2 * gram, np.diag(gram))
    return min(*weights, 1 - weights.sum())


def obtuse_and_centred(points, **cells):
    found = census(mesh(points, **cells))
    return found.obtuse, found.self_centered


def test_equilateral_simplices_are_self_centered():
    assert obtuse_and_centred(TRIANGLE, triangle=[range(3)]) == (0, 1)
    assert obtuse_and_centred(TET, tetra=[range(4)]) == (0, 1)
    assert obtuse_and_centred(TET, tetra=[[1, 0, 2, 3]]) == (0, 1)


@pytest.mark.parametrize("seed", range(5))
def test_right_angles_are_not_obtuse(seed):
    """The circumcentre lies on the longest edge, however rounding moves it."""
    square = in_tilted_plane(tri_grid(3), seed)
    cube = transformed(tet_grid(2), lambda p: p @ rotation(seed).T + 0.1)
    for of, n in ((square, 18), (cube, 48)):
        found = census(of)
        assert (found.n_simplices, found.obtuse, found.self_centered) == (n, 0, n)


def test_a_corner_of_a_cube_does_not_contain_its_circumcentre():
    """Its dihedral angles are not obtuse."""
    assert obtuse_and_centred(CORNER, tetra=[range(4)]) == (0, 0)


def test_simplices_without_content():
    line = [[0, 0, 0], [1, 0, 0], [3, 0, 0]]
    assert obtuse_and_centred(line, triangle=[range(3)]) == (1, 0)
    assert obtuse_and_centred([line[0], *line[:2]], triangle=[range(3)]) == (0, 0)
    assert obtuse_and_centred([[*p, 0] for p in SQUARE], tetra=[range(4)])[1] == 0


@given(corners_of_cell(2, 1e-3))
@examples(100)
def test_triangles_are_obtuse_or_self_centered(corners):
    found = obtuse_and_centred(corners, triangle=[range(3)])
    assert sum(found) == 1
    least = centred(corners, np.arange(3))
    if abs(least) > 1e-6:
        assert found[1] == (least > 0)


@given(corners_of_cell(3, 1e-2))
@examples(100)
def test_tets_against_a_slow_way(corners):
    cells = np.arange(4)[None]
    obtuse, inside = obtuse_and_centred(corners, tetra=cells)
    least = centred(corners, cells[0])
    if abs(least) > 1e-6:
        assert inside == (least > 0)
    if size_of_cell(corners) > 0:
        greatest = np.degrees(dihedral_angles(corners, cells, "tetra").max())
        if abs(greatest - 90) > 1e-5:
            assert obtuse == (greatest > 90)


def size_of_cell(corners):
    return np.linalg.det(corners[1:] - corners[0])


# The shapes of 18.6: what is obtuse in them, and whether they contain their circumcentre.
TYPES = {
    "regular": (TET, 0, 1),
    "spade": ([[0, 0, 0], [2, 0, 0], [1, 1.5, 0], [1, 0, 0.2]], 1, 0),
    "sliver": ([[1, 0, 0.05], [-1, 0, 0.05], [0, 1, -0.05], [0, -1, -0.05]], 1, 1),
    "cap": ([[0, 0, 0], [2, 0, 0], [1, 1.7, 0], [1, 0.6, 0.1]], 1, 0),
    "wedge": ([[0, 0, 0], [0.1, 0, 0], [0.05, 1, 0.6], [0.05, 1, -0.6]], 0, 1),
    "spindle": ([[-0.05, 0, 0], [0.05, 0, 0], [0, 1, 0.05], [0, 1, -0.05]], 0, 1),
    "spear": ([[0, 0, 0], [0.55, 0, 0], [1.1, 0.05, 0], [0.55, 0.1, 2]], 1, 0),
    "needle": ([*(0.1 * TRIANGLE), [0.05, 0.03, 1]], 0, 1),
}


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("order", list(permutations(range(4))))
def test_types_of_tets(name, order):
    corners, *expected = TYPES[name]
    kind = drivers.type_of(np.array(corners, dtype=float), np.array(order))
    assert TetType(kind).name.lower() == name
    assert list(obtuse_and_centred(corners, tetra=[order])) == expected


@pytest.mark.parametrize(
    "of", [shaken(tri_grid(5)), shaken(tet_grid(3)), icosahedron(), hexagon(2)]
)
def test_the_check_finds_as_many_obtuse_cells(of):
    groups = check(of, select=["M405"]).groups
    assert census(of).obtuse == sum(len(group) for group in groups)


# Figure 18.5 --------------------------------------------------------------------------------

QUADS = {
    "positive": SQUARE,
    "degenerated": [[0, 0], [1, 0], [0.5, 0.5], [0, 1]],
    "non-convex": [[0, 0], [1, 0], [0.2, 0.2], [0, 1]],
    "self-intersecting": [[0, 0], [1, 0], [0.1, 1], [0.9, 1.1]],
    "negative": SQUARE[::-1],
}
NO_QUADS = dict.fromkeys(QUADS, 0)


def test_names_of_the_cases():
    assert [case.name.lower().replace("_", "-") for case in QuadCase] == list(QUADS)


@pytest.mark.parametrize("case", QUADS)
@pytest.mark.parametrize("first", range(4))
def test_cases_of_a_quad(case, first):
    one = mesh(QUADS[case], quad=[np.roll(range(4), first)])
    assert census(one).quads == NO_QUADS | {case: 1}


@pytest.mark.parametrize("case", [case for case in QUADS if case != "negative"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("first", range(4))
def test_cases_of_a_quad_of_a_surface(case, backwards, first):
    """A quad in a tilted plane, and one beside it that is upright: from neither side negative."""
    flat = mesh([*QUADS[case], [5, 0], [5, 1]], quad=[np.roll(range(4), first)])
    of = in_tilted_plane(flat)
    of.points = np.concatenate([of.points, of.points[4:] + rotation(0)[:, 2]])
    cells = of.blocks[0].cells
    of.blocks[0].cells = np.concatenate([cells[:, ::-1] if backwards else cells, [[4, 5, 7, 6]]])
    assert census(of).quads == NO_QUADS | Counter([case, "positive"])


def test_a_symmetric_bow_tie_intersects_itself():
    tie = mesh([[0, 0], [1, 0], [0, 1], [1, 1]], quad=[range(4)])
    assert census(tie).quads["self-intersecting"] == 1
    assert census(in_tilted_plane(tie)).quads["self-intersecting"] == 1


def test_the_upper_side_of_a_plane():
    """Clockwise is negative in the plane of x and y; elsewhere most of the area tells."""
    of = quad_grid(2)
    turned_over = with_cells(of, of.blocks[0].cells[:, ::-1])
    assert census(turned_over).quads == NO_QUADS | {"negative": 4}
    assert census(in_tilted_plane(turned_over)).quads == NO_QUADS | {"positive": 4}


def test_a_negative_quad_need_not_be_convex():
    corners = QUADS["non-convex"][::-1]
    assert census(mesh(corners, quad=[range(4)])).quads == NO_QUADS | {"negative": 1}


def test_a_quad_without_area_is_degenerated():
    line = [[k, 0] for k in range(4)]
    assert census(mesh(line, quad=[range(4)])).quads == NO_QUADS | {"degenerated": 1}
