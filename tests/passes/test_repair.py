"""The pass repair: the mesh of a file is mended, wherever the pass stands."""

from dataclasses import fields

import pytest

from meshopt_cli.errors import BadMeshError
from meshopt_cli.jobs import optimize as job
from meshopt_cli.passes.repair import Repair
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.repairs import MENDS
from meshopt_cli.validity import check
from support.broken import BROKEN
from support.edits import shaken, torn
from support.meshes import tet_grid

TORN = torn(shaken(tet_grid(3), 0.3), 5)


def run(one, **request):
    plan = plan_for(Request(**request), one.dimension())
    return job.optimize(one, plan.pipeline, plan.measure)


def test_its_options_are_the_mends():
    names = [f.name for f in fields(Repair)]
    assert names == [*MENDS, "tolerance"]
    for f in fields(Repair)[:-1]:
        assert f.metadata["help"].startswith(f"whether to {MENDS[f.name].summary.split(';')[0]}")


@pytest.mark.parametrize("passes", [("repair", "smooth"), ("smooth", "repair")])
def test_a_mesh_that_is_not_valid_is_mended_and_optimized(passes, caplog):
    with pytest.raises(BadMeshError, match="M202"):
        run(TORN, passes=("smooth",))
    result = run(TORN, passes=passes)
    assert check(result.mesh).is_valid
    assert result.after.worst < result.before.worst
    first = result.lines[0]
    assert (first.round, first.tally.name) == (0, "repair")
    assert first.tally.applied == first.tally.visited == len(TORN.points) - len(tet_grid(3).points)
    assert [line.tally.name for line in result.lines].count("repair") == 1
    assert f"repair: points merged: {first.tally.applied}" in caplog.text


def test_what_is_not_asked_for_is_not_done():
    with pytest.raises(BadMeshError, match="M202"):
        run(TORN, passes=("repair", "smooth"), settings=("repair.merge=no",))


def test_a_pipeline_file_may_have_it(tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_text(
        '[[before]]\nname = "repair"\nfill = "no"\ntolerance = 1e-9\n[[pass]]\nname = "smooth"\n'
    )
    plan = plan_for(Request(config=path))
    assert plan.pipeline.repairs == (Repair(fill="no", tolerance=1e-9),)
    assert check(run(TORN, config=path).mesh).is_valid
    with pytest.raises(BadMeshError, match="M211"):
        run(BROKEN["tet missing inside"][0], config=path)


def test_repair_alone_hands_the_mended_mesh_on():
    result = run(BROKEN["tet missing inside"][0], passes=("repair",))
    assert check(result.mesh).is_valid
    assert result.after.n_cells == len(BROKEN["tet missing inside"][0].blocks[0].cells) + 1
