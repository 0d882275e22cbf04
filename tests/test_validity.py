"""Every rule of `check` on the smallest meshes that break it, and on none that do not."""

import subprocess
import sys

import numpy as np
import pytest
from builders import hex_grid, in_space, joined, mesh, octahedron, quad_grid, tet_grid, tri_grid
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh import Block, Mesh
from meshopt_cli.validity import ERROR, RULES, WARNING, Gates, check, choose

CORNER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
CUBE = [[*p, z] for z in (0, 1) for p in SQUARE]
PRISM = [[*p, z] for z in (0, 1) for p in [SQUARE[0], SQUARE[1], SQUARE[3]]]
PYRAMID = [[*p, 0] for p in SQUARE] + [[0.5, 0.5, 1]]
INCLINED = np.array([[1, 2, 3], [0.5, -1, 2]])
MIDDLES = [(CORNER[a] + CORNER[b]) / 2 for a, b in [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]]


def moved(base, point, to):
    points = base.points.copy()
    points[point] = to
    return Mesh(points, base.blocks)


def transformed(base, change):
    return Mesh(change(base.points), base.blocks)


def shifted(base, *by):
    return transformed(base, lambda points: points + np.array(by))


def together(one, other):
    """Two meshes as they are in one."""
    (block,) = other.blocks
    moved_on = Block(block.type, block.cells + len(one.points))
    return Mesh(np.concatenate([one.points, other.points]), [*one.blocks, moved_on])


def with_cells(base, cells):
    return Mesh(base.points, [Block(base.blocks[0].type, np.array(cells))])


def turned(base, row):
    """One cell turned over."""
    cells = base.blocks[0].cells.copy()
    cells[row] = cells[row][[1, 0, 2, 3]] if base.blocks[0].type == "tetra" else cells[row][::-1]
    return with_cells(base, cells)


def torn(base, n):
    """The first n cells torn off: they get points of their own."""
    cells = base.blocks[0].cells.copy()
    old = np.intersect1d(cells[:n], cells[n:])
    part = cells[:n]
    shared = np.isin(part, old)
    part[shared] = len(base.points) + np.searchsorted(old, part[shared])
    points = np.concatenate([base.points, base.points[old]])
    return Mesh(points, [Block(base.blocks[0].type, cells)])


VALID = {
    "tets": tet_grid(2),
    "hexahedra": hex_grid(2),
    "quads": quad_grid(3),
    "triangles": tri_grid(3),
    "one tet": mesh(CORNER, tetra=[[0, 1, 2, 3]]),
    "one hexahedron": mesh(CUBE, hexahedron=[range(8)]),
    "one wedge": mesh(PRISM, wedge=[range(6)]),
    "one pyramid": mesh(PYRAMID, pyramid=[range(5)]),
    "pyramid on a hexahedron": mesh(
        [*CUBE, [0.5, 0.5, 2]], hexahedron=[range(8)], pyramid=[[4, 5, 6, 7, 8]]
    ),
    "closed surface": octahedron(),
    "open surface": in_space(tri_grid(3), np.arange(16) ** 2 / 99),
    "surface of quads": in_space(quad_grid(3), np.arange(16) ** 2 / 99),
    "plane at a height": in_space(tri_grid(3), 5.0),
    "inclined plane": transformed(tri_grid(3), lambda p: p @ INCLINED),
    "inclined plane of quads": transformed(quad_grid(3), lambda p: p @ -INCLINED),
    "clockwise triangles": with_cells(tri_grid(2), tri_grid(2).blocks[0].cells[:, ::-1]),
    "parts a little apart": joined(tet_grid(1), shifted(tet_grid(1), 1.001, 0, 0)),
    "cells of lower dimension are free": mesh(
        CORNER,
        vertex=[[0]],
        line=[[0, 1], [1, 0], [2, 2]],
        triangle=[[0, 1, 2], [2, 1, 0], [0, 1, 2]],
        tetra=[[0, 1, 2, 3]],
    ),
    "second order": mesh([*CORNER, *MIDDLES], tetra10=[range(10)]),
    "no cells": Mesh(np.empty((0, 3)), []),
    "no rows": mesh(np.empty((0, 3)), tetra=np.empty((0, 4))),
    "lines": mesh(SQUARE, line=[[0, 1], [1, 2], [2, 3]]),
    "unknown type": mesh(SQUARE, polygon4=[[0, 1, 2, 3]]),
}

