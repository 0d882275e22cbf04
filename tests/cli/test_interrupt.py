"""Ctrl-C, time limits and logs of single runs."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from support.edits import shaken
from support.files import write
from support.meshes import tet_grid

posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


@pytest.fixture
def large(tmp_path):
    """Enough for some seconds of the preset best."""
    return write(tmp_path / "in.vtu", shaken(tet_grid(22), 0.25, 1))


def interrupted(tmp_path, path, *options, twice=False):
    log = tmp_path / "log"
    words = ["optimize", path, tmp_path / "out.vtu", "--preset", "best", "--log-file", log]
    command = [sys.executable, "-m", "meshopt_cli", *map(str, words), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as run:  # fmt: skip
        while not log.exists() or log.read_text().count("round ") < 4:
            time.sleep(0.02)
            assert run.poll() is None
        start = time.monotonic()
        run.send_signal(signal.SIGINT)
        if twice:
            time.sleep(0.01)
            run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=30)
    return run.returncode, out, err, time.monotonic() - start


@posix
def test_an_interrupt_ends_a_run_at_once(tmp_path, large):
    status, out, err, seconds = interrupted(tmp_path, large)
    assert (status, out) == (130, "")
    assert "interrupted: nothing is written" in err
    assert seconds < 5
    assert not (tmp_path / "out.vtu").exists()


@posix
def test_an_interrupt_keeps_the_best_where_that_is_asked_for(tmp_path, large, meshopt):
    status, out, err, seconds = interrupted(tmp_path, large, "--keep-best", "--json")
    assert status == 130
    assert "out.vtu is written" in err
    assert seconds < 10
    report = json.loads(out)
    assert report["stopped"] == "cancelled"
    assert report["after"]["worst"] < report["before"]["worst"]
    assert meshopt("check", tmp_path / "out.vtu").status == 0


def test_keep_best_is_for_one_mesh(tmp_path, meshopt, large):
    assert meshopt("optimize", large, "--output-dir", tmp_path / "x", "--keep-best").status == 2


@pytest.mark.parametrize("limit", [0.1, 0.3])
def test_a_time_limit_is_kept(tmp_path, meshopt, large, limit):
    ran = meshopt("optimize", large, tmp_path / "out.vtu", "--preset", "best", "--json",
                  "--time-limit", limit)  # fmt: skip
    report = json.loads(ran.out)
    assert report["stopped"] == "time limit"
    assert sum(one["seconds"] for one in report["passes"]) < limit + 1.0
    assert report["after"]["worst"] <= report["before"]["worst"]


def test_a_log_tells_of_the_command_passes_warnings_and_errors(tmp_path, meshopt, tets):
    log = tmp_path / "log"
    assert meshopt("optimize", tets, tmp_path / "out.vtk", "-q", "--log-file", log).err == ""
    lines = log.read_text().splitlines()
    assert all(re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d+ [A-Z]+ ", line) for line in lines)
    assert "optimize" in lines[0]
    assert any("round 1: swap: " in line for line in lines)
    n = len(lines)
    ran = meshopt("report", tmp_path / "none.vtk", "--log-file", log)
    assert ran.status == 3
    assert ran.err.count("none.vtk") == 1
    lines = log.read_text().splitlines()
    assert len(lines) > n
    for command in ("check", "view", "repair"):
        words = [command, tmp_path / "none.vtk", *([tmp_path / "x.vtk"] * (command == "repair"))]
        words += {"repair": ["--all"], "view": ["-o", tmp_path / "x.png"]}.get(command, [])
        assert meshopt(*words, "--log-file", log).status == 3
        assert f": {command} " in log.read_text()
    assert meshopt("check", tets, "--log-file", tmp_path / "no" / "log").status == 3
