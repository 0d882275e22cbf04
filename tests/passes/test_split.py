"""New vertices go where they are needed most."""

from __future__ import annotations

import pytest

from meshopt_cli.passes import PASSES
from support.invariants import assert_kept, workspace
from support.samples import sample


@pytest.mark.parametrize("ratio", [1.02, 1.2, 1.25, 4.0])
def test_many_vertices(ratio):
    """However many may come: the worst Q does not rise, and the bound holds."""
    source = sample("raw_ball.mesh")
    work = workspace(source)
    before = work.standing()
    PASSES["split"](worse_than=1.5, max_vertices=ratio).run(work)
    assert_kept(source, work)
    assert work.standing().worst >= before.worst
    assert len(source.points) < work.n_points <= ratio * len(source.points) + 1


def test_the_worst_cells_get_a_second_chance():
    """Once the mesh has grown much they come first again: not all vertices go to the others."""
    work = workspace(sample("raw_ball.mesh"))
    before = work.standing()
    PASSES["split"](max_vertices=1.2).run(work)
    assert work.standing().worst > 5.0 * before.worst
