"""What goes to stdout and stderr, on terminals, in pipes and with strange names."""

import io
import os
import re
import subprocess
import sys

import pytest

from support.files import worst_of
from support.processes import ESCAPE, in_terminal, needs_terminal, outside, without_notice


@needs_terminal
def test_no_color_means_none_on_a_terminal_either(tets):
    status, shown = in_terminal("report", tets, stdout_too=True, NO_COLOR="1")
    assert status == 0
    assert b"tetrahedra" in shown
    assert ESCAPE.encode() not in shown


def test_a_pipe_gets_the_product_and_nothing_else(tets, tmp_path):
    ran = outside("optimize", tets, tmp_path / "out.vtk")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.startswith(tets.name)
    assert "\r" not in ran.out
    assert ESCAPE not in ran.out


@pytest.mark.parametrize("command", ["report", "list"])
def test_a_reader_that_goes_away_is_no_error(tets, command):
    """As in `meshopt report ... | head -1`, with a reader faster than any."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        child = subprocess.run(
            [
                sys.executable,
                "-m",
                "meshopt_cli",
                command,
                tets if command == "report" else "passes",
            ],
            stdout=writer,
            stderr=subprocess.PIPE,
            timeout=120,
            check=False,
        )
    finally:
        os.close(writer)
    assert without_notice(child.stderr.decode()) == ""
    # 1 would mean that the mesh is bad.
    assert child.returncode in {0, 141}


def test_a_reader_that_goes_away_does_not_undo_the_work(tets, tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    output = tmp_path / "out.vtk"
    command = [sys.executable, "-m", "meshopt_cli", "optimize", tets, output]
    try:
        child = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writer)
    assert without_notice(child.stderr.decode()) == ""
    assert child.returncode in {0, 141}
    assert worst_of(output) < worst_of(tets)


def test_a_name_that_stdout_cannot_show_is_no_error(meshopt, tets, tmp_path, monkeypatch):
    """On a terminal that is not UTF-8; above all not after the mesh was written."""
    path = tets.rename(tmp_path / "caf\u00e9.vtk")
    stdout = io.TextIOWrapper(io.BytesIO(), "ascii", write_through=True)
    monkeypatch.setattr("sys.stdout", stdout)
    ran = meshopt("optimize", path, tmp_path / "out.vtk")
    assert (ran.status, ran.err) == (0, "")
    assert b"tetrahedra" in stdout.buffer.getvalue()


def test_a_name_that_is_no_text_is_no_error(meshopt, tets, tmp_path):
    """Names of files are bytes; those from older systems may not be UTF-8."""
    try:
        path = tets.rename(tmp_path / os.fsdecode(b"caf\xe9.vtk"))
    except (OSError, UnicodeError):
        pytest.skip("the file system has no such names")
    reports = [tmp_path / f"report{suffix}" for suffix in (".json", ".md", ".csv", ".txt")]
    ran = meshopt("optimize", path, tmp_path / "out.vtk", "-q", *[f"--report={r}" for r in reports])
    assert ran == (0, "", "")
    assert all("caf" in report.read_text(encoding="utf-8") for report in reports)


def test_quiet_says_nothing(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "-q")
    assert ran == (0, "", "")
    assert worst_of(tmp_path / "out.vtk") < worst_of(tets)


def test_quiet_says_errors(meshopt, tmp_path):
    ran = meshopt("optimize", tmp_path / "missing.vtk", tmp_path / "out.vtk", "-q")
    assert ran.status == 3
    assert "missing.vtk" in ran.complaint


def test_verbose_shows_each_round(meshopt, tets, tmp_path):
    arguments = ["optimize", tets, tmp_path / "out.vtk", "--passes", "smooth,swap"]
    short, long = meshopt(*arguments), meshopt(*arguments, "-v")
    for name in ("smooth", "swap"):
        rounds = [int(n) for n in re.findall(rf"^{name} +(\d+) ", long.out, re.M)]
        assert rounds == list(range(1, len(rounds) + 1))
        assert re.findall(rf"^{name} +(\d+) ", short.out, re.M) == [str(len(rounds))]
    assert len(rounds) > 1
    assert ESCAPE not in long.out + long.err
