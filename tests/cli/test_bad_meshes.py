"""A bad mesh, our own bugs, an interrupt: status 1, 4 and 130."""

import os
import re
import signal

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.errors import InvariantError
from meshopt_cli.jobs import optimize as job
from support.edits import shaken, turned_over
from support.files import contents, fail, strict, untouched, worst_of, write
from support.meshes import large_grid, tet_grid
from support.processes import in_terminal, needs_terminal


def test_an_invalid_mesh_is_not_optimized_and_its_cells_are_named(meshopt, broken, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("optimize", broken, tmp_path / "out.vtk")
    assert (ran.status, ran.out) == (1, "")
    *findings, last = ran.err.splitlines()
    assert last.startswith(f"meshopt: {broken}: ")
    named = [re.match(rf"{re.escape(str(broken))}:cell (\d+): (M\d+) ", line) for line in findings]
    assert all(named)
    assert {match[2] for match in named} >= {"M101", "M201"}
    one = formats.read(broken)[0]
    cells = one.blocks[0].cells
    corners = one.points[cells]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    assert {int(m[1]) for m in named if m[2] == "M101"} == set(np.flatnonzero(volume < 0).tolist())
    same = [{int(m[1])} for m in named if m[2] == "M201"]
    assert same == [{len(cells) - 1}]


def test_a_mesh_that_stays_too_bad_is_not_written(meshopt, tets, tmp_path):
    report = tmp_path / "report.json"
    output = tmp_path / "out.vtk"
    ran = meshopt("optimize", tets, output, "--fail-above", "1.05", "--report", report)
    assert ran.status == 1
    assert str(tets) in ran.complaint
    assert "1.05" in ran.complaint
    assert set(contents(tmp_path)) == {tets, report}
    value = strict(report.read_text())
    assert value["output"] is None
    assert value["after"]["worst"] > 1.05
    assert value["input"]["path"] == str(tets)


def test_a_mesh_that_is_good_enough_is_written(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "--fail-above", "100")
    assert (ran.status, ran.err) == (0, "")
    assert worst_of(tmp_path / "out.vtk") <= 100


def test_a_bad_mesh_in_place_stays_as_it_is(meshopt, tets, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, "--in-place", "--fail-above", "1.05", "-q")
    assert (ran.status, ran.out) == (1, "")
    assert str(tets) in ran.complaint


def test_a_mesh_of_the_other_orientation_is_turned(meshopt, tmp_path):
    path = write(tmp_path / "turned.mesh", turned_over(shaken(tet_grid(3))))
    output = tmp_path / "out.mesh"
    ran = meshopt("optimize", path, output)
    assert ran.status == 0
    assert "turned" in ran.complaint
    one = formats.read(output)[0]
    corners = one.points[one.blocks[-1].cells]
    assert np.all(np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0)
    assert meshopt("check", path).status == 1
    assert meshopt("check", output).status == 0


@pytest.mark.parametrize("name", ["tets", "triangles"])
def test_what_optimize_writes_check_accepts(meshopt, request, tmp_path, name):
    path = request.getfixturevalue(name)
    output = tmp_path / f"out{path.suffix}"
    assert meshopt("optimize", path, output, "--preset", "best").status == 0
    ran = meshopt("check", output)
    assert (ran.status, ran.err) == (0, "")
    assert worst_of(output) < worst_of(path)


def test_a_broken_invariant(meshopt, tets, tmp_path, monkeypatch):
    monkeypatch.setattr(job, "prove", fail(InvariantError("the volume of a region changed")))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk")
    assert (ran.status, ran.out) == (4, "")
    assert "the volume of a region changed" in ran.complaint
    assert str(tets) in ran.complaint


@pytest.mark.parametrize("traceback", [False, True])
def test_an_unexpected_error(meshopt, tets, tmp_path, monkeypatch, traceback):
    if traceback:
        monkeypatch.setenv("MESHOPT_TRACEBACK", "1")
    monkeypatch.setattr(job, "prove", fail(ZeroDivisionError("in two\nlines")))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk")
    assert (ran.status, ran.out) == (4, "")
    assert ("Traceback" in ran.err) == traceback
    last = ran.err.splitlines()[-1] if traceback else ran.complaint
    assert last.startswith("meshopt: internal error")
    assert "ZeroDivisionError" in last
    assert "in two lines" in last


def test_an_interrupt_is_one_line(meshopt, tets, tmp_path, monkeypatch):
    monkeypatch.setattr(job, "prove", fail(KeyboardInterrupt()))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk")
    assert (ran.status, ran.out) == (130, "")
    assert "interrupted" in ran.complaint


def test_an_interrupt_while_writing_leaves_nothing_behind(meshopt, tets, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", fail(KeyboardInterrupt()))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk")
    assert ran.status == 130


@needs_terminal
def test_ctrl_c_stops_the_work_and_leaves_nothing_behind(tmp_path):
    path = write(tmp_path / "large.vtu", large_grid(24))
    with untouched(tmp_path):
        status, shown = in_terminal(
            "optimize", path, tmp_path / "out.vtu", "--preset", "standard",
            until=b"smooth", send=signal.SIGINT,
        )  # fmt: skip
    assert b"\r" in shown.rstrip(b"\r\n"), "no progress bar was on the terminal"
    assert status == 130
    assert b"Traceback" not in shown
    assert b"interrupted" in shown.splitlines()[-1]
