"""The command line: exit statuses, what goes to stdout and stderr, and what is written."""

import contextlib
import csv
import gzip
import hashlib
import io
import json
import logging
import os
import re
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import fields, replace
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
import pytest
from builders import hex_grid, in_space, mesh, octahedron, quad_grid, tet_grid, tri_grid

from meshopt_cli import __version__, formats
from meshopt_cli.cli.main import COMMANDS, STATUSES, main, status_of
from meshopt_cli.errors import InvariantError
from meshopt_cli.formats import FORMATS, Encoding, encoding_for
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.quality.summary import DEFAULT_MEASURE, MEASURES, cell_quality
from meshopt_cli.report.rows import HEADINGS
from meshopt_cli.validity import RULES

try:
    import termios
except ImportError:
    termios = None

ESCAPE = "\x1b"
NOTICE = "compiling kernels"  # said once on each machine, whatever the command

needs_terminal = pytest.mark.skipif(termios is None, reason="this system has no pseudo-terminals")


# Helpers ----------------------------------------------------------------------------------


class Ran(NamedTuple):
    """What became of a command line."""

    status: int
    out: str
    err: str

    @property
    def complaint(self):
        """The one line on stderr."""
        (line,) = self.err.splitlines()
        assert line.startswith("meshopt: ")
        return line


@pytest.fixture(autouse=True)
def _plain_environment(monkeypatch):
    """What a user may have set does not change what is shown."""
    for name in ("FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "COLUMNS", "MESHOPT_TRACEBACK"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture(autouse=True)
def _log_as_before():
    """Give the log back to the other tests as it was."""
    log = logging.getLogger("meshopt")
    handlers, level, propagate = log.handlers[:], log.level, log.propagate
    yield
    log.handlers[:], log.propagate = handlers, propagate
    log.setLevel(level)


def without_notice(text):
    return "".join(line for line in text.splitlines(keepends=True) if NOTICE not in line)


@pytest.fixture
def meshopt(capsys):
    """Run a command line in this process."""

    def run(*arguments):
        capsys.readouterr()
        status = status_of([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Ran(status, out, without_notice(err))

    return run


def outside(*arguments, **environment):
    """Run a command line in a process of its own, with pipes for stdout and stderr."""
    child = subprocess.run(
        [sys.executable, "-m", "meshopt_cli", *map(str, arguments)],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "utf-8", **environment},
        timeout=120,
        check=False,
    )
    out, err = child.stdout.decode(), child.stderr.decode()
    return Ran(child.returncode, out, without_notice(err))


def write(path, one, encoding=None):
    formats.write(path, one, encoding or encoding_for(path))
    return path


def shaken(grid, seed=0):
    """A grid with its internal points moved, all cells positive still."""
    points = grid.points
    side = round(len(points) ** (1 / points.shape[1])) - 1
    inner = np.all((points > 1e-9) & (points < 1 - 1e-9), axis=1)
    generator = np.random.default_rng(seed)
    points[inner] += generator.uniform(-0.22, 0.22, (inner.sum(), points.shape[1])) / side
    return grid


def turned(one):
    """The mesh with all its cells listed the other way round."""
    blocks = [replace(b, cells=b.cells[:, [0, 2, 1, *range(3, b.cells.shape[1])]].copy())
              for b in one.blocks]  # fmt: skip
    return replace(one, blocks=blocks)


@pytest.fixture
def tets(tmp_path):
    """A file of tetrahedra with something to gain."""
    return write(tmp_path / "tets.vtk", shaken(tet_grid(4)))


@pytest.fixture
def triangles(tmp_path):
    return write(tmp_path / "triangles.vtu", in_space(shaken(tri_grid(6))))


@pytest.fixture
def broken(samples):
    return samples / "broken.vtk"


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@contextlib.contextmanager
def untouched(folder):
    """Prove that no file comes, goes or changes, temporary ones included."""
    before = contents(folder)
    yield
    assert contents(folder) == before


def worst_of(path, measure=DEFAULT_MEASURE):
    simplices = cast(formats.read(path)[0])
    q = cell_quality(simplices.points, simplices.cells, MEASURES[measure])
    return 1.0 / q.min() if q.min() > 0 else np.inf


def strict(text):
    """Read JSON as the standard has it, without NaN and Infinity."""

    def refuse(constant):
        raise ValueError(constant)

    return json.loads(text, parse_constant=refuse)


# Meshes that are wrong, each in its own way: what is in them, the exit status, what is said.
BAD_MESHES = {
    "quads": (lambda: in_space(quad_grid(3)), 3, "quad"),
    "second_order": (lambda: mesh(np.random.default_rng(0).random((10, 3)), tetra10=[range(10)]),
                     3, "tetra10"),
    "surface": (octahedron, 3, "plane"),
    "hexes_and_tets": (lambda: mesh([*hex_grid(1).points, *(np.eye(4, 3) + 2)],
                                    hexahedron=hex_grid(1).blocks[0].cells, tetra=[[11, 8, 9, 10]]),
                       3, "hexahedron"),
    "lines": (lambda: mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], line=[[0, 1], [1, 2]]), 1, "lines"),
    "points": (lambda: mesh([[0, 0, 0], [1, 0, 0]], vertex=[[0], [1]]), 1, "points"),
}  # fmt: skip
every_bad_mesh = pytest.mark.parametrize("name", BAD_MESHES)


def bad_mesh(folder, name):
    make, status, said = BAD_MESHES[name]
    return write(folder / f"{name}.vtu", make()), status, said


# Help -------------------------------------------------------------------------------------


def test_help_of_the_module_shows_the_exit_statuses():
    ran = outside("--help")
    assert (ran.status, ran.err) == (0, "")
    text = " ".join(ran.out.split())
    for status, meaning in STATUSES.items():
        assert f"{status} {meaning}" in text
    for command in COMMANDS:
        assert re.search(rf"^  {command} ", ran.out, re.M)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_shows_all_its_options(meshopt, command):
    ran = meshopt(command, "--help")
    assert (ran.status, ran.err) == (0, "")
    parameters = main.get_command(click.Context(main), command).params
    options = [name for p in parameters if isinstance(p, click.Option) for name in p.opts]
    assert options or command == "list"
    assert all(option in ran.out for option in options)


