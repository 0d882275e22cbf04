"""`meshopt report` by a metric with limits and gradation, and with sizes of parts."""

import math

import numpy as np
import pytest

from meshopt_cli.formats.medit_sol import SCALAR, TENSOR, Solution, write_sol
from meshopt_cli.metric.bounds import bounded
from meshopt_cli.metric.domain import domain_of
from meshopt_cli.metric.field import Metric, components
from meshopt_cli.metric.gradation import graded
from support.edits import shaken, tagged
from support.files import strict, write
from support.meshes import tet_grid, tri_grid
from support.metrics import judged, of_matrices, random_tensors


def told(meshopt, path, *more):
    ran = meshopt("report", path, "--format", "json", *more)
    assert ran.status == 0, ran.err
    return strict(ran.out)["metric"]


@pytest.fixture
def one():
    return shaken(tet_grid(3))


def tensors_in(folder, one):
    tensors = random_tensors(3, len(one.points), 0.5) * 9.0
    path = folder / "m.sol"
    write_sol(path, Solution(3, [(TENSOR, components(tensors))]))
    return path, of_matrices(tensors)


def test_what_is_reported_is_the_shaped_metric(meshopt, tmp_path, one):
    path = write(tmp_path / "a.mesh", one)
    sol, metric = tensors_in(tmp_path, one)
    domain = domain_of(one)
    for options, expected in (
        (["--size-min", 0.2, "--size-max", 0.5], bounded(metric, 0.2, 0.5)),
        (["--gradation", 1.3], graded(metric, domain.points, domain.edges, 1.3)),
    ):
        value = told(meshopt, path, "--metric", sol, *options)
        summary = judged(one, expected).summary
        assert value["edges"]["tau"] == pytest.approx(summary.edges.tau, rel=1e-9)
        assert value["worst"] == pytest.approx(summary.worst, rel=1e-9)
        assert value["content"] == pytest.approx(summary.content, rel=1e-9)
        changed = (expected.values != metric.values).any(axis=1).sum()
        assert changed > 0
        assert f"at {changed} of 64 vertices" in value["source"]
        for option in options[1::2]:
            assert f"{option:g}" in value["source"]
    assert told(meshopt, path, "--metric", sol)["source"] == "m.sol (xx, xy, yy, xz, yz, zz)"


def test_limits_hold_for_a_graded_metric_too(meshopt, tmp_path, one):
    path = write(tmp_path / "a.mesh", one)
    sizes = np.full((64, 1), 2.0)
    sizes[0] = 1e-3
    sol = tmp_path / "h.sol"
    write_sol(sol, Solution(3, [(SCALAR, sizes)]))
    value = told(meshopt, path, "--metric", sol, "--size-min", 0.1, "--gradation", 1.5)
    domain = domain_of(one)
    way = graded(Metric(np.maximum(sizes, 0.1), ""), domain.points, domain.edges, 1.5)
    assert way.values.min() == 0.1
    assert value["edges"]["tau"] == pytest.approx(judged(one, way).summary.edges.tau, rel=1e-9)
    assert value["source"].index("at least") < value["source"].index("gradation")
    assert "other at 1 of 64" in value["source"]


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_a_formula_with_a_jump_is_graded(meshopt, tmp_path, make):
    path = write(tmp_path / "a.vtu", make(4))
    formula = "max(0.05, min(5, 1000*x))"
    before = told(meshopt, path, "--size", formula)
    after = told(meshopt, path, "--size", formula, "--gradation", 1.2)
    # sizes are 0.05 + x log(1.2) at most
    most = 0.05 + math.log(1.2)
    assert after["edges"]["least"] >= 0.25 / most * (1 - 1e-9) > before["edges"]["least"]


def test_sizes_of_regions(meshopt, tmp_path):
    one = tagged(tet_grid(2), [1] * 24 + [2] * 24)
    path = write(tmp_path / "a.mesh", one)
    plain = told(meshopt, path, "--size", "0.5")
    both = told(meshopt, path, "--size", "1=0.5", "--size", "2=0.5")
    assert both.pop("source") == "size 1=0.5, 2=0.5"
    plain.pop("source")
    assert both == plain
    finer = told(meshopt, path, "--size", "0.5", "--size", "2=0.25")
    assert finer["content"] > plain["content"]
    assert finer["edges"]["greatest"] == pytest.approx(2.0 * plain["edges"]["greatest"])


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--gradation", "1.3"], "--gradation goes with --metric or --size"),
        (["--size-min", "1", "--size-max", "2"], "--size-min goes with --metric or --size"),
        (["--size-max", "2"], "--size-max goes with --metric or --size"),
        (["--size", "1", "--size-min", "2", "--size-max", "1"], "2 is above --size-max 1"),
        (["--size", "1", "--gradation", "1"], "1 is out of range"),
        (["--size", "1", "--size", "2"], "twice"),
        (["--size", "1=1", "--metric", "implied"], "exclude each other"),
        (["--size", "1=1"], "no --size holds"),
        (["--size", "3=1", "--size", "1"], "no cell is in a group '3': choose one of 1, 2"),
    ],
)
def test_what_is_refused(meshopt, tmp_path, options, what):
    path = write(tmp_path / "a.mesh", tagged(tet_grid(2), [1] * 24 + [2] * 24))
    ran = meshopt("report", path, *options)
    assert (ran.status, ran.out) == (2, "")
    assert what in ran.complaint


def test_vertices_without_a_size_are_named_as_the_file_does(meshopt, tmp_path):
    path = write(tmp_path / "a.mesh", tagged(tri_grid(1), [1, 2]))
    ran = meshopt("report", path, "--size", "1=1")
    assert ran.status == 2
    assert " at vertex " in ran.complaint
