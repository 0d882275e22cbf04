"""Why a run ends: each reason is said where it is the reason, and no other."""

from __future__ import annotations

import contextlib
import time

import pytest

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes import Budget
from meshopt_cli.passes.check import Check
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.swap import Swap
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.plans.stages import Outcome, Repeat, Sequence
from meshopt_cli.plans.stop import NO_CHANGE, NOTHING_TO_GAIN, TANGLED, TIME_IS_UP, Stop
from meshopt_cli.progress.observer import OutOfTimeError, Silent
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.session import Workspace
from support.edits import shaken
from support.meshes import tet_grid
from support.samples import SAMPLES, sample

ASPECT_RATIO = QUALITIES["aspect-ratio"].judge
FOR_EVER = Repeat(Sequence((Smooth(),)), Stop(rounds=10**6, gain=0))


class Slow(Silent):
    """An observer that takes its time."""

    def advanced(self, by):
        time.sleep(0.02)


@pytest.fixture
def work():
    return Workspace(sample("grid.vtk"), ASPECT_RATIO)


@pytest.mark.parametrize("preset", PRESETS)
def test_no_time_at_all(work, preset):
    """The input comes back, and the reason is the time."""
    chosen = PRESETS[preset]
    points = work.mesh.points.copy()
    outcome = Pipeline(preset, chosen.build(chosen.stops[3], 3), time_limit=0.0).run(work)
    assert outcome.stopped == TIME_IS_UP
    assert outcome.work.mesh.points.tobytes() == points.tobytes()


def test_a_hundredth_of_a_second(work):
    before = work.standing()
    outcome = Pipeline("test", (FOR_EVER,), time_limit=0.01).run(work, Slow())
    assert outcome.stopped == TIME_IS_UP
    assert not before.is_better_than(outcome.work.standing())
    Check().run(outcome.work)


def test_time_enough(work):
    outcome = Pipeline("test", (FOR_EVER,), time_limit=1e6).run(work)
    assert outcome.stopped == NO_CHANGE


def test_a_pass_may_run_out_of_time(work):
    """Its mesh is whole."""
    with pytest.raises(OutOfTimeError):
        Smooth().run(work, Slow(), Budget.of(0.01))
    Check().run(work)


class Spoiling(Sequence):
    """Does harm, and is then out of time or done."""

    late = False

    def run(self, outcome, round=0):
        super().run(outcome, round)
        if self.late:
            raise OutOfTimeError


@pytest.mark.parametrize("guarded", [True, False])
@pytest.mark.parametrize("late", [True, False])
def test_harm_stays_only_where_what_makes_it_good_may_follow(guarded, late):
    """A stage that is cut short ends on the best mesh it saw, guarded or not."""
    work = Workspace(sample("raw_ball.mesh"), ASPECT_RATIO)
    Swap().run(work)
    Smooth().run(work)
    before = work.standing()
    body = Spoiling((Smooth(method="laplace", accept="valid", relaxation=1.0),))
    object.__setattr__(body, "late", late)
    outcome = Outcome(work)
    with pytest.raises(OutOfTimeError) if late else contextlib.nullcontext():
        Repeat(body, Stop(rounds=1), guarded=guarded).run(outcome)
    assert outcome.lines[-1].tally.applied
    is_worse = before.is_better_than(outcome.work.standing())
    assert is_worse == (not guarded and not late)


def test_rounds_without_a_change():
    outcome = Outcome(Workspace(sample("grid.vtk"), ASPECT_RATIO))
    Repeat(Sequence((Swap(worse_than=1e6),)), Stop()).run(outcome)
    assert outcome.stopped == NO_CHANGE
    assert outcome.lines[-1].round == 1


def test_a_pipeline_without_a_change(work):
    outcome = Pipeline("test", (Repeat(Sequence((Swap(worse_than=1e6),)), Stop()),)).run(work)
    assert outcome.stopped == NOTHING_TO_GAIN


def test_a_tangle_that_nothing_mends():
    read, _ = formats.read(SAMPLES / "tangled.vtk")
    audit = Sequence((Check(inverted="allowed"),))
    outcome = Pipeline("test", (audit, FOR_EVER)).run(Workspace(cast(read), ASPECT_RATIO))
    assert outcome.stopped == TANGLED


def test_the_command_line_says_it(tmp_path, capsys):
    """For a limit of nothing, which no work fits in."""
    path = tmp_path / "in.mesh"
    formats.write(path, shaken(tet_grid(3), 1.0, 1), formats.FORMATS["medit"].default)
    arguments = ["optimize", str(path), str(tmp_path / "out.mesh"), "--time-limit", "0"]
    assert status_of(arguments) == 0
    assert "stopped: time limit" in capsys.readouterr().out
