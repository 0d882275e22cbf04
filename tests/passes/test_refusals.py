"""Cells that a visitor could do nothing for, and what their boundary facets allow."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.kernels.search.target import best_over_face, facet_bounds
from meshopt_cli.passes.mend import Mend
from meshopt_cli.work.refusals import ALIKE, Refusals, no_refusals
from support.invariants import workspace
from support.samples import sample


@pytest.fixture
def work():
    return workspace(sample("raw_ball.mesh"))


def test_cells_are_alike_while_they_change_little(work):
    cells = work.living()[::3]
    refused = Refusals.of(work.mesh, cells)
    assert refused.are_alike(work.mesh, cells).all()
    assert not refused.are_alike(work.mesh, np.setdiff1d(work.living(), cells)).any()
    work.mesh.quality[cells[0]] *= 1 + 0.5 * ALIKE
    work.mesh.quality[cells[1]] *= 1 + 2.0 * ALIKE
    work.mesh.cells[cells[2]] = work.mesh.cells[cells[2]][[1, 2, 0, 3]]
    other = np.setdiff1d(work.corners(work.living()), work.mesh.cells[cells[3]])[0]
    work.mesh.cells[cells[3], 0] = other
    changed = ~refused.are_alike(work.mesh, cells)
    assert np.flatnonzero(changed).tolist() == [1, 3]
    assert np.flatnonzero(~refused.are_unchanged(work.mesh)).tolist() == [0, 1, 3]


def test_the_later_refusal_of_a_cell_counts(work):
    cells = work.living()
    first = Refusals.of(work.mesh, cells[:6])
    work.mesh.quality[cells[4]] = 0.1
    both = no_refusals(work.mesh).joined(first).joined(Refusals.of(work.mesh, cells[4:9]))
    assert sorted(both.rows) == cells[:9].tolist()
    assert both.quality[both.rows == cells[4]].tolist() == [0.1]


def test_what_was_refused_is_not_tried_again(work):
    """Though all around it changed: but the worst of the mesh is, always."""
    step = Mend(worse_than=1.6, urgent_factor=1.0, near_bound=1.0)
    while step.run(work).applied:
        pass
    bad = work.worse_cells(step.limit)
    assert len(bad) > 100
    work.next_sweep()
    work.mesh.vertex_clock[:] = work.clock
    assert step.run(work).visited < 0.1 * len(bad)
    assert replace(step, urgent_factor=1e6).run(work).visited > 0.5 * len(bad)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "grid.vtk", "two_regions.msh"])
def test_facets_allow_what_is_found_over_them(name):
    """The quick estimate is no more than the search finds, and at most 3 % less."""
    work = workspace(sample(name))
    cells = work.living()
    allowed = np.empty(len(cells))
    facet_bounds(work.mesh, cells, allowed)
    at_boundary = (work.mesh.neighbours[cells] < 0).sum(axis=1)
    assert np.all(allowed[at_boundary == 0] == 1.0)
    corners = np.array([[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]])
    for row in np.flatnonzero(at_boundary == 1)[:40]:
        (local,) = np.flatnonzero(work.mesh.neighbours[cells[row]] < 0)
        facet = work.mesh.cells[cells[row]][corners[local]]
        best = max(
            best_over_face(work.mesh.judge, work.mesh.points, *(int(v) for v in order))
            for order in (facet, facet[::-1])
        )
        assert best / 1.03 <= allowed[row] <= best * (1 + 1e-9)


def test_no_visit_where_the_facets_allow_no_more(work):
    """Nor beyond the part of the cells that is asked for."""
    allowed = np.empty(len(work.living()))
    facet_bounds(work.mesh, work.living(), allowed)
    bad = work.worse_cells(1 / 1.6)
    all_ = Mend(worse_than=1.6, near_bound=1.0, max_vertices=1.0)
    some = Mend(worse_than=1.6, near_bound=1.5, max_vertices=1.0)
    few = Mend(worse_than=1.6, near_bound=1.0, max_vertices=1.0, max_share=0.02)
    visits = [step.run(work.copy()).visited for step in (all_, some, few)]
    assert 0 < visits[1] < visits[0] <= len(bad)
    assert 0 < visits[2] <= max(64, 0.02 * work.n_cells)
