"""Surfaces in space that branch, and sheets that are oriented each by itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from support.edits import tagged, turned, with_cells
from support.kinds import X, Y, Z, band, box, fold, plate, star, tee
from support.meshes import in_space, joined, mesh, octahedron, quad_grid, tri_grid
from support.settings import examples


def group_of(of, code, **options):
    (group,) = [group for group in check(of, **options).groups if group.code == code]
    return group


@pytest.mark.parametrize("grid", [tri_grid, quad_grid])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_the_edges_of_a_branch_are_named_on_request(n, grid):
    of = tee(n, grid)
    assert check(of).codes == ()
    group = group_of(of, "M214", extend=["M214"])
    assert len(group) == n
    ends = {frozenset(found.other_points) for found in group.findings(of)}
    axis = np.flatnonzero(~of.points[:, :2].any(axis=1))
    assert len(ends) == n
    assert set().union(*ends) == set(axis.tolist())
    assert all(len(found.other_cells) == 2 for found in group.findings(of))
    assert check(of, extend=["M214"]).is_valid


def test_faces_that_crowd_in_a_plane_overlap():
    of = mesh([[0, 0], [1, 0], [0, 1], [1, 1], [0, -1]], triangle=[[0, 1, 2], [0, 1, 3], [1, 0, 4]])
    for flat in (of, in_space(Mesh(of.points, of.blocks), 2.0)):
        assert "M204" in check(flat).codes
        assert "M214" not in check(flat, extend=["M214"]).codes


def test_a_cell_twice_is_no_branch():
    of = octahedron()
    doubled = with_cells(of, np.concatenate([of.blocks[0].cells, of.blocks[0].cells[:1]]))
    assert check(doubled, extend=["M214"]).codes == ("M201",)


@pytest.mark.parametrize("n", [2, 4])
def test_a_fold_is_told_once(n):
    of = fold(n)
    (found,) = group_of(of, "M215").findings(of)
    assert f"{n} edges" in found.message
    assert check(of).is_valid


@examples(30)
@given(st.lists(st.booleans(), min_size=6, max_size=6), st.integers(2, 4))
def test_plates_of_a_box_may_be_turned_either_way(outwards, n):
    of = box(n, outwards)
    report = check(of)
    assert report.is_valid
    assert bool(report.codes) == (len(set(outwards)) > 1)
    assert set(report.codes) <= {"M215"}


@examples(30)
@given(st.integers(0, 95), st.integers(3, 6))
def test_a_cell_turned_over_among_others_is_wrong(row, k):
    sheets = [X, Y, -X, -Y, X + Y, X - Y][:k]
    of = star(4, sheets)
    row %= len(of.blocks[0].cells)
    places = of.points[of.blocks[0].cells[row]]
    of = turned(of, row)
    at_branch = np.isclose(np.abs(places[:, :2]).max(axis=1), 0).sum() > 1
    assert ("M207" in check(of).codes) or at_branch
    assert not at_branch or check(of).codes in ((), ("M207",))


def test_a_part_of_a_smooth_sheet_turned_over_is_wrong():
    n = 24
    points = np.concatenate([[[np.cos(a), np.sin(a), z] for a in np.linspace(0, np.pi, n + 1)]
                             for z in (0, 1)])  # fmt: skip
    i = np.arange(n)
    cells = np.stack([i, i + 1, n + i + 2, n + i + 1], axis=1)
    of = mesh(points, quad=cells)
    assert check(of).codes == ()
    half = with_cells(of, np.where(i[:, None] < n // 2, cells, cells[:, ::-1]))
    assert check(half).codes == ("M207",)
    # Regions of their own are sheets of their own.
    parts = tagged(half, np.where(i < n // 2, 1, 2))
    assert check(parts).codes == ("M215",)


@pytest.mark.parametrize("n", [12, 40])
def test_a_band_with_one_side_is_told_so(n):
    assert check(band(n, 2)).codes == ()
    of = band(n, 1)
    (found,) = group_of(of, "M215").findings(of)
    assert "one side only" in found.message
    assert check(of).is_valid


def test_sheets_of_triangles_and_quads_branch_too():
    both = star(2, [X, Y])
    third = plate(2, -Y, Z, grid=quad_grid)
    place = {tuple(p): k for k, p in enumerate(both.points.round(9).tolist())}
    number = np.array([
        place.setdefault(tuple(p), len(place)) for p in third.points.round(9).tolist()
    ])  # fmt: skip
    of = Mesh(np.array(list(place)), [*both.blocks, Block("quad", number[third.blocks[0].cells])])
    assert check(of).codes == ()
    assert len(group_of(of, "M214", select=["M214"])) == 2


def test_sheets_that_touch_in_a_vertex_are_told_as_before():
    of = joined(plate(2, X, Z), plate(2, -X, -Z))
    of.points[:, 1] = 0.1 * np.abs(of.points[:, 0])
    assert check(of).codes == ("M212",)
