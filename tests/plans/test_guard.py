"""Which of the meshes of some rounds is gone on from."""

from dataclasses import astuple
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.plans.guard import LIKE, Guard
from meshopt_cli.work.standing import Standing


class At:
    """Work that stands as it is told to."""

    def __init__(self, worst, mean, tail=9.0, left=0, lack=0.0):
        self.now = Standing(worst, mean, tail, left, lack)

    def standing(self):
        return self.now

    def copy(self):
        return At(*astuple(self.now))


def test_a_worst_cell_that_stays_does_not_count():
    """Others that get better are worth a worst q that hardly differs."""
    guard = Guard(At(0.1, 2.0))
    guard.note(better := At(0.1 * (1 - 0.5 * LIKE), 1.9))
    assert guard.best == better.now


def test_what_edges_lack_of_a_metric_comes_first():
    guard = Guard(At(0.1, 2.0, lack=0.2))
    guard.note(better := At(0.09, 2.1, lack=0.1))
    assert guard.best == better.now
    guard.note(At(0.2, 1.5, lack=0.15))
    assert guard.best == better.now


def test_a_worst_cell_that_gets_better_does():
    guard = Guard(At(0.1, 2.0))
    guard.note(better := At(0.11, 2.1))
    assert guard.best == better.now


def test_bad_cells_count_beside_the_mean():
    guard = Guard(At(0.1, 2.0, 9.0))
    guard.note(better := At(0.1, 2.05, 8.0))
    assert guard.best == better.now


def test_what_is_left_to_do_counts_before_the_mean():
    """And after a worst q that differs."""
    guard = Guard(At(0.1, 2.0, left=5))
    guard.note(better := At(0.1 * (1 - 0.5 * LIKE), 2.1, left=4))
    assert guard.best == better.now
    guard.note(At(0.1, 1.9, left=5))
    assert guard.best == better.now
    guard.note(worst := At(0.11, 2.2, left=6))
    assert guard.best == worst.now


def test_nothing_is_copied_that_is_not_gone_on_from():
    """The best mesh is copied before it changes, and only then."""
    guard = Guard(first := At(0.1, 2.0))
    guard.keep(first)
    guard.note(better := At(0.2, 2.0))
    assert guard.better_of(better) is better
    guard.keep(better)
    guard.note(worse := At(0.15, 1.5))
    assert guard.better_of(worse) is not worse
    assert guard.better_of(worse).standing() == better.now


STANDINGS = st.builds(At, st.floats(0.01, 0.02), st.floats(1.0, 2.0), st.floats(2.0, 9.0))


@given(st.lists(STANDINGS, min_size=1, max_size=20))
def test_many_rounds_lose_no_more_than_one(works):
    """However often it goes on from what is a little worse, it stays near the best worst q."""
    guard = Guard(works[0])
    for before, work in pairwise(works):
        guard.keep(before)
        guard.note(work)
    most = max(work.now.worst for work in works)
    near = [work.now for work in works if work.now.worst >= (1 - LIKE) * most]
    kept = guard.better_of(works[-1]).standing()
    assert kept.worst >= (1 - LIKE) * most
    assert kept.cost <= min(standing.cost for standing in near) + 1e-6


@given(st.lists(st.builds(At, st.floats(-1.0, 1.0), st.floats(1.0, 2.0)), min_size=1, max_size=9))
def test_what_is_tangled_is_never_preferred(works):
    guard = Guard(works[0])
    for work in works[1:]:
        guard.note(work)
    assert (guard.best.worst > 0) == any(work.now.worst > 0 for work in works)
