"""Rounds and their ends, the guard that keeps the best mesh, rounds of rounds."""

from __future__ import annotations

import numpy as np
import pytest
from patches import sample

from meshopt_cli.passes import Silent
from meshopt_cli.passes.check import Check
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.swap import Swap
from meshopt_cli.pipeline import (
    GAIN_BELOW,
    NO_CHANGE,
    NOTHING_TO_GAIN,
    ROUNDS_DONE,
    TARGET_REACHED,
    TIME_IS_UP,
    Chain,
    Pipeline,
    Repeat,
    Sequence,
    Stop,
)
from meshopt_cli.workspace import Workspace


@pytest.fixture
def work():
    return Workspace(sample("grid.vtk"), 0)


def run(work, *stages, **options):
    return Pipeline("test", stages, **options).run(work)


def test_ends_when_nothing_changes(work):
    outcome = run(work, Repeat(Sequence((Swap(below=1e6),)), Stop()))
    assert outcome.lines[-1].round == 1
    assert outcome.stopped in (NO_CHANGE, NOTHING_TO_GAIN)


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


def test_an_interrupt_leaves_the_mesh_whole(work):
    class Impatient(Silent):
        def advance(self, by):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Smooth().run(work, Impatient())
    Check().run(work, Silent())
