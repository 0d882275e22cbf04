"""Passes are values: what was visited belongs to the mesh, and is gone back to with it."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, fields
from threading import Barrier

import numpy as np
import pytest

from meshopt_cli.passes import PASSES
from meshopt_cli.passes.mend import Mend
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.swap import Swap
from meshopt_cli.plans.angles import WithAngles
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.plans.stages import Outcome, Repeat, Sequence
from meshopt_cli.plans.stop import Stop
from support.invariants import snapshot, workspace
from support.samples import sample

every_pass = pytest.mark.parametrize("kind", PASSES.values(), ids=lambda kind: kind.name)


# Spoils a good mesh, and so has it gone back to.
CARELESS = Smooth(method="laplace", accept="valid", relaxation=1.0)


@pytest.fixture
def work():
    return workspace(sample("raw_ball.mesh"))


@every_pass
def test_a_pass_is_a_value(kind):
    step = kind()
    assert step == kind()
    assert hash(step) == hash(kind())
    for option in fields(kind):
        with pytest.raises(FrozenInstanceError):
            setattr(step, option.name, option.default)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_pipeline_can_be_sent_away(preset):
    """As bytes, to another process."""
    pipeline = plan_for(Request(preset=preset)).pipeline
    assert pickle.loads(pickle.dumps(pipeline)) == pipeline


def test_a_run_leaves_a_pipeline_as_it_was(work):
    pipeline = plan_for(Request(preset="fast")).pipeline
    before = pickle.dumps(pipeline)
    pipeline.run(work)
    assert pickle.dumps(pipeline) == before


@pytest.mark.parametrize("name", ["raw_ball.mesh", "quadtree.vtk"])
def test_threads_share_a_pipeline(name):
    """Each with a mesh of its own: all of them make of it what one alone does."""
    source = sample(name)
    pipeline = plan_for(Request(preset="standard"), source.dimension).pipeline
    start = Barrier(4)

    def optimized(_):
        own = workspace(source)
        start.wait()
        result, origin = pipeline.run(own).work.result()
        return result.points.tobytes(), result.cells.tobytes(), origin.tobytes()

    with ThreadPoolExecutor(4) as threads:
        results = list(threads.map(optimized, range(4)))
    alone = Barrier(1)
    start = alone
    assert set(results) == {optimized(0)}


def test_visits_go_back_with_the_mesh(work):
    """A copy knows what was visited when it was made, whatever the other is put through since."""
    step = Mend(worse_than=1.8)
    step.run(work)
    kept = work.copy()
    values = {key: np.array(value) for key, value in kept.visits.items()}
    Smooth().run(work)
    step.run(work)
    assert kept.visits.keys() == values.keys()
    assert all(np.array_equal(kept.visits[key], values[key]) for key in values)
    assert any(not np.array_equal(work.visits[key], values[key]) for key in values)


def test_equal_passes_share_what_they_visited(work):
    while Swap().run(work).applied:
        pass
    assert Swap().run(work).visited == 0
    assert Swap(worse_than=1.5).run(work).visited > 0


@pytest.fixture
def good():
    """A mesh that careless work spoils."""
    pipeline = plan_for(Request(preset="fast")).pipeline
    work = pipeline.run(workspace(sample("raw_ball.mesh"))).work
    work.visits = {}
    return work


def settle(work, step):
    """Run a pass until it finds nothing more to do."""
    while step.run(work).applied:
        pass


def test_another_measure_lets_a_pass_visit_all_again(good):
    step = Swap()
    settle(good, step)
    outcome = Outcome(good)
    WithAngles(Sequence((step,))).run(outcome)
    assert outcome.lines[0].tally.visited > 0


@pytest.mark.parametrize("spoilt", [True, False], ids=["goes back", "goes on"])
def test_visits_by_another_measure_are_none_by_the_first(good, spoilt):
    """After a stage with angles a pass visits what one that was no part of it visits."""
    step = Smooth(sweeps=1)
    settle(good, step)
    stage = WithAngles(Sequence((step, CARELESS) if spoilt else (step,)))
    outcome = Outcome(good.copy())
    stage.run(outcome)
    assert outcome.lines[0].tally.applied > 0
    assert (outcome.work.mesh.points.tobytes() == good.mesh.points.tobytes()) == spoilt
    expected = outcome.work.copy()
    expected.visits = dict(good.visits)
    assert step.run(outcome.work).visited == step.run(expected).visited
    assert snapshot(outcome.work) == snapshot(expected)


def test_what_was_not_visited_before_a_stage_is_visited_after_it(good):
    """Though the stage visited it, by another measure, and was for nothing."""
    step = Smooth(sweeps=1)
    outcome = Outcome(good.copy())
    WithAngles(Sequence((step, CARELESS))).run(outcome)
    assert step.run(outcome.work).visited == step.run(good).visited > 0


def test_rounds_that_go_back_take_the_visits_with_them(good):
    step = Swap()
    settle(good, step)
    outcome = Outcome(good.copy())
    Repeat(Sequence((CARELESS, step, CARELESS)), Stop(rounds=1)).run(outcome)
    assert outcome.lines[1].tally.visited > 0
    assert outcome.work.mesh.points.tobytes() == good.mesh.points.tobytes()
    assert step.run(outcome.work).visited == 0
