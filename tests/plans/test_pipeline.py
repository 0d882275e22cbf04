"""Rounds and their ends, the guard that keeps the best mesh, rounds of rounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.kernels.shape.angles import ANGLE_Q, angle_range
from meshopt_cli.kernels.types import CLOCK
from meshopt_cli.passes.check import Check
from meshopt_cli.passes.mend import Mend
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.split import Split
from meshopt_cli.passes.swap import Swap
from meshopt_cli.plans.angles import NEAR_TARGET, WithAngles
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.stages import Chain, Outcome, Repeat, Sequence
from meshopt_cli.plans.stop import (
    GAIN_BELOW,
    NO_CHANGE,
    NOTHING_TO_GAIN,
    ROUNDS_DONE,
    TARGET_REACHED,
    TIME_IS_UP,
    Stop,
)
from meshopt_cli.progress.observer import Silent
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.session import Workspace
from support.samples import sample

ASPECT_RATIO = QUALITIES["aspect-ratio"].judge


@pytest.fixture
def work():
    return Workspace(sample("grid.vtk"), ASPECT_RATIO)


def run(work, *stages, **options):
    return Pipeline("test", stages, **options).run(work)


def test_ends_when_there_was_nothing_to_change(work):
    outcome = run(work, Repeat(Sequence((Swap(worse_than=1e6),)), Stop()))
    assert outcome.lines[-1].round == 1
    assert outcome.stopped == NOTHING_TO_GAIN


def test_ends_when_nothing_changes_any_more():
    """Swaps alone come to an end, however many rounds they may take, and with a gain."""
    outcome = run(
        Workspace(sample("raw_ball.mesh"), ASPECT_RATIO),
        Repeat(Sequence((Swap(),)), Stop(rounds=99, gain=0)),
    )
    assert outcome.stopped == NO_CHANGE
    assert outcome.lines[-1].tally.applied == 0
    assert 1 < outcome.lines[-1].round < 99


def test_ends_when_the_gain_is_small(work):
    outcome = run(work, Repeat(Sequence((Smooth(),)), Stop(rounds=50, gain=0.5)))
    assert outcome.stopped == GAIN_BELOW
    assert outcome.lines[-1].round < 50


def test_ends_when_the_target_is_reached(work):
    outcome = run(work, Repeat(Sequence((Smooth(),)), Stop(rounds=50, gain=0, target_quality=5)))
    assert outcome.stopped == TARGET_REACHED
    assert outcome.work.standing().worst >= 1 / 5


def test_ends_after_the_rounds(work):
    outcome = run(work, Repeat(Sequence((Smooth(sweeps=1),)), Stop(rounds=2, gain=0)))
    assert outcome.stopped == ROUNDS_DONE
    assert outcome.lines[-1].round == 2


def test_ends_when_time_is_up(work):
    stages = Repeat(Sequence((Smooth(),)), Stop(rounds=50, gain=0))
    outcome = run(work, stages, time_limit=0.0)
    assert outcome.stopped in (TIME_IS_UP, NOTHING_TO_GAIN)
    Check().run(outcome.work, Silent())


def test_the_best_mesh_is_kept(work):
    before = work.standing()
    careless = Smooth(method="laplace", accept="valid", relaxation=1.0)
    outcome = run(work, Repeat(Sequence((careless, Smooth(sweeps=1))), Stop(rounds=4, gain=0)))
    ends = [line.standing for line in outcome.lines[1::2]]
    assert not any(end.is_better_than(outcome.work.standing()) for end in (before, *ends))


def test_rounds_of_rounds(work):
    """They go on from each other, and the last of the inner ones tells why it ended."""
    inner = Repeat(Sequence((Smooth(sweeps=1),)), Stop(rounds=50, gain=0.2))
    once = run(work.copy(), inner)
    outcome = run(work, Repeat(Chain((inner, inner)), Stop(rounds=2, gain=0)))
    assert outcome.stopped == once.stopped == GAIN_BELOW
    assert not once.work.standing().is_better_than(outcome.work.standing())
    assert len(outcome.lines) > len(once.lines)


def test_rounds_of_rounds_end_on_the_best_mesh(work):
    careless = Sequence((Smooth(method="laplace", accept="valid", relaxation=1.0),))
    good = Repeat(Sequence((Smooth(),)), Stop(rounds=5))
    alone = run(work.copy(), good).work.standing()
    outcome = run(work, good, Repeat(Chain((careless, careless)), Stop(rounds=3, gain=0)))
    assert not alone.is_better_than(outcome.work.standing())


def test_a_small_gain_gives_the_input_back(work):
    once = run(work, Repeat(Sequence((Smooth(sweeps=20),)), Stop(rounds=50, gain=1e-4))).work
    cells, points = once.mesh.cells.copy(), once.mesh.points.copy()
    again = run(once, Repeat(Sequence((Smooth(sweeps=20),)), Stop(rounds=50, gain=1e-4)))
    assert again.stopped == NOTHING_TO_GAIN
    np.testing.assert_array_equal(again.work.mesh.cells, cells)
    np.testing.assert_array_equal(again.work.mesh.points, points)


def test_late_rounds_visit_what_changed_only(work):
    step = Swap()
    while step.run(work, Silent()).applied:
        pass
    assert step.run(work, Silent()).visited == 0


@pytest.mark.parametrize("name", ["raw_ball.mesh", "quadtree.vtk"])
def test_a_swap_is_tried_again_where_something_changed_only(name):
    """At the edges and faces between vertices of the ball of one that moved, and no others."""
    work = Workspace(sample(name), ASPECT_RATIO)
    step = Swap()
    while step.run(work, Silent()).applied:
        pass
    mesh = work.mesh
    work.next_sweep()
    vertex = int(np.flatnonzero(~mesh.fixed & (mesh.vertex_cell >= 0))[0])
    living = work.living()
    ball = living[(mesh.cells[living] == vertex).any(axis=1)]
    mesh.vertex_clock[mesh.cells[ball]] = mesh.state[CLOCK]
    touched = np.isin(mesh.cells[living], mesh.cells[ball]).sum(axis=1)
    corners = mesh.cells.shape[1]
    # Edges and, in space, faces of a cell that have so many of its vertices.
    places = np.array([[0, 0, 1, 3], [0, 0, 1, 4, 10]][corners - 3])
    tally = step.run(work, Silent())
    assert tally.applied == 0
    assert 0 < tally.visited <= places[touched].sum()
    assert step.run(work, Silent()).visited == 0


def test_a_split_without_promise_is_for_the_urgent_only():
    work = Workspace(sample("raw_ball.mesh"), ASPECT_RATIO)
    urgent = np.count_nonzero(work.mesh.quality[work.living()] <= 1.5 * work.standing().worst)
    step = Split(worse_than=1.5, first_gain=1e3)
    assert 0 < step.run(work.copy(), Silent()).applied <= urgent
    assert replace(step, first_gain=0.0).run(work.copy(), Silent()).applied > urgent


def test_angles_come_first_where_the_worst_is_good_enough():
    """A lenient stage raises the least angle and leaves the worst Q within its limit."""
    work = Workspace(sample("raw_ball.mesh"), ASPECT_RATIO, target=2.5)
    good = Repeat(Sequence((Smooth(), Swap(), Split())), Stop(rounds=8, gain=1e-3))
    work = run(work, good).work
    mend = Mend(worse_than=ANGLE_Q, max_vertices=2.0)
    rounds = Repeat(Sequence((mend, Smooth(worse_than=1.6))), Stop(rounds=6, gain=1e-3))
    outcome = Outcome(work.copy(), Silent())
    WithAngles(rounds, lenient=True).run(outcome)
    assert least_angle(outcome.work) > least_angle(work)
    assert outcome.work.standing().worst >= min(work.standing().worst, 1 / (NEAR_TARGET * 2.5))
    assert outcome.work.judge == outcome.work.mesh.judge == ASPECT_RATIO
    assert outcome.work.bounds.target == 2.5


def test_no_angle_counts_where_the_worst_is_bad(work):
    bad = Workspace(sample("raw_ball.mesh"), ASPECT_RATIO)
    assert not run(bad, WithAngles(Sequence((Smooth(),)), lenient=True)).lines


def least_angle(work):
    return angle_range(work.mesh.points, work.mesh.cells[work.living()])[0]


def test_an_interrupt_leaves_the_mesh_whole(work):
    class Impatient(Silent):
        def advanced(self, by):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Smooth().run(work, Impatient())
    Check().run(work, Silent())