# Sound only where the coordinates are exact enough.
FINE = {
    "thin tets": transformed(tet_grid(2), lambda p: p * [1, 1e-6, 1e-6]),
    "thin triangles": transformed(tri_grid(2), lambda p: p * [1, 1e-7]),
    "short edges in a wide domain": together(
        tet_grid(1), transformed(tet_grid(1), lambda p: p * 1e-13 + [0.0, 0.0, -0.001])
    ),
}


def quad(corner):
    return mesh([[0, 0], [1, 0], corner, [0, 1]], quad=[[0, 1, 2, 3]])


# What is broken, and the codes for it: no more and no fewer.
BROKEN = {
    "not a number": (moved(tet_grid(2), 13, [np.nan, 0, 0]), "M001"),
    "infinite": (moved(tet_grid(2), 13, [0, -np.inf, 0]), "M001"),
    "unused and not a number": (
        mesh([*CORNER, [0, 0, np.nan]], tetra=[[0, 1, 2, 3]]),
        "M001 M203",
    ),
    "vertex beyond the last": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 4]]), "M002"),
    "vertex before the first": (mesh(CORNER, tetra=[[0, 1, 2, 3], [-1, 1, 2, 3]]), "M002"),
    "vertex far out": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 2**62]]), "M002"),
    "line beyond the last": (mesh(CORNER, line=[[0, 4]], tetra=[[0, 1, 2, 3]]), "M002"),
    "unknown type beyond the last": (mesh(SQUARE, polygon4=[[0, 1, 2, 3], [0, 1, 2, 4]]), "M002"),
    "repeated in a tet": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 0]]), "M003"),
    "repeated in a quad": (mesh(SQUARE, quad=[[0, 1, 2, 3], [0, 1, 1, 2]]), "M003"),
    "repeated in a hexahedron": (
        mesh(CUBE, hexahedron=[range(8), [0, 1, 2, 3, 4, 5, 6, 6]]),
        "M003",
    ),
    "inverted tet": (turned(tet_grid(2), 5), "M101"),
    "inverted triangle": (turned(tri_grid(2), 5), "M101"),
    "inverted triangle in an inclined plane": (turned(VALID["inclined plane"], 5), "M101"),
    "inverted triangle among clockwise ones": (turned(VALID["clockwise triangles"], 5), "M101"),
    "tets with a vertex beyond them": (moved(tet_grid(2), 13, [1.2, 0.5, 0.5]), "M101"),
    "hexahedron inverted at a corner": (moved(VALID["one hexahedron"], 6, [0.2] * 3), "M101"),
    "wedge inverted at a corner": (moved(VALID["one wedge"], 5, [0.1, 0.1, -0.1]), "M101"),
    "pyramid inverted at a corner": (moved(VALID["one pyramid"], 2, [0.2, 0.2, 0]), "M101"),
    "negative quad": (mesh(SQUARE, quad=[[3, 2, 1, 0]]), "M101"),
    "negative quad among others": (turned(quad_grid(2), 1), "M101"),
    "negative quad in an inclined plane": (turned(VALID["inclined plane of quads"], 1), "M101"),
    "flat tet": (mesh([[*p, 0] for p in SQUARE], tetra=[range(4)]), "M102"),
    "tet on a line": (mesh([[k, k, k] for k in range(4)], tetra=[range(4)]), "M102"),
    "nearly flat tet": (moved(VALID["one tet"], 3, [0.3, 0.3, 1e-13]), "M102"),
    "hexahedron flat at a corner": (moved(VALID["one hexahedron"], 6, [2 / 3] * 3), "M102"),
    "flat triangle in the plane": (mesh([[0, 0], [1, 0], [3, 0]], triangle=[range(3)]), "M102"),
    "flat triangle on a surface": (
        mesh([*CORNER, [0.5, 0.5, 0]], triangle=[[0, 1, 3], [0, 3, 2], [1, 4, 2], [1, 2, 3]]),
        "M102",
    ),
    "flat quad": (mesh([[0, 0], [1, 0], [2, 0], [3, 0]], quad=[range(4)]), "M102"),
    "all tets inverted": (
        with_cells(tet_grid(2), tet_grid(2).blocks[0].cells[:, [1, 0, 2, 3]]),
        "M103",
    ),
    "all hexahedra inverted": (
        with_cells(hex_grid(2), np.roll(hex_grid(2).blocks[0].cells, 4, axis=1)),
        "M103",
    ),
    "quad not convex": (quad([0.2, 0.2]), "M104"),
    "quad that intersects itself": (mesh(SQUARE, quad=[[0, 2, 1, 3]]), "M104"),
    "degenerate quad": (quad([0.5, 0.5]), "M104"),
    "negative quad not convex": (with_cells(quad([0.2, 0.2]), [[3, 2, 1, 0]]), "M101 M104"),
    "tet twice": (mesh(CORNER, tetra=[[0, 1, 2, 3], [1, 2, 0, 3]]), "M201"),
    "hexahedron twice, turned": (
        mesh(CUBE, hexahedron=[range(8), [1, 2, 3, 0, 5, 6, 7, 4]]),
        "M201",
    ),
    "triangle twice": (mesh(SQUARE, triangle=[[0, 1, 2], [2, 3, 0], [1, 2, 0]]), "M201 M204"),
    "parts with a point in one place": (
        mesh([*CORNER, *-CORNER], tetra=[[0, 1, 2, 3], [4, 6, 5, 7]]),
        "M202",
    ),
    "points nearly in one place": (
        mesh([*CORNER, *(-CORNER - 1e-13)], tetra=[[0, 1, 2, 3], [4, 6, 5, 7]]),
        "M202",
    ),
    "stray copy": (mesh([*CORNER, CORNER[0]], tetra=[[0, 1, 2, 3]]), "M202 M203"),
    "unused points": (mesh([*CORNER, [5, 5, 5], [5, 5, 5]], tetra=[[0, 1, 2, 3]]), "M203"),
    "unused point far away": (mesh([*CORNER, [1e300, 0, 0]], tetra=[[0, 1, 2, 3]]), "M203"),
    "used by a vertex only": (
        mesh([*CORNER, [5, 5, 5]], vertex=[[4]], tetra=[[0, 1, 2, 3]]),
        "M203",
    ),
    "three pages of a book": (
        mesh(
            [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]],
            triangle=[[0, 1, 2], [1, 0, 3], [1, 0, 4]],
        ),
        "M204",
    ),
    "three tets on a face": (
        mesh([*CORNER, [1, 1, 1], [2, 3, 7]], tetra=[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 3, 5]]),
        "M204 M209",
    ),
    "three hexahedra on a face": (
        mesh(
            [*CUBE, *[[x, y, 2] for x, y in SQUARE], *[[x + 0.1, y + 0.3, 3] for x, y in SQUARE]],
            hexahedron=[range(8), range(4, 12), [4, 5, 6, 7, 12, 13, 14, 15]],
        ),
        "M204",
    ),
    "hanging node": (
        mesh([*SQUARE, [0.5, 0.5]], triangle=[[0, 1, 2], [0, 4, 3], [4, 2, 3]]),
        "M205",
    ),
    "hanging node off the middle, in an inclined plane": (
        mesh(
            np.array([*SQUARE, [0.3, 0.3]]) @ INCLINED, triangle=[[0, 1, 2], [0, 4, 3], [4, 2, 3]]
        ),
        "M205",
    ),
    "hanging node on a face": (
        mesh(
            [*CORNER, [1 / 3] * 3, [1, 1, 1]],
            tetra=[[0, 1, 2, 3], [1, 2, 4, 5], [2, 3, 4, 5], [3, 1, 4, 5]],
        ),
        "M205",
    ),
    "hanging nodes of hexahedra": (
        joined(hex_grid(1), shifted(hex_grid(2), 1, 0, 0)),
        "M205",
    ),
    "crack between triangles": (torn(tri_grid(2), 1), "M202 M205"),
    "crack between tets": (torn(tet_grid(2), 5), "M202 M205"),
    "crack between hexahedra": (torn(hex_grid(2), 1), "M202 M205"),
    "surface with a triangle turned": (turned(octahedron(), 3), "M207"),
    "surface with a quad turned": (turned(VALID["surface of quads"], 4), "M207"),
    "tets on one side of a face": (
        mesh([*CORNER, [-1, -1, 2]], tetra=[[0, 1, 2, 3], [0, 1, 2, 4]]),
        "M207 M209",
    ),
    "edges that cross": (
        mesh(
            [[0, 0], [3, 0], [1.5, 3], [0, 2], [1.5, -1], [3, 2]], triangle=[[0, 1, 2], [3, 4, 5]]
        ),
        "M209",
    ),
    "cell inside another": (
        mesh([[0, 0], [9, 0], [0, 9], [1, 1], [2, 1], [1, 2]], triangle=[[0, 1, 2], [3, 4, 5]]),
        "M209",
    ),
    "folded triangles": (
        mesh([[0, 0], [1, 0], [0, 1], [1, 1]], triangle=[[0, 1, 2], [0, 1, 3]]),
        "M207 M209",
    ),
}