def test_version(meshopt):
    assert meshopt("--version").out.split()[-1] == __version__


# Usage: status 2 ---------------------------------------------------------------------------


WRONG_OPTIONS = [
    (["--preset", "fats"], "fast"),
    (["--passes", "swapp"], "swap"),
    (["--passes", "smooth,swapp"], "swap"),
    (["--passes", ""], "passes"),
    (["--passes", " , "], "passes"),
    (["--measure", "aspect"], "aspect-ratio"),
    (["--measure", "edge-ratio"], "edge-ratio"),
    (["--file-format", "stl"], "vtu"),
    (["--input-format", "stl"], "vtu"),
    (["--region", "none"], "none"),
    (["--set", "smooth"], "PASS.OPTION=VALUE"),
    (["--set", "smoth.below=2"], "smooth"),
    (["--set", "smooth.belo=2"], "below"),
    (["--set", "smooth.below=much"], "smooth.below"),
    (["--set", "smooth.below=0.5"], "smooth.below"),
    (["--set", "smooth.method=no"], "laplace"),
    (["--passes", "swap", "--set", "smooth.below=2"], "smooth"),
    (["--preset", "fast", "--passes", "swap"], "--passes"),
    (["--config", "missing.toml"], "missing.toml"),
    (["--report", "report.doc"], "report.doc"),
    (["--report", "report"], "report"),
    (["--rounds", "0"], "--rounds"),
    (["--rounds", "many"], "--rounds"),
    (["--target-quality", "0.5"], "--target-quality"),
    (["--target-quality", "nan"], "target-quality"),
    (["--time-limit", "-1"], "--time-limit"),
    (["--time-limit", "nan"], "time-limit"),
    (["--fail-above", "0.9"], "--fail-above"),
    (["--fail-above", "nan"], "fail-above"),
    (["--no-such-option"], "--no-such-option"),
    (["-q", "-v"], "-v"),
    (["third.vtk"], "third.vtk"),
]
every_wrong_option = pytest.mark.parametrize(
    ("arguments", "said"), WRONG_OPTIONS, ids=[" ".join(a) for a, _ in WRONG_OPTIONS]
)


@every_wrong_option
def test_a_wrong_option_is_named_and_nothing_is_written(
    meshopt, tets, tmp_path, monkeypatch, arguments, said
):
    monkeypatch.chdir(tmp_path)
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk", *arguments)
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--rounds", "0"],
        ["--no-such-option"],
        ["--set"],
        ["-q", "-v"],
        ["--preset", "fats"],
    ],
    ids=" ".join,
)
def test_wrong_usage_is_said_in_one_line(meshopt, tets, tmp_path, arguments):
    assert meshopt("optimize", tets, tmp_path / "out.vtk", *arguments).complaint


@pytest.mark.parametrize(
    "arguments",
    [
        ["optimise"],
        ["optimize"],
        ["check"],
        ["report"],
        ["list"],
        ["list", "meshes"],
        ["check", "MESH", "--format", "xml"],
        ["check", "MESH", "--select", "M999"],
        ["check", "MESH", "--ignore", "X"],
        ["check", "missing.vtk", "--select", "M999"],
        ["check", "MESH", "-q", "-v"],
        ["report", "MESH", "--format", "xml"],
        ["report", "MESH", "--measure", "aspect"],
        ["report", "missing.vtk", "--measure", "aspect"],
    ],
    ids=" ".join,
)
def test_wrong_usage_of_the_commands(meshopt, tets, arguments):
    ran = meshopt(*[tets if word == "MESH" else word for word in arguments])
    assert (ran.status, ran.out) == (2, "")
    assert ran.err


@pytest.mark.parametrize("link", ["same", "other spelling", "symbolic", "hard"])
def test_output_over_input_needs_to_be_asked_for(meshopt, tets, tmp_path, link):
    output = tmp_path / "link.vtk"
    if link == "same":
        output = tets
    elif link == "other spelling":
        (tmp_path / "sub").mkdir()
        output = tmp_path / "sub" / ".." / tets.name
    elif link == "symbolic":
        output.symlink_to(tets)
    else:
        os.link(tets, output)
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, output)
    assert (ran.status, ran.out) == (2, "")
    assert str(output) in ran.complaint
    assert "--in-place" in ran.complaint


