"""Every operator does what its simulation said, or nothing at all (18.6)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import patches
import pytest
from builders import tet_grid, tri_grid

from meshopt_cli import adjacency
from meshopt_cli.kernels import accept, measures
from meshopt_cli.kernels.collapse import Collapse
from meshopt_cli.kernels.relocate import Relocation
from meshopt_cli.kernels.types import (
    APPLIED,
    CLOCK,
    FIXED,
    NOT_BETTER,
)
from meshopt_cli.passes.smooth import METHODS, WEIGHTS
from meshopt_cli.workspace import Workspace

RULES = {
    "strict": (accept.STRICT, 0.0),
    "ratio": (accept.RATIO, 0.7),
    "no-worse": (accept.RATIO, 1.0),
    "floor": (accept.FLOOR, 0.3),
    "valid": (accept.VALID, 0.0),
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
    lambda work, _, plan: patches.do_flip(work.mesh, plan),
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
INSERTION = Operator(
    lambda work: iter(work.living()),
    lambda work, cell, *rule: patches.plan_insertion(work.mesh, cell, work.scratch),
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
    rows = work.living()
    return {int(r): (tuple(c), work.mesh.points[c].tobytes()) for r, c in _rows(work, rows)}


def _rows(work, rows):
    return zip(rows, work.mesh.cells[rows], strict=True)


def measured(work, rows):
    """q of some cells, from their vertices."""
    q = np.empty(len(rows))
    cells = np.ascontiguousarray(work.mesh.cells[list(rows)])
    measures.measure_cells(work.mesh.measure, work.mesh.points, cells, q)
    return q


def is_allowed(rule, floor, before, after):
    """The acceptance rules of 18.5, once more and by themselves."""
    if rule == accept.STRICT:
        return after > before
    if rule == accept.RATIO:
        return after > 0 and after >= floor * before
    if rule == accept.FLOOR:
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
    worst = worst_of(plan)
    if made:
        np.testing.assert_allclose(measured(twin, made).min(), worst, rtol=0, atol=1e-10)
        assert twin.mesh.quality[made].min() == worst
        assert is_allowed(rule, floor, work.mesh.quality[gone].min(), worst)
        # What changed is visited again, and nothing else.
        assert np.all(twin.mesh.cell_clock[made] == twin.mesh.state[CLOCK])
        same = [row for row in new if row not in made]
        assert np.all(twin.mesh.cell_clock[same] == work.mesh.cell_clock[same])
    patches.assert_kept(work.result()[0], twin)
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


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("operator", [FACE_SWAP, EDGE_SWAP], ids=["face", "edge"])
def test_swap(operator, rule):
    """Swaps of faces and edges all over a grid."""
    verdicts = attempts(shaken_workspace(3, 3), operator, rule)
    assert verdicts[APPLIED] > 0
    assert verdicts[FIXED] > 0
    assert verdicts[NOT_BETTER] > 0 or rule == "valid"


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


@pytest.mark.parametrize("dimension", [2, 3])
def test_insertion_anywhere(dimension):
    """A new vertex in any cell of a grid keeps everything else."""
    work = shaken_workspace(dimension, 5)
    work.reserve_points(work.n_input_points + 1)
    attempts(work, INSERTION, "strict")
