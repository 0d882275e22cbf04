"""What a part of a mesh is given to: pure, and fit to be sent to another process."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from meshopt_cli.boundary.patches import patches_of
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes.collapse import Collapse
from meshopt_cli.plans.improve import improve
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.plans.stages import Sequence
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.bounds import Bounds
from support.edits import halves, shaken
from support.meshes import tet_grid, tri_grid
from support.samples import sample

JUDGE = QUALITIES["aspect-ratio"].judge


def frozen(part):
    """Every byte of some simplices."""
    names = ("points", "cells", "region", "fixed", "facets", "edges")
    return {name: getattr(part, name).tobytes() for name in names}


def test_a_part_is_held_against_the_whole():
    """Vertices may not vanish where the whole has lost too many already, wherever that was."""
    part = sample("raw_ball.mesh")
    pipeline = Pipeline("collapse", (Sequence((Collapse(),)),))
    (alone,) = improve(part, pipeline, JUDGE).lines
    assert alone.tally.applied > 0
    few_left = Bounds(1.0, n_input_vertices=10 * len(part.points), n_input_points=len(part.points))
    (within,) = improve(part, pipeline, JUDGE, bounds=few_left).lines
    assert within.tally.applied == 0


@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("grid", [tri_grid(5), tet_grid(3)], ids=["triangles", "tets"])
def test_it_is_pure_and_can_be_sent(grid, slides):
    """A copy that went through pickle gives the same; what is given stays as it is."""
    mesh = halves(shaken(grid))
    part = cast(mesh)
    patches = patches_of(mesh, part, 1e-6) if slides else None
    preset = PRESETS["standard"]
    pipeline = Pipeline("standard", preset.build(preset.stops[part.dimension], part.dimension))
    given = frozen(part)
    sent = pickle.loads(pickle.dumps((part, pipeline, JUDGE, 1.5, patches)))
    worked = improve(part, pipeline, JUDGE, 1.5, patches)
    assert frozen(part) == given
    other = pickle.loads(pickle.dumps(improve(*sent)))
    assert frozen(worked.part) == frozen(other.part)
    np.testing.assert_array_equal(worked.origin, other.origin)
    assert worked.stopped == other.stopped
    assert worked.part.points.tobytes() != part.points.tobytes()