def test_output_may_not_be_missing(meshopt, tets, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("optimize", tets)
    assert (ran.status, ran.out) == (2, "")
    assert "OUTPUT" in ran.complaint


@pytest.mark.parametrize("twice", [False, True])
def test_in_place(meshopt, tets, tmp_path, twice):
    before = worst_of(tets)
    ran = meshopt("optimize", tets, *[tets] * twice, "--in-place")
    assert (ran.status, ran.err) == (0, "")
    assert list(contents(tmp_path)) == [tets]
    assert worst_of(tets) < before


# Files: status 3 ---------------------------------------------------------------------------


def unreadable(folder):
    """Paths that are no mesh files, by what is wrong with them."""
    paths = {
        "missing": folder / "missing.vtk",
        "folder": folder / "folder.vtk",
        "extension": folder / "mesh.stl",
        "no extension": folder / "mesh",
        "empty": folder / "empty.vtu",
        "nonsense": folder / "nonsense.msh",
        "truncated": folder / "truncated.mesh",
        "below a file": folder / "file" / "mesh.vtk",
    }
    paths["folder"].mkdir()
    paths["extension"].write_text("solid")
    paths["no extension"].write_text("MeshVersionFormatted 2")
    paths["empty"].write_text("")
    paths["nonsense"].write_bytes(bytes(range(256)))
    paths["truncated"].write_text("MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0")
    (folder / "file").write_text("no folder")
    return paths


@pytest.mark.parametrize("what", ["missing", "folder", "extension", "no extension", "empty",
                                  "nonsense", "truncated", "below a file"])  # fmt: skip
@pytest.mark.parametrize("command", ["optimize", "check", "report"])
def test_a_file_that_cannot_be_read(meshopt, tmp_path, command, what):
    path = unreadable(tmp_path)[what]
    with untouched(tmp_path):
        ran = meshopt(command, path, *([tmp_path / "out.vtk"] if command == "optimize" else []))
    assert (ran.status, ran.out) == (3, "")
    assert str(path) in ran.complaint


@every_bad_mesh
def test_a_mesh_that_is_of_no_use(meshopt, tmp_path, name):
    path, status, said = bad_mesh(tmp_path, name)
    with untouched(tmp_path):
        ran = meshopt("optimize", path, tmp_path / "out.vtu")
    assert (ran.status, ran.out) == (status, "")
    assert str(path) in ran.complaint
    assert said in ran.complaint


@pytest.mark.parametrize("name", ["quads", "lines", "points"])
def test_a_mesh_without_simplices_has_no_report(meshopt, tmp_path, name):
    path, status, said = bad_mesh(tmp_path, name)
    ran = meshopt("report", path)
    assert (ran.status, ran.out) == (status, "")
    assert str(path) in ran.complaint
    assert said in ran.complaint


# What can be measured of a mesh that cannot be optimized: cells, vertices, what is said.
MEASURED = {"second_order": (1, 4, "corners"), "surface": (8, 6, "own plane"),
            "hexes_and_tets": (1, 4, "1 cells of type hexahedron")}  # fmt: skip


@pytest.mark.parametrize("name", MEASURED)
def test_a_report_says_what_it_can(meshopt, tmp_path, name):
    path, _, _ = bad_mesh(tmp_path, name)
    n_cells, n_points, said = MEASURED[name]
    ran = meshopt("report", path, "--format", "json")
    assert ran.status == 0
    assert said in ran.complaint
    before = strict(ran.out)["before"]
    assert (before["ne"], before["np"]) == (n_cells, n_points)
    if name == "surface":  # equilateral triangles
        assert before["worst"] == pytest.approx(1)
        assert before["angle_min"] == pytest.approx(60)


@pytest.mark.parametrize(
    "where", ["out.stl", "out", "file/out.vtk", "missing/out.vtk", "folder.vtk"]
)
def test_a_file_that_cannot_be_written(meshopt, tets, tmp_path, where):
    (tmp_path / "file").write_text("no folder")
    (tmp_path / "folder.vtk").mkdir()
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / where)
    assert (ran.status, ran.out) == (3, "")
    assert str(tmp_path / where) in ran.complaint


def fail(error):
    """A function that raises this, whatever it is called with."""

    def failing(*_, **__):
        raise error

    return failing


@pytest.mark.parametrize("function", ["replace", "fsync"])
@pytest.mark.parametrize("exists", [False, True])
def test_a_disk_that_fails_leaves_all_as_it_was(
    meshopt, tets, tmp_path, monkeypatch, function, exists
):
    output = tmp_path / "out.vtk"
    if exists:
        output.write_text("an older file")
    monkeypatch.setattr(os, function, fail(OSError(28, "No space left on device")))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, output)
    assert (ran.status, ran.out) == (3, "")
    assert str(output) in ran.complaint
    assert "no space" in ran.complaint.lower()


def test_a_report_that_cannot_be_written(meshopt, tets, tmp_path):
    path = tmp_path / "missing" / "report.md"
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "--report", path)
    assert ran.status == 3
    assert str(path) in ran.complaint
    ran = meshopt("report", tets, "-o", path)
    assert (ran.status, ran.out) == (3, "")
    assert str(path) in ran.complaint


# A bad mesh: status 1 -------------------------------------------------------------------------


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
    path = write(tmp_path / "turned.mesh", turned(shaken(tet_grid(3))))
    output = tmp_path / "out.mesh"
    ran = meshopt("optimize", path, output)
    assert ran.status == 0
    assert "orientation" in ran.complaint
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


# Our own bugs: status 4 -----------------------------------------------------------------------


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


# Interrupted: status 130 ----------------------------------------------------------------------


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


def large_grid(n):
    """A shaken grid of 6 n^3 tetrahedra, too much work for a blink."""
    small = tet_grid(1).blocks[0].cells
    axis = np.arange(n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3) * 1.0
    corner = np.stack(np.unravel_index(small, (2, 2, 2)), -1)
    cubes = np.stack(np.meshgrid(axis[:-1], axis[:-1], axis[:-1], indexing="ij"), -1).reshape(-1, 3)
    places = (cubes[:, None, None] + corner).reshape(-1, 4, 3)
    cells = np.ravel_multi_index(np.moveaxis(places, -1, 0), (n + 1,) * 3)
    inner = np.all((points > 0) & (points < n), axis=1)
    points[inner] += np.random.default_rng(0).uniform(-0.22, 0.22, (inner.sum(), 3))
    return Mesh(points, [Block("tetra", cells)])


