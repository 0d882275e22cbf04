"""The worst cells: which they are, where they are, and what their files call them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.jobs.optimize_mesh import Task
from meshopt_cli.jobs.report import report_on
from meshopt_cli.mesh.cast import cast
from meshopt_cli.plans.config import Request
from meshopt_cli.quality.families import summarize_mesh
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import OF_SIMPLICES, cell_quality
from meshopt_cli.quality.worst import N_WORST, worst_cells
from support.edits import shaken
from support.files import write
from support.meshes import mesh, tet_grid, tri_grid

ASPECT = OF_SIMPLICES["aspect-ratio"]


def found(q):
    """The worst of some quads that all lie in one place."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    cells = np.tile(np.arange(4), (len(q), 1))
    return worst_cells(np.array(q), points, cells, "quad", lambda rows: np.zeros((len(rows), 3)))


@given(st.lists(st.sampled_from([1.0, 2.0, 2.5, np.inf, np.nan]) | st.floats(1, 9), max_size=60))
def test_they_are_the_worst_and_of_equals_the_first(q):
    order = sorted(range(len(q)), key=lambda i: (-(np.inf if np.isnan(q[i]) else q[i]), i))
    assert [one.number for one in found(q)] == order[:N_WORST]
    assert all(not np.isnan(one.quality) for one in found(q))


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_places_are_those_of_the_file(tilt):
    """Of triangles in a plane, wherever it lies."""
    flat = shaken(tri_grid(5)).points
    c, s = np.cos(tilt), np.sin(tilt)
    points = np.column_stack([flat[:, 0] + 3.0, c * flat[:, 1], s * flat[:, 1]])
    one = mesh(points, triangle=shaken(tri_grid(5)).blocks[0].cells)
    worst = summarize_mesh(one, measurable(one), ASPECT).worst_cells
    cells = one.blocks[0].cells
    for place in worst:
        expected = points[cells[place.number]].mean(axis=0)
        assert place.where == pytest.approx(tuple(expected), abs=1e-12)


def test_types_and_figures_are_those_of_the_cells():
    source = shaken(tet_grid(3))
    simplices = cast(source)
    summary = summarize_mesh(source, measurable(source), ASPECT)
    q = cell_quality(simplices.points, simplices.cells, ASPECT)
    assert [one.quality for one in summary.worst_cells] == [
        1.0 / q[one.number] for one in summary.worst_cells
    ]
    assert {one.type for one in summary.worst_cells} <= set(summary.types)
    assert summary.worst == summary.worst_cells[0].quality


def test_of_several_families_the_worst_of_all():
    points = np.array([[0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2], [1.2, 0, 2], [3, 0.5, 2.0]])
    one = mesh(points, triangle=[[1, 4, 2], [4, 5, 2]], quad=[[0, 1, 2, 3]])
    summary = summarize_mesh(one, measurable(one), ASPECT)
    assert [len(part.worst_cells) for part in summary.parts] == [2, 1]
    assert [(w.family, w.number) for w in summary.worst_cells] == [
        ("triangle", 0), ("triangle", 1), ("quad", 0),
    ]  # fmt: skip
    assert summary.worst_cells[2].where == (0.5, 0.5, 2.0)
    assert [w.quality for w in summary.worst_cells][::2] == [summary.worst, summary.best]


@pytest.mark.parametrize("suffix", [".msh", ".vtk", ".vtu", ".mesh", ".meshb"])
@pytest.mark.parametrize("name", ["two_regions.msh", "quadtree.vtk", "plate.vtu"])
def test_they_are_called_as_the_written_file_calls_them(samples, tmp_path, name, suffix):
    output = tmp_path / f"out{suffix}"
    request = Request(passes=("smooth",), rounds=1)
    report = optimize_file(FileTask(samples / name, output, Task(request))).report
    for path, summary in ((samples / name, report.before), (output, report.after)):
        read = report_on(path).before
        names = {(one.cell, round(one.quality, 6)) for one in read.worst_cells}
        assert {(one.cell, round(one.quality, 6)) for one in summary.worst_cells} == names
        assert all(one.cell for one in summary.worst_cells)


def test_cells_of_what_is_not_written_have_no_names(tmp_path):
    path = write(tmp_path / "in.vtk", shaken(tet_grid(3)))
    asked = Task(Request(preset="fast", rounds=1))
    task = FileTask(path, tmp_path / "out.vtk", asked, fail_above=1.0)
    report = optimize_file(task).report
    assert all(one.cell for one in report.before.worst_cells)
    assert not any(one.cell for one in report.after.worst_cells)


def test_cells_that_a_repair_left_have_no_names_before(tmp_path):
    path = write(tmp_path / "in.vtk", shaken(tet_grid(3)))
    request = Request(passes=("repair", "smooth"), settings=("repair.duplicates=yes",), rounds=1)
    report = optimize_file(FileTask(path, tmp_path / "out.vtk", Task(request))).report
    assert not any(one.cell for one in report.before.worst_cells)
    assert all(one.cell for one in report.after.worst_cells)
