"""How good a mesh is, is looked for again where it has changed, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.passes import PASSES
from meshopt_cli.work.standing import standing_of
from support.invariants import workspace
from support.samples import sample


def looked_for(work):
    """The standing of a mesh from its cells as they are."""
    return standing_of(work.mesh.quality[work.living()].copy())


@pytest.mark.parametrize("name", ["raw_ball.mesh", "quadtree.vtk"])
@pytest.mark.parametrize("kind", PASSES.values(), ids=lambda kind: kind.name)
def test_after_a_pass(kind, name):
    work = workspace(sample(name))
    for _ in range(2):
        before = work.standing()
        kept = work.copy()
        kind().run(work)
        assert work.standing() == looked_for(work)
        assert kept.standing() == looked_for(kept) == before


def test_by_another_judge():
    work = workspace(sample("raw_ball.mesh"))
    judge = work.judge
    work.judge_by(judge._replace(lenience=1.5))
    lenient = work.standing()
    assert lenient == looked_for(work)
    seen = work.judged()
    work.judge_by(judge)
    assert work.standing() == looked_for(work) == work.judged() == seen
    assert lenient != seen


def test_not_looked_for_twice(monkeypatch):
    work = workspace(sample("raw_ball.mesh"))
    first = work.standing()
    work.mesh.quality[:] = np.nan  # it would be noticed
    assert work.standing() is first
