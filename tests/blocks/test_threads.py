"""Sweeps and runs in blocks: the same bytes whatever number of threads is at work."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import meshopt_cli as meshopt
from meshopt_cli.blocks import crew, cut, partition
from meshopt_cli.blocks.crew import Share, n_threads
from meshopt_cli.kernels.types import EDITION
from meshopt_cli.passes import PASSES, Budget
from meshopt_cli.progress.observer import CancelledError, OutOfTimeError, Silent
from meshopt_cli.work import storage
from support.edits import halves, shaken
from support.invariants import assert_kept, snapshot, workspace
from support.meshes import tet_grid, tri_grid

small_blocks = pytest.mark.usefixtures("_small_blocks")
MESHES = {2: halves(shaken(tri_grid(40))), 3: halves(shaken(tet_grid(10)))}
SMALL = {2: halves(shaken(tri_grid(26))), 3: halves(shaken(tet_grid(7)))}  # for whole runs
SWEEPS = [
    ("smooth", {}),
    ("smooth", {"method": "optimize", "worse_than": 1.3}),
    ("smooth", {"method": "descent", "order": "random"}),
    ("swap", {}),
    ("swap", {"accept": "mean", "pick": "best", "order": "index"}),
    ("odt", {"sweeps": 3}),
    ("relax", {}),
]
NUMBERS = (1, 2, 3, 4, 7)


def swept(dimension, name, options, threads, observer=None):
    work = workspace(MESHES[dimension])
    step = PASSES[name](**options)
    tally = step.run(work, observer or Silent(), Budget(threads=threads))
    return work, tally


@small_blocks
@pytest.mark.parametrize("dimension", MESHES)
@pytest.mark.parametrize(("name", "options"), SWEEPS)
def test_a_pass_gives_the_same_for_any_number_of_threads(dimension, name, options):
    work, tally = swept(dimension, name, options, 1)
    assert tally.applied > 0
    assert_kept(work._source, work)
    for threads in NUMBERS[1:]:
        other, counted = swept(dimension, name, options, threads)
        assert snapshot(other) == snapshot(work)
        assert counted.counts.tolist() == tally.counts.tolist()


@small_blocks
@pytest.mark.parametrize("name", ["smooth", "swap"])
@pytest.mark.parametrize("dimension", MESHES)
def test_blocks_find_what_one_piece_finds(dimension, name, monkeypatch):
    work, tally = swept(dimension, name, {}, 2)
    monkeypatch.setattr(partition, "LEAST_CELLS", {2: np.inf, 3: np.inf})
    whole, at_once = swept(dimension, name, {}, 2)
    assert tally.applied == pytest.approx(at_once.applied, rel=0.1)
    assert work.standing().mean == pytest.approx(whole.standing().mean, rel=0.01)
    assert 1 / work.standing().worst <= 1.3 / whole.standing().worst


@small_blocks
@pytest.mark.parametrize("name", ["smooth", "swap", "odt"])
def test_threads_that_take_their_time_change_nothing(name, monkeypatch):
    expected = [snapshot(swept(dimension, name, {}, 1)[0]) for dimension in MESHES]
    step, generator, lock = Share.step, np.random.default_rng(0), threading.Lock()
    names = set()

    def slow_step(self, *arguments):
        with lock:
            before, after = generator.uniform(0.0, 0.002, 2)
        names.add(threading.current_thread().name)
        time.sleep(before)
        n = step(self, *arguments)
        time.sleep(after)
        return n

    monkeypatch.setattr(Share, "step", slow_step)
    monkeypatch.setattr(crew, "CHUNK", 100)
    for _ in range(2):
        found = [snapshot(swept(dimension, name, {}, 4)[0]) for dimension in MESHES]
        assert found == expected
    assert len(names) == 4


@small_blocks
@pytest.mark.parametrize("boundary", ["fixed", "slide"])
@pytest.mark.parametrize("preset", ["fast", "standard", "best"])
@pytest.mark.parametrize("dimension", MESHES)
def test_a_run_gives_the_same_for_any_number_of_threads(dimension, preset, boundary):
    def run(threads):
        result = meshopt.optimize(
            SMALL[dimension], preset=preset, boundary=boundary, rounds=2, threads=threads
        )
        mesh = result.mesh
        return result, mesh.points.tobytes(), [b.cells.tobytes() for b in mesh.blocks]

    result, *expected = run(1)
    assert result.after.worst < result.before.worst
    assert meshopt.check(result.mesh).is_valid
    for threads in NUMBERS[1:]:
        assert run(threads)[1:] == tuple(expected)


@small_blocks
def test_a_block_without_room_leaves_cells_to_the_next_turn(monkeypatch):
    monkeypatch.setattr(storage, "ROOM", 1.0)
    monkeypatch.setattr(cut, "SPARE_PART", 0.0)
    monkeypatch.setattr(cut, "SPARE_ROWS", 24)
    full = []
    close = cut.Shells.close
    monkeypatch.setattr(
        cut.Shells, "close", lambda self: (full.extend(s.is_full for s in self.shares), close(self))
    )
    options = {"accept": "mean", "order": "index"}
    works = [swept(3, "swap", options, threads)[0] for threads in (1, 3)]
    assert any(full)
    assert_kept(works[0]._source, works[0])
    assert snapshot(works[0]) == snapshot(works[1])


class Counting(Silent):
    """An observer that has seen enough after so many steps."""

    def __init__(self, enough=10**9):
        self.visited, self.steps, self.total, self.enough = 0, 0, 0, enough
        self.threads = set()

    def started(self, name, total):
        self.total += total

    def advanced(self, by):
        self.threads.add(threading.get_ident())
        self.visited += by
        self.steps += 1

    @property
    def is_cancelled(self):
        return self.steps >= self.enough


@small_blocks
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("name", ["smooth", "swap"])
def test_a_run_is_ended_between_chunks(name, threads):
    observer = Counting()
    work, _ = swept(3, name, {"worse_than": 1.0}, threads, observer)
    assert observer.visited <= observer.total
    assert observer.threads == {threading.get_ident()}
    ended = Counting(enough=5)
    work, step = workspace(MESHES[3]), PASSES[name]()
    with pytest.raises(CancelledError):
        step.run(work, ended, Budget(threads=threads))
    assert ended.steps == 5
    assert work.mesh.state[EDITION] > 0
    assert_kept(work._source, work)


@small_blocks
def test_time_runs_out_in_blocks(monkeypatch):
    work, step = workspace(MESHES[3]), PASSES["swap"]()
    share_step = Share.step

    def slow_step(self, *arguments):
        time.sleep(0.01)
        return share_step(self, *arguments)

    monkeypatch.setattr(Share, "step", slow_step)
    with pytest.raises(OutOfTimeError):
        step.run(work, Silent(), Budget.of(0.03, 2))
    assert_kept(work._source, work)


def test_small_meshes_are_worked_on_in_one_piece(monkeypatch):
    monkeypatch.delattr(partition, "bisected")
    _, tally = swept(3, "smooth", {}, 4)
    assert tally.applied > 0


def test_a_failure_in_a_thread_comes_out(monkeypatch):
    def fails(mesh, order, scratch, counts):
        raise MemoryError

    shares = [Share(None, np.arange(3), np.arange(3)) for _ in range(5)]
    with pytest.raises(MemoryError):
        crew.work_on(shares, fails, (), [None, None], lambda n: None)


def test_so_many_threads_as_are_wanted_or_there_are_cores(monkeypatch):
    monkeypatch.setattr(crew, "n_cores", lambda: 5)
    assert n_threads(None) == 5
    assert n_threads(3) == 3


def test_no_more_threads_than_shares(monkeypatch):
    made = []
    pool = ThreadPoolExecutor.__init__

    def noted(self, n, *rest):
        made.append(n)
        pool(self, n, *rest)

    monkeypatch.setattr(ThreadPoolExecutor, "__init__", noted)
    shares = [Share(None, np.arange(3), np.arange(3)) for _ in range(2)]
    crew.work_on(shares, lambda mesh, order, *_: len(order), (), [None] * 9, lambda n: None)
    assert made == [2]
    assert all(share.is_over for share in shares)
