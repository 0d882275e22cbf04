"""What is counted of a mesh: on meshes small enough to count by hand, and against slow ways."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.degrees import edge_angles
from meshopt_cli.mesh.model import Block, Mesh, top_blocks
from meshopt_cli.quality.census import Degrees, census
from meshopt_cli.validity import check
from support.broken import CUBE, SQUARE, VALID
from support.edits import declaring, halves, shaken, transformed
from support.kinds import tee
from support.meshes import (
    diamond,
    double_pyramid,
    fan,
    hex_grid,
    hexagon,
    hollow_icosahedron,
    icosahedron,
    mesh,
    quad_grid,
    spindle,
    tet_grid,
    tri_grid,
)
from support.planes import in_tilted_plane, rotation
from support.samples import SAMPLE_NAMES, sample
from support.settings import examples

NONE = Degrees()
SOLIDS = [name for name, family in FAMILIES.items() if family.dimension == 3]
FACES = [name for name, family in FAMILIES.items() if family.dimension == 2]


def ideal(name):
    """A mesh of one ideal cell."""
    reference = FAMILIES[name].reference
    return mesh(reference, **{name: [range(len(reference))]})


def constraints(of):
    found = census(of)
    return found.constrained_cells, found.constrained_edges, found.constrained_faces


def layers(n, n_layers):
    """Wedges over the triangles of a hexagon."""
    flat = hexagon(n)
    points = [[*p, z] for z in range(n_layers + 1) for p in flat.points]
    triangles = flat.blocks[0].cells
    size = len(flat.points)
    rows = [np.hstack([triangles + k * size, triangles + (k + 1) * size]) for k in range(n_layers)]
    return mesh(points, wedge=np.concatenate(rows))


def cube_of_pyramids():
    """From the centre to the sides of a cube."""
    sides = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    return mesh([*CUBE, [0.5, 0.5, 0.5]], pyramid=[[*side, 8] for side in sides])


def renumbered(of, seed):
    """The mesh with its points and cells in another order, simplices from another corner."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(of.points))
    place = np.argsort(order)
    turns = {"triangle": [1, 2, 0], "quad": [1, 2, 3, 0], "tetra": [1, 2, 0, 3]}
    blocks = []
    for block in of.blocks:
        rows = random.permutation(len(block.cells))
        local = turns.get(block.type, range(block.cells.shape[1]))
        data = {name: values[rows] for name, values in block.data.items()}
        blocks.append(Block(block.type, place[block.cells[rows]][:, list(local)], data))
    return replace(of, points=of.points[order], blocks=blocks)


MESHES = {
    "triangles": shaken(tri_grid(5)),
    "hexagon": hexagon(3),
    "tets": shaken(tet_grid(3)),
    "icosahedron": icosahedron(),
    "hexahedra": hex_grid(3),
    "wedges": layers(2, 2),
    "pyramids": cube_of_pyramids(),
    "quads": shaken(quad_grid(4), 0.45),
    "several": VALID["pyramid on a hexahedron"],
    "regions": halves(tet_grid(3)),
}


# Definitions 18.8 and 18.9 ------------------------------------------------------------------


@pytest.mark.parametrize("name", SOLIDS + FACES)
def test_all_facets_of_a_single_cell_are_in_the_boundary(name):
    assert constraints(ideal(name)) == (1, 0, 0)


def test_constrained_triangles_and_their_edges():
    assert constraints(tri_grid(1)) == (2, 1, 0)
    assert constraints(tri_grid(3)) == (2, 2, 0)
    assert constraints(hexagon(2)) == (0, 0, 0)
    assert constraints(fan(5)) == (0, 0, 0)
    assert constraints(diamond(1.0)) == (2, 1, 0)


def test_constrained_tets_edges_and_faces():
    assert constraints(double_pyramid(1.0)) == (2, 0, 1)  # three edges of it are on the boundary
    assert constraints(tet_grid(1)) == (0, 1, 6)
    assert constraints(spindle(5)) == (0, 1, 5)
    assert constraints(icosahedron()) == (0, 0, 0)
    assert constraints(hollow_icosahedron())[0] == 0