ALL = {name: (sound, "") for name, sound in VALID.items()} | BROKEN
ROTATION = np.linalg.qr(np.array([[3.0, 1, 2], [1, 5, -1], [2, 2, 7]]))[0]
ROTATION *= np.sign(np.linalg.det(ROTATION))


def codes(of, **options):
    return " ".join(check(of, **options).codes)


@pytest.mark.parametrize("name", [*ALL, *FINE])
def test_codes(name):
    of, expected = ALL.get(name) or (FINE[name], "")
    report = check(of)
    assert " ".join(report.codes) == expected
    severities = {RULES[code].severity for code in expected.split()}
    assert report.is_valid == (ERROR not in severities)
    assert bool(report.errors) == (ERROR in severities)
    assert bool(report.warnings) == (WARNING in severities)


@pytest.mark.parametrize("code", [code for code in RULES if not code.startswith("M4")])
def test_every_rule_is_broken_alone(code):
    assert code in [expected for _, expected in BROKEN.values()]


def test_a_gate_finds_the_cells_beyond_it():
    of = tet_grid(2)
    assert check(of, gates=Gates(fail_above=10.0)).codes == ()
    worst = check(of, gates=Gates(fail_above=1.1))
    assert worst.codes == ("M401",)
    assert len(worst.groups[0]) == len(of.blocks[0].cells)


