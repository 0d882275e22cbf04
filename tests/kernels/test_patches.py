"""Operators on the smallest patches that show something, by name."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.cells import TET_EDGES
from meshopt_cli.kernels.types import (
    APPLIED,
    FIXED,
    FULL,
    INVALID,
    MAX_BALL,
    MAX_SHELL,
    NOT_BETTER,
    TOO_LARGE,
    TOO_LONG,
)
from support.edits import declaring, halves, with_regions
from support.invariants import assert_kept, assert_whole, workspace
from support.meshes import diamond, double_pyramid, fan, icosahedron, open_spindle, spindle
from support.operators import (
    EDGE_SWAP,
    ENDS,
    FACE_REMOVAL,
    FACE_SWAP,
    FLIP,
    NOT_VISITED,
    RELOCATIONS,
    RULES,
    attempt,
    collapse,
    facet_handles,
)


def plan_at(patch, operator, handle, rule="strict"):
    """The plan for one place of a patch."""
    return operator.simulate(workspace(patch), handle, *RULES[rule])


def applied(work, operator, handle, rule="valid"):
    """Apply an operator in place, whatever it does to quality."""
    plan = operator.simulate(work, handle, *RULES[rule])
    assert plan.verdict == APPLIED
    operator.apply(work, handle, plan)
    assert_whole(work)


def cell_sets(work):
    """The cells as sets of vertices."""
    return {frozenset(cell.tolist()) for cell in work.mesh.cells[work.living()]}


def edge_number(cell, a, b):
    """Local number of an edge of a tet."""
    ends = [{cell[i], cell[j]} for i, j, _, _ in TET_EDGES]
    return ends.index({a, b})


def axis_handle(work):
    """Handle of the axis of a spindle in the worst of its tets."""
    cell = int(np.argmin(work.mesh.quality[work.living()]))
    return 8 * cell + edge_number(work.mesh.cells[cell].tolist(), 0, 1)


@pytest.mark.parametrize("n", range(3, 14))
def test_spindle(n):
    """A shell of n tets becomes 2 (n - 2), around other edges."""
    work = workspace(spindle(n, shake=0.1, seed=n))
    handle = axis_handle(work)
    assert attempt(work, EDGE_SWAP, handle, *RULES["valid"]) == APPLIED
    applied(work, EDGE_SWAP, handle)
    assert work.n_cells == 2 * (n - 2)
    assert not any({0, 1} <= cell for cell in cell_sets(work))


@pytest.mark.parametrize("n", [4, 5, 6, 7])
def test_long_spindle_improves(n):
    """The axis of a long spindle is worth removing."""
    work = workspace(spindle(n, height=0.2 * n + 1, shake=0.05))
    before = work.standing()
    applied(work, EDGE_SWAP, axis_handle(work), "strict")
    assert work.standing().worst > before.worst


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_open_spindle(n):
    """The faces inside an open shell go; its edge and its two outer faces stay."""
    work = workspace(open_spindle(n, 3 * n))
    source = work.result()[0]
    handle = axis_handle(work)
    assert attempt(work, EDGE_SWAP, handle, *RULES["valid"]) == APPLIED
    applied(work, EDGE_SWAP, handle)
    assert work.n_cells == 2 * n - 1
    assert sum({0, 1} <= cell for cell in cell_sets(work)) == 1
    assert_kept(source, work)


def test_open_spindle_that_is_too_wide():
    """More than half a spindle has no room for the tet between its outer faces."""
    work = workspace(open_spindle(4, 7))
    assert attempt(work, EDGE_SWAP, axis_handle(work), *RULES["valid"]) == INVALID


@pytest.mark.parametrize("n", [3, 5])
def test_removal_of_the_faces_of_a_spindle(n):
    """What the removal of an edge made, the removal of faces undoes at once."""
    work = workspace(spindle(n, shake=0.1, seed=n))
    before = cell_sets(work)
    applied(work, EDGE_SWAP, axis_handle(work))
    for handle in facet_handles(work):
        plan = FACE_REMOVAL.simulate(work, handle, *RULES["valid"])
        if plan.verdict == APPLIED and plan.n_new == n:
            FACE_REMOVAL.apply(work, handle, plan)
            break
    assert sorted(map(sorted, cell_sets(work))) == sorted(map(sorted, before))


def test_spindle_is_seen_from_its_worst_tet_only():
    work = workspace(spindle(6, shake=0.2))
    seen = [EDGE_SWAP.simulate(work, 8 * c + 0, *RULES["valid"]).verdict for c in range(6)]
    assert [c for c in range(6) if seen[c] != NOT_VISITED] == [axis_handle(work) // 8]


def test_spindle_too_large():
    """A shell that fits is swapped; one tet more, and it has a verdict of its own."""
    fits = workspace(spindle(MAX_SHELL))
    assert EDGE_SWAP.simulate(fits, axis_handle(fits), *RULES["valid"]).verdict != TOO_LARGE
    more = workspace(spindle(MAX_SHELL + 1))
    assert attempt(more, EDGE_SWAP, axis_handle(more), *RULES["valid"]) == TOO_LARGE


@pytest.mark.parametrize("operator", [RELOCATIONS["laplace"], ENDS], ids=["relocation", "collapse"])
def test_ball_too_large(operator):
    """A ball that fits is worked on; one cell more, and it has a verdict of its own."""
    handle = (0, 1) if operator is ENDS else 0
    assert plan_at(fan(MAX_BALL, (0.4, 0)), operator, handle).verdict != TOO_LARGE
    assert plan_at(fan(MAX_BALL + 1, (0.4, 0)), operator, handle).verdict == TOO_LARGE


def test_face_swap_and_back():
    """Two tets become three, and the swap of the new edge brings the two back."""
    work = workspace(double_pyramid(0.2))
    before = cell_sets(work)
    applied(work, FACE_SWAP, 3, "strict")
    assert cell_sets(work) == {frozenset({3, 4, *pair}) for pair in ((0, 1), (1, 2), (2, 0))}
    for handle in EDGE_SWAP.handles(work):
        plan = EDGE_SWAP.simulate(work, handle, *RULES["valid"])
        if plan.verdict == APPLIED:
            EDGE_SWAP.apply(work, handle, plan)
            break
    assert cell_sets(work) == before


@pytest.mark.parametrize(
    ("patch", "verdict"),
    [
        (double_pyramid(2**0.5), NOT_BETTER),
        (double_pyramid(0.2, 1.5), INVALID),
        (halves(double_pyramid(0.2)), APPLIED),
        (with_regions(double_pyramid(0.2), [1, 2]), FIXED),
    ],
    ids=["regular", "not convex", "one region", "two regions"],
)
def test_face_swap_verdicts(patch, verdict):
    assert attempt(workspace(patch), FACE_SWAP, 3, *RULES["strict"]) == verdict


def test_flip_twice():
    """A flip takes the other diagonal; a second one takes the first again."""
    work = workspace(diamond(0.5))
    before = cell_sets(work)
    applied(work, FLIP, 2, "strict")
    assert cell_sets(work) == {frozenset({2, 3, 0}), frozenset({2, 3, 1})}
    handle = next(h for h in range(7) if work.mesh.neighbours[h >> 2, h & 3] >= 0)
    applied(work, FLIP, handle, "valid")
    assert cell_sets(work) == before


@pytest.mark.parametrize(
    ("patch", "verdict"),
    [
        (diamond(2.0), NOT_BETTER),
        (diamond(0.5, 1.5), INVALID),
        (diamond(0.5, 1.0), INVALID),
        (with_regions(diamond(0.5), [1, 2]), FIXED),
    ],
    ids=["better as it is", "not convex", "in line", "two regions"],
)
def test_flip_verdicts(patch, verdict):
    assert attempt(workspace(patch), FLIP, 2, *RULES["strict"]) == verdict


@pytest.mark.parametrize("ball", [fan(6, (0.6, 0.2)), icosahedron((0.5, 0.3, 0.2))])
@pytest.mark.parametrize("name", RELOCATIONS)
def test_relocation_into_the_middle(ball, name):
    """Every method brings the vertex of a regular ball nearer to its centre."""
    work = workspace(ball)
    applied(work, RELOCATIONS[name], 0, "strict")
    assert np.linalg.norm(work.mesh.points[0]) < np.linalg.norm(ball.points[0])


def test_collapse_growth():
    """No edge may grow beyond the limit, whatever quality gains."""
    work = workspace(fan(8, (0.9, 0.1)))
    assert attempt(work, collapse(False, 10.0), (0, 1), *RULES["valid"]) == APPLIED
    assert attempt(work, collapse(False, 0.5), (0, 1), *RULES["valid"]) == TOO_LONG


def test_no_room():
    """Without rows for another tet the swap waits, and is applied when there are some."""
    work = workspace(double_pyramid(0.2))
    full = work.mesh.state[0]
    work.mesh.state[0] = len(work.mesh.cells)
    assert FACE_SWAP.simulate(work, 3, *RULES["strict"]).verdict == FULL
    work.mesh.state[0] = full
    work.grow()
    applied(work, FACE_SWAP, 3, "strict")


def test_required_edge_of_a_spindle():
    """A declared edge is not swapped away, and its ends neither move nor vanish."""
    work = workspace(declaring(spindle(5, height=3.0), line=[[1, 0]]))
    assert attempt(work, EDGE_SWAP, axis_handle(work), *RULES["valid"]) == FIXED


@pytest.mark.parametrize("operator", [RELOCATIONS["laplace"], ENDS])
def test_declared_vertex_of_a_ball(operator):
    """A declared vertex neither moves nor vanishes."""
    work = workspace(declaring(fan(6, (0.6, 0.2)), vertex=[[0]]))
    handle = (0, 1) if operator is ENDS else 0
    assert attempt(work, operator, handle, *RULES["valid"]) == FIXED
