"""Optimization of triangles and tetrahedra of second order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.errors import BadMeshError, MeshoptError, UnsupportedMeshError
from meshopt_cli.jobs.admission import InvalidMeshError
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from support.curved import (
    ORDER_2,
    boundary_edges,
    bulging,
    corners_only,
    disc,
    jacobians,
    middles_by_place,
    of_second_order,
    on_circle,
    renumbered,
    rim,
)
from support.edits import shaken, turned_over
from support.meshes import in_space, tet_grid, tri_grid
from support.planes import in_tilted_plane
from support.recipes import Recipe, made
from support.runs import optimized
from support.settings import examples

every_policy = pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=lambda policy: policy.name)


def outcome(of, *args, **request):
    """A result, or the kind of error instead."""
    try:
        return optimized(of, *args, **request)
    except MeshoptError as error:
        return type(error)


def assert_same_mesh(one, other):
    assert one.points.tobytes() == other.points.tobytes()
    assert one.points.dtype == other.points.dtype
    assert [b.type for b in one.blocks] == [b.type for b in other.blocks]
    for mine, yours in zip(one.blocks, other.blocks, strict=True):
        assert np.array_equal(mine.cells, yours.cells)
        assert list(mine.data) == list(yours.data)
        for name, values in mine.data.items():
            assert np.array_equal(values, yours.data[name]), name


recipes = st.builds(
    Recipe,
    dimension=st.sampled_from([2, 3]),
    n=st.sampled_from([2, 3, 4]),
    seed=st.integers(0, 2**16),
    amount=st.sampled_from([0.5, 1.0, 1.5]),
    notched=st.booleans(),
    regions=st.sampled_from(["one", "halves", "corner", "many"]),
    declared=st.lists(
        st.sampled_from(["sides", "parts of sides", "some sides", "facets", "edges", "vertices"]),
        unique=True, max_size=3,
    ).map(tuple),
    place=st.sampled_from(["as it is", "other plane", "tilted"]),
    single=st.booleans(),
    tangled=st.sampled_from([False, False, False, True]),
)  # fmt: skip


@every_policy
@examples(25)
@given(recipe=recipes, raised=st.booleans())
def test_straight_cells_become_what_those_of_first_order_do(policy, recipe, raised):
    """The same corners, bit for bit, and nodes half way between the ends of all edges."""
    one, _ = made(recipe)
    only = tuple(ORDER_2) if raised else ("tetra" if recipe.dimension == 3 else "triangle",)
    first = outcome(one, policy, rounds=2)
    second = outcome(of_second_order(one, only=only), policy, rounds=2)
    if isinstance(first, type):
        assert second is first
        return
    corners, middles = corners_only(second)
    assert_same_mesh(corners, first)
    edges, nodes = np.array(list(middles)), list(middles.values())
    half_way = first.points[edges].astype(float).mean(axis=1).astype(first.points.dtype)
    assert np.array_equal(second.points[nodes], half_way)
    assert len(second.points) == len(first.points) + len(middles)
    assert check(second).is_valid


def shaken_disc(seed=0):
    """A disc of second order with a curved rim, its corners inside moved at random."""
    one = disc(5)
    inner = np.linalg.norm(one.points, axis=1) < 0.99
    one.points[inner] += np.random.default_rng(seed).uniform(-0.06, 0.06, (inner.sum(), 2))
    return of_second_order(one, on_circle)


def shaken_ball(amount=0.05, seed=0):
    """A box of second order with curved sides, its corners inside moved at random."""
    one = shaken(tet_grid(4), 0.25, seed)
    one.points -= 0.5
    return of_second_order(one, bulging(amount))


CURVED = {
    "disc": shaken_disc,
    "disc in space": lambda: in_space(shaken_disc(), 2.0),
    "disc in a tilted plane": lambda: in_tilted_plane(shaken_disc()),
    "ball": shaken_ball,
    "hollow ball": lambda: shaken_ball(-0.05),
    "ball in single precision": lambda: single(shaken_ball()),
}
every_curved = pytest.mark.parametrize("name", CURVED)


def single(of):
    return replace(of, points=of.points.astype(np.float32))


@every_policy
@every_curved
@examples(5)
@given(seed=st.integers(0, 2**16))
def test_a_curved_boundary_stays_bit_for_bit(name, policy, seed):
    of = renumbered(CURVED[name](), seed)
    result = optimized(of, policy)
    assert rim(result) == rim(of)
    assert {b.type for b in result.blocks} == {b.type for b in of.blocks}
    assert check(result).is_valid
    flat = result if of.dimension() == 3 or of.points.shape[1] == 2 else None
    if flat is not None:
        assert jacobians(flat).min() > 0
    assert middles_by_place(result) != middles_by_place(of)


def test_edges_inside_between_two_vertices_of_the_boundary_are_free():
    """They are none of the boundary, although both of their ends are."""
    points = np.array([[0, 0], [4, 0], [4, 1], [0, 1], [2, -0.2], [2, 1.2]])
    long = [[0, 4, 3], [4, 1, 2], [4, 2, 3], [3, 2, 5]]  # 2 3 is longer than 4 5
    of = of_second_order(Mesh(points, [Block("triangle", np.array(long))]), bulging(0.01))
    result = optimized(of, passes=("swap",))
    assert rim(result) == rim(of)
    inside = middles_by_place(result).keys() - rim(of).keys()
    assert frozenset({(2.0, -0.2), (2.0, 1.2)}) in inside
    assert inside != middles_by_place(of).keys() - rim(of).keys()


def crossed(n=6, height=1.25, bulge=0.24):
    """A strip of tall triangles whose lower side bulges into them, as far as they allow.

    Better cells would be less tall, and then invalid.
    """
    one = tri_grid(n)
    one.points *= n
    level = one.points[:, 1]
    one.points[:, 1] = np.where(level > 0, level + height - 1, 0)
    # Far from the lower side, they may become better.
    above = (level > 2) & (level < n) & (one.points[:, 0] > 0) & (one.points[:, 0] < n)
    one.points[above] += np.random.default_rng(0).uniform(-0.3, 0.3, (above.sum(), 2))
    lower = lambda middles: middles[:, 1] < 1e-9  # noqa: E731

    def up(mesh, edges, middles):
        return np.outer(lower(middles) * bulge, [0, 1])

    return of_second_order(one, up)


def test_cells_that_would_become_invalid_are_refused(caplog):
    of = crossed()
    assert check(of).is_valid
    result = optimized(of)
    assert "would become invalid" in caplog.text
    assert jacobians(result).min() > 0
    assert rim(result) == rim(of)
    free = optimized(of_second_order(corners_only(of)[0]))  # the same with straight sides
    corners = [corners_only(one)[0].points.tobytes() for one in (of, result, free)]
    assert len(set(corners)) == 3


@examples(10)
@given(seed=st.integers(0, 2**16), bulge=st.floats(-0.25, 0.25), n=st.integers(2, 4))
def test_no_cell_at_a_curved_boundary_becomes_invalid(seed, bulge, n):
    """Any bulge that the cells of the input bear is borne by those of the result."""
    one = shaken(tet_grid(n), 0.3, seed)
    one.points -= 0.5
    of = of_second_order(one, bulging(bulge))
    assume(abs(bulge) > 1e-3 and jacobians(of).min() > 1e-3)
    for policy in (Fixed(), Slide()):
        result = optimized(of, policy)
        assert rim(result) == rim(of)
        assert jacobians(result).min() > 0


def test_invalid_cells_at_curved_edges_are_mended_where_better_cells_do(caplog):
    """As flat cells at a curved boundary are, which meshers leave behind."""
    one = disc(4)
    inner = np.flatnonzero(np.linalg.norm(one.points, axis=1) < 0.8)
    one.points[inner[-1]] *= 1.28
    of = of_second_order(one, bulging(-0.05))
    assert check(of).codes == ("M105",)
    result = optimized(of)
    assert "better cells are to mend that" in caplog.text
    assert jacobians(result).min() > 0
    assert rim(result) == rim(of)
    assert check(result).is_valid


def test_invalid_cells_that_stay_invalid_are_refused():
    of = of_second_order(disc(3), bulging(0.3, lambda m: np.hypot(*m.T) < 0.4))
    assert check(of).codes == ("M105",)
    with pytest.raises(InvalidMeshError, match="stay invalid"):
        optimized(of)


@pytest.mark.parametrize("make", [lambda: disc(4), lambda: shaken(tet_grid(3), 0.1)])
def test_curved_edges_inside_stay_with_their_ends(make, caplog):
    one = make()
    one.points -= one.points.mean(axis=0)
    near = np.sort(np.linalg.norm(one.points, axis=1))[8]
    bent = bulging(0.08, lambda middles: np.linalg.norm(middles, axis=1) < near)
    of = of_second_order(one, bent)
    straight = middles_by_place(of_second_order(one))
    curved = {k: v for k, v in middles_by_place(of).items() if straight[k] != v}
    assert len(curved) > 3
    result = optimized(of)
    assert "edges inside the mesh that are curved" in caplog.text
    assert curved.items() <= middles_by_place(result).items()
    assert check(result).is_valid


def test_a_curved_facet_between_coplanar_corners_does_not_slide():
    """Its corners lie in a side of the box, its middle nodes do not."""
    one = shaken(tet_grid(3), 0.2)
    edges = boundary_edges(one)
    middles = one.points[edges].mean(axis=1)
    on_top = np.flatnonzero((middles[:, 2] == 1) & (np.abs(middles[:, :2] - 0.5) < 0.3).all(axis=1))
    chosen = middles[on_top[0]]

    def lift(mesh, edges, middles):
        return np.outer((middles == chosen).all(axis=1) * 0.03, [0, 0, 1])

    of = of_second_order(one, lift)
    lifted = {k: v for k, v in middles_by_place(of).items() if v[2] > 1}
    assert len(lifted) == 1
    (edge,) = lifted
    result = optimized(of, Slide())
    assert lifted.items() <= middles_by_place(result).items()

    def facets_at(two):
        corners, _ = corners_only(two)
        cells = corners.blocks[0].cells
        rows = np.concatenate([np.delete(cells, k, axis=1) for k in range(4)])
        rows, times = np.unique(np.sort(rows, axis=1), axis=0, return_counts=True)
        places = [frozenset(map(tuple, corners.points[row].tolist())) for row in rows[times == 1]]
        return {place for place in places if edge <= place}

    assert facets_at(result) == facets_at(of)
    assert check(result).is_valid


def test_cells_listed_the_other_way_round_are_turned(caplog):
    one = shaken(tet_grid(3), 0.2)
    over = turned_over(one)
    half = replace(one, blocks=[replace(one.blocks[0], cells=one.blocks[0].cells.copy())])
    half.blocks[0].cells[::2] = over.blocks[0].cells[::2]
    wanted = optimized(of_second_order(one, bulging(0.02)))
    for turned in (over, half):
        result = optimized(of_second_order(turned, bulging(0.02)))
        assert "turned" in caplog.text
        assert rim(result) == rim(wanted)
        assert jacobians(result).min() > 0


WEDGE = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]


def with_wedge():
    of = of_second_order(tet_grid(1))
    points = np.concatenate([of.points, np.random.default_rng(0).random((15, 3)) + 5])
    block = Block("wedge15", len(of.points) + np.arange(15)[None])
    return Mesh(points, [*of.blocks, block])


def of_both_orders():
    one = tet_grid(1)
    cells = one.blocks[0].cells
    parts = [Block("tetra", cells[:3]), Block("triangle", cells[3:, :3])]
    two = of_second_order(Mesh(one.points, [Block("tetra", cells[3:])]))
    return Mesh(two.points, [parts[0], *two.blocks])


def lifted():
    """Corners in a plane, a middle node out of it."""
    of = in_space(of_second_order(tri_grid(2)))
    of.points[-1, 2] = 0.05
    return of


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lifted, "middle nodes"),
        (lambda: replace(of_second_order(tri_grid(1)), blocks=[
            Block("triangle7", np.array([[0, 1, 2, 4, 5, 6, 3]]))]), "triangle7"),
    ],
    ids=["out of its plane", "seven nodes"],
)  # fmt: skip
def test_what_is_not_taken(make, said):
    with pytest.raises(UnsupportedMeshError, match=said):
        optimized(make())


@pytest.mark.parametrize("make", [with_wedge, of_both_orders])
def test_other_cells_beside_are_refused(make):
    with pytest.raises((UnsupportedMeshError, BadMeshError)):
        optimized(make())


def test_middle_nodes_that_do_not_match_are_refused():
    of = of_second_order(tri_grid(2))
    points = np.concatenate([of.points, of.points[of.blocks[0].cells[0, 5]][None] + 0.01])
    of.blocks[0].cells[0, 5] = len(of.points)
    with pytest.raises(InvalidMeshError, match="M106"):
        optimized(replace(of, points=points))