@pytest.mark.parametrize("scale", [1e-150, 1e-9, 1e9, 1e150])
@pytest.mark.parametrize("offset", [0, 1e4])
@pytest.mark.parametrize("name", ALL)
def test_scale_and_position_do_not_matter(name, scale, offset):
    of, expected = ALL[name]
    if name == "unused point far away":
        scale = min(scale, 1.0)
    shift = offset * np.array([1, -0.7, 0.3])[: of.points.shape[1]]
    assert codes(transformed(of, lambda points: scale * (points + shift))) == expected


@pytest.mark.parametrize("name", ALL)
def test_direction_does_not_matter_in_space(name):
    of, expected = ALL[name]
    if of.points.shape[1] == 3:
        assert codes(transformed(of, lambda points: points @ ROTATION.T)) == expected


@pytest.mark.parametrize("name", ALL)
def test_single_precision(name):
    of, expected = ALL[name]
    with np.errstate(over="ignore"):
        single = transformed(of, lambda points: (points + 0.3).astype(np.float32))
    if name != "unused point far away":
        assert codes(single) == expected


def test_flat_far_from_the_origin():
    flat = [[0, 0, 0], [1, 0.1, 0.3], [0.3, 1, 0.7], [0.37, 0.46, 0.43]]
    flat[3] = np.dot([0.2, 0.5, 0.3], flat[:3])
    assert codes(shifted(mesh(flat, tetra=[range(4)]), 1e9, 2e9, -1e9)) == "M102"


