"""Every operator does what its simulation said, or nothing at all (18.6)."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import patches
import pytest
from builders import tet_grid, tri_grid

from meshopt_cli.cells import TET_EDGES
from meshopt_cli.kernels import accept
from meshopt_cli.kernels.operators.collapse import Collapse
from meshopt_cli.kernels.operators.relocate import Relocation
from meshopt_cli.kernels.operators.swap import Swap
from meshopt_cli.kernels.shape import simplex
from meshopt_cli.kernels.types import (
    APPLIED,
    CLOCK,
    FIXED,
    FULL,
    INVALID,
    MAX_BALL,
    MAX_SHELL,
    NOT_BETTER,
    TOO_LARGE,
    TOO_LONG,
)
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes.smooth import METHODS, WEIGHTS
from meshopt_cli.quality.summary import MEASURES
from meshopt_cli.work.workspace import Workspace

RULES = {
    "strict": (accept.STRICT, 0.0),
    "ratio": (accept.RATIO, 0.7),
    "no-worse": (accept.RATIO, 1.0),
    "floor": (accept.FLOOR, 0.3),
    "valid": (accept.VALID, 0.0),
    "mean": (accept.MEAN, 0.4),
}
NOT_VISITED = -1


@dataclass(frozen=True)
class Operator:
    """How to find the handles of an operator, simulate it and apply it."""

    handles: Callable[[Workspace], Iterator[Any]]
    simulate: Callable[[Workspace, Any, int, float], Any]
    apply: Callable[[Workspace, Any, Any], None]


def facet_handles(work):
    for cell in work.living():
        yield from range(4 * cell, 4 * cell + work.dimension + 1)


def edge_handles(work):
    for cell in work.living():
        yield from range(8 * cell, 8 * cell + 6)


def edge_ends(work):
    """Every edge of the mesh, both ways round."""
    edges = adjacency.edges(work.mesh.cells[work.living()], len(work.mesh.points))
    yield from (tuple(int(v) for v in e) for e in np.concatenate([edges, edges[:, ::-1]]))


def relocation(method, weight="quality", relaxation=0.8):
    def simulate(work, vertex, rule, floor):
        how = Relocation(METHODS[method], WEIGHTS[weight], relaxation, rule, floor, 2.0)
        return patches.plan_relocation(work.mesh, vertex, how, work.scratch)

    return Operator(
        lambda work: iter(np.unique(work.mesh.cells[work.living()])),
        simulate,
        lambda work, v, plan: patches.do_relocation(work.mesh, v, plan, work.scratch),
    )


def collapse(midpoint, max_growth=1.5):
    def simulate(work, ends, rule, floor):
        how = Collapse(rule, floor, max_growth, midpoint)
        return patches.plan_collapse(work.mesh, *ends, how, work.scratch)

    return Operator(
        edge_ends,
        simulate,
        lambda work, _, plan: patches.do_collapse(work.mesh, plan, work.scratch),
    )


def apply_swap(work, _, plan):
    patches.do_swap(work.mesh, plan, work.scratch)


FLIP = Operator(
    facet_handles,
    lambda work, handle, *rule: patches.plan_flip(work.mesh, handle, *rule),
    lambda work, _, plan: patches.do_flip(work.mesh, plan, work.scratch),
)
FACE_SWAP = Operator(
    facet_handles,
    lambda work, handle, *rule: patches.plan_face_swap(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
EDGE_SWAP = Operator(
    edge_handles,
    lambda work, handle, *rule: patches.plan_edge_swap(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
FACE_REMOVAL = Operator(
    facet_handles,
    lambda work, handle, *rule: patches.plan_face_removal(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
ANY_SWAP = Operator(
    lambda work: itertools.product(work.living(), range(10)),
    lambda work, place, *rule: patches.plan_any_swap(
        work.mesh, *place, Swap(*rule, False, 0), work.scratch
    ),
    apply_swap,
)
# Under the rule of the mean every cell is good enough for its mean to have to fall.
INSERTION = Operator(
    lambda work: iter(work.living()),
    lambda work, cell, rule, _: patches.plan_insertion(
        work.mesh, cell, -math.inf if rule == accept.MEAN else math.inf, work.scratch
    ),
    lambda work, _, plan: patches.do_insertion(work.mesh, plan, work.scratch),
)
RELOCATIONS = {
    **{method: relocation(method) for method in METHODS if method != "quality"},
    **{f"quality-{weight}": relocation("quality", weight) for weight in WEIGHTS},
}
ENDS, MIDPOINT = collapse(False), collapse(True)


def worst_of(plan):
    return min(plan.q_one, plan.q_other) if hasattr(plan, "q_one") else plan.worst


def in_use(work):
    """Cells by row, each with the coordinates of its corners."""
    mesh = work.mesh
    return {int(row): (mesh.cells[row].tobytes(), mesh.points[mesh.cells[row]].tobytes())
            for row in work.living()}  # fmt: skip


def measured(work, rows):
    """q of some cells, from their vertices."""
    q = np.empty(len(rows))
    cells = np.ascontiguousarray(work.mesh.cells[list(rows)])
    simplex.measure_cells(work.mesh.measure, work.mesh.points, cells, q)
    return q


def is_allowed(rule, floor, before, after):
    """The acceptance rules of 18.5, once more and by themselves."""
    if rule == accept.STRICT:
        return after > before
    if rule == accept.RATIO:
        return after > 0 and after >= floor * before
    if rule in (accept.FLOOR, accept.MEAN):
        return after > 0 and after >= min(floor, before)
    return after > 0


def attempt(work, operator, handle, rule, floor):
    """Simulate an operator at one place and, where it says so, apply it to a copy.

    Returns
    -------
    verdict : int
    """
    before = patches.snapshot(work)
    plan = operator.simulate(work, handle, rule, floor)
    assert patches.snapshot(work) == before, "a simulation wrote to the mesh"
    if plan.verdict != APPLIED:
        return plan.verdict
    twin = work.copy()
    twin.mesh.state[CLOCK] += 1
    plan = operator.simulate(twin, handle, rule, floor)
    operator.apply(twin, handle, plan)
    old, new = in_use(work), in_use(twin)
    gone = [row for row in old if new.get(row) != old[row]]
    made = [row for row in new if old.get(row) != new[row]]
    patches.assert_kept(work.result()[0], twin)
    if not made:
        return plan.verdict
    worst = worst_of(plan)
    np.testing.assert_allclose(measured(twin, made).min(), worst, rtol=0, atol=1e-10)
    assert twin.mesh.quality[made].min() == pytest.approx(worst, abs=1e-12)
    assert is_allowed(rule, floor, work.mesh.quality[gone].min(), worst)
    if rule == accept.MEAN:
        assert np.mean(1.0 / measured(twin, made)) < np.mean(1.0 / measured(work, gone))
    return plan.verdict


def attempts(work, operator, rule):
    """Number of times each verdict came out, over all places of the mesh."""
    verdicts = Counter()
    for handle in operator.handles(work):
        verdicts[attempt(work, operator, handle, *RULES[rule])] += 1
    return verdicts


def shaken_workspace(dimension, seed, measure="aspect-ratio"):
    """A small grid whose inner vertices are badly placed, with room for more vertices."""
    grid = tri_grid(5) if dimension == 2 else tet_grid(3)
    return patches.workspace(patches.shaken(grid, 0.3, seed), measure)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", RELOCATIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_relocation(dimension, name, rule):
    """Every way to relocate under every rule; `optimize` may only improve, whatever the rule."""
    work = shaken_workspace(dimension, 1)
    chosen = "strict" if name == "optimize" else rule
    verdicts = attempts(work, RELOCATIONS[name], chosen)
    assert verdicts[APPLIED] > 0
    assert verdicts[FIXED] == np.count_nonzero(work.mesh.fixed[: work.n_input_points])


@pytest.mark.parametrize("rule", RULES)
def test_flip(rule):
    """Flips all over a grid."""
    verdicts = attempts(shaken_workspace(2, 2), FLIP, rule)
    assert verdicts[APPLIED] > 0
    assert verdicts[FIXED] > 0
    assert verdicts[NOT_BETTER] > 0 or rule == "valid"


@pytest.mark.parametrize("rule", [rule for rule in RULES if rule != "mean"])
@pytest.mark.parametrize(
    "operator", [FACE_SWAP, EDGE_SWAP, FACE_REMOVAL], ids=["face", "edge", "faces"]
)
def test_swap(operator, rule):
    """Swaps of faces and edges all over a grid."""
    verdicts = attempts(shaken_workspace(3, 3), operator, rule)
    assert verdicts[APPLIED] > 0
    assert verdicts[FIXED] > 0
    assert verdicts[NOT_BETTER] > 0 or rule == "valid"


@pytest.mark.parametrize("rule", RULES)
def test_any_swap(rule):
    """The swaps that a sweep chooses from, the mean of theirs included."""
    verdicts = attempts(shaken_workspace(3, 3), ANY_SWAP, rule)
    assert verdicts[APPLIED] > 0


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("operator", [ENDS, MIDPOINT], ids=["ends", "midpoint"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_collapse(dimension, operator, rule):
    """Collapses onto either end and onto the middle, of every edge of a grid."""
    verdicts = attempts(shaken_workspace(dimension, 4), operator, rule)
    assert verdicts[APPLIED] > 0
    assert verdicts[FIXED] > 0


@pytest.mark.parametrize(
    "patch", [patches.hollow_polygon(6), patches.hollow_icosahedron()], ids=["plane", "space"]
)
def test_insertion(patch):
    """The vertex in the middle that a polygon or a polyhedron lacks is found."""
    work = patches.workspace(patch)
    work.reserve_points(len(patch.points) + 1)
    while len(work.mesh.cells) < 64:
        work.grow()
    verdicts = attempts(work, INSERTION, "strict")
    assert verdicts[APPLIED] > 0


@pytest.mark.parametrize("rule", ["strict", "mean"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_insertion_anywhere(dimension, rule):
    """A new vertex in any cell of a grid keeps everything else."""
    work = shaken_workspace(dimension, 5)
    work.reserve_points(work.n_input_points + 1)
    attempts(work, INSERTION, rule)


def everything(work):
    """The operators of a mesh whose rule can be chosen."""
    yield from (op for name, op in RELOCATIONS.items() if name != "optimize")
    yield from (ENDS, MIDPOINT)
    yield from (FLIP,) if work.dimension == 2 else (FACE_SWAP, EDGE_SWAP)


PLAIN = {
    "squares": tri_grid(3),
    "hexagon": patches.hexagon(2),
    "cubes": tet_grid(3),
    "octahedron": patches.spindle(4),
    "icosahedron": patches.icosahedron(),
}


@pytest.mark.parametrize("rule", [accept.RATIO, accept.FLOOR])
@pytest.mark.parametrize("name", PLAIN)
def test_at_the_limit(name, rule):
    """Cells of equal quality: what is exactly as good as before hides nothing that is worse."""
    work = patches.workspace(PLAIN[name])
    for operator in everything(work):
        for handle in operator.handles(work):
            attempt(work, operator, handle, rule, 1.0)


@pytest.mark.parametrize("name", PLAIN)
def test_flat_cells_are_no_cells(name):
    """The most tolerant rule still wants cells that are positive beyond rounding."""
    work = patches.workspace(PLAIN[name])
    for operator in everything(work):
        for handle in operator.handles(work):
            attempt(work, operator, handle, accept.VALID, 0.0)


@pytest.mark.parametrize("name", ["laplace", "weighted", "quality-uniform"])
@pytest.mark.parametrize("patch", [patches.hexagon(1), patches.icosahedron()])
def test_standing_still_is_no_change(patch, name):
    """A vertex that is where it should be is not applied: rounds would never end."""
    work = patches.workspace(patch)
    for rule in ("no-worse", "floor", "valid"):
        plan = RELOCATIONS[name].simulate(work, 0, *RULES[rule])
        moved = np.linalg.norm(np.array(plan.position) - work.mesh.points[0])
        assert plan.verdict != APPLIED or moved > 1e-9


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_measure(dimension, measure):
    """Plans tell the truth whatever measures quality."""
    work = shaken_workspace(dimension, 6, measure)
    for operator in (RELOCATIONS["optimize"], FLIP if dimension == 2 else EDGE_SWAP):
        assert attempts(work, operator, "strict")[APPLIED] > 0


# By name --------------------------------------------------------------------------------


def plan_at(patch, operator, handle, rule="strict"):
    """The plan for one place of a patch."""
    return operator.simulate(patches.workspace(patch), handle, *RULES[rule])


def applied(work, operator, handle, rule="valid"):
    """Apply an operator in place, whatever it does to quality."""
    plan = operator.simulate(work, handle, *RULES[rule])
    assert plan.verdict == APPLIED
    operator.apply(work, handle, plan)
    patches.assert_whole(work)


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
    work = patches.workspace(patches.spindle(n, shake=0.1, seed=n))
    handle = axis_handle(work)
    assert attempt(work, EDGE_SWAP, handle, *RULES["valid"]) == APPLIED
    applied(work, EDGE_SWAP, handle)
    assert work.n_cells == 2 * (n - 2)
    assert not any({0, 1} <= cell for cell in cell_sets(work))


@pytest.mark.parametrize("n", [4, 5, 6, 7])
def test_long_spindle_improves(n):
    """The axis of a long spindle is worth removing."""
    work = patches.workspace(patches.spindle(n, height=0.2 * n + 1, shake=0.05))
    before = work.standing()
    applied(work, EDGE_SWAP, axis_handle(work), "strict")
    assert work.standing().worst > before.worst


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_open_spindle(n):
    """The faces inside an open shell go; its edge and its two outer faces stay."""
    work = patches.workspace(patches.open_spindle(n, 3 * n))
    source = work.result()[0]
    handle = axis_handle(work)
    assert attempt(work, EDGE_SWAP, handle, *RULES["valid"]) == APPLIED
    applied(work, EDGE_SWAP, handle)
    assert work.n_cells == 2 * n - 1
    assert sum({0, 1} <= cell for cell in cell_sets(work)) == 1
    patches.assert_kept(source, work)


def test_open_spindle_that_is_too_wide():
    """More than half a spindle has no room for the tet between its outer faces."""
    work = patches.workspace(patches.open_spindle(4, 7))
    assert attempt(work, EDGE_SWAP, axis_handle(work), *RULES["valid"]) == INVALID


@pytest.mark.parametrize("n", [3, 5])
def test_removal_of_the_faces_of_a_spindle(n):
    """What the removal of an edge made, the removal of faces undoes at once."""
    work = patches.workspace(patches.spindle(n, shake=0.1, seed=n))
    before = cell_sets(work)
    applied(work, EDGE_SWAP, axis_handle(work))
    for handle in facet_handles(work):
        plan = FACE_REMOVAL.simulate(work, handle, *RULES["valid"])
        if plan.verdict == APPLIED and plan.n_new == n:
            FACE_REMOVAL.apply(work, handle, plan)
            break
    assert sorted(map(sorted, cell_sets(work))) == sorted(map(sorted, before))


def test_spindle_is_seen_from_its_worst_tet_only():
    work = patches.workspace(patches.spindle(6, shake=0.2))
    seen = [EDGE_SWAP.simulate(work, 8 * c + 0, *RULES["valid"]).verdict for c in range(6)]
    assert [c for c in range(6) if seen[c] != NOT_VISITED] == [axis_handle(work) // 8]


def test_spindle_too_large():
    """A shell that fits is swapped; one tet more, and it has a verdict of its own."""
    fits = patches.workspace(patches.spindle(MAX_SHELL))
    assert EDGE_SWAP.simulate(fits, axis_handle(fits), *RULES["valid"]).verdict != TOO_LARGE
    more = patches.workspace(patches.spindle(MAX_SHELL + 1))
    assert attempt(more, EDGE_SWAP, axis_handle(more), *RULES["valid"]) == TOO_LARGE


@pytest.mark.parametrize("operator", [RELOCATIONS["laplace"], ENDS], ids=["relocation", "collapse"])
def test_ball_too_large(operator):
    """A ball that fits is worked on; one cell more, and it has a verdict of its own."""
    handle = (0, 1) if operator is ENDS else 0
    assert plan_at(patches.fan(MAX_BALL, (0.4, 0)), operator, handle).verdict != TOO_LARGE
    assert plan_at(patches.fan(MAX_BALL + 1, (0.4, 0)), operator, handle).verdict == TOO_LARGE


def test_face_swap_and_back():
    """Two tets become three, and the swap of the new edge brings the two back."""
    work = patches.workspace(patches.double_pyramid(0.2))
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
        (patches.double_pyramid(2**0.5), NOT_BETTER),
        (patches.double_pyramid(0.2, 1.5), INVALID),
        (patches.halves(patches.double_pyramid(0.2)), APPLIED),
        (patches.with_regions(patches.double_pyramid(0.2), [1, 2]), FIXED),
    ],
    ids=["regular", "not convex", "one region", "two regions"],
)
def test_face_swap_verdicts(patch, verdict):
    assert attempt(patches.workspace(patch), FACE_SWAP, 3, *RULES["strict"]) == verdict


def test_flip_twice():
    """A flip takes the other diagonal; a second one takes the first again."""
    work = patches.workspace(patches.diamond(0.5))
    before = cell_sets(work)
    applied(work, FLIP, 2, "strict")
    assert cell_sets(work) == {frozenset({2, 3, 0}), frozenset({2, 3, 1})}
    handle = next(h for h in range(7) if work.mesh.neighbours[h >> 2, h & 3] >= 0)
    applied(work, FLIP, handle, "valid")
    assert cell_sets(work) == before


@pytest.mark.parametrize(
    ("patch", "verdict"),
    [
        (patches.diamond(2.0), NOT_BETTER),
        (patches.diamond(0.5, 1.5), INVALID),
        (patches.diamond(0.5, 1.0), INVALID),
        (patches.with_regions(patches.diamond(0.5), [1, 2]), FIXED),
    ],
    ids=["better as it is", "not convex", "in line", "two regions"],
)
def test_flip_verdicts(patch, verdict):
    assert attempt(patches.workspace(patch), FLIP, 2, *RULES["strict"]) == verdict


@pytest.mark.parametrize("ball", [patches.fan(6, (0.6, 0.2)), patches.icosahedron((0.5, 0.3, 0.2))])
@pytest.mark.parametrize("name", RELOCATIONS)
def test_relocation_into_the_middle(ball, name):
    """Every method brings the vertex of a regular ball nearer to its centre."""
    work = patches.workspace(ball)
    applied(work, RELOCATIONS[name], 0, "strict")
    assert np.linalg.norm(work.mesh.points[0]) < np.linalg.norm(ball.points[0])


def test_collapse_growth():
    """No edge may grow beyond the limit, whatever quality gains."""
    work = patches.workspace(patches.fan(8, (0.9, 0.1)))
    assert attempt(work, collapse(False, 10.0), (0, 1), *RULES["valid"]) == APPLIED
    assert attempt(work, collapse(False, 0.5), (0, 1), *RULES["valid"]) == TOO_LONG


def test_no_room():
    """Without rows for another tet the swap waits, and is applied when there are some."""
    work = patches.workspace(patches.double_pyramid(0.2))
    full = work.mesh.state[0]
    work.mesh.state[0] = len(work.mesh.cells)
    assert FACE_SWAP.simulate(work, 3, *RULES["strict"]).verdict == FULL
    work.mesh.state[0] = full
    work.grow()
    applied(work, FACE_SWAP, 3, "strict")


# What must stay -------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
def test_declared_entities_stay(dimension):
    """Operators keep the vertices, edges and facets of the file, and every interface."""
    grid = patches.halves(tri_grid(5)) if dimension == 2 else tet_grid(3)
    source = cast(patches.declaring_some(patches.shaken(grid, 0.2, 7)))
    assert source.fixed.any()
    assert len(source.edges if dimension == 3 else source.facets)
    work = patches.workspace(source)
    work.reserve_points(work.n_input_points + 1)
    for operator in (*everything(work), INSERTION):
        rule = "strict" if operator is INSERTION else "valid"
        attempts(work, operator, rule)


def test_required_edge_of_a_spindle():
    """A declared edge is not swapped away, and its ends neither move nor vanish."""
    work = patches.workspace(patches.declaring(patches.spindle(5, height=3.0), line=[[1, 0]]))
    assert attempt(work, EDGE_SWAP, axis_handle(work), *RULES["valid"]) == FIXED


@pytest.mark.parametrize("operator", [RELOCATIONS["laplace"], ENDS])
def test_declared_vertex_of_a_ball(operator):
    """A declared vertex neither moves nor vanishes."""
    work = patches.workspace(patches.declaring(patches.fan(6, (0.6, 0.2)), vertex=[[0]]))
    handle = (0, 1) if operator is ENDS else 0
    assert attempt(work, operator, handle, *RULES["valid"]) == FIXED
