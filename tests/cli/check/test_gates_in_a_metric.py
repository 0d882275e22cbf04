"""Gates on what a whole mesh is in a metric (M406)."""

import json
from operator import attrgetter

import numpy as np
import pytest

from meshopt_cli.formats.medit_sol import SCALAR, Solution, write_sol
from meshopt_cli.metric.field import Metric
from meshopt_cli.quality.gates import FIGURES, limit_of
from support.broken import BROKEN
from support.edits import shaken
from support.files import write
from support.meshes import hex_grid, tet_grid, tri_grid
from support.metrics import judged

SIZE = "0.4+0.1*x"


@pytest.fixture
def one():
    return shaken(tet_grid(3))


@pytest.fixture
def path(tmp_path, one):
    return write(tmp_path / "a.mesh", one)


def figures(one):
    sizes = 0.4 + 0.1 * one.points[:, :1]
    summary = judged(one, Metric(sizes, "")).summary
    return {name: attrgetter(figure.path)(summary) for name, figure in FIGURES.items()}


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("sign", [">=", "<="])
def test_gates_on_every_figure(check, path, one, name, sign):
    value = figures(one)[name]
    for factor in (0.99, 1.01):
        gate = f"{name}{sign}{value * factor:.6f}"
        status, out, err = check(path, "--size", SIZE, "--gate", gate)
        is_kept = (factor < 1.0) == (sign == ">=")
        assert (status, err) == (0 if is_kept else 1, "")
        found = [line for line in out.splitlines() if "M406" in line]
        assert len(found) == (0 if is_kept else 1)
        assert all(f"{name} is {value:.6g}" in line and str(path) in line for line in found)


def test_each_that_fails_has_its_line(check, path):
    gates = [part for gate in ("tau>=2", "unit-edges>=0", "metric-q<=1") for part in
             ("--gate", gate)]  # fmt: skip
    status, out, _ = check(path, "--size", SIZE, *gates, "--format", "json")
    (file,) = json.loads(out)["files"]
    assert status == 1
    assert file["counts"] == {"M406": 2}
    first, second = (finding["message"] for finding in file["findings"])
    assert first.startswith("tau is ")
    assert second.startswith("metric-q is ")


def test_the_measure_is_that_of_the_check(check, path, one):
    sizes = Metric(0.4 + 0.1 * one.points[:, :1], "")
    value = judged(one, sizes, "radius-ratio").summary.worst
    for limit, expected in ((value * 1.001, 0), (value * 0.999, 1)):
        gate = ["--gate", f"metric-q<={limit}", "--measure", "radius-ratio"]
        assert check(path, "--size", SIZE, *gate)[0] == expected


@pytest.mark.parametrize("form", ["text", "json", "github", "junit", "sarif"])
def test_every_form_tells_of_it(check, path, form):
    status, out, _ = check(path, "--size", SIZE, "--gate", "tau>=2", "--format", form)
    assert status == 1
    assert "M406" in out
    assert "tau is 0." in out


def test_a_metric_from_a_file_with_gradation(check, path, tmp_path):
    sizes = np.full((64, 1), 0.4)
    sizes[0] = 0.01
    write_sol(tmp_path / "h.sol", Solution(3, [(SCALAR, sizes)]))
    options = ["--metric", tmp_path / "h.sol", "--format", "json", "--gate", "tau>=1"]

    def message(*more):
        (file,) = json.loads(check(path, *options, *more)[1])["files"]
        return file["findings"][0]["message"]

    assert message() != message("--gradation", "1.1")


def test_cells_of_any_family(check, tmp_path):
    for name, one in (("h.vtu", hex_grid(2)), ("t.vtu", tri_grid(4))):
        there = write(tmp_path / name, one)
        n = {"h.vtu": 2, "t.vtu": 4}[name]
        gate = ["--size", f"{1 / n}", "--gate", "unit-edges>=0.99999"]
        assert check(there, *gate)[0] == 0
        assert check(there, "--size", "9", *gate[2:])[0] == 1


@pytest.mark.parametrize("name", ["not a number", "vertex beyond the last", "repeated in a tet"])
def test_meshes_without_shape_are_bad_for_that(check, tmp_path, name):
    there = write(tmp_path / "bad.vtu", BROKEN[name][0])
    status, out, _ = check(there, "--size", "1", "--gate", "tau>=0.1")
    assert status == 1
    assert "M00" in out
    assert "M406" not in out


def test_inverted_cells_have_no_finite_q(check, tmp_path):
    bad = write(tmp_path / "bad.vtu", BROKEN["inverted tet"][0])
    status, out, _ = check(bad, "--size", "1", "--gate", "metric-q<=1e9", "--format", "json")
    assert status == 1
    assert json.loads(out)["files"][0]["counts"]["M406"] == 1


def test_several_files_in_several_processes(check, path, tmp_path):
    other = write(tmp_path / "b.vtu", tet_grid(2))
    status, _, err = check(path, other, "--size", SIZE, "--size", "wall=1", "--gate", "tau>=2")
    assert status == 2
    assert [line.split(": ")[1] for line in err.splitlines()] == [str(path), str(other)]
    status, out, _ = check(path, other, "--size", SIZE, "--gate", "tau>=2", "--jobs", "2")
    assert status == 1
    assert out.count("M406 tau is ") == 2


def test_the_rule_can_be_ignored(check, path):
    gate = ["--size", SIZE, "--gate", "tau>=2"]
    assert check(path, *gate, "--ignore", "M406")[0] == 0
    assert check(path, *gate, "--select", "M1")[0] == 1


def test_defaults_from_a_file(check, path, tmp_path):
    lines = 'size = ["0.4+0.1*x"]\ngradation = 1.3\ngate = ["tau>=2"]\n'
    (tmp_path / "meshopt.toml").write_text(f"[check]\n{lines}")
    status, out, _ = check(path)
    assert status == 1
    assert "M406" in out


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--gate", "tau>=0.9"], "tau needs a metric: add --metric or --size"),
        (["--size", "1"], "of no use here without a --gate on tau, "),
        (["--size", "1", "--gate", "tau>=0.9 @ steel"], "of the whole mesh"),
        (["--metric", "mm", "--gate", "tau>=0.9"], "no array 'mm'"),
        (["--size", "x-9", "--gate", "tau>=0.9"], "not positive"),
        (["--gradation", "1.3", "--gate", "tau>=0.9"], "--gradation goes with"),
        (["--size", "1", "--gate", "tua>=0.9"], "no quantity 'tua'"),
    ],
)
def test_what_is_refused(check, path, options, what):
    status, out, err = check(path, *options)
    assert (status, out) == (2, "")
    assert what in err
    assert len(err.splitlines()) == 1


def test_what_is_marked_does_not_take_the_place_of_the_metric(check, path, tmp_path):
    sol = tmp_path / "h.sol"
    write_sol(sol, Solution(3, [(SCALAR, np.ones((64, 1)))]))
    before = sol.read_bytes()
    gate = ["--metric", sol, "--gate", "tau>=0.9", "--mark", sol]
    assert check(path, *gate)[0] in (2, 3)
    assert sol.read_bytes() == before


def test_they_are_written_as_they_are_read():
    for text in ("tau >= 0.9", "metric-q <= 5"):
        assert str(limit_of(text)) == text
