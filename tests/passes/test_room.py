"""How much room there is in memory decides nothing: neither the mesh nor what is counted."""

from __future__ import annotations

from dataclasses import fields
from functools import cache

import numpy as np
import pytest

from meshopt_cli.kernels.operators.swap import Swapping, sweep_swap
from meshopt_cli.kernels.types import N_CELLS, N_VERDICTS
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.work import storage
from meshopt_cli.work.session import Workspace
from support.edits import halves, shaken
from support.invariants import snapshot
from support.invariants import workspace as workspace_of
from support.meshes import tet_grid, tri_grid
from support.samples import SAMPLE_NAMES, sample


@cache
def source_named(name):
    """The cells of a small mesh."""
    if name in SAMPLE_NAMES:
        return sample(name)
    grid = tri_grid(6) if name == "triangles" else tet_grid(4)
    return cast(halves(shaken(grid, 1.0, 11)))


MESHES = ("raw_ball.mesh", "quadtree.vtk", "triangles", "tets")


def _variants():
    """Each pass as it is, and with each of its choices, and what makes it do more."""
    for kind in PASSES.values():
        yield pytest.param(kind, {}, id=kind.name)
        for f in fields(kind):
            for choice in f.metadata["choices"]:
                if choice != f.default:
                    yield pytest.param(kind, {f.name: choice}, id=f"{kind.name}-{choice}")
    yield pytest.param(PASSES["split"], {"constrained": 0.01, "max_vertices": 4.0}, id="split-all")
    yield pytest.param(PASSES["mend"], {"steps": 50, "worse_than": 1.5}, id="mend-steps")
    yield pytest.param(PASSES["split"], {"worse_than": 1.5, "max_vertices": 1.01}, id="split-few")


def with_room(monkeypatch, room, spare, n_points=0):
    """Make so much room for cells from now on, and so many rows more for vertices."""
    monkeypatch.setattr(storage, "ROOM", room)
    monkeypatch.setattr(storage, "SPARE", spare)
    reserve = Workspace.reserve_points
    monkeypatch.setattr(
        Workspace, "reserve_points", lambda work, n: reserve(work, n + n_points), raising=True
    )


def everything(work):
    """Every byte of a result."""
    result, origin = work.result()
    arrays = (result.points, result.cells, result.region, origin)
    return [array.tobytes() for array in arrays]


def outcome(kind, options, name):
    """What a pass makes of a mesh, and counts, twice."""
    work = workspace_of(source_named(name))
    tallies = [kind(**options).run(work) for _ in range(2)]
    return everything(work), [tally.counts.tolist() for tally in tallies], work


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize(("kind", "options"), list(_variants()))
def test_passes(kind, options, name, monkeypatch):
    """The same with all the room that there may be, and with none to spare."""
    with monkeypatch.context() as patched:
        with_room(patched, 8.0, 10_000, n_points=5_000)
        expected, counts, roomy = outcome(kind, options, name)
    with_room(monkeypatch, 1.0, 1)
    got, recounted, tight = outcome(kind, options, name)
    assert recounted == counts
    assert got == expected
    assert len(tight.mesh.cells) < len(roomy.mesh.cells)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("name", ["raw_ball.mesh", "triangles"])
def test_presets(preset, name, monkeypatch):
    source = source_named(name)
    chosen, dimension = PRESETS[preset], source.dimension
    pipeline = Pipeline(preset, chosen.build(chosen.stops[dimension], dimension))
    with_room(monkeypatch, 4.0, 10_000, n_points=1_000)
    roomy = everything(pipeline.run(workspace_of(source)).work)
    monkeypatch.undo()
    with_room(monkeypatch, 1.0, 100)
    assert everything(pipeline.run(workspace_of(source)).work) == roomy


def test_a_sweep_stops_where_there_is_no_room():
    """Before anything is done there, and goes on from there once there is some."""
    work = workspace_of(source_named("raw_ball.mesh"))
    order = work.living()
    how = Swapping(0, 0.0, False, 0)
    counts = np.zeros(N_VERDICTS, dtype=np.int64)
    used = int(work.mesh.state[N_CELLS])
    work.mesh.state[N_CELLS] = len(work.mesh.cells)
    before = snapshot(work)
    assert sweep_swap(work.mesh, order, how, work.scratch, counts) == 0
    assert snapshot(work) == before
    assert not counts.any()
    work.mesh.state[N_CELLS] = used
    assert sweep_swap(work.mesh, order, how, work.scratch, counts) == len(order)
    assert counts.any()
