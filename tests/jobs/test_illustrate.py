"""Pictures for reports."""

import numpy as np
import pytest

from meshopt_cli.jobs.illustrate import SIDE, WIDTH
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.jobs.optimize_mesh import Task
from meshopt_cli.jobs.report import Wanted, compared, report_on
from meshopt_cli.pictures import library
from meshopt_cli.plans.config import Request
from meshopt_cli.reports.html import to_html
from support.corners import tri_quad_grid
from support.edits import shaken
from support.files import write
from support.meshes import hex_grid, octahedron, tet_grid, tri_grid
from support.pictures import needs_pictures, pixels

MOST = 3_000_000  # bytes of a page
MESHES = {
    "triangles": shaken(tri_grid(6)),
    "faces": tri_quad_grid(4),
    "surface": octahedron(),
    "tets": shaken(tet_grid(3)),
    "hexahedra": shaken(hex_grid(3), 0.1),
}

DRAWN = Wanted(with_pictures=True)


def check(pictures, n, is_surface=False):
    """There are n meshes, surfaces from both sides, each with pictures of the worst cells."""
    assert pictures.missing == ""
    assert len(pictures.worst) == n
    assert len(pictures.wholes) == n * (2 if is_surface else 1)
    for one in pictures.wholes:
        found = pixels(one.png)
        assert found.shape == (one.height, one.width, 4)
        assert one.width == WIDTH
        assert (found[..., 3] > 200).mean() > 0.1
    for one in (picture for some in pictures.worst for picture in some):
        found = pixels(one.png)
        assert found.shape == (one.height, one.width, 4) == (SIDE, SIDE, 4)
        assert (found[..., 3] > 200).any()
    assert [place for place, _ in pictures.ticks]


@needs_pictures
@pytest.mark.parametrize("name", MESHES)
def test_a_mesh_and_its_worst_cells(tmp_path, name):
    path = write(tmp_path / "a.vtk", MESHES[name])
    report = report_on(path, DRAWN)
    check(report.pictures, 1, name == "surface")
    (worst,) = report.pictures.worst
    names = [one.cell for one in report.before.worst_cells]
    assert [picture.words.split(", Q")[0] for picture in worst] == names
    assert len(to_html([report])) < MOST
    assert report == report_on(path, DRAWN)
    assert report_on(path).pictures is None


@needs_pictures
@pytest.mark.parametrize("name", ["triangles", "tets", "hexahedra"])
def test_before_and_after_a_run(tmp_path, name):
    path = write(tmp_path / "a.vtk", MESHES[name])
    task = FileTask(path, tmp_path / "b.vtk", Task(Request(preset="fast")), with_pictures=True)
    report = optimize_file(task).report
    check(report.pictures, 2)
    for summary, worst in zip((report.before, report.after), report.pictures.worst, strict=True):
        assert len(worst) == len(summary.worst_cells) > 0
    one, other = (pixels(picture.png) for picture in report.pictures.wholes)
    assert one.shape == other.shape
    assert np.any(one != other)


@needs_pictures
def test_both_sides_of_both_surfaces(tmp_path):
    path = write(tmp_path / "a.vtk", MESHES["surface"])
    one = report_on(path, DRAWN)
    both = compared(one, one)
    check(both.pictures, 2, True)
    page = to_html([both])
    places = [page.index(f"{when}: {side}") for when in ("before", "after")
              for side in ("one side", "the other side")]  # fmt: skip
    assert places == sorted(places)


@needs_pictures
def test_cells_that_have_no_name_have_no_picture(tmp_path):
    """A repair came before: which cells of the file these were is not known."""
    path = write(tmp_path / "a.vtk", MESHES["tets"])
    request = Request(passes=("repair", "smooth"))
    task = FileTask(path, tmp_path / "b.vtk", Task(request), with_pictures=True)
    report = optimize_file(task).report
    before, after = report.pictures.worst
    assert before == ()
    assert len(after) == len(report.after.worst_cells)


def test_without_the_extra_a_report_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(library, "find_spec", lambda name: None)
    path = write(tmp_path / "a.vtk", MESHES["tets"])
    report = report_on(path, DRAWN)
    assert report.pictures.wholes == ()
    assert report.pictures.missing == library.missing()
    page = to_html([compared(report, report)])
    assert library.missing().split(":")[0] in page
    assert "<img" not in page
