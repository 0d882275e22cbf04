"""Over-constrained entities (Definitions 18.8, 18.9) get a vertex inside."""

from __future__ import annotations

import pytest

from meshopt_cli import validity
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes import PASSES
from meshopt_cli.passes.split import over_constrained
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.stages import Repeat, Sequence
from meshopt_cli.plans.stop import Stop
from meshopt_cli.progress.observer import Silent
from support.edits import shaken
from support.invariants import assert_kept, workspace
from support.meshes import hollow_icosahedron, spindle, tet_grid, tri_grid


def constrained(simplices):
    """Codes of what is over-constrained in the cells of a workspace's result."""
    kind = "tetra" if simplices.dimension == 3 else "triangle"
    points = simplices.points[:, : simplices.dimension]
    mesh = Mesh(points, [Block(kind, simplices.cells)])
    return validity.check(mesh, select=["M3"]).codes


PATCHES = {
    "corner of a square": tri_grid(1),
    "grid of triangles": tri_grid(3),
    "cube": tet_grid(1),
    "grid of tetrahedra": tet_grid(2),
    "shell": spindle(5),
    "hollow": hollow_icosahedron(),
}


@pytest.mark.parametrize("name", PATCHES)
def test_none_is_left(name):
    source = cast(PATCHES[name])
    assert constrained(source)
    work = workspace(source)
    PASSES["split"](constrained=0.01, max_vertices=4.0, worst="free").run(work, Silent())
    assert_kept(source, work)
    assert over_constrained(work) == 0
    after, _ = work.result()
    assert not constrained(after)
    assert len(after.points) > len(source.points)


def test_the_bound_on_vertices_holds():
    source = cast(tet_grid(2))
    work = workspace(source)
    PASSES["split"](constrained=0.01, max_vertices=1.1, worst="free").run(work, Silent())
    assert len(work.result()[0].points) <= 1.1 * len(source.points) + 1


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_a_run_has_fewer_and_no_worse_cells(make):
    source = cast(shaken(make(4), 0.8, 5))
    work = workspace(source)
    before, n_before = work.standing(), over_constrained(work)
    step = PASSES["split"](constrained=0.2, max_vertices=4.0, worse_than=1e6)
    outcome = Pipeline("split", (Repeat(Sequence((step,)), Stop(rounds=1)),)).run(work)
    assert_kept(source, outcome.work)
    assert over_constrained(outcome.work) < 0.5 * n_before
    assert outcome.work.standing().worst >= before.worst * (1 - 1e-9)


def test_not_unless_it_is_asked_for():
    work = workspace(cast(tet_grid(2)))
    assert PASSES["split"](worse_than=1000.0).run(work, Silent()).applied == 0