def test_constrained_cells_of_other_families():
    """All facets in the boundary but one: a row of cells has two such ends."""
    row = mesh([[x, y] for x in range(4) for y in range(2)],
               quad=[[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(3)])  # fmt: skip
    assert constraints(row) == (2, 2, 0)
    assert constraints(quad_grid(2)) == (0, 0, 0)
    rod = mesh([[*p, z] for z in range(4) for p in SQUARE],
               hexahedron=[range(4 * k, 4 * k + 8) for k in range(3)])  # fmt: skip
    assert constraints(rod) == (2, 0, 2)
    assert constraints(hex_grid(2)) == (0, 0, 0)
    assert constraints(hex_grid(1)) == (1, 0, 0)
    assert constraints(VALID["pyramid on a hexahedron"]) == (2, 0, 1)
    assert constraints(cube_of_pyramids()) == (0, 0, 0)
    assert constraints(layers(1, 1)) == (0, 1, 6)


def test_interfaces_and_declared_facets_constrain():
    assert constraints(halves(tri_grid(1))) == (2, 0, 0)
    assert constraints(declaring(tri_grid(1), line=[[0, 3]])) == (2, 0, 0)
    pair = declaring(double_pyramid(1.0), triangle=[[0, 1, 2]])
    assert constraints(pair) == (2, 0, 0)
    rod = mesh(
        [[*p, z] for z in range(3) for p in SQUARE],
        hexahedron=[range(4 * k, 4 * k + 8) for k in range(2)],
        quad=[[4, 5, 6, 7]],
    )
    assert constraints(rod) == (2, 0, 0)


def test_edges_where_a_surface_branches_are_boundary():
    """The skin of what is optimized has them; the check takes them for edges inside."""
    assert constraints(tee(1)) == (6, 3, 0)


def is_counted(of):
    branches = any(group.code == "M214" for group in check(of, select=["M214"]).groups)
    return bool(top_blocks(of)) and of.dimension() >= 2 and not branches


AGREEING = {
    **{name: of for name, of in VALID.items() if is_counted(of)},
    **{name: of for name, of in MESHES.items() if name != "regions"},
}


@pytest.mark.parametrize("name", AGREEING)
def test_the_check_finds_as_many(name):
    of = AGREEING[name]
    found = {group.code: len(group) for group in check(of, select=["M3"]).groups}
    assert constraints(of) == tuple(found.get(code, 0) for code in ("M301", "M302", "M303"))


# Degrees ------------------------------------------------------------------------------------


def slow_degrees(of):
    """Degrees of vertices inside and outside, and how many cells are around edges inside."""
    facets, edges = Counter(), Counter()
    for block in top_blocks(of):
        family = FAMILIES[block.type]
        for cell in block.cells:
            facets.update(frozenset(cell[f].tolist()) for t in family.facets for f in t)
            edges.update(frozenset(cell[e].tolist()) for e in family.edges)
    outer = [facet for facet, n in facets.items() if n == 1]
    rim = set().union(*outer)
    degree = Counter(v for edge in edges for v in edge)
    vertices = [Counter(n for v, n in degree.items() if (v in rim) is out) for out in (False, True)]
    if of.dimension() == 2:
        return *vertices, {}
    return *vertices, Counter(n for e, n in edges.items() if not any(e <= f for f in outer))


def counted(of):
    found = census(of)
    return tuple(d.counts for d in (found.inner_vertices, found.boundary_vertices,
                                    found.inner_edges))  # fmt: skip


@pytest.mark.parametrize("name", MESHES)
def test_degrees_are_those_of_a_slow_count(name):
    if name not in ("hexahedra", "wedges"):
        assert counted(MESHES[name]) == slow_degrees(MESHES[name])


@pytest.mark.parametrize("of", [hex_grid(2), layers(2, 2)], ids=["hexahedra", "wedges"])
def test_edges_across_a_quad_of_the_boundary_are_none(of):
    """No diagonal is an edge, so that the slow count holds for quads, too."""
    assert counted(of)[:2] == slow_degrees(of)[:2]
    assert sum(counted(of)[2].values()) == sum(slow_degrees(of)[2].values())


def test_regular_triangles():
    found = census(hexagon(3))
    assert found.inner_vertices == Degrees({6: 19}, {0: 19})
    assert found.boundary_vertices == Degrees({3: 6, 4: 12}, {0: 18})
    assert found.inner_edges == NONE


def test_inner_vertices_of_quads():
    found = census(quad_grid(4))
    assert found.inner_vertices == Degrees({4: 9}, {0: 9})
    assert found.boundary_vertices == Degrees({2: 4, 3: 12}, {0: 16})
    three = mesh([[0, 0], *([np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3)],
                 quad=[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]])  # fmt: skip
    assert census(three).inner_vertices == Degrees({3: 1}, {-1: 1})


def test_triangles_among_quads():
    """Three triangles and two quads fill the angle around a vertex, which then has 5 edges."""
    angles = np.radians([0, 60, 120, 180, 270])
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = [ring[3] + ring[4], ring[4] + ring[0]]
    of = mesh([[0, 0], *ring, *corners],
              triangle=[[0, 1, 2], [0, 2, 3], [0, 3, 4]],
              quad=[[0, 4, 6, 5], [0, 5, 7, 1]])  # fmt: skip
    assert census(of).inner_vertices == Degrees({5: 1}, {0: 1})


@pytest.mark.parametrize(("n", "off"), [(3, -2), (4, -1), (5, 0), (6, 0), (7, 1), (9, 3)])
def test_tets_around_an_edge(n, off):
    found = census(spindle(n))
    assert found.inner_edges == Degrees({n: 1}, {off: 1})
    assert found.inner_vertices == NONE
    assert (found.inner_edges.under, found.inner_edges.over) == (int(off < 0), int(off > 0))


def test_twenty_tets_around_a_vertex():
    found = census(icosahedron())
    assert found.inner_vertices == Degrees({12: 1}, {0: 1})
    assert found.inner_edges == Degrees({5: 12}, {0: 12})
    assert set(found.boundary_vertices.excess) == {0}


def test_cubes():
    found = census(hex_grid(3))
    assert found.inner_vertices == Degrees({6: 8}, {0: 8})
    assert found.boundary_vertices.counts == {3: 8, 4: 24, 5: 24}
    assert found.boundary_vertices.excess == {0: 56}
    assert found.inner_edges == Degrees({4: 36}, {0: 36})


def test_wedges():
    """Six around edges along them, four around those across."""
    found = census(layers(2, 2))
    assert found.inner_vertices == Degrees({8: 7}, {0: 7})
    assert found.inner_edges.counts == {4: 30, 6: 14}
    assert found.inner_edges.excess == {0: 44}
    assert found.boundary_vertices.excess == {0: sum(found.boundary_vertices.counts.values())}


def test_pyramids():
    found = census(cube_of_pyramids())
    assert found.inner_vertices.counts == {8: 1}
    assert found.inner_edges == Degrees({3: 8}, {0: 8})  # 3 or 4, by angles of 109.5 degrees


def test_ideal_angles_at_edges():
    assert edge_angles("tetra") == (70.528779,) * 6
    assert edge_angles("hexahedron") == (90.0,) * 12
    assert Counter(edge_angles("wedge")) == {60.0: 3, 90.0: 6}
    assert Counter(edge_angles("pyramid")) == {54.735610: 4, 109.471221: 4}


def test_an_interface_ends_no_mesh():
    plain, parted = census(tet_grid(3)), census(halves(tet_grid(3)))
    assert plain.inner_vertices == parted.inner_vertices
    assert plain.inner_edges == parted.inner_edges
    assert plain.constrained_edges != parted.constrained_edges


def test_points_without_a_cell_have_no_degree():
    of = hexagon(2)
    found = census(of)
    of.points = np.concatenate([of.points, [[9.0, 9.0]] * 5])
    assert census(of) == found


# All of it ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MESHES)
def test_numbering_and_direction_do_not_matter(name):
    of = MESHES[name]
    found = census(of)
    for seed in range(3):
        assert census(renumbered(of, seed)) == found
        if of.points.shape[1] == 3:
            turn = rotation(seed)
            assert census(transformed(of, lambda p, turn=turn: p @ turn.T)) == found
        else:
            assert census(in_tilted_plane(of, seed)) == found


@pytest.mark.parametrize("name", ["triangles", "hexagon", "tets", "icosahedron", "regions"])
def test_what_is_optimized_has_the_counts_of_its_mesh(name):
    assert census(cast(MESHES[name])) == census(MESHES[name])


@pytest.mark.parametrize("name", SAMPLE_NAMES)
def test_samples(name):
    part = sample(name)
    found = census(part)
    n = found.inner_vertices.total + found.boundary_vertices.total
    assert n == len(np.unique(part.cells))
    assert found.n_simplices == len(part.cells)
    assert sum(found.inner_vertices.excess.values()) == found.inner_vertices.total


def test_cells_of_second_order_count_by_their_corners():
    assert census(VALID["second order"]) == census(VALID["one tet"])


@pytest.mark.parametrize("name", ["no cells", "no rows", "lines", "unknown type"])
def test_meshes_without_anything_to_count(name):
    found = census(VALID[name])
    assert (found.inner_vertices, found.boundary_vertices, found.quads) == (NONE, NONE, {})
    assert constraints(VALID[name]) == (0, 0, 0)


def test_arrays_that_cannot_be_written_to():
    of = Mesh(tet_grid(1).points, [Block("tetra", tet_grid(1).blocks[0].cells.astype(np.int32))])
    of.points.flags.writeable = of.blocks[0].cells.flags.writeable = False
    assert census(of) == census(tet_grid(1))


@given(st.integers(0, 2**31))
@examples(10)
def test_any_triangles(seed):
    """Degrees and constraints do not depend on where points are, but for targets outside."""
    of = shaken(tri_grid(4), 0.2, seed)
    assert counted(of) == counted(tri_grid(4))
    assert constraints(of) == constraints(tri_grid(4))
