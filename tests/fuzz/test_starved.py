"""Runs that are killed, interrupted, or short of room, at any moment.

What they were to write is as it was, or whole; what is temporary is gone, at the latest after
the next run; the status and the one line that is said are true.
"""

import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from support.edits import shaken
from support.files import write
from support.fuzz import cases
from support.meshes import tet_grid
from support.processes import heed_signals, without_notice

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and limits as POSIX has them")

STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129, signal.SIGKILL: -9}
OLD = "as it was\n"


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    return write(tmp_path_factory.mktemp("starved") / "mesh.vtu", shaken(tet_grid(4), 0.5, 1))


def jobs(mesh, folder):
    """Command lines, each with what it writes."""
    out, report, mark = folder / "out.vtu", folder / "report.json", folder / "mark.vtu"
    return (
        (["optimize", mesh, out, "--report", report], [out, report]),
        (["optimize", mesh, folder / "out.msh", "--preset", "fast"], [folder / "out.msh"]),
        (["repair", "--all", mesh, out], [out]),
        (["check", mesh, "--extend-select", "M3", "--mark", mark], [mark]),
        (["report", mesh, "-o", report], [report]),
        (["optimize", mesh, folder / "out.mesh.gz", "-q"], [folder / "out.mesh.gz"]),
    )


def start(arguments, folder, limit=None):
    """A run with a folder of its own for temporary files, and perhaps a limit to what it gets."""
    tmp = folder.parent / "tmp"
    tmp.mkdir(exist_ok=True)

    def prepare():
        heed_signals()
        if limit is not None:
            resource.setrlimit(*limit)

    return subprocess.Popen(
        [sys.executable, "-m", "meshopt_cli", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
        env={**os.environ, "TMPDIR": str(tmp)},
        preexec_fn=prepare,  # noqa: PLW1509
    )  # fmt: skip


def prepared(folder, written, with_old):
    folder.mkdir()
    for path in written if with_old else ():
        path.write_text(OLD)


def is_whole(path):
    """Whether a file is readable to its end."""
    if path.suffix == ".json":
        import json

        return bool(json.loads(path.read_text()))
    command = [sys.executable, "-m", "meshopt_cli", "report", str(path)]
    if path.name == "mark.vtu":
        command[3] = "check"
    return subprocess.run(command, capture_output=True, check=False).returncode in (0, 1)


def assert_told(folder, written, with_old, child, may_be_left=False):
    """What is there is old or whole, and of what was written the message says so."""
    out, err = child.communicate(timeout=120)
    err = without_notice(err)
    left = {p for p in folder.rglob("*") if p not in written}
    assert may_be_left or not left
    assert may_be_left or not list((folder.parent / "tmp").iterdir())
    was = OLD if with_old else None
    for path in written:
        is_old = (path.read_text(errors="replace") if path.exists() else None) == was
        assert is_old or is_whole(path), path
        is_told = re.search(rf"{re.escape(str(path))}( and \S+)* (is|are) written", err) is not None
        if child.returncode > 1:
            assert is_told == (not is_old), (err, path)
    assert "Traceback" not in err
    assert "internal error" not in err
    if child.returncode > 1:
        assert len([line for line in err.splitlines() if "warning" not in line]) == 1, err
    return out, err


def wait_until_started(child):
    """Until the first line of ours ran: before, a signal does what it does to any Python."""
    status = Path(f"/proc/{child.pid}/status")
    for _ in range(1000):
        if not status.exists() or child.poll() is not None:
            break
        caught = int(re.search(r"SigCgt:\s*(\w+)", status.read_text())[1], 16)
        if caught >> (signal.SIGTERM - 1) & 1:
            return
        time.sleep(0.002)
    time.sleep(0.3)  # where that is not told


def signalled(folder, arguments, written, number, delay, with_old):
    prepared(folder, written, with_old)
    child = start(arguments, folder)
    wait_until_started(child)
    time.sleep(delay)
    child.send_signal(number)
    assert_told(folder, written, with_old, child, may_be_left=number == signal.SIGKILL)
    assert child.returncode in (0, 1, STATUS[number])


def at_random(seed, mesh, tmp_path):
    """A job, its folder, and whether there are files in the places it writes to."""
    dice = random.Random(seed)
    folder = tmp_path / f"run{seed}"
    arguments, written = dice.choice(jobs(mesh, folder))
    return dice, folder, arguments, written, dice.random() < 0.5


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals(mesh, tmp_path, number):
    for seed in range(cases(4)):
        dice, folder, arguments, written, with_old = at_random(seed, mesh, tmp_path)
        signalled(folder, arguments, written, number, dice.uniform(0.0, 0.8), with_old)


def test_kills(mesh, tmp_path):
    """What a run that was killed leaves is gone after the next one."""
    for seed in range(cases(4)):
        dice, folder, arguments, written, with_old = at_random(seed, mesh, tmp_path)
        signalled(folder, arguments, written, signal.SIGKILL, dice.uniform(0.0, 0.8), with_old)
        for path in (*folder.glob(".meshopt-*"), *(tmp_path / "tmp").iterdir()):
            os.utime(path, (0, 0))  # as if it had been some seconds ago
        child = start(arguments, folder)
        assert_told(folder, written, with_old=False, child=child)
        assert child.returncode in (0, 1)


@pytest.mark.parametrize("what", [resource.RLIMIT_FSIZE, resource.RLIMIT_AS])
def test_limits(mesh, tmp_path, what):
    """Of the size of a file, as on a disk that is full, and of memory."""
    most = 60_000 if what == resource.RLIMIT_FSIZE else 700 << 20
    for seed in range(cases(4)):
        dice, folder, arguments, written, with_old = at_random(seed, mesh, tmp_path)
        least = 40 << 20 if what == resource.RLIMIT_AS else 0
        size = dice.randint(least, most)
        prepared(folder, written, with_old)
        child = start(arguments, folder, (what, (size, size)))
        assert_told(folder, written, with_old, child)
        assert child.returncode in (0, 1, 3), size
