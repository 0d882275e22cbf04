"""Every operator does what its simulation said, or nothing at all (18.6)."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from meshopt_cli.kernels import accept
from meshopt_cli.kernels.types import APPLIED, FIXED, INVALID, NOT_BETTER
from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality.measures import OF_SIMPLICES
from support.edits import declaring_some, halves, shaken
from support.invariants import workspace
from support.meshes import (
    hexagon,
    hollow_icosahedron,
    hollow_polygon,
    icosahedron,
    spindle,
    tet_grid,
    tri_grid,
)
from support.operators import (
    ANY_SWAP,
    EDGE_SWAP,
    ENDS,
    FACE_REMOVAL,
    FACE_SWAP,
    FLIP,
    INSERTION,
    MIDPOINT,
    RELOCATIONS,
    RULES,
    attempt,
    attempts,
    shaken_workspace,
)


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


@pytest.mark.parametrize("patch", [hollow_polygon(6), hollow_icosahedron()], ids=["plane", "space"])
def test_insertion(patch):
    """The vertex in the middle that a polygon or a polyhedron lacks is found."""
    work = workspace(patch)
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
    verdicts = attempts(work, INSERTION, rule)
    assert verdicts[APPLIED] > 0
    assert verdicts[NOT_BETTER] > 0


def everything(work):
    """The operators of a mesh whose rule can be chosen."""
    yield from (op for name, op in RELOCATIONS.items() if name != "optimize")
    yield from (ENDS, MIDPOINT)
    yield from (FLIP,) if work.dimension == 2 else (FACE_SWAP, EDGE_SWAP)


PLAIN = {
    "squares": tri_grid(3),
    "hexagon": hexagon(2),
    "cubes": tet_grid(3),
    "octahedron": spindle(4),
    "icosahedron": icosahedron(),
}


def verdicts_of_all(work, rule, floor):
    """Number of times each verdict came out, over all places and operators."""
    return Counter(
        attempt(work, operator, handle, rule, floor)
        for operator in everything(work)
        for handle in operator.handles(work)
    )


@pytest.mark.parametrize("rule", [accept.RATIO, accept.FLOOR])
@pytest.mark.parametrize("name", PLAIN)
def test_at_the_limit(name, rule):
    """Cells of equal quality: what is exactly as good as before is no reason for a change."""
    verdicts = verdicts_of_all(workspace(PLAIN[name]), rule, 1.0)
    assert verdicts[NOT_BETTER] > 0
    assert verdicts[APPLIED] == 0


@pytest.mark.parametrize("name", PLAIN)
def test_flat_cells_are_no_cells(name):
    """The most tolerant rule still wants cells that are positive beyond rounding."""
    verdicts = verdicts_of_all(workspace(PLAIN[name]), accept.VALID, 0.0)
    assert verdicts[APPLIED] > 0
    assert verdicts[INVALID] + verdicts[NOT_BETTER] > 0


@pytest.mark.parametrize("name", ["laplace", "weighted", "quality-uniform"])
@pytest.mark.parametrize("patch", [hexagon(1), icosahedron()])
def test_standing_still_is_no_change(patch, name):
    """A vertex that is where it should be is not applied: rounds would never end."""
    work = workspace(patch)
    for rule in ("no-worse", "floor", "valid"):
        plan = RELOCATIONS[name].simulate(work, 0, *RULES[rule])
        moved = np.linalg.norm(np.array(plan.position) - work.mesh.points[0])
        assert plan.verdict != APPLIED or moved > 1e-9


@pytest.mark.parametrize("measure", OF_SIMPLICES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_measure(dimension, measure):
    """Plans tell the truth whatever measures quality."""
    work = shaken_workspace(dimension, 6, measure)
    for operator in (RELOCATIONS["optimize"], FLIP if dimension == 2 else EDGE_SWAP):
        assert attempts(work, operator, "strict")[APPLIED] > 0


@pytest.mark.parametrize("dimension", [2, 3])
def test_declared_entities_stay(dimension):
    """Operators keep the vertices, edges and facets of the file, and every interface."""
    grid = halves(tri_grid(5)) if dimension == 2 else tet_grid(3)
    source = cast(declaring_some(shaken(grid, 0.8, 7)))
    assert source.fixed.any()
    assert len(source.edges if dimension == 3 else source.facets)
    work = workspace(source)
    work.reserve_points(work.n_input_points + 1)
    for operator in (*everything(work), INSERTION):
        rule = "strict" if operator is INSERTION else "valid"
        attempts(work, operator, rule)
