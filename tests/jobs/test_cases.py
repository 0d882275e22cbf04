"""Samples through pipelines: each file in cases/ has a sample, a pipeline and what must come out.

Bounds, none of which the sample itself keeps, except those on vertices:

worst, mean
    Greatest Q allowed, by the measure of the pipeline.
good
    Least percentage of cells with Q from 1 to 2.
added, removed
    Greatest number of vertices that came or went, in percent of the sample's.
stopped
    Why the run ended.
"""

import tomllib

import numpy as np
import pytest

from meshopt_cli import formats, validity
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.quality.measures import cell_quality
from support.samples import ROOT

CASES = sorted((ROOT / "tests" / "cases").glob("*.toml"))
KEYS = {"sample", "pipeline", "bounds"}
QUALITY = {"worst", "mean", "good"}
BOUNDS = QUALITY | {"added", "removed", "stopped"}


def read_case(path):
    case = tomllib.loads(path.read_text(encoding="utf-8"))
    assert set(case) == KEYS
    assert set(case["bounds"]) <= BOUNDS
    assert set(case["bounds"]) & QUALITY
    return case


def keeps(summary, bounds):
    """Which of the bounds on quality a mesh keeps."""
    kept = {
        "worst": summary.worst <= bounds.get("worst", np.inf),
        "mean": summary.mean <= bounds.get("mean", np.inf),
        "good": summary.percent[0] >= bounds.get("good", 0.0),
    }
    return {name: kept[name] for name in QUALITY & set(bounds)}


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_case(path, samples, tmp_path):
    case = read_case(path)
    bounds = case["bounds"]
    (tmp_path / "pipeline.toml").write_text(case["pipeline"], encoding="utf-8")
    mesh, _ = formats.read(samples / case["sample"])
    plan = plan_for(Request(config=tmp_path / "pipeline.toml"), mesh.dimension())
    result = job.optimize(mesh, plan.pipeline, plan.measure)
    before, after = result.before, result.after

    assert not any(keeps(before, bounds).values()), "the sample keeps a bound by itself"
    assert all(keeps(after, bounds).values()), after
    change = 100.0 * (after.n_points - before.n_points) / before.n_points
    assert -bounds.get("removed", 100.0) <= change <= bounds.get("added", np.inf)
    assert bounds.get("stopped", result.stopped) == result.stopped

    # What is said of the mesh is so of the mesh, and it can be used.
    optimized = cast(result.mesh)
    q = cell_quality(optimized.points, optimized.cells, plan.measure)
    assert 1.0 / q.min() == pytest.approx(after.worst, rel=1e-12)
    assert validity.check(result.mesh).is_valid


def test_every_pass_has_a_case():
    text = "\n".join(path.read_text(encoding="utf-8") for path in CASES)
    for name, kind in PASSES.items():
        # None of these makes cells better; and cases have no metric.
        assert (
            name in ("check", "repair", "confine")
            or kind.needs_metric
            or f'name = "{name}"' in text
        )


@pytest.mark.parametrize("sample", ["raw_ball.mesh", "quadtree.vtk", "plate.vtu", "grid.vtk"])
def test_every_sample_has_a_case(sample):
    assert any(read_case(path)["sample"] == sample for path in CASES)