def in_terminal(*arguments, until=None, send=None, stdout_too=False, **environment):
    """Run a command line with stderr, or also stdout, on a terminal of its own.

    Parameters
    ----------
    until : bytes, optional
        Once this is on the terminal, send the signal.

    Returns
    -------
    status : int
    shown : bytes
        All that was on the terminal.
    """
    ours, theirs = os.openpty()
    termios.tcsetwinsize(theirs, (24, 100))
    child = subprocess.Popen(
        [sys.executable, "-m", "meshopt_cli", *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=theirs if stdout_too else subprocess.DEVNULL,
        stderr=theirs,
        env={**os.environ, "PYTHONIOENCODING": "utf-8", "TERM": "xterm", **environment},
    )
    os.close(theirs)
    shown = b""
    try:
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:  # how Linux says that the other end is closed
                break
            if not piece:
                break
            shown += piece
            if send is not None and until in shown:
                child.send_signal(send)
                send = None
        return child.wait(timeout=60), shown
    finally:
        child.kill()
        child.wait()
        os.close(ours)


@needs_terminal
def test_ctrl_c_stops_the_work_and_leaves_nothing_behind(tmp_path):
    path = write(tmp_path / "large.vtu", large_grid(16))
    with untouched(tmp_path):
        status, shown = in_terminal(
            "optimize", path, tmp_path / "out.vtu", "--preset", "best",
            until=b"smooth", send=signal.SIGINT,
        )  # fmt: skip
    assert b"\r" in shown.rstrip(b"\r\n"), "no progress bar was on the terminal"
    assert status == 130
    assert b"Traceback" not in shown
    assert b"interrupted" in shown.splitlines()[-1]


# Streams --------------------------------------------------------------------------------------


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


def test_arrays_go_along_unless_told_otherwise(meshopt, tmp_path):
    one = shaken(tet_grid(3))
    n = len(one.blocks[0].cells)
    one.blocks[0].data = {"stress": np.linspace(0, 1, n), "part": np.arange(n) % 2}
    one.point_data = {"T": np.linspace(0, 1, len(one.points))}
    path, output = write(tmp_path / "in.vtu", one), tmp_path / "out.vtu"
    for options, names in (((), {"stress", "part"}), (("--no-data",), {"part"})):
        ran = meshopt("optimize", path, output, "--passes", "smooth", *options)
        assert (ran.status, ran.err) == (0, "")
        result = formats.read(output)[0]
        assert set(result.blocks[0].data) == names
        assert set(result.point_data) == ({"T"} if "stress" in names else set())


def test_arrays_that_make_regions(meshopt, tmp_path):
    one = shaken(tet_grid(3))
    n = len(one.blocks[0].cells)
    one.blocks[0].data = {"part": np.arange(n) % 2, "layer": np.arange(n) // (n // 3)}
    path, output = write(tmp_path / "in.vtu", one), tmp_path / "out.vtu"
    ran = meshopt("optimize", path, output, "--region", "part", "--region", "layer")
    assert ran.status == 0
    ran = meshopt("optimize", path, output, "--region", "parts")
    assert ran.status == 2
    assert f"{path}: no array 'parts'" in ran.complaint
    assert "part, layer" in ran.complaint


# Pipes, compressed files, text and binary ---------------------------------------------------


def in_a_pipe(data, *arguments):
    """Run a command line with a mesh on stdin; stdout as bytes."""
    command = [sys.executable, "-m", "meshopt_cli", *map(str, arguments)]
    child = subprocess.run(command, input=data, capture_output=True, timeout=120, check=False)
    return child.returncode, child.stdout, without_notice(child.stderr.decode())


@pytest.mark.parametrize("options", [(), ("--input-format", "vtk", "--file-format", "vtk")])
def test_a_mesh_through_a_pipe(meshopt, tets, tmp_path, options):
    """The mesh is all that stdout gets; the report goes to stderr."""
    status, out, err = in_a_pipe(tets.read_bytes(), "optimize", "-", "-", *options)
    assert status == 0
    assert meshopt("optimize", tets, tmp_path / "out.vtk").status == 0
    assert out == (tmp_path / "out.vtk").read_bytes()
    assert "Q_T" in err


def test_the_json_report_beside_a_pipe(tets, tmp_path):
    report = tmp_path / "report.json"
    arguments = ("optimize", "-", "-", "--file-format", "vtu", "--json", "--report", report)
    status, out, err = in_a_pipe(tets.read_bytes(), *arguments)
    assert status == 0
    assert json.loads(err) == json.loads(report.read_text())
    said = json.loads(err)
    assert said["input"]["sha256"] == hashlib.sha256(tets.read_bytes()).hexdigest()
    assert said["output"] == {
        "path": "-", "format": "vtu", "sha256": hashlib.sha256(out).hexdigest()
    }  # fmt: skip


@pytest.mark.parametrize(
    ("data", "arguments", "status", "said"),
    [
        (b"", ("-", "-"), 3, "empty"),
        (b"solid", ("-", "-"), 3, "not a mesh"),
        (b"# vtk DataFile Version 3.0\n", ("-", "-", "--input-format", "gmsh"), 3, "not a Gmsh"),
        (b"", ("-",), 2, "OUTPUT"),
        (b"", ("-", "--in-place"), 2, "OUTPUT"),
    ],
)
def test_what_is_wrong_in_a_pipe(data, arguments, status, said):
    ran = in_a_pipe(data, "optimize", *arguments)
    assert ran[:2] == (status, b"")
    (line,) = ran[2].splitlines()
    assert said in line


def test_nothing_goes_down_the_pipe_when_the_mesh_stays_bad(tets):
    status, out, err = in_a_pipe(tets.read_bytes(), "optimize", "-", "-", "--fail-above", "1.01")
    assert status == 1
    assert b"DATASET" not in out
    assert "nothing written" in err


def test_check_and_report_read_pipes_and_compressed_files(meshopt, tets, tmp_path):
    status, out, _ = in_a_pipe(tets.read_bytes(), "check", "-")
    assert (status, out.decode().strip()) == (0, "-: valid")
    packed = tmp_path / "packed.vtk.gz"
    packed.write_bytes(gzip.compress(tets.read_bytes()))
    assert meshopt("report", packed).out.startswith("packed.vtk.gz: ")


def test_compressed_in_and_out(meshopt, tets, tmp_path):
    packed, output = tmp_path / "packed.vtk.gz", tmp_path / "out.mesh.gz"
    packed.write_bytes(gzip.compress(tets.read_bytes()))
    assert meshopt("optimize", packed, output).status == 0
    assert meshopt("optimize", tets, tmp_path / "out.mesh").status == 0
    assert gzip.decompress(output.read_bytes()) == (tmp_path / "out.mesh").read_bytes()


@pytest.mark.parametrize("suffix", [".msh", ".vtk", ".vtu"])
def test_text_or_binary_on_request(meshopt, tets, tmp_path, suffix):
    output = tmp_path / f"out{suffix}"
    for option, binary in (("--ascii", False), ("--binary", True)):
        assert meshopt("optimize", tets, output, option).status == 0
        assert formats.sniff(output).binary == binary


def test_medit_is_text_or_binary_by_its_name(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.mesh", "--binary")
    assert ran.status == 2
    assert ".meshb" in ran.complaint
    assert meshopt("optimize", tets, tmp_path / "out.mesh", "--ascii").status == 0


def test_the_report_says_what_is_lost(meshopt, samples, tmp_path):
    ran = meshopt("optimize", samples / "two_regions.msh", tmp_path / "out.mesh", "--json")
    names = formats.read(samples / "two_regions.msh")[0].names
    lost = " ".join(json.loads(ran.out)["lost"])
    assert names
    assert all(f"{name} = {tag}" in lost for name, (tag, _) in names.items())
    assert lost.split(",")[0] in ran.complaint


# Refusals ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Mesh(np.random.default_rng(0).random((6, 3)),
                      [Block("triangle6", np.arange(6)[None])]), "first order"),
        (lambda: quad_grid(2), "simplices"),
        (octahedron, "meshopt check"),
        (lambda: replace(tet_grid(2), points=tet_grid(2).points * 1e60), "scale it"),
        (lambda: replace(tri_grid(2), points=tri_grid(2).points * 1e-60), "scale it"),
    ],
    ids=["second order", "quads", "surface", "huge", "tiny"],
)  # fmt: skip
def test_what_cannot_be_optimized_is_refused_with_a_remedy(meshopt, tmp_path, make, said):
    path = tmp_path / "in.msh"
    formats.write(path, make(), encoding_for(path))
    ran = meshopt("optimize", path, tmp_path / "out.msh")
    assert ran.status == 3
    assert said in ran.complaint
    assert not (tmp_path / "out.msh").exists()


