"""Meshes in pieces on the command line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from support.edits import shaken
from support.files import contents, write
from support.meshes import tet_grid
from support.processes import heed_signals


@pytest.fixture
def index(meshopt, tets, tmp_path):
    path = tmp_path / "in.pvtu"
    ran = meshopt("split", tets, path, "--pieces", 3)
    assert ran.status == 0
    assert "3 pieces of 128 to 128 cells" in ran.out
    return path


def test_there_and_back(meshopt, index, tmp_path):
    ran = meshopt("optimize", index, tmp_path / "out.pvtu", "--report", tmp_path / "r.json")
    assert (ran.status, ran.err) == (0, "")
    assert "in.pvtu: 384 tetrahedra, 125 vertices" in ran.out
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["after"]["worst"] <= report["before"]["worst"]
    assert report["after"]["mean"] < report["before"]["mean"]
    assert report["output"]["format"] == "pvtu"
    assert "piece 0, " in {cell["cell"][:9] for cell in report["before"]["worst_cells"]}
    checked = meshopt("check", tmp_path / "out.pvtu", "--engine", "local")
    assert checked.status == 0
    assert checked.out.splitlines()[-1] == "4 files: 4 valid"
    joined = meshopt("join", tmp_path / "out.pvtu", tmp_path / "out.msh")
    assert joined.status == 0
    assert meshopt("check", tmp_path / "out.msh").status == 0


def test_in_place(meshopt, index, tmp_path):
    assert meshopt("optimize", index, index, "--preset", "fast").status == 2
    assert meshopt("optimize", index, "--in-place", "--preset", "fast", "-q").status == 0
    assert meshopt("check", index).status == 0
    assert not list(tmp_path.glob("*.work"))


def test_nothing_is_written_that_is_too_bad(meshopt, index, tmp_path):
    ran = meshopt("optimize", index, tmp_path / "out.pvtu", "--fail-above", 1.01)
    assert ran.status == 1
    assert "above 1.01: nothing written" in ran.err
    assert not (tmp_path / "out.pvtu").exists()


def test_wrong_words(meshopt, index, tets, tmp_path):
    out = tmp_path / "out.pvtu"
    for words, what in (
        (("optimize", tets, out), "meshopt split"),
        (("optimize", index, tmp_path / "out.vtu", "--engine", "local"), "for meshes in pieces"),
        (("optimize", index, out, "--engine", "local", "--scheduler", "x"), "--engine dask"),
        (("optimize", index, out, "--boundary", "slide"), "slide"),
        (("check", tets, "--engine", "local"), "for meshes in pieces"),
        (("check", index, "--engine", "local", "--mark", tmp_path / "m.vtu"), "--mark"),
        (("split", tets, tmp_path / "out.vtu", "--pieces", 2), ".pvtu"),
        (("split", tets, out, "--pieces", 1000), "1000 pieces cannot be made"),
        (("split", tets, out), "--pieces"),
    ):
        ran = meshopt(*words)
        assert ran.status == 2, words
        assert what in ran.complaint, words
    assert meshopt("split", tmp_path / "none.vtk", out, "--pieces", 2).status == 3
    assert not out.exists()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_was_ended_goes_on(number, meshopt, tmp_path):
    mesh = write(tmp_path / "mesh.vtu", shaken(tet_grid(12), 0.25, 1))
    index, out = tmp_path / "in.pvtu", tmp_path / "out.pvtu"
    assert meshopt("split", mesh, index, "--pieces", 6, "-q").status == 0
    assert meshopt("optimize", index, tmp_path / "expected.pvtu", "-q").status == 0
    command = [sys.executable, "-m", "meshopt_cli", "optimize", str(index), str(out), "-q"]
    with subprocess.Popen([*command, "--jobs", "2"], stderr=subprocess.PIPE, text=True,
                          preexec_fn=heed_signals) as run:  # noqa: PLW1509 # fmt: skip
        while not list((tmp_path / "out.work").glob("turn0/improve*.json")):
            assert run.poll() is None
            time.sleep(0.01)
        run.send_signal(number)
        run.communicate(timeout=60)
    assert run.returncode == (130 if number == signal.SIGINT else -9)
    assert not out.exists()
    ran = meshopt("optimize", index, out)
    assert ran.status == 0
    assert "goes on where it was ended" in ran.err
    expected, found = (
        [data for _, data in sorted(contents(tmp_path / name).items())]
        for name in ("expected", "out")
    )
    assert expected == found
