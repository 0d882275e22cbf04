"""Pipes and devices get what is written to them, and stay what they are."""

import os
import stat
import threading
from pathlib import Path

import pytest

from meshopt_cli.files.sink import PIPE, as_pipe, is_stream
from meshopt_cli.formats import FORMATS, encoding_for, read, write
from support.meshes import tet_grid

MESH = tet_grid(2)


@pytest.fixture
def fifo(tmp_path):
    path = tmp_path / "pipe.mesh"
    os.mkfifo(path)
    return path


def test_a_fifo_hands_on_what_is_written(fifo, tmp_path):
    """And gives what is read from it, with nothing left beside it."""
    got = []
    reader = threading.Thread(target=lambda: got.append(read(fifo)))
    reader.start()
    write(fifo, MESH, FORMATS["medit"].default)
    reader.join(20)
    ((mesh, source),) = got
    assert source.encoding.format == "medit"
    assert len(mesh.points) == len(MESH.points)
    assert list(tmp_path.iterdir()) == [fifo]
    assert stat.S_ISFIFO(fifo.stat().st_mode)


def test_a_device_takes_the_format_of_the_source():
    null = Path(os.devnull)
    encoding = encoding_for(null, FORMATS["vtu"].default)
    assert encoding.format == "vtu"
    write(null, MESH, encoding)
    assert stat.S_ISCHR(null.stat().st_mode)


def test_what_is_a_stream(tmp_path, fifo):
    file = tmp_path / "mesh.msh"
    file.touch()
    (tmp_path / "link").symlink_to(fifo)
    assert all(
        map(is_stream, (PIPE, fifo, tmp_path / "link", Path("/dev/null"), Path("/dev/fd/9")))
    )
    assert not any(map(is_stream, (file, tmp_path, tmp_path / "none.msh")))


def test_other_names_of_stdin_and_stdout():
    assert as_pipe(Path("/dev/stdin"), 0) == as_pipe(Path("/dev/fd/1"), 1) == PIPE
    assert as_pipe(Path("/dev/stdin"), 1) != PIPE