def test_a_place_that_is_none_is_refused_before_the_work(meshopt, tmp_path):
    for place in (tmp_path / "none" / "out.msh", tmp_path):
        ran = meshopt("optimize", tmp_path / "not_read.msh", place)
        assert ran.status == 3
        assert f"{place}: cannot be written" in ran.complaint


def test_arrays_on_cells_of_all_dimensions(meshopt, tmp_path):
    """VTK has every array on every cell: one that lines keep and triangles lose is a trap."""
    one = in_space(shaken(tri_grid(5)))
    one.blocks.append(Block("line", np.array([[0, 1], [1, 2]])))
    for block in one.blocks:
        n = len(block.cells)
        block.data = {"stress": np.linspace(0, 1, n), "part": np.full(n, 3)}
    for suffix in (".vtk", ".vtu"):
        path, output = tmp_path / f"in{suffix}", tmp_path / f"out{suffix}"
        write(path, one)
        ran = meshopt("optimize", path, output)
        assert ran.status == 0
        result = formats.read(output)[0]
        assert all(b.data["stress"].max() <= 1 for b in result.blocks)
        assert [b.type for b in result.blocks] == ["triangle", "line"]
        assert all(np.all(b.data["part"] == 3) for b in result.blocks)


# The report -----------------------------------------------------------------------------------


SUMMARY_KEYS = {"ne", "np", "worst", "mean", "best", "target", "invalid", "histogram",
                "angle_min", "angle_max", "angles_forced", "measures"}  # fmt: skip
PASS_KEYS = {"round", "name", "visited", "applied", "refused", "seconds", "worst", "mean"}
TOP_KEYS = {"meshopt", "input", "output", "measure", "dimension", "before", "after", "passes",
            "stopped", "seconds", "lost"}  # fmt: skip
FILE_KEYS = {"path", "format", "sha256"}


def check_summary(value, one, measure=DEFAULT_MEASURE):
    """What is said of a mesh is so."""
    assert set(value) == SUMMARY_KEYS
    simplices = cast(one)
    q = cell_quality(simplices.points, simplices.cells, MEASURES[measure])
    assert value["ne"] == len(simplices.cells)
    assert value["np"] == len(np.unique(simplices.cells))
    assert value["worst"] == pytest.approx(1 / q.min(), rel=1e-12)
    assert value["best"] == pytest.approx(1 / q.max(), rel=1e-12)
    assert value["mean"] == pytest.approx(np.mean(1 / q), rel=1e-12)
    assert value["invalid"] == 0
    assert value["measures"][measure] == value["worst"]
    assert set(value["measures"]) == set(MEASURES)
    histogram = value["histogram"]
    assert set(histogram) == {"edges", "counts", "percent"}
    assert histogram["edges"] == [1, 2, 3, 10, None]
    assert sum(histogram["counts"]) == value["ne"]
    assert sum(histogram["percent"]) == pytest.approx(100.0)
    assert histogram["counts"][0] == np.sum(1 / q <= 2)


@pytest.mark.parametrize("name", ["tets", "triangles"])
@pytest.mark.parametrize("measure", [DEFAULT_MEASURE, "mean-edge"])
def test_the_json_report(meshopt, request, tmp_path, name, measure):
    path = request.getfixturevalue(name)
    output = tmp_path / f"out{path.suffix}"
    ran = meshopt("optimize", path, output, "--json", "--measure", measure, "-v")
    assert ran.status == 0
    value = strict(ran.out)
    assert set(value) == TOP_KEYS
    assert value["meshopt"] == __version__
    assert value["measure"] == measure
    assert value["dimension"] == {"tets": 3, "triangles": 2}[name]
    for key, file in (("input", path), ("output", output)):
        assert set(value[key]) == FILE_KEYS
        assert value[key]["path"] == str(file)
        assert value[key]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
        assert value[key]["format"] == path.suffix[1:]
    check_summary(value["before"], formats.read(path)[0], measure)
    check_summary(value["after"], formats.read(output)[0], measure)
    assert value["after"]["worst"] <= value["before"]["worst"]
    assert value["after"]["target"] == value["before"]["target"]
    assert set(value["seconds"]) == {"read", "optimize", "write"}
    assert all(seconds >= 0 for seconds in value["seconds"].values())
    assert value["stopped"]
    assert value["passes"]
    for one in value["passes"]:
        assert set(one) == PASS_KEYS
        assert one["name"] in PASSES
        assert one["visited"] == one["applied"] + sum(one["refused"].values())
        assert one["round"] >= 0
        assert one["seconds"] >= 0


