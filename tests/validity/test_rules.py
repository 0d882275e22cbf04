"""Every rule of `check` on the smallest meshes that break it, and on none that do not."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import ERROR, RULES, WARNING, Gates, check, choose
from support.broken import BROKEN, CORNER, FINE, SQUARE, VALID
from support.edits import shifted, torn, transformed, turned, with_cells
from support.meshes import mesh, octahedron, quad_grid, tet_grid
from support.settings import examples

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


@pytest.mark.parametrize(
    "code", [code for code in RULES if not code.startswith("M4") and not RULES[code].on_request]
)
def test_every_rule_is_broken_in_the_table(code):
    assert code in " ".join(expected for _, expected in BROKEN.values())


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


# Figure 18.5.
CASES_OF_A_QUAD = {
    "degenerated": ([[0, 0], [1, 0], [0.5, 0.5], [0, 1]], "M104", "the quad is degenerate: two"),
    "non-convex": ([[0, 0], [1, 0], [0.2, 0.2], [0, 1]], "M104", "the quad is not convex"),
    "self-intersecting": ([[0, 0], [1, 0], [0, 1], [1, 1]], "M104", "the quad intersects itself"),
    "negative": ([[0, 0], [0, 1], [1, 1], [1, 0]], "M101", "the quad is negative"),
}


@pytest.mark.parametrize("case", CASES_OF_A_QUAD)
@pytest.mark.parametrize("first", range(4))
def test_cases_of_a_quad(case, first):
    corners, code, message = CASES_OF_A_QUAD[case]
    one = mesh(corners, quad=[np.roll(range(4), first)])
    (group,) = check(one).groups
    (finding,) = group.findings(one)
    assert (group.rule.code, message in finding.message) == (code, True)


def test_a_positive_quad_is_valid():
    assert check(mesh(SQUARE, quad=[range(4)])).is_valid


def test_a_negative_quad_is_told_to_be_turned():
    one = turned(quad_grid(2), 1)
    (group,) = check(one, select=["M101"]).groups
    message = group.findings(one)[0].message
    assert "the quad is negative" in message
    assert "turning it mends that" in message


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


@examples(50)
@given(ROWS, st.permutations(range(4)))
def test_one_cell_listed_in_another_order(row, order):
    cells = GRID.blocks[0].cells.copy()
    cells[row] = cells[row][order]
    even = np.linalg.det(np.eye(4)[order]) > 0
    assert codes(with_cells(GRID, cells)) == ("" if even else "M101")


@examples(30)
@given(st.lists(ROWS, min_size=1, max_size=4), st.permutations(range(4)))
def test_duplicates(rows, order):
    cells = GRID.blocks[0].cells
    of = with_cells(GRID, np.concatenate([cells, cells[rows][:, order]]))
    (found,) = check(of, select=["M201"]).groups
    assert [(f.cell, f.other_cells) for f in found.findings(of)] == [
        (len(cells) + k, ((0, row),)) for k, row in enumerate(rows)
    ]


@examples(30)
@given(ROWS, PLACES, st.one_of(st.integers(-(2**63), -1), st.integers(27, 2**63 - 1)))
def test_vertices_out_of_range(row, place, vertex):
    cells = GRID.blocks[0].cells.copy()
    cells[row, place] = vertex
    assert codes(with_cells(GRID, cells)) == "M002"


@examples(30)
@given(ROWS, PLACES, st.integers(1, 3))
def test_repeated_vertices(row, place, step):
    cells = GRID.blocks[0].cells.copy()
    cells[row, place] = cells[row, place - step]
    assert codes(with_cells(GRID, cells)) == "M003"


@examples(30)
@given(st.integers(0, 26), st.integers(0, 2), st.sampled_from([np.nan, np.inf, -np.inf]))
def test_coordinates_not_finite(point, axis, value):
    points = GRID.points.copy()
    points[point, axis] = value
    assert codes(Mesh(points, GRID.blocks)) == "M001"


@examples(30)
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


@examples(300)
@given(anything())
def test_no_content_is_too_strange(of):
    report = check(of)
    for group in report.groups:
        assert len(group) > 0
        assert len(group.findings(of)) == len(group)
