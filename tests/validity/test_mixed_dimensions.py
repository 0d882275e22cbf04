"""Beams and shells beside cells of a greater dimension, and facets that have lost their cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from meshopt_cli.validity.study import Study
from support.edits import cell_inside, declaring, shifted, together, without
from support.kinds import plate_with_beam, solid_with_fin
from support.meshes import double_pyramid, hex_grid, mesh, quad_grid, tet_grid, tri_grid
from support.settings import examples


def messages(of, code):
    return [f.message for g in check(of).groups if g.code == code for f in g.findings(of)]


def boundary(of):
    (block,) = of.blocks
    region = np.zeros(len(block.cells), np.int64)
    beyond = adjacency.neighbours(block.cells, region, len(of.points))
    return adjacency.boundary_facets(block.cells, beyond)


@pytest.mark.parametrize("length", [1, 2, 7])
def test_beams_are_counted(length):
    (said,) = messages(plate_with_beam(3, length), "M216")
    assert said.startswith("the line stands" if length == 1 else f"{length} lines stand")
    assert check(plate_with_beam(3, length)).is_valid


@pytest.mark.parametrize(("kind", "n"), [("triangle", 18), ("quad", 9)])
def test_shells_are_counted(kind, n):
    (said,) = messages(solid_with_fin(3, kind), "M216")
    assert said.startswith(f"{n} {kind}s stand")


def test_each_part_is_told_by_itself():
    of = plate_with_beam(3, 2)
    other = shifted(Mesh(of.points, of.blocks[1:]), 0, 9, 0)
    both = together(of, other)
    # The points of the plate that came along stand for nothing.
    assert messages(both, "M216")[0].startswith("2 lines")
    assert len(messages(both, "M216")) == 2


def test_lines_along_a_shell_belong_to_it():
    of = solid_with_fin(2)
    fin = of.blocks[1].cells
    rim = np.sort(adjacency.edges_of_triangles(fin), axis=1)
    edges, count = np.unique(rim, axis=0, return_counts=True)
    of.blocks.append(Block("line", edges[count == 1]))
    (said,) = messages(of, "M216")
    assert "8 triangles and " in said


@examples(40)
@given(st.sets(st.integers(0, 47), max_size=20), st.integers(0, 2))
def test_facets_of_the_boundary_stand_for_it(rows, times):
    of = tet_grid(2)
    facets = boundary(of)[sorted(rows)].reshape(-1, 3)
    listed = np.concatenate([facets, *[facets[:, [1, 0, 2]]] * times])
    assert check(declaring(of, triangle=listed)).codes == ()


@examples(40)
@given(st.integers(0, 10**6))
def test_a_facet_whose_cell_is_gone_is_an_error(seed):
    of = tet_grid(4)
    row = cell_inside(of) if seed % 2 else seed % len(of.blocks[0].cells)
    left = without(of, row)
    face = of.blocks[0].cells[row][np.delete(np.arange(4), seed % 4)]
    report = check(declaring(left, triangle=[face]), select=["M208", "M216"])
    everyone = np.sort(left.blocks[0].cells[:, adjacency.TET_FACETS].reshape(-1, 3), axis=1)
    is_there = (everyone == np.sort(face)).all(axis=1).any()
    all_used = np.isin(face, left.blocks[0].cells).all()
    assert report.codes == (() if is_there else ("M208",) if all_used else ("M216",))


@pytest.mark.parametrize(
    "of", [tri_grid(3), quad_grid(3), double_pyramid(1.0), hex_grid(2)],
    ids=["triangles", "quads", "tets", "hexahedra"],
)  # fmt: skip
def test_a_cell_with_a_vertex_of_its_own_leaves_lost_facets(of):
    (block,) = of.blocks
    listed = [Block({2: "line", 3: "triangle", 4: "quad"}[facets.rows.shape[1]],
                    facets.rows[facets.alone()]) for facets in Study(of).facet_sets]  # fmt: skip
    count = np.bincount(block.cells.ravel(), minlength=len(of.points))
    corners = np.flatnonzero((count[block.cells] == 1).any(axis=1))
    assert len(corners)
    for row in corners.tolist():
        left = Block(block.type, np.delete(block.cells, row, axis=0))
        torn = Mesh(of.points, [*listed, left])
        (lost,) = check(torn, select=["M208", "M216"]).groups
        assert lost.code == "M208"
        numbers = [f.cell for f in lost.findings(torn)]
        assert all(np.isin(listed[0].cells[k], block.cells[row]).all() for k in numbers)
        # Where all of the boundary is declared as it is now, the same are beams and shells.
        alone = [Block(b.type, b.cells[numbers]) for b in listed]
        whole = Study(Mesh(of.points, [left])).facet_sets
        skin = [Block(b.type, f.rows[f.alone()]) for b, f in zip(listed, whole, strict=True)]
        both = check(Mesh(of.points, [*skin, *alone, left]), select=["M208", "M216"])
        assert both.codes == ("M216",)


def test_a_membrane_with_all_its_vertices_in_the_cells_may_hang_on_a_shell():
    """The faces next to the solid have no vertex of their own, but an edge with those that do."""
    of = solid_with_fin(3)
    low = of.points[:, 2] <= 1
    rows = of.blocks[1].cells
    foot = rows[low[rows].sum(axis=1) == 2]
    assert len(foot)
    shared = foot[0][low[foot[0]]]
    apex = int(np.flatnonzero(low & ~np.isin(np.arange(len(low)), shared))[0])
    of.blocks[1].cells = np.concatenate([rows, [[*shared, apex]]])
    assert "M208" not in check(of).codes
    assert messages(of, "M216")[0].startswith("19 triangles")


def test_faces_of_a_form_that_no_cell_has_are_no_lost_facets():
    of = declaring(tet_grid(1), quad=[[0, 2, 6, 4]])
    assert check(of).codes == ("M216",)
    assert check(declaring(hex_grid(1), quad=[[0, 1, 7, 6]])).codes == ("M208",)
    assert check(declaring(hex_grid(1), triangle=[[0, 1, 7]])).codes == ("M216",)


def test_a_line_across_a_plane_is_an_error():
    for grid in (tri_grid, quad_grid):
        assert check(declaring(grid(3), line=[[0, 2]])).codes == ("M208",)
        assert check(declaring(grid(3), line=[[0, 4]])).codes == ()


def test_beams_of_second_order_are_beams():
    of = plate_with_beam(3, 1)
    line = of.blocks[1].cells[0]
    middle = of.points[line].mean(axis=0)
    of = Mesh(np.vstack([of.points, middle]), [of.blocks[0],
              Block("line3", np.array([[*line, len(of.points)]]))])  # fmt: skip
    assert check(of).codes == ("M216",)


def test_cells_of_lower_dimension_to_nowhere():
    of = plate_with_beam(3, 1)
    of.blocks[1].cells = np.array([[3, 99]])
    assert "M002" in check(of).codes


def test_beams_beside_cells_apart():
    """What binds is found where points in one place count as one."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    one = mesh(corners, tetra=[[0, 1, 2, 3]])
    assert check(declaring(one, triangle=[[0, 1, 2]])).codes == ()