@pytest.mark.parametrize(
    ("row", "message"),
    [(0, "the quad is not convex"), (1, "the quad intersects itself"), (2, "degenerate")],
)
def test_kinds_of_quads(row, message):
    one = [quad([0.2, 0.2]), mesh(SQUARE, quad=[[0, 2, 1, 3]]), quad([0.5, 0.5])][row]
    (group,) = check(one).groups
    assert message in group.findings(one)[0].message


def test_findings_say_where():
    of = mesh([*CORNER, [5, 5, 5]], vertex=[[0]], tetra=[[0, 1, 2, 3], [1, 0, 2, 3]])
    of.blocks.append(Block("tetra", np.array([[3, 2, 1, 0]])))
    (double, unused) = (check(of, select=[code]).groups[0] for code in ("M201", "M203"))
    assert len(double) == 2
    first, second = double.findings(of)
    assert (first.block, first.cell, first.other_cells) == (1, 1, ((1, 0),))
    assert (second.block, second.cell, second.other_cells) == (2, 0, ((1, 0),))
    assert first.where == (0.25, 0.25, 0.25)
    assert double.findings(of, 1) == [first]
    (stray,) = unused.findings(of, 10)
    assert (stray.block, stray.cell, stray.point, stray.where) == (None, None, 4, (5.0, 5.0, 5.0))


def test_finding_of_a_missing_vertex():
    of = mesh(CORNER, tetra=[[0, 1, 2, 9], [7, 8, 9, -3]])
    one, other = check(of).groups[0].findings(of)
    assert one.where == pytest.approx((1 / 3, 1 / 3, 0))
    assert other.where is None


def test_findings_of_several_cells():
    of = BROKEN["three hexahedra on a face"][0]
    (found,) = check(of).groups[0].findings(of)
    assert (found.cell, found.other_cells) == (2, ((0, 1), (0, 0)))


def test_coincident_points_name_the_first():
    of = mesh([*CORNER, CORNER[1], CORNER[1]], tetra=[[0, 1, 2, 3]])
    group = check(of).groups[0]
    assert [(f.point, f.other_points) for f in group.findings(of)] == [(4, (1,)), (5, (1,))]


def test_very_many_points_in_one_place():
    of = Mesh(
        np.concatenate([CORNER, np.zeros((5000, 3))]), [Block("tetra", np.array([[0, 1, 2, 3]]))]
    )
    assert len(check(of, select=["M202"]).groups[0]) == 5000


def test_hanging_node_names_vertex_and_cell():
    of = BROKEN["hanging node"][0]
    (found,) = check(of).groups[0].findings(of)
    assert (found.point, found.cell) == (4, 0)
    assert found.where == (0.5, 0.5, 0.0)[: of.points.shape[1]]


def test_the_odd_one_out_is_the_one_that_disagrees():
    of = turned(octahedron(), 3)
    (found,) = check(of).groups[0].findings(of)
    assert found.cell == 3


def test_the_whole_mesh_has_no_place():
    of = BROKEN["all tets inverted"][0]
    (found,) = check(of).groups[0].findings(of)
    assert (found.block, found.cell, found.point, found.where) == (None, None, None, None)


def test_select_and_ignore():
    of = BROKEN["stray copy"][0]
    assert codes(of, select=["M203"]) == "M203"
    assert codes(of, select=["m2"], ignore=["M202"]) == "M203"
    assert codes(of, select=["M1"]) == ""
    assert codes(of, ignore=["M"]) == ""
    asked = [code for code, rule in RULES.items() if rule.on_request]
    assert [rule.code for rule in choose()] == [code for code in RULES if code not in asked]
    assert [rule.code for rule in choose(asked)] == asked
    assert [rule.code for rule in choose(["M"])] == list(RULES)


