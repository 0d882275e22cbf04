"""What repairs change, and what they leave."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.elements import ELEMENTS
from meshopt_cli.errors import BadMeshError
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.orientation import turned
from meshopt_cli.mesh.periodic import Link
from meshopt_cli.mesh.sizes import contents
from meshopt_cli.repairs import MENDS, repair
from meshopt_cli.repairs.closing import cell_within
from meshopt_cli.validity import RULES, check
from support.broken import BROKEN, CUBE, VALID
from support.curved import of_second_order
from support.edits import cell_inside, declaring, tagged, torn, without
from support.elements import reference
from support.meshes import hex_grid, in_space, mesh, quad_grid, tet_grid, tri_grid
from support.random_edits import meshes
from support.settings import examples


def errors_in(one):
    return {group.code for group in check(one).errors}


def came_up(one, other):
    """Codes of the errors of a mesh that another one has not, nor hides by others of its own."""
    before, after = errors_in(one), errors_in(other)
    if before & {"M002", "M003"}:
        return set()
    hidden = {"M105"} if "M101" in before else set()
    if before & {"M101", "M102", "M201", "M202", "M204"}:
        hidden |= {code for code in RULES if code > "M204"}
    return after - before - hidden


def copied(one):
    blocks = [replace(b, cells=b.cells.copy(), data=dict(b.data)) for b in one.blocks]
    return replace(one, points=one.points.copy(), blocks=blocks)


def same(one, other):
    return np.array_equal(one.points, other.points, equal_nan=True) and all(
        mine.type == yours.type and np.array_equal(mine.cells, yours.cells)
        for mine, yours in zip(one.blocks, other.blocks, strict=True)
    )


def size_of(one):
    """Volume, or area, of the main cells."""
    top = one.dimension()
    return sum(
        float(contents(one.points, b.cells, b.type).sum())
        for b in one.blocks if FAMILIES[b.type].dimension == top
    )  # fmt: skip


TABLE = {n: one for n, one in VALID.items() if one.dimension() >= 0}
TABLE |= {name: one for name, (one, _) in BROKEN.items()}


@pytest.mark.parametrize("name", TABLE)
def test_nothing_new_is_wrong_afterwards(name):
    """Whatever is asked for; and a second repair finds nothing to do."""
    one = TABLE[name]
    original = copied(one)
    done = repair(one, MENDS)
    assert same(one, original)
    assert not came_up(one, done.mesh)
    assert not repair(done.mesh, MENDS).counts


@pytest.mark.parametrize("name", VALID)
def test_nothing_is_changed_without_need(name):
    if VALID[name].dimension() >= 0:
        done = repair(VALID[name], [mend for mend in MENDS if mend != "unused"])
        assert (done.mesh, done.counts, done.notes) == (VALID[name], {}, ())


@pytest.mark.parametrize("mend", MENDS)
@pytest.mark.parametrize("name", BROKEN)
def test_only_what_is_asked_for_is_done(name, mend):
    one = BROKEN[name][0]
    done = repair(one, [mend])
    assert list(done.mends) == [mend]
    assert (done.mesh is one) == (not done.counts)


@pytest.mark.parametrize("grid", [tri_grid(4), tet_grid(2)], ids=["plane", "space"])
@examples(80)
@given(data=st.data())
def test_any_mesh(grid, data):
    """A repair never fails, never does harm, and does all that it can at once."""
    one = data.draw(meshes(grid))
    names = data.draw(st.sets(st.sampled_from(list(MENDS))))
    done = repair(one, names)
    if "merge" not in names:  # points that are one now may show what is wrong between cells
        assert not came_up(one, done.mesh)
    assert not repair(done.mesh, names).counts


# Points --------------------------------------------------------------------------------------


def test_merged_points_hand_over_what_is_said_of_them():
    one = torn(tri_grid(2), 1)
    n = len(one.points)
    one.point_data = {
        "ids": np.arange(n) + 7,
        "temperature": np.arange(n, dtype=float),
        "same": np.ones(n),
        "medit:required": np.zeros(n, np.int64),
    }
    one.point_data["medit:required"][n - 1] = 1
    one.periodic = [Link(1, 5, 6, (), np.array([[n - 1, 0], [1, 2]]))]
    done = repair(one, ["merge"])
    assert check(done.mesh).is_valid
    assert done.notes == (
        "of points that were merged, the first one's values are kept: temperature",
    )
    merged = done.mesh
    twin = int(np.flatnonzero((merged.points == one.points[n - 1]).all(axis=1))[0])
    assert merged.point_data["medit:required"].sum() == merged.point_data["medit:required"][twin]
    assert merged.point_data["medit:required"][twin] == 1
    np.testing.assert_array_equal(merged.points, one.points[merged.point_data["ids"] - 7])
    old = one.points[one.periodic[0].pairs]
    np.testing.assert_array_equal(merged.points[merged.periodic[0].pairs], old)


def test_points_are_merged_within_a_tolerance():
    one = torn(tri_grid(4), 3)
    one.points[-1] += 1e-5
    assert repair(one, ["merge"], 1e-4).counts["points merged"] > repair(
        one, ["merge"], 1e-9
    ).counts["points merged"]  # fmt: skip


def test_a_point_that_the_file_declares_is_kept():
    one = BROKEN["used by a vertex only"][0]
    done = repair(one, MENDS)
    assert done.mesh is one
    assert done.notes == ("unused points that cells of type vertex declare: 1 left",)


def test_vertices_that_do_not_exist_go_on_not_to_exist():
    one = mesh([*np.eye(3), [9, 9, 9]], triangle=[[0, 1, 2], [0, 1, 7], [-4, 1, 2]])
    left = repair(one, ["unused"]).mesh
    assert len(left.points) == 3
    assert errors_in(left) == {"M002"}


def test_nothing_would_be_left():
    with pytest.raises(BadMeshError, match="no cell of it would be left"):
        repair(mesh(np.eye(3), triangle=[[0, 1, 1]]), ["flat"])
    with pytest.raises(BadMeshError, match="no cells"):
        repair(Mesh(np.eye(3), []), MENDS)


# Cells ---------------------------------------------------------------------------------------


def test_duplicates_of_other_regions_are_named():
    one = tagged(BROKEN["tet twice"][0], [1, 2])
    done = repair(one, ["duplicates"])
    assert done.mesh.blocks[0].data["medit:ref"].tolist() == [1]
    assert done.notes == ("duplicate cells that had other tags than the first: 1",)


# What becomes of a hexahedron whose corners are drawn together.
DRAWN = {
    "an edge": ({1: 0, 5: 4}, "wedge", 0.5),
    "a face": ({5: 4, 6: 4, 7: 4}, "pyramid", 1 / 3),
    "a face to an edge": ({5: 4, 6: 7}, "wedge", 0.5),
    "three edges": ({5: 4, 6: 4, 7: 4, 3: 2}, "tetra", 1 / 6),
}


@pytest.mark.parametrize("name", DRAWN)
def test_cells_drawn_together_are_what_they_are(name):
    to, family, size = DRAWN[name]
    corners = [to.get(k, k) for k in range(8)]
    one = tagged(mesh(CUBE, hexahedron=[range(8), corners]), [4, 5])
    one.blocks[0].cells = one.blocks[0].cells[1:]
    one.blocks[0].data = {"medit:ref": np.array([5])}
    done = repair(one, ["flat", "unused"]).mesh
    made = [block for block in done.blocks if len(block.cells)]
    assert [block.type for block in made] == [family]
    assert made[0].data["medit:ref"].tolist() == [5]
    assert check(done).is_valid
    assert size_of(done) == pytest.approx(size)


@pytest.mark.parametrize("family", ["triangle", "tetra", "wedge", "pyramid", "hexahedron", "quad"])
def test_a_cell_is_known_by_its_facets(family):
    row = FAMILIES[family]
    random = np.random.default_rng(3)
    for _ in range(20):
        number = random.permutation(20)[: row.n_corners]
        facets = [tuple(reversed(number[f].tolist())) for t in row.facets for f in t]
        random.shuffle(facets)
        found = cell_within([tuple(np.roll(f, random.integers(4)).tolist()) if len(f) > 2 else f
                             for f in facets], row.dimension)  # fmt: skip
        assert found is not None
        assert found[0] == family
        place = {int(v): row.reference[k] for k, v in enumerate(number)}
        points = np.array([place[v] for v in found[1]])[:, : row.dimension]
        assert contents(points, np.arange(row.n_corners)[None], family)[0] > 0.1
    assert cell_within(facets[1:], row.dimension) is None


def test_flat_cells_hand_their_facets_over():
    """The facets on the other side are declared as those of the flat cell were."""
    one = tet_grid(1)
    one.blocks[0].cells = np.concatenate([one.blocks[0].cells, [[0, 4, 6, 2]]])
    one = declaring(one, triangle=[[0, 4, 2], [4, 6, 2], [1, 3, 7]])
    (at,) = [k for k, block in enumerate(one.blocks) if block.type == "triangle"]
    for tags, lost in (([8, 8, 9], 1), ([7, 8, 9], 0)):
        one.blocks[at].data = {"medit:ref": np.array(tags), "ids": np.array([1, 2, 3])}
        done = repair(one, ["flat"])
        assert done.counts.get("flat cells dropped", 0) == lost
        assert ("M102" in errors_in(done.mesh)) == (not lost)
        facets = done.mesh.blocks[at]
        assert sorted(facets.data["medit:ref"]) == sorted(tags)
        assert len(set(facets.data["ids"])) == 3
        if lost:
            assert check(done.mesh).is_valid
            assert {frozenset(f) for f in facets.cells[facets.data["medit:ref"] == 8].tolist()} == {
                frozenset([0, 4, 6]), frozenset([0, 6, 2])
            }  # fmt: skip
        else:
            assert "1 left" in done.notes[0]


def test_layers_of_flat_cells_go_one_after_the_other():
    """A fan of flat triangles beside a grid, of which only the outermost is at the boundary."""
    points = np.array([[0, 0], [1, 0], [0.5, 1], [0.25, 0], [0.5, 0], [0.75, 0]])
    one = mesh(points, triangle=[[3, 2, 0], [4, 2, 3], [5, 2, 4], [1, 2, 5], [0, 3, 4], [0, 4, 5],
                                 [0, 5, 1]])  # fmt: skip
    one.blocks[0].cells = turned(one.blocks[0].cells)
    one.blocks[0].cells[4:] = turned(one.blocks[0].cells[4:])
    assert "M102" in errors_in(one)
    done = repair(one, ["flat"])
    assert done.counts == {"flat cells dropped": 3}
    assert "M102" not in errors_in(done.mesh)


@pytest.mark.parametrize("order", ["first", "second"])
@pytest.mark.parametrize("make", [tri_grid, tet_grid, quad_grid, hex_grid])
def test_a_missing_cell_comes_back_as_it_was(make, order):
    whole = make(4 if make in (tri_grid, tet_grid) else 3)
    kind, n = whole.blocks[0].type, len(whole.blocks[0].cells)
    row = cell_inside(whole) if kind in ("triangle", "tetra") else n // 2
    whole.blocks[0].data = {"medit:ref": np.full(n, 3), "cell_id": np.arange(n) + 10}
    if order == "second":
        if kind in ("quad", "hexahedron"):
            pytest.skip("grids of second order are of simplices here")
        whole = of_second_order(whole)
    block = whole.blocks[0]
    keep = np.arange(n) != row
    data = {name: values[keep] for name, values in block.data.items()}
    one = replace(whole, blocks=[Block(block.type, block.cells[keep], data)])
    assert errors_in(one) == {"M211"}
    done = repair(one, ["fill"]).mesh
    assert check(done).is_valid
    filled = done.blocks[0]
    assert set(filled.cells[-1]) == set(block.cells[row])
    assert filled.data["medit:ref"].tolist() == [3] * n
    assert len(set(filled.data["cell_id"].tolist())) == n


@pytest.mark.parametrize("kind", ["quad8", "hexahedron20", "hexahedron27", "wedge15", "tetra10"])
def test_cells_of_second_order_are_turned_with_their_nodes(kind):
    one = mesh(reference(kind), **{kind: [range(ELEMENTS[kind].n_nodes)]})
    cells = turned(one.blocks[0].cells, kind)
    broken = replace(one, blocks=[replace(one.blocks[0], cells=cells)])
    assert errors_in(one) == set()
    assert errors_in(broken) != set()
    done = repair(broken, ["orientation"])
    assert done.counts == {"cells turned": 1}
    assert errors_in(done.mesh) == set()


def test_corners_in_the_order_of_voxels():
    for one, order in ((quad_grid(3), [0, 1, 3, 2]), (hex_grid(2), [0, 1, 3, 2, 4, 5, 7, 6])):
        block = one.blocks[0]
        broken = replace(one, blocks=[replace(block, cells=block.cells[:, order])])
        assert errors_in(broken)
        done = repair(broken, ["orientation"])
        assert done.counts == {"cells whose corners were put in order": len(block.cells)}
        assert np.array_equal(done.mesh.blocks[0].cells, block.cells)


def test_a_surface_without_two_sides_stays():
    one = BROKEN["band with one side"][0]
    assert repair(one, ["orientation"]).mesh is one


def test_mixed_cells_are_turned_together():
    one = in_space(tri_grid(2), 0.0)
    quads = in_space(quad_grid(2), 0.0)
    quads.points[:, 0] += 1.0
    points = np.concatenate([one.points, quads.points])
    both = mesh(points, triangle=one.blocks[0].cells[:, ::-1], quad=9 + quads.blocks[0].cells)
    done = repair(both, ["merge", "orientation"]).mesh
    assert check(done).is_valid


def test_lower_cells_without_length_go():
    one = declaring(without(tet_grid(2)), line=[[0, 1], [26, 26]])
    done = repair(one, ["flat"]).mesh
    assert check(done).is_valid


@pytest.mark.parametrize("space", [False, True])
def test_flat_triangles_between_others_go(space):
    """The triangle beyond the longest edge is divided, and both halves have its arrays."""
    grid = tri_grid(4)
    inner = int(np.flatnonzero((grid.points == 0.5).all(axis=1))[0])
    grid.points[inner] = [0.375, 0.625]
    n = len(grid.blocks[0].cells)
    grid.blocks[0].data = {"medit:ref": np.full(n, 4), "cell_id": np.arange(n)}
    if space:
        grid = in_space(grid, 0.1 * (grid.points[:, 0] > 0.8))
    assert "M102" in errors_in(grid)
    done = repair(grid, ["flat"])
    n_flat = done.counts["flat cells dropped"]
    assert check(done.mesh).is_valid
    assert len(done.mesh.blocks[0].cells) == n
    assert n_flat > 0
    assert sorted(set(done.mesh.blocks[0].data["cell_id"])) == sorted(
        done.mesh.blocks[0].data["cell_id"]
    )
    assert size_of(done.mesh) == pytest.approx(size_of(grid))


def test_an_edge_that_the_file_declares_is_not_divided():
    grid = tri_grid(4)
    inner = int(np.flatnonzero((grid.points == 0.5).all(axis=1))[0])
    grid.points[inner] = [0.375, 0.625]
    ends = [int(np.argmin(np.abs(grid.points - p).sum(axis=1))) for p in ([0.25, 0.5], [0.5, 0.75])]
    one = declaring(grid, line=[ends])
    done = repair(one, ["flat"])
    assert done.mesh is one
    assert "1 left" in done.notes[0]
