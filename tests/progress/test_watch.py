"""What a run tells while it works, and how it is ended."""

import io
import math
import time

import numpy as np
import pytest

import meshopt_cli as meshopt
from meshopt_cli.progress.lines import words
from support.edits import shaken
from support.meshes import hex_grid, tet_grid, tri_grid

MESHES = {
    "tets": lambda: tet_grid(6),
    "triangles": lambda: tri_grid(12),
    "hexes": lambda: hex_grid(4),
}


@pytest.fixture(params=MESHES)
def mesh(request):
    return shaken(MESHES[request.param](), 0.25, 1)


def test_stages_and_passes_are_told(mesh):
    told = []
    result = meshopt.optimize(mesh, progress=told.append)
    stages = list(dict.fromkeys(one.stage for one in told))
    assert stages == ["reading", "checking", "optimizing", "comparing"]
    steps = {one.step for one in told}
    assert {facts.name for facts in result.passes} - {"repair", "check"} <= steps
    assert all(0.0 <= one.share <= 1.0 for one in told)
    assert [one.seconds for one in told] == sorted(one.seconds for one in told)
    known = [one.worst for one in told if not math.isnan(one.worst)]
    assert known
    assert max(known) >= result.after.worst * 0.999


@pytest.mark.parametrize("after", [0, 1, 5, 20])
def test_a_run_is_cancelled_with_the_best_so_far(mesh, after):
    calls = 0

    def told(progress):
        nonlocal calls
        calls += 1
        if progress.stage == "optimizing" and calls > after:
            progress.cancel()

    result = meshopt.optimize(mesh, preset="best", progress=told)
    assert result.stopped == "cancelled" or calls <= after + 10  # it had ended before
    assert result.after.worst <= result.before.worst
    assert meshopt.check(result.mesh)


def test_nothing_changes_by_being_watched(mesh):
    a = meshopt.optimize(mesh).mesh
    b = meshopt.optimize(mesh, progress=lambda _: None).mesh
    assert np.array_equal(a.points, b.points)


def test_an_error_of_who_watches_is_his():
    def told(progress):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        meshopt.optimize(tet_grid(3), progress=told)


@pytest.fixture
def seen():
    told = []
    meshopt.optimize(shaken(tet_grid(5), 0.25, 1), progress=told.append)
    return told


def test_the_line_of_tqdm(seen, monkeypatch):
    monkeypatch.setattr("meshopt_cli.progress.lines.LATE", 0.01)
    stream = io.StringIO()
    with meshopt.tqdm_progress(stream, plain=True) as told:
        told(seen[0])
        while not stream.getvalue():  # though nothing more is told
            time.sleep(0.01)
        assert "reading ..." in stream.getvalue()
        for one in seen:
            told(one)
    text = stream.getvalue()
    assert "checking ..." in text
    assert "worst Q" in text
    assert "100%" in text
    assert "\n" not in text


def test_short_runs_show_nothing(seen):
    stream = io.StringIO()
    with meshopt.tqdm_progress(stream) as told:
        told(seen[0])
    assert stream.getvalue() == ""


def test_the_bar_of_rich(seen, capsys):
    with meshopt.rich_progress() as told:
        for one in seen:
            told(one)
    assert "comparing" in capsys.readouterr().out


def test_words(seen):
    last = [one for one in seen if one.step][-1]
    assert f"{last.worst:.4g}" in words(last)
