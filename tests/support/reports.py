"""Reports on meshes that do not exist, and what JSON says of one that does."""

import math

import numpy as np
import pytest
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality.measures import DEFAULT_MEASURE, OF_SIMPLICES, cell_quality
from meshopt_cli.quality.summary import Summary
from meshopt_cli.reports.model import FileFacts, PassFacts, Report

INFINITE = math.inf


def summary(counts=(60, 30, 10, 0), worst=7.5, **changes):
    """Figures of a mesh that does not exist."""
    values = {
        "measure": "aspect-ratio",
        "family": "tetra",
        "n_cells": sum(counts),
        "n_points": sum(counts) // 4 + 1,
        "counts": tuple(counts),
        "n_invalid": 0,
        "worst": worst,
        "mean": 1.5,
        "best": 1.01,
        "target": 1.45,
        "angle_min": 10.0,
        "angle_max": 160.0,
        "worst_by_measure": {"edge-ratio": 3.5, "mean-edge": INFINITE},
    }
    values |= changes
    return Summary(dimension=FAMILIES[values["family"]].dimension, **values)


def ran(round, name, visited=10, applied=4, **changes):
    """What a pass is said to have done; the rest was refused."""
    refused = {"not-better": visited - applied} if visited > applied else {}
    return PassFacts(round, name, visited, applied, refused, 0.25, 7.5, 1.5, **changes)


def report(before=None, after=None, path="in/some.mesh", passes=(), **changes):
    """A report on one mesh, or on a run when there is a mesh after it."""
    values = {"input": FileFacts(path, "medit", "0" * 64), "before": before or summary()}
    if after is not None:
        values |= {
            "output": FileFacts("out.mesh", "medit", "1" * 64),
            "after": after,
            "stopped": "no change",
            "seconds": {"read": 0.1, "optimize": 2.0, "write": 0.01},
        }
    return Report(version="0", **{**values, "passes": tuple(passes), **changes})


ROUNDS = [ran(0, "check", 0, 0), ran(1, "smooth"), ran(1, "swap", 2000, 1000), ran(2, "smooth", 5)]
OF_A_MESH = report()
OF_A_RUN = report(after=summary((99, 1, 0, 0), worst=2.25), passes=ROUNDS)
both_kinds = pytest.mark.parametrize("one", [OF_A_MESH, OF_A_RUN], ids=["mesh", "run"])

qualities = st.floats(1.0, 1e300) | st.just(INFINITE)
ranks = st.lists(st.integers(0, 10**7), min_size=4, max_size=4).filter(sum)
summaries = st.builds(
    summary,
    ranks,
    qualities,
    mean=qualities,
    best=qualities,
    target=qualities,
    angle_min=st.floats(0, 60),
    angle_max=st.floats(60, 180),
    family=st.sampled_from(["triangle", "tetra"]),
    measure=st.sampled_from(list(OF_SIMPLICES)),
    worst_by_measure=st.dictionaries(st.sampled_from(list(OF_SIMPLICES)), qualities),
)
reports = st.builds(report, summaries) | st.builds(report, summaries, summaries)

SUMMARY_KEYS = {"ne", "np", "worst", "mean", "best", "target", "invalid", "histogram",
                "angle_min", "angle_max", "angles_forced", "measures",
                "types", "room", "census", "worst_cells", "families"}  # fmt: skip
PASS_KEYS = {"round", "name", "visited", "applied", "refused", "seconds", "worst", "mean",
             "kinds"}  # fmt: skip
TOP_KEYS = {"meshopt", "input", "output", "measure", "dimension", "before", "after", "passes",
            "metric", "metric_after", "regions", "stopped", "statistics", "statistics_after",
            "left_out", "seconds", "lost"}  # fmt: skip
FILE_KEYS = {"path", "format", "sha256"}


def check_summary(value, one, measure=DEFAULT_MEASURE):
    """What is said of a mesh is so."""
    assert set(value) == SUMMARY_KEYS
    simplices = cast(one)
    q = cell_quality(simplices.points, simplices.cells, OF_SIMPLICES[measure])
    assert value["ne"] == len(simplices.cells)
    assert value["np"] == len(np.unique(simplices.cells))
    assert value["worst"] == pytest.approx(1 / q.min(), rel=1e-12)
    assert value["best"] == pytest.approx(1 / q.max(), rel=1e-12)
    assert value["mean"] == pytest.approx(np.mean(1 / q), rel=1e-12)
    assert value["invalid"] == 0
    assert value["measures"][measure] == value["worst"]
    assert sum(value["types"].values()) == value["ne"]
    assert len(value["types"]) == {2: 3, 3: 8}[simplices.dimension]
    if simplices.dimension == 2:
        assert value["room"] is None
    else:
        assert 0 <= value["room"]["near"] <= value["room"]["held"] <= value["ne"]
        assert all(p["Q"] > 1.1 * p["allowed"] >= 1.1 for p in value["room"]["most"])
    worst = value["worst_cells"]
    assert len(worst) == min(10, value["ne"])
    assert [cell["Q"] for cell in worst] == pytest.approx(np.sort(1 / q)[::-1][:10], rel=1e-12)
    assert all(set(cell) == {"cell", "family", "type", "where", "Q"} for cell in worst)
    census = value["census"]
    assert census["simplices"] == value["ne"]
    assert 0 <= census["obtuse"] <= value["ne"]
    assert 0 <= census["self_centered"] <= value["ne"]
    degrees = census["degrees"]
    vertices = [degrees[name]["counts"] for name in ("inner_vertices", "boundary_vertices")]
    assert sum(sum(counts.values()) for counts in vertices) == value["np"]
    for found in degrees.values():
        assert sum(found["counts"].values()) == sum(found["excess"].values())
    assert set(value["measures"]) == set(OF_SIMPLICES)
    histogram = value["histogram"]
    assert set(histogram) == {"edges", "counts", "percent"}
    assert histogram["edges"] == [1, 2, 3, 10, None]
    assert sum(histogram["counts"]) == value["ne"]
    assert sum(histogram["percent"]) == pytest.approx(100.0)
    assert histogram["counts"][0] == np.sum(1 / q <= 2)
