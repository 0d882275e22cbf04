"""`meshopt report --against`."""

import csv
import io

import pytest

from meshopt_cli.jobs.report import Wanted, report_on
from meshopt_cli.quality.measures import MEASURES
from support.corners import tri_quad_grid
from support.edits import shaken
from support.files import strict, untouched, worst_of, write
from support.meshes import in_space, tri_grid
from support.reports import TOP_KEYS


@pytest.fixture
def other(tmp_path):
    return write(tmp_path / "other.vtu", in_space(shaken(tri_grid(5), 0.1)))


@pytest.fixture
def mixed(tmp_path):
    return write(tmp_path / "mixed.vtu", in_space(tri_quad_grid(4)))


def test_rows_of_both_in_a_table(meshopt, triangles, other):
    ran = meshopt("report", other, "--against", triangles)
    assert (ran.status, ran.err) == (0, "")
    lines = ran.out.splitlines()
    assert lines[0].startswith(f"{other.name} against {triangles.name}: 72 triangles")
    rows = {line.split()[0]: line.split() for line in lines[2:6] if line[0] != " "}
    assert rows["before"][-2:] == ["72", "49"]
    assert rows["after"][-2:] == ["50", "36"]
    assert "13 vertices less" in ran.out
    assert "stopped" not in ran.out


def test_all_figures_of_both_in_json(meshopt, triangles, other):
    options = ("--measure", "corner-min,aspect-ratio", "--metric", "implied", "--format", "json")
    value = strict(meshopt("report", other, "--against", triangles, *options).out)
    assert set(value) == TOP_KEYS
    before = strict(meshopt("report", triangles, *options).out)
    after = strict(meshopt("report", other, *options).out)
    assert value["before"] == before["before"]
    assert value["after"] == after["before"]
    assert value["input"] == before["input"]
    assert value["output"] == after["input"]
    assert value["statistics"] == before["statistics"]
    assert value["statistics_after"] == after["statistics"]
    assert value["metric"] == before["metric"]
    assert value["metric_after"] == after["metric"]
    assert value["stopped"] is None
    assert value["passes"] == []


def test_lines_of_both_in_csv(meshopt, triangles, other):
    ran = meshopt("report", other, "--against", triangles, "--format", "csv",
                  "--measure", "corner-min", "--size", "0.2")  # fmt: skip
    rows = list(csv.DictReader(io.StringIO(ran.out)))
    assert [(row["file"], row["mesh"]) for row in rows] == [
        (str(triangles), "before"), (str(other), "after"),
    ]  # fmt: skip
    for row, path in zip(rows, (triangles, other), strict=True):
        one = report_on(path, Wanted(("corner-min",)))
        assert float(row["Q_T"]) == pytest.approx(worst_of(path))
        assert float(row["corner-min triangle least"]) == one.statistics[0].least
        assert float(row["tau"]) > 0.0
    assert rows[0]["tau"] != rows[1]["tau"]


@pytest.mark.parametrize("form", ["table", "markdown", "html"])
def test_measures_and_lengths_of_both(meshopt, triangles, other, form):
    text = meshopt("report", other, "--against", triangles, "--format", form,
                   "--measure", "corner-min", "--metric", "implied").out  # fmt: skip
    for when in ("triangles before", "triangles after"):
        assert text.count(when) >= 1
    assert text.count("inner edges") >= 2


@pytest.mark.parametrize("form", ["table", "markdown", "html", "csv", "json"])
@pytest.mark.parametrize("turn", [False, True])
def test_meshes_of_other_cells(meshopt, triangles, mixed, form, turn):
    one, two = (mixed, triangles) if turn else (triangles, mixed)
    ran = meshopt("report", one, "--against", two, "--format", form)
    assert (ran.status, ran.err) == (0, "")
    if form == "json":
        families = [set(strict(ran.out)[when]["families"]) for when in ("before", "after")]
        assert families == ([set(), {"triangle", "quad"}] if not turn
                            else [{"triangle", "quad"}, set()])[::-1]  # fmt: skip
        return
    quads = "quads after" if turn else "quads before"
    for name in ("triangles before", "triangles after", quads, "all before", "all after"):
        assert name in ran.out
    assert {"quads before", "quads after"} - {quads} != set()
    assert ({"quads before", "quads after"} - {quads}).pop() not in ran.out


def test_meshes_of_other_dimensions_are_not_compared(meshopt, tets, triangles, other):
    ran = meshopt("report", tets, other, "--against", triangles, "--format", "csv")
    assert ran.status == 2
    assert str(tets) in ran.err
    assert "dimension 3 are not compared" in ran.err
    assert len(list(csv.DictReader(io.StringIO(ran.out)))) == 2


def test_the_other_mesh_is_not_written_over(meshopt, triangles, other, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("report", other, "--against", triangles, "-o", triangles, "--format", "json")
    assert ran.status == 2


def test_what_cannot_be_read_ends_it(meshopt, triangles, tmp_path):
    ran = meshopt("report", triangles, "--against", tmp_path / "missing.vtk")
    assert (ran.status, ran.out) == (3, "")


def test_a_comparison_with_itself_changes_nothing(meshopt, triangles):
    names = ",".join(name for name, m in MEASURES.items() if "triangle" in m.ways)
    value = strict(
        meshopt("report", triangles, "--against", triangles, "--measure", names,
                "--format", "json").out
    )  # fmt: skip
    assert value["before"] == value["after"]
    assert value["statistics"] == value["statistics_after"] != []
