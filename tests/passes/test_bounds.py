"""What a part of a mesh cannot know of the whole is given to it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from meshopt_cli.passes import PASSES
from support.invariants import snapshot, workspace
from support.samples import sample


@pytest.fixture
def work():
    return workspace(sample("raw_ball.mesh"))


def test_a_mesh_is_the_whole(work):
    assert work.worst_of_all == work.standing().worst
    assert work.bounds.n_input_vertices == work.n_vertices
    assert work.bounds.n_input_points == work.n_input_points


@pytest.mark.parametrize("name", ["swap", "collapse", "split", "mend"])
def test_told_what_it_knows_a_pass_does_the_same(work, name):
    told = work.copy()
    told.bounds = replace(work.bounds, worst=work.standing().worst)
    counts = PASSES[name]().run(work).counts.tolist()
    # One sweep at a time: the mesh gets better, and what was told does not.
    assert PASSES[name]().run(told).counts.tolist() == counts
    assert snapshot(told) == snapshot(work)


def test_no_cell_becomes_the_worst_of_the_whole(work):
    """A part may get worse by its mean, but not below the worst of all."""
    free, bound = work.copy(), work.copy()
    bound.bounds = replace(work.bounds, worst=1.0)
    step = PASSES["swap"](accept="mean", least_quality=0.0)
    assert step.run(free).applied > step.run(bound).applied


def test_what_is_urgent_in_a_part_may_not_be_in_the_whole(work):
    free, bound = work.copy(), work.copy()
    bound.bounds = replace(work.bounds, worst=1e-6)
    step = PASSES["split"](worse_than=1.5, first_gain=1e3)
    assert step.run(free).applied > 0
    assert step.run(bound).applied == 0


def test_a_share_of_the_vertices(work):
    """Those that may go and those that may come are counted against what is given."""
    few, many = work.copy(), work.copy()
    few.bounds = replace(work.bounds, n_input_vertices=0, n_input_points=0)
    many.bounds = replace(work.bounds, n_input_vertices=10 * work.n_vertices)
    assert PASSES["collapse"]().run(many).applied == 0
    assert PASSES["collapse"]().run(few).applied > 0
    assert PASSES["split"]().run(few).applied == 0
    assert PASSES["split"]().run(many).applied > 0


def test_near_the_target_of_the_whole_no_rings_are_mended(work):
    near = work.copy()
    near.bounds = replace(work.bounds, target=1e6)
    step = PASSES["mend"](worse_than=1.84, max_rings=2)
    assert step.run(near).visited < step.run(work).visited


def test_bounds_go_with_a_copy(work):
    work.bounds = replace(work.bounds, worst=0.25)
    assert work.copy().bounds == work.bounds
