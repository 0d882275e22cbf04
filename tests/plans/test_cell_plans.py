"""What presets do with meshes of any cells besides what their passes do."""

import numpy as np

from meshopt_cli.mesh.any_cells import cast_any
from meshopt_cli.passes.collapse import Collapse
from meshopt_cli.passes.smooth import Smooth, is_settled
from meshopt_cli.plans.stages import Outcome, Sequence, Trial, Unsettled
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.work.face_work import work_on
from support.edits import shaken
from support.meshes import hex_grid, quad_grid

JUDGE = MEASURES["scaled-jacobian"].judge
GLOBAL = Smooth(method="global")


def test_all_vertices_move_again_only_where_something_changed_since():
    outcome = Outcome(work_on(cast_any(shaken(hex_grid(4), 0.2)), JUDGE))
    stage = Unsettled(Sequence((GLOBAL,)))
    assert not is_settled(outcome.work)
    stage.run(outcome)
    assert is_settled(outcome.work)
    stage.run(outcome)
    assert len(outcome.lines) == 1
    outcome.work.move(outcome.work.mesh.points + 0.0)
    stage.run(outcome)
    assert len(outcome.lines) == 2


def test_a_trial_that_brings_nothing_leaves_all_as_it_was():
    """A collapse that any valid cell is good enough for, in a grid that it can only harm."""
    work = work_on(cast_any(shaken(quad_grid(6), 0.1)), JUDGE)
    points, n_cells = work.mesh.points.copy(), work.n_cells
    harm = Collapse(worse_than=1.0, accept="valid", min_vertices=0.5)
    outcome = Outcome(work)
    Trial(Sequence((harm,)), Sequence(())).run(outcome)
    assert outcome.lines[0].tally.applied > 0
    assert outcome.work.n_cells == n_cells
    assert np.array_equal(outcome.work.mesh.points, points)


def test_a_trial_goes_on_only_with_other_cells():
    outcome = Outcome(work_on(cast_any(quad_grid(4)), JUDGE))
    Trial(Sequence((Collapse(),)), Sequence((GLOBAL,))).run(outcome)
    assert [line.tally.name for line in outcome.lines] == ["collapse"]
