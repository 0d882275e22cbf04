"""The operators as one kind of thing: find places, simulate, apply, and judge what came out."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from meshopt_cli.kernels import accept, judge
from meshopt_cli.kernels.operators.collapse import Collapsing
from meshopt_cli.kernels.operators.odt import Pull
from meshopt_cli.kernels.operators.relocate import Relocation
from meshopt_cli.kernels.operators.swap import Swapping
from meshopt_cli.kernels.types import APPLIED, CLOCK
from meshopt_cli.mesh import adjacency
from meshopt_cli.passes.odt import densities
from meshopt_cli.passes.smooth import METHODS, WEIGHTS
from meshopt_cli.work.session import Workspace
from support import drivers
from support.edits import shaken
from support.invariants import assert_kept, snapshot, workspace
from support.meshes import tet_grid, tri_grid

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
        return drivers.plan_relocation(work.mesh, vertex, how, work.scratch)

    return Operator(
        lambda work: iter(np.unique(work.mesh.cells[work.living()])),
        simulate,
        lambda work, v, plan: drivers.do_relocation(work.mesh, v, plan, work.scratch),
    )


def pull(relaxation=1.9):
    def simulate(work, vertex, rule, floor):
        how = Pull(relaxation, rule, floor)
        return drivers.plan_pull(work.mesh, vertex, how, densities(work), work.scratch)

    return replace(relocation("laplace"), simulate=simulate)


def collapse(midpoint, max_growth=1.5):
    def simulate(work, ends, rule, floor):
        how = Collapsing(rule, floor, max_growth, midpoint)
        return drivers.plan_collapse(work.mesh, *ends, how, work.scratch)

    return Operator(
        edge_ends,
        simulate,
        lambda work, _, plan: drivers.do_collapse(work.mesh, plan, work.scratch),
    )


def apply_swap(work, _, plan):
    drivers.do_swap(work.mesh, plan, work.scratch)


FLIP = Operator(
    facet_handles,
    lambda work, handle, *rule: drivers.plan_flip(work.mesh, handle, *rule),
    lambda work, _, plan: drivers.do_flip(work.mesh, plan, work.scratch),
)
FACE_SWAP = Operator(
    facet_handles,
    lambda work, handle, *rule: drivers.plan_face_swap(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
EDGE_SWAP = Operator(
    edge_handles,
    lambda work, handle, *rule: drivers.plan_edge_swap(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
FACE_REMOVAL = Operator(
    facet_handles,
    lambda work, handle, *rule: drivers.plan_face_removal(work.mesh, handle, *rule, work.scratch),
    apply_swap,
)
ANY_SWAP = Operator(
    lambda work: itertools.product(work.living(), range(10)),
    lambda work, place, *rule: drivers.plan_any_swap(
        work.mesh, *place, Swapping(*rule, False, 0), work.scratch
    ),
    apply_swap,
)
# Under the rule of the mean every cell is good enough for its mean to have to fall.
INSERTION = Operator(
    lambda work: iter(work.living()),
    lambda work, cell, rule, _: drivers.plan_insertion(
        work.mesh, cell, -math.inf if rule == accept.MEAN else math.inf, work.scratch
    ),
    lambda work, _, plan: drivers.do_insertion(work.mesh, plan, work.scratch),
)
RELOCATIONS = {
    **{method: relocation(method) for method in METHODS if method != "quality"},
    **{f"quality-{weight}": relocation("quality", weight) for weight in WEIGHTS},
    "odt": pull(),
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
    judge.measure_cells(work.mesh.judge, work.mesh.points, cells, q)
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
    before = snapshot(work)
    plan = operator.simulate(work, handle, rule, floor)
    assert snapshot(work) == before, "a simulation wrote to the mesh"
    if plan.verdict != APPLIED:
        return plan.verdict
    twin = work.copy()
    twin.mesh.state[CLOCK] += 1
    plan = operator.simulate(twin, handle, rule, floor)
    operator.apply(twin, handle, plan)
    old, new = in_use(work), in_use(twin)
    gone = [row for row in old if new.get(row) != old[row]]
    made = [row for row in new if old.get(row) != new[row]]
    assert_kept(work.result()[0], twin)
    assert made, "what was applied made nothing"
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
    return workspace(shaken(grid, 1.0, seed), measure)
