"""Python and the command line in processes of their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from typing import NamedTuple

import pytest

from support.samples import ROOT

try:
    import termios
except ImportError:
    termios = None

ESCAPE = "\x1b"
NOTICE = "compiling kernels"  # said once on each machine, whatever the command

needs_terminal = pytest.mark.skipif(termios is None, reason="this system has no pseudo-terminals")


def heed_signals():
    """Let a child end by signals that this process ignores, as one in the background does."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)


def start_python(code, *arguments, **environment):
    """Start a fresh Python that can import the package and what the tests share."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": path, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def said(process):
    """What a process printed in the end; fails when it failed."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    return out


def run_python(code, *arguments, **environment):
    """What a fresh Python prints; fails when it fails."""
    return said(start_python(code, *arguments, **environment))


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


def without_notice(text):
    return "".join(line for line in text.splitlines(keepends=True) if NOTICE not in line)


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


def in_a_pipe(data, *arguments):
    """Run a command line with a mesh on stdin; stdout as bytes."""
    command = [sys.executable, "-m", "meshopt_cli", *map(str, arguments)]
    child = subprocess.run(command, input=data, capture_output=True, timeout=120, check=False)
    return child.returncode, child.stdout, without_notice(child.stderr.decode())


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
        preexec_fn=heed_signals,  # noqa: PLW1509
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
