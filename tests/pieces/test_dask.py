"""Workers of Dask make the same bytes, also where some of them die."""

from __future__ import annotations

import os
import signal

import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.formats.vtk.parallel import folder_of
from meshopt_cli.jobs.optimize_mesh import Task
from meshopt_cli.pieces.dask import Workers, workers
from meshopt_cli.pieces.engines import Here
from meshopt_cli.pieces.run import PiecesTask, optimize_pieces
from meshopt_cli.plans.config import Request
from support.files import contents

distributed = pytest.importorskip("distributed")


def bytes_of(index):
    return [data for _, data in sorted(contents(folder_of(index)).items())]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_worker_that_dies_changes_no_byte(whole, pieces_of, tmp_path):
    index = pieces_of(whole, 4)
    task = Task(Request(preset="fast"))
    optimize_pieces(PiecesTask(index, tmp_path / "expected.pvtu", task), Here())
    killed = []
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as some,
        distributed.Client(some) as client,
    ):

        def told(what, done, n, worst):
            if "improve" in what and not killed:
                killed.append(some.workers[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        output = tmp_path / "out.pvtu"
        optimize_pieces(PiecesTask(index, output, task), Workers(client), told)
    assert killed
    assert bytes_of(output) == bytes_of(tmp_path / "expected.pvtu")


def test_a_scheduler_that_is_not_there(monkeypatch):
    monkeypatch.setattr("meshopt_cli.pieces.dask.TIMEOUT", 0.5)
    with (
        pytest.raises(ConfigError, match="no scheduler answers"),
        workers("tcp://127.0.0.1:1", None, lambda _: None),
    ):
        pass


def test_what_is_missing_is_said(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(ConfigError, match=r"pip install 'meshopt-cli\[dask\]'"),
        workers(None, None, lambda _: None),
    ):
        pass
