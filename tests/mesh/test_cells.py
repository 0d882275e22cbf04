"""The table of cell families: what its rows say of one another."""

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from meshio._mesh import topological_dimension

from meshopt_cli.cells import (
    FAMILIES,
    SIMPLICES,
    TET_EDGES,
    TET_FACETS,
    TRI_EDGES,
    TRI_FACETS,
    dimension_of,
    family_of,
)

ROWS = list(FAMILIES.values())
every = pytest.mark.parametrize("family", ROWS, ids=lambda f: f.name)
bounded = pytest.mark.parametrize("family", [f for f in ROWS if f.facets], ids=lambda f: f.name)
solid = pytest.mark.parametrize(
    "family", [f for f in ROWS if f.dimension == 3], ids=lambda f: f.name
)


def content(points):
    """Signed content of simplices, (n, d + 1, 3)."""
    d = points.shape[1] - 1
    return np.linalg.det(points[:, 1:, :d] - points[:, :1, :d]) / math.factorial(d)


def facets_of(family):
    return [facet.tolist() for table in family.facets for facet in table]


def sides_of(facet):
    return list(zip(facet, facet[1:] + facet[:1], strict=True))


@bounded
def test_facets_close(family):
    if family.dimension == 2:
        starts, ends = zip(*facets_of(family), strict=True)
        assert sorted(starts) == sorted(ends) == list(range(family.n_corners))
        return
    along = Counter(side for facet in facets_of(family) for side in sides_of(facet))
    assert set(along.values()) == {1}
    assert all((b, a) in along for a, b in along)


@bounded
def test_facets_are_turned_outwards(family):
    middle = family.reference.mean(axis=0)
    for facet in facets_of(family):
        corners = family.reference[facet]
        if family.dimension == 3:
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        else:
            normal = np.cross(corners[1] - corners[0], [0.0, 0.0, 1.0])
        assert normal @ (corners.mean(axis=0) - middle) > 0.1
        assert np.abs((corners - corners[0]) @ normal).max() < 1e-15


@bounded
def test_facets_have_the_width_of_their_table(family):
    widths = [table.shape[1] for table in family.facets]
    assert widths == sorted(set(widths))
    assert family.has_flat_facets == (max(widths) == family.dimension)


@every
def test_edges_are_those_of_the_facets(family):
    edges = [tuple(edge) for edge in family.edges.tolist()]
    assert edges == sorted(set(edges))
    assert all(a < b for a, b in edges)
    if family.facets:
        sides = {tuple(sorted(side)) for facet in facets_of(family) for side in sides_of(facet)}
        assert set(edges) == sides
        # Euler's formula
        n_facets, of_all = (len(facets_of(family)), 2) if family.dimension == 3 else (0, 0)
        assert family.n_corners - len(edges) + n_facets == of_all


@every
def test_edges_of_the_ideal_cell_have_length_1(family):
    ends = family.reference[family.edges]
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 1.0, rtol=1e-15)
    assert not family.reference[:, family.dimension :].any()


@solid
def test_hinges_are_the_edges_between_two_facets(family):
    facets = facets_of(family)
    common = []
    for one, other in family.hinges.tolist():
        first = {frozenset(side) for side in sides_of(facets[one])}
        shared = first & {frozenset(side) for side in sides_of(facets[other])}
        assert len(shared) == 1
        common += [tuple(sorted(edge)) for edge in shared]
    assert sorted(common) == [tuple(edge) for edge in family.edges.tolist()]


@pytest.mark.parametrize("family", [f for f in ROWS if f.dimension >= 2], ids=lambda f: f.name)
def test_corners_are_positive_and_follow_the_edges(family):
    assert (content(family.reference[family.corners]) > 0.01).all()
    edges = {frozenset(edge) for edge in family.edges.tolist()}
    for apex, *others in family.corners.tolist():
        assert all(frozenset((apex, other)) in edges for other in others)
    # Every vertex with as many edges as the cell has dimensions is the apex of one.
    degree = np.bincount(family.edges.ravel())
    apexes = np.flatnonzero(degree == family.dimension).tolist()
    assert family.corners[:, 0].tolist() == (apexes[:1] if family.is_simplex else apexes)


def test_corners_of_a_quad_are_those_of_figure_18_1():
    """The triangles of both diagonals: each has a corner between its two neighbours."""
    quad = FAMILIES["quad"]
    halves = {frozenset(half) for way in quad.partitions for half in way.tolist()}
    assert {frozenset(corner) for corner in quad.corners.tolist()} == halves