@pytest.mark.parametrize("name", ["tets", "triangles"])
def test_the_table(meshopt, request, tmp_path, name):
    path = request.getfixturevalue(name)
    ran = meshopt("optimize", path, tmp_path / f"out{path.suffix}")
    assert (ran.status, ran.err) == (0, "")
    title, head, *rows = ran.out.splitlines()
    assert title.startswith(f"{path.name}: ")
    assert re.split(r"\s{2,}", head.strip()) == list(HEADINGS)
    found = {row.split()[0]: row.split()[1:] for row in rows[:4] if row[0] != " "}
    assert list(found) == ["before", "after"]
    for cells in found.values():
        assert len(cells) == len(HEADINGS)
        assert sum(float(cell) for cell in cells[:4]) == pytest.approx(100, abs=0.21)
    bars = [line for line in rows[4:] if re.match("(before|after) ", line)]
    assert len(bars) == 2
    assert "stopped: " in ran.out
    assert len(re.findall("^smooth ", ran.out, re.M)) == 1


def read_report(path):
    """What a report file says of the worst Q after the run, in as many digits as it has."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".json":
        return strict(text)["after"]["worst"]
    if path.suffix == ".csv":
        return float(list(csv.DictReader(io.StringIO(text)))[-1]["Q_T"])
    words = next(re.findall(r"[\w.%+-]+", line) for line in text.splitlines() if "after" in line)
    return float(words[words.index("after") + 6])


def test_reports_in_files(meshopt, tets, tmp_path):
    paths = [tmp_path / f"report{suffix}" for suffix in (".json", ".md", ".csv", ".txt")]
    output = tmp_path / "out.vtk"
    ran = meshopt("optimize", tets, output, *[f"--report={path}" for path in paths], "-q")
    assert ran == (0, "", "")
    for path in paths:
        assert read_report(path) == pytest.approx(worst_of(output), abs=0.006)
        assert ESCAPE not in path.read_text(encoding="utf-8")
    assert set(strict(paths[0].read_text())) == TOP_KEYS
    assert set(strict(paths[0].read_text())["after"]["measures"]) == set(MEASURES)


def test_a_time_limit_of_nothing_gives_the_mesh_back(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "--time-limit", "0", "--json")
    assert ran.status == 0
    before, after = (strict(ran.out)[key] for key in ("before", "after"))
    assert after == before
    assert np.array_equal(*(formats.read(p)[0].points for p in (tets, tmp_path / "out.vtk")))


def test_a_target_ends_the_rounds(meshopt, tets, tmp_path):
    """And a mesh that is there already is left alone."""
    arguments = ["optimize", tets, tmp_path / "out.vtk", "--json", "--passes", "smooth"]
    far = strict(meshopt(*arguments).out)
    near = strict(meshopt(*arguments, "--target-quality", "2.9").out)
    assert near["stopped"] == "target quality"
    assert near["after"]["worst"] <= 2.9
    assert len(near["passes"]) < len(far["passes"])


# The same input gives the same bytes ----------------------------------------------------------


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("name", ["tets", "triangles"])
def test_the_same_bytes_twice(meshopt, request, tmp_path, name, preset):
    path = request.getfixturevalue(name)
    outputs = [tmp_path / f"{k}{path.suffix}" for k in ("one", "other")]
    for output in outputs:
        assert meshopt("optimize", path, output, "--preset", preset).status == 0
    assert outputs[0].read_bytes() == outputs[1].read_bytes()


def test_the_same_bytes_in_another_process(meshopt, tets, tmp_path):
    passes = "--passes=relax,swap,smooth"
    order = ["--set", "swap.order=random", "--set", "swap.seed=3"]
    here, there = tmp_path / "here.vtk", tmp_path / "there.vtk"
    assert meshopt("optimize", tets, here, passes, *order).status == 0
    assert outside("optimize", tets, there, passes, *order, PYTHONHASHSEED="77").status == 0
    assert here.read_bytes() == there.read_bytes()


# Formats --------------------------------------------------------------------------------------


CONVERTED = {
    "gmsh": None,
    "gmsh22": None,
    "vtk": Encoding("vtk", "5.1", binary=True),
    "vtk42": Encoding("vtk", "4.2", binary=False),
    "vtu": Encoding("vtu", "1.0", binary=True, compressed=True),
    "medit": Encoding("medit", "2", binary=False),
    "meditb": Encoding("meditb", "2", binary=True),
}
SUFFIXES = {"gmsh": ".msh", "gmsh22": ".msh", "vtk": ".vtk", "vtk42": ".vtk", "vtu": ".vtu",
            "medit": ".mesh", "meditb": ".meshb"}  # fmt: skip


@pytest.fixture(params=CONVERTED)
def two_regions(request, samples, tmp_path):
    """A mesh of two regions, with triangles on their boundaries, in every format."""
    source = samples / ("two_regions_22.msh" if request.param == "gmsh22" else "two_regions.msh")
    path = tmp_path / f"in{SUFFIXES[request.param]}"
    if CONVERTED[request.param] is None:
        path.write_bytes(source.read_bytes())
        return path
    return write(path, formats.read(source)[0], CONVERTED[request.param])


def lower_cells(one):
    """Cells of lower dimension with their tags, whatever their numbering."""
    return Counter(
        (block.type, frozenset(map(tuple, one.points[cell].tolist())),
         tuple((name, values[row].item()) for name, values in sorted(block.data.items())))
        for block in one.blocks if block.type != "tetra"
        for row, cell in enumerate(block.cells)
    )  # fmt: skip


def volumes_by_tags(one):
    volumes = {}
    for block in one.blocks:
        if block.type == "tetra":
            corners = one.points[block.cells]
            each = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
            assert np.all(each > 0)
            for row, volume in enumerate(each):
                tags = tuple((n, a[row].item()) for n, a in sorted(block.data.items()))
                volumes[tags] = volumes.get(tags, 0.0) + volume
    return volumes


def test_a_format_keeps_tags_and_cells_of_lower_dimension(meshopt, two_regions, tmp_path):
    output = tmp_path / f"out{two_regions.suffix}"
    ran = meshopt("optimize", two_regions, output)
    assert (ran.status, ran.err) == (0, "")
    old, source = formats.read(two_regions)
    new, written = formats.read(output)
    assert written.encoding == source.encoding
    assert new.names == old.names
    assert [b.type for b in new.blocks] == [b.type for b in old.blocks]
    assert lower_cells(new) == lower_cells(old)
    assert sum(lower_cells(new).values()) > 600
    before, after = volumes_by_tags(old), volumes_by_tags(new)
    assert len(before) == 2
    assert after == pytest.approx(before, rel=1e-9)
    assert worst_of(output) < worst_of(two_regions)


def test_a_format_by_name_goes_before_the_suffix(meshopt, tets, tmp_path):
    output = tmp_path / "out.msh"
    assert meshopt("optimize", tets, output, "--file-format", "gmsh22", "-q").status == 0
    assert formats.read(output)[1].encoding.format == "gmsh22"


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_can_be_written(meshopt, triangles, tmp_path, name):
    output = tmp_path / f"out{FORMATS[name].extensions[0]}"
    assert meshopt("optimize", triangles, output, "--file-format", name, "-q") == (0, "", "")
    assert formats.read(output)[1].encoding.format == name
    assert worst_of(output) < worst_of(triangles)


# check ----------------------------------------------------------------------------------------


@pytest.fixture
def several(tmp_path, tets, broken):
    """Files for check with the status that each has alone."""
    lines, _, _ = bad_mesh(tmp_path, "lines")
    quads, _, _ = bad_mesh(tmp_path, "quads")
    return {tets: 0, quads: 0, broken: 1, lines: 1, tmp_path / "missing.vtk": 3}


def test_check_of_one_mesh(meshopt, several):
    for path, status in several.items():
        ran = meshopt("check", path)
        assert ran.status == status
        assert str(path) in ran.out + ran.err
        if status == 0:
            assert ran.out == f"{path}: valid\n"
            assert ran.err == ""


def test_check_of_several_meshes_has_the_worst_status(meshopt, several):
    paths = list(several)
    for n in range(1, len(paths) + 1):
        for chosen in (paths[:n], paths[:n][::-1]):
            ran = meshopt("check", *chosen)
            assert ran.status == max(several[path] for path in chosen)
            assert all(str(path) in ran.out + ran.err for path in chosen)


def test_check_says_what_is_wrong_and_where(meshopt, broken):
    ran = meshopt("check", broken)
    assert ran.err == ""
    *findings, last = ran.out.splitlines()
    assert last.startswith(f"{broken}: not valid (")
    for line in findings:
        where = line.removeprefix(f"{broken}:")
        assert re.match(r"cell \d+: M\d{3} .* at \(\S+, \S+, \S+\)$", where)
    n_errors = int(re.search(r"([\d,]+) error", last)[1].replace(",", ""))
    assert n_errors == len(findings)


def test_check_as_json(meshopt, several):
    ran = meshopt("check", *several, "--format", "json")
    value = strict(ran.out)
    assert ran.status == 3
    assert list(value) == ["files"]
    assert [Path(one["path"]) for one in value["files"]] == list(several)
    for one, (path, status) in zip(value["files"], several.items(), strict=True):
        assert one["status"] == status
        assert one["valid"] == (status == 0)
        if status == 3:
            assert str(path) in one["error"]
            continue
        assert one["format"] == path.suffix[1:]
        assert one["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert set(one["counts"]) <= set(RULES)
        codes = Counter(finding["code"] for finding in one["findings"])
        assert set(codes) == set(one["counts"])
        assert all(codes[code] <= n for code, n in one["counts"].items())
        for finding in one["findings"]:
            assert set(finding) == {"code", "severity", "message", "entities", "others", "where"}
            assert finding["severity"] == RULES[finding["code"]].severity
            assert len(finding["where"]) == 3
    bad = value["files"][list(several.values()).index(1)]
    assert {"M101", "M201"} <= set(bad["counts"])


def test_check_as_json_of_a_point_that_is_nowhere(meshopt, tmp_path):
    one = tet_grid(2)
    one.points[3, 0] = np.nan
    one.points[4, 1] = np.inf
    path = write(tmp_path / "nan.vtu", one)
    ran = meshopt("check", path, "--format", "json")
    assert ran.status == 1
    (value,) = strict(ran.out)["files"]
    assert value["counts"]["M001"] == 2


def test_check_shows_the_first_of_many(meshopt, tmp_path):
    one = tet_grid(4)
    cells = one.blocks[0].cells
    one.blocks[0].cells = np.concatenate([cells, cells[:50]])
    path = write(tmp_path / "doubled.vtu", one)
    ran = meshopt("check", path, "--select", "M201")
    shown = [line for line in ran.out.splitlines() if re.search(r": M201 (?!\d)", line)]
    (more,) = re.findall(r": M201 (\d+) more", ran.out)
    assert len(shown) + int(more) == 50
    assert len(shown) < 50


def test_check_selects_and_ignores(meshopt, broken):
    def codes(*options):
        ran = meshopt("check", broken, "--format", "json", *options)
        (value,) = strict(ran.out)["files"]
        assert ran.status == value["status"] == (1 if value["counts"] else 0)
        return set(value["counts"])

    everything = codes()
    assert {"M101", "M201"} <= everything
    assert codes("--select", "M201") == {"M201"}
    assert codes("--select", "M1,M201") == {c for c in everything if c[:2] == "M1"} | {"M201"}
    assert codes("--ignore", "M201") == everything - {"M201"}
    assert codes("--select", "M2", "--ignore", "M201") == {
        c for c in everything - {"M201"} if c[:2] == "M2"
    }
    assert codes("--ignore", ",".join(everything)) == set()


def test_check_warnings_are_no_errors(meshopt, tmp_path):
    one = tet_grid(2)
    one.points = np.concatenate([one.points, [[9.0, 9.0, 9.0]]])
    path = write(tmp_path / "unused.vtu", one)
    ran = meshopt("check", path)
    assert ran.status == 0
    assert "M203" in ran.out
    assert ran.out.splitlines()[-1] == f"{path}: valid (1 warning)"


def test_check_quietly(meshopt, tets, broken):
    assert meshopt("check", tets, "-q") == (0, "", "")
    ran = meshopt("check", broken, "-q")
    assert ran.status == 1
    assert all(": M" in line for line in ran.out.splitlines())
    assert ran.out


# report ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["table", "json", "markdown", "csv"])
@pytest.mark.parametrize("to_file", [False, True])
def test_report_of_several_meshes(meshopt, tets, triangles, broken, tmp_path, form, to_file):
    paths = [tets, triangles, broken]
    where = tmp_path / "report"
    ran = meshopt("report", *paths, "--format", form, *(["-o", where] if to_file else []))
    assert (ran.status, ran.err) == (0, "")
    text = where.read_text(encoding="utf-8") if to_file else ran.out
    assert bool(ran.out) != to_file
    if form == "json":
        values = strict(text)
        assert [v["input"]["path"] for v in values] == [str(path) for path in paths]
        assert all(set(v) == TOP_KEYS for v in values)
        assert all(v["after"] is v["output"] is v["stopped"] is None for v in values)
        check_summary(values[0]["before"], formats.read(tets)[0])
        check_summary(values[1]["before"], formats.read(triangles)[0])
        assert values[2]["before"]["worst"] is None
        assert values[2]["before"]["invalid"] > 0
    elif form == "csv":
        rows = list(csv.DictReader(io.StringIO(text)))
        assert [row["file"] for row in rows] == [str(path) for path in paths]
        assert [float(row["Q_T"]) for row in rows] == pytest.approx([worst_of(p) for p in paths])
    else:
        assert [text.index(path.name) for path in paths] == sorted(
            text.index(path.name) for path in paths
        )
        for heading in HEADINGS:
            assert text.count(heading) >= len(paths)
        assert "before" not in text


def test_report_of_one_mesh_as_json_is_an_object(meshopt, tets):
    assert set(strict(meshopt("report", tets, "--format", "json").out)) == TOP_KEYS


@pytest.mark.parametrize("measure", MEASURES)
def test_report_by_any_measure(meshopt, tets, measure):
    ran = meshopt("report", tets, "--measure", measure, "--format", "csv")
    (row,) = csv.DictReader(io.StringIO(ran.out))
    assert float(row["Q_T"]) == pytest.approx(worst_of(tets, measure), rel=1e-12)
    assert measure.replace("-", " ") in meshopt("report", tets, "--measure", measure).out


def test_report_goes_on_after_a_mesh_that_cannot_be_read(meshopt, tets, triangles, tmp_path):
    lines, _, _ = bad_mesh(tmp_path, "lines")
    missing = tmp_path / "missing.vtk"
    ran = meshopt("report", tets, missing, lines, triangles, "--format", "csv")
    assert ran.status == 3
    assert [row["file"] for row in csv.DictReader(io.StringIO(ran.out))] == [
        str(tets),
        str(triangles),
    ]
    errors = ran.err.splitlines()
    assert len(errors) == 2
    assert str(missing) in errors[0]
    assert str(lines) in errors[1]


@pytest.mark.parametrize("make", [lambda: in_space(tri_grid(2)), lambda: tet_grid(2)])
def test_report_of_a_mesh_with_vertices_that_are_not_there(meshopt, tmp_path, make):
    """What check calls M002 is a bad mesh, not a bug of ours."""
    one = make()
    one.blocks[0].cells[0, 0] = len(one.points) + 3
    path = write(tmp_path / "out_of_range.vtu", one)
    assert meshopt("check", path).status == 1
    ran = meshopt("report", path)
    assert (ran.status, ran.out) == (1, "")
    assert str(path) in ran.complaint


# list -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("passes", PASSES),
        ("measures", MEASURES),
        ("formats", FORMATS),
        ("rules", RULES),
        ("presets", PRESETS),
    ],
)
def test_list_shows_every_name_of_a_table(meshopt, name, table):
    ran = meshopt("list", name)
    assert (ran.status, ran.err) == (0, "")
    first = [line.split()[0] for line in ran.out.splitlines() if line.strip() and line[0] != " "]
    assert first[: len(table)] == list(table) or [w for w in first if w in table] == list(table)
    assert ESCAPE not in ran.out


def test_list_shows_the_options_of_the_passes(meshopt):
    out = meshopt("list", "passes").out
    for kind in PASSES.values():
        names = [f.name.replace("_", "-") for f in fields(kind)]
        if names:
            part = out.split(f"options of {kind.name} ")[1].split("options of ")[0]
            assert all(re.search(rf"^ +{name} ", part, re.M) for name in names)


# The README --------------------------------------------------------------------------------


def test_the_readme_has_every_option_and_format():
    text = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    command = main.get_command(click.Context(main), "optimize")
    for parameter in command.params:
        if isinstance(parameter, click.Option) and parameter.name != "help":
            for name in (*parameter.opts[:1], *parameter.secondary_opts):
                assert f"`{name}" in text, name
    for name, row in FORMATS.items():
        assert any(
            line.startswith(f"| `{name}` | `{row.extensions[0]}`") for line in text.splitlines()
        ), name
