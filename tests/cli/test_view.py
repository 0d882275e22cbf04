"""`meshopt view`."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from meshopt_cli.jobs import view
from meshopt_cli.jobs.view import worst_of
from meshopt_cli.pictures import library
from meshopt_cli.quality.measures import LESS, MEASURES
from support.corners import tri_quad_grid
from support.edits import shaken
from support.files import untouched, write
from support.meshes import hex_grid, octahedron, tet_grid
from support.pictures import is_png, needs_pictures, pixels, scene
from support.refused import bad_mesh
from support.samples import ROOT


@pytest.fixture
def drawn(monkeypatch):
    """What would have been drawn, which takes no library."""
    found = []

    def keep(drawings, scale, title, form, width):
        found.append((drawings, scale, title, form))
        return b"a picture"

    from meshopt_cli.pictures import sheet

    monkeypatch.setattr(sheet, "sheet", keep)
    monkeypatch.setattr(library, "find_spec", lambda name: name)
    return found


@needs_pictures
@pytest.mark.parametrize("name", ["a.png", "a.svg", "A.PNG"])
@pytest.mark.parametrize("options", [(), ("--worst", 2), ("--negative", "--shrink", 0.7)])
def test_a_picture_is_written(meshopt, tets, tmp_path, name, options):
    before = tets.read_bytes()
    ran = meshopt("view", tets, "-o", tmp_path / name, *options)
    assert (ran.status, ran.out, ran.err) == (0, "", "")
    data = (tmp_path / name).read_bytes()
    assert is_png(data) == name.lower().endswith("png")
    assert tets.read_bytes() == before
    again = tmp_path / f"again-{name}"
    assert meshopt("view", tets, "-o", again, *options).status == 0
    assert again.read_bytes() == data


@needs_pictures
def test_a_picture_is_as_wide_as_it_is_asked_for(meshopt, tets, tmp_path):
    assert meshopt("view", tets, "-o", tmp_path / "a.png", "--width", 321).status == 0
    assert pixels((tmp_path / "a.png").read_bytes()).shape[1] == 321


def test_orientations_are_counted(meshopt, tmp_path, drawn):
    one = hex_grid(2)
    one.points[(one.points == 0.5).all(axis=1)] = 0.95
    path = write(tmp_path / "a.vtk", one)
    assert meshopt("view", path, "-o", tmp_path / "a.png", "--negative").status == 0
    (_, scale, title, _) = drawn[0]
    assert re.fullmatch(r"a\.vtk: 8 hexahedra; [1-8] negative, 0 flat", title)
    assert scale.title == "orientation"


def test_no_library_is_loaded_for_a_report_without_pictures(tets):
    code = (
        "import sys; from meshopt_cli.cli.entry import status_of\n"
        "assert status_of(['report', sys.argv[1]]) == 0\n"
        "print(*{'matplotlib', 'pyvista', 'PIL'} & set(sys.modules), file=sys.stderr)"
    )
    path = {**os.environ, "PYTHONPATH": str(ROOT)}
    ran = subprocess.run([sys.executable, "-c", code, str(tets)], env=path, capture_output=True,
                         text=True, check=True)  # fmt: skip
    assert ran.stderr.split() == []


@needs_pictures
def test_names_of_any_letters_are_no_matter(meshopt, tmp_path, tets):
    path = tets.rename(tmp_path / f"\u7f51 $x_1$ {'long ' * 30}.vtk")
    ran = meshopt("view", path, "-o", tmp_path / "a.png")
    assert (ran.status, ran.err) == (0, "")


def test_the_measure_and_the_file_are_named(meshopt, triangles, tmp_path, drawn):
    ran = meshopt("view", triangles, "-o", tmp_path / "a.svg", "--measure", "corner-min")
    assert ran.status == 0, ran.err
    ((drawing,), scale, title, form) = drawn[0]
    assert form == "svg"
    assert drawing.is_flat
    assert "corner min" in scale.title
    assert title.startswith(f"{triangles.name}: 72 triangles; corner min ")


@pytest.mark.parametrize("make", [lambda: shaken(tet_grid(3)), tri_quad_grid, octahedron])
def test_close_ups_name_the_cells_as_the_file_does(meshopt, tmp_path, drawn, make):
    one = make(3) if make is tri_quad_grid else make()
    path = write(tmp_path / "a.mesh", one)
    assert meshopt("view", path, "-o", tmp_path / "a.png", "--worst", 4).status == 0
    drawings = drawn[0][0]
    assert len(drawings) == 4
    kinds = "tetrahedron|triangle|quadrilateral"
    assert all(re.fullmatch(rf"({kinds}) \d+, Q \d+\.\d+", d.title) for d in drawings)
    worst = [float(d.title.split()[-1]) for d in drawings]
    assert worst == sorted(worst, reverse=True)


@pytest.mark.parametrize("name", ["aspect-ratio", "dihedral-min", "content", "edge-max"])
def test_the_worst_are_those_of_the_measure(name):
    measure = MEASURES[name]
    seen = scene(shaken(tet_grid(3)), name)
    values = seen.values["tetra"]
    sign = 1.0 if measure.better == LESS else -1.0
    found = worst_of(seen, measure, 7)
    expected = np.sort(sign * values)[::-1][:7]
    assert [sign * value for _, _, value in found] == pytest.approx(expected)
    assert [values[row] for _, row, _ in found] == [value for _, _, value in found]


def test_solids_are_cut_in_the_middle_unless_it_is_said(meshopt, tmp_path, drawn):
    path = write(tmp_path / "a.vtk", hex_grid(4))
    for options in ((), ("--cut", "x=50%"), ("--cut", "none"), ("--cut", "z=0.3")):
        assert meshopt("view", path, "-o", tmp_path / "a.png", *options).status == 0
    counts = [drawings[0].layers[0].count for drawings, *_ in drawn]
    assert counts[0] == counts[1] == 4 * 4 * 2 * 6  # every one of these cells is seen
    assert counts[2] == 6 * 4**2  # the hull
    assert counts[3] == 4 * 4 * 6


@needs_pictures
def test_a_picture_goes_to_stdout(tets):
    code = "import sys; from meshopt_cli.cli.entry import run; sys.argv[0] = 'meshopt'; run()"
    path = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", code, "view", str(tets), "-o", "-"]
    ran = subprocess.run(words, env=path, capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert is_png(ran.stdout)


WRONG = [
    (("-o", "a.jpg"), 2, r"a\.jpg: a picture ends in \.png, \.svg"),
    (("-o", "a.png", "--measure", "aspect"), 2, "did you mean 'aspect-ratio'"),
    (("-o", "a.png", "--measure", "corner-min"), 2, "corner-min is no measure of tetrahedra"),
    (("-o", "a.png", "--cut", "q=1"), 2, "--cut q=1: a cut is such as"),
    (("-o", "a.png", "--cut", "x=-9"), 2, "no cell lies below: x goes from 0 to 1"),
    (("-o", "a.png", "--shrink", "0"), 2, "must be above 0 and at most 1"),
    (("-o", "a.png", "--worst", "0"), 2, "must be from 1 to 100"),
    (("-o", "a.png", "--width", "20000"), 2, "must be from 100 to 10000"),
    (("-o", "a.png", "--input-format", "gmsh"), 3, "not"),
    (("-o", "missing/a.png"), 3, "cannot be written"),
]


@pytest.mark.parametrize(("options", "status", "message"), WRONG)
def test_what_is_wrong_is_said(
    meshopt, tets, tmp_path, drawn, monkeypatch, options, status, message
):
    monkeypatch.chdir(tmp_path)
    with untouched(tmp_path):
        ran = meshopt("view", tets, *options)
    assert ran.status == status
    assert len(ran.err.splitlines()) == 1
    assert re.search(message, ran.err)


def test_a_mesh_is_not_drawn_over(meshopt, tets, tmp_path, drawn):
    with untouched(tmp_path):
        ran = meshopt("view", tets, "-o", tets)
    assert ran.status == 2
    assert "is an input itself" in ran.err


@pytest.mark.parametrize("name", ["lines", "points"])
def test_a_bad_mesh_is_not_drawn(meshopt, tmp_path, drawn, name):
    path, _, _ = bad_mesh(tmp_path, name)
    ran = meshopt("view", path, "-o", tmp_path / "a.png")
    assert ran.status in (1, 3)
    assert len(ran.err.splitlines()) == 1
    assert not (tmp_path / "a.png").exists()


def test_without_the_extra_it_is_said_how_to_get_it(meshopt, tets, tmp_path, monkeypatch):
    monkeypatch.setattr(library, "find_spec", lambda name: None)
    with untouched(tmp_path):
        ran = meshopt("view", tets, "-o", tmp_path / "a.png")
    assert ran.status == 2
    assert ran.err == f"meshopt: {library.missing()}\n"
    assert library.REMEDY in ran.err


def test_without_a_display_a_file_is_asked_for(meshopt, tets, monkeypatch, drawn):
    monkeypatch.setattr(view.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    ran = meshopt("view", tets)
    assert ran.status == 2
    assert re.fullmatch(r"meshopt: no display for a window: .* -o FILE.png\n", ran.err)