@every
def test_partitions_fill_the_cell(family):
    whole = {
        "vertex": 1.0,
        "line": 1.0,
        "triangle": math.sqrt(3) / 4,
        "quad": 1.0,
        "tetra": math.sqrt(2) / 12,
        "pyramid": math.sqrt(2) / 6,
        "wedge": math.sqrt(3) / 4,
        "hexahedron": 1.0,
    }[family.name]
    for way in family.partitions:
        if family.dimension:
            parts = content(family.reference[way])
            assert (parts > 0.01).all()
            assert parts.sum() == pytest.approx(whole, rel=1e-14)


@solid
def test_partitions_have_no_gaps(family):
    """Each facet of a part is one of another part, turned the other way, or lies in a facet of
    the cell."""
    for way in family.partitions:
        facets = Counter()
        for part in way:
            for facet in part[TET_FACETS].tolist():
                least = facet.index(min(facet))
                facets[tuple(facet[least:] + facet[:least])] += 1
        assert set(facets.values()) == {1}
        for a, b, c in facets:
            if (a, c, b) not in facets:
                assert any({a, b, c} <= set(facet) for facet in facets_of(family))


@every
def test_partitions_are_all_different(family):
    ways = {frozenset(frozenset(part) for part in way.tolist()) for way in family.partitions}
    assert len(ways) == len(family.partitions)


def test_as_many_parts_as_the_figures_say():
    parts = {name: {len(way) for way in f.partitions} for name, f in FAMILIES.items()}
    assert parts["quad"] == {2}
    assert parts["wedge"] == {3}
    assert parts["hexahedron"] == {5, 6}


def test_six_parts_of_a_hexahedron_are_two_wedges():
    """Figure 18.3: a plane through two long edges has three of the parts on either side."""
    hexahedron = FAMILIES["hexahedron"]
    for way in hexahedron.partitions:
        if len(way) == 6:
            middles = hexahedron.reference[way].mean(axis=1) - 0.5
            planes = [
                np.eye(3)[i] - sign * np.eye(3)[j]
                for i, j in itertools.combinations(range(3), 2)
                for sign in (1.0, -1.0)
            ]
            above = [np.count_nonzero(middles @ plane > 1e-9) for plane in planes]
            assert 3 in above


@pytest.mark.parametrize("cell_type", sorted(topological_dimension))
def test_types_of_any_order_have_a_family(cell_type):
    """All types that meshio knows by the name of a family and a number of nodes, or none."""
    stem = cell_type.rstrip("0123456789")
    family = family_of(cell_type)
    if stem in FAMILIES:
        assert family is FAMILIES[stem]
        assert dimension_of(cell_type) == family.dimension == topological_dimension[cell_type]
        assert not cell_type[len(stem) :] or int(cell_type[len(stem) :]) > family.n_corners
    else:
        assert family is None
        assert dimension_of(cell_type) == 3


def test_second_order_types_are_known():
    of_second_order = "line3 triangle6 triangle7 quad8 quad9 tetra10 tetra11 pyramid13 pyramid14 "
    of_second_order += "wedge15 wedge18 hexahedron20 hexahedron24 hexahedron27"
    for cell_type in of_second_order.split():
        assert family_of(cell_type).name == cell_type.rstrip("0123456789")


def test_simplices_stand_in_the_order_of_their_dimension():
    assert [FAMILIES[name].dimension for name in SIMPLICES] == [0, 1, 2, 3]
    assert all(f.is_simplex == (f.name in SIMPLICES) for f in ROWS)


@pytest.mark.parametrize(
    ("name", "facets", "edges"),
    [("triangle", TRI_FACETS, TRI_EDGES), ("tetra", TET_FACETS, TET_EDGES)],
)
def test_the_numbering_of_the_kernels(name, facets, edges):
    """Facet i and vertex i make a positive cell, and so do an edge and what lies opposite."""
    family = FAMILIES[name]
    vertices = list(range(family.n_corners))
    for i, facet in enumerate(facets):
        assert sorted([*facet, i]) == vertices
    rows = np.column_stack([facets, vertices])
    assert (content(family.reference[rows]) > 0.1).all()
    assert (content(family.reference[edges]) > 0.1).all()
    assert all(sorted(row) == vertices for row in edges.tolist())
    ends = sorted(tuple(sorted(row)) for row in edges[:, :2].tolist())
    assert ends == [tuple(edge) for edge in family.edges.tolist()]
    assert facets.dtype == edges.dtype == np.int64
    assert facets.flags.c_contiguous
    assert edges.flags.c_contiguous


def test_the_numbering_of_the_kernels_stays():
    """Results depend on the order of these rows to the last bit."""
    assert TET_FACETS.tolist() == [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]]
    assert TRI_FACETS.tolist() == [[1, 2], [2, 0], [0, 1]]
    assert TET_EDGES.tolist() == [
        [0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1],
    ]  # fmt: skip
    assert TRI_EDGES.tolist() == [[1, 2, 0], [2, 0, 1], [0, 1, 2]]