@pytest.mark.parametrize(
    "options", [{"select": ["M999"]}, {"ignore": ["M101", "X"]}, {"select": [""]}]
)
def test_unknown_code(options):
    with pytest.raises(ConfigError, match="M101, M102"):
        check(VALID["one tet"], **options)


def test_the_table():
    assert list(RULES) == sorted(RULES)
    for code, rule in RULES.items():
        assert rule.code == code
        assert rule.severity in (ERROR, WARNING)
        assert rule.title[0].islower()
        for text in (rule.explanation, rule.fix):
            assert text.endswith(".")
            assert "\n" not in text


def test_needs_neither_compiler_nor_reader():
    program = "import sys, meshopt_cli.validity; print({'numba', 'meshio'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "set()"


# One change to a sound mesh, and the code that has to be among those found.
GRID = tet_grid(2)
ROWS = st.integers(0, len(GRID.blocks[0].cells) - 1)
PLACES = st.integers(0, 3)


@settings(max_examples=50, deadline=None)
@given(ROWS, st.permutations(range(4)))
def test_one_cell_listed_in_another_order(row, order):
    cells = GRID.blocks[0].cells.copy()
    cells[row] = cells[row][order]
    even = np.linalg.det(np.eye(4)[order]) > 0
    assert codes(with_cells(GRID, cells)) == ("" if even else "M101")


@settings(max_examples=30, deadline=None)
@given(st.lists(ROWS, min_size=1, max_size=4), st.permutations(range(4)))
def test_duplicates(rows, order):
    cells = GRID.blocks[0].cells
    of = with_cells(GRID, np.concatenate([cells, cells[rows][:, order]]))
    (found,) = check(of, select=["M201"]).groups
    assert [(f.cell, f.other_cells) for f in found.findings(of)] == [
        (len(cells) + k, ((0, row),)) for k, row in enumerate(rows)
    ]


@settings(max_examples=30, deadline=None)
@given(ROWS, PLACES, st.one_of(st.integers(-(2**63), -1), st.integers(27, 2**63 - 1)))
def test_vertices_out_of_range(row, place, vertex):
    cells = GRID.blocks[0].cells.copy()
    cells[row, place] = vertex
    assert codes(with_cells(GRID, cells)) == "M002"


@settings(max_examples=30, deadline=None)
@given(ROWS, PLACES, st.integers(1, 3))
def test_repeated_vertices(row, place, step):
    cells = GRID.blocks[0].cells.copy()
    cells[row, place] = cells[row, place - step]
    assert codes(with_cells(GRID, cells)) == "M003"


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 26), st.integers(0, 2), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_coordinates_not_finite(point, axis, value):
    points = GRID.points.copy()
    points[point, axis] = value
    assert codes(Mesh(points, GRID.blocks)) == "M001"


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 40))
def test_torn_meshes(n):
    assert codes(torn(GRID, n)) == "M202 M205"


TYPES = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
TYPES |= {"line": 2, "vertex": 1, "triangle6": 6, "polygon5": 5, "wedge15": 6}
FEW = st.integers(-1, 12)


@st.composite
def anything(draw):
    """A mesh of random content."""
    kind = draw(st.sampled_from([np.float32, np.float64]))
    width = 32 if kind is np.float32 else 64
    values = st.one_of(st.floats(width=width), st.sampled_from([0.0, 0.5, 1.0, 2.0]))
    points = draw(
        hnp.arrays(
            kind, st.tuples(FEW.filter(lambda n: n >= 0), st.sampled_from([2, 3])), elements=values
        )
    )
    blocks = [
        Block(
            name, draw(hnp.arrays(np.int64, (draw(st.integers(0, 6)), TYPES[name]), elements=FEW))
        )
        for name in draw(st.lists(st.sampled_from(list(TYPES)), max_size=4))
    ]
    return Mesh(points, blocks)


@settings(max_examples=300, deadline=None)
@given(anything())
def test_no_content_is_too_strange(of):
    report = check(of)
    for group in report.groups:
        assert len(group) > 0
        assert len(group.findings(of)) == len(group)
