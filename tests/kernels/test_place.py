"""Relocation in meshes of any cells, beside that of simplices and beside numpy."""

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.kernels.operators.relocate import (
    DESCENT,
    LAPLACE,
    OPTIMIZE,
    QUALITY,
    WEIGHTED,
    Relocation,
)
from meshopt_cli.kernels.types import APPLIED, N_VERDICTS
from meshopt_cli.mesh.any_cells import AnyCells, cast_any
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.facets import CellSet
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.work.cells import CellWork
from meshopt_cli.work.session import Workspace
from support.corners import wedge_grid
from support.edits import shaken
from support.meshes import hex_grid, quad_grid, tet_grid, tri_grid

METHODS = {"laplace": LAPLACE, "weighted": WEIGHTED, "quality": QUALITY, "optimize": OPTIMIZE,
           "descent": DESCENT}  # fmt: skip
DRIVING = [name for name, m in MEASURES.items() if m.drives and "hexahedron" in m.ways]


def alone(family, seed):
    """One cell, shaken, as a working mesh."""
    by = np.random.default_rng(seed).uniform(-0.15, 0.15, FAMILIES[family].reference.shape)
    by[:, FAMILIES[family].dimension :] = 0.0
    points = FAMILIES[family].reference + by
    return alone_at(family, points)


def alone_at(family, points):
    """One cell whose corners are at some points."""
    cells = CellSet(family, np.arange(len(points))[None], np.zeros(1, np.int64))
    return AnyCells(
        points, [cells], np.zeros(len(points), bool), np.zeros(1, np.int64), np.zeros(1, bool),
        np.empty((0, 2), np.int64), None, False,
    )  # fmt: skip


@pytest.mark.parametrize("family", [f for f in FAMILIES if FAMILIES[f].dimension >= 2])
@pytest.mark.parametrize("name", DRIVING)
@pytest.mark.parametrize("seed", range(5))
def test_kernels_measure_what_reports_do(family, name, seed):
    cell = alone(family, seed)
    work = CellWork(cell, MEASURES[name].judge)
    rows = cell.cell_sets[0].cells
    (expected,) = MEASURES[name].of(cell.points, rows, family)
    assert 1.0 / work.cell_quality()[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("family", [f for f in FAMILIES if FAMILIES[f].dimension >= 2])
@pytest.mark.parametrize("name", DRIVING)
def test_an_ideal_cell_is_ideal(family, name):
    work = CellWork(alone_at(family, FAMILIES[family].reference), MEASURES[name].judge)
    assert work.standing().worst == pytest.approx(1.0, rel=1e-12)


def swept(work, method, n_points, sweep):
    """Where the points are after all of them were visited in order, and how many moved."""
    counts = np.zeros(N_VERDICTS, dtype=np.int64)
    how = Relocation(method, 2, 0.7, 0, 0.0, np.inf)
    sweep(work.mesh, np.arange(n_points), how, work.scratch, counts)
    return work.mesh.points, counts[APPLIED]


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
@pytest.mark.parametrize("method", [name for name in METHODS if name != "optimize"])
@pytest.mark.parametrize("name", ["aspect-ratio", "volume-length"])
def test_simplices_go_where_they_go_as_simplices(make, method, name):
    """One sweep, in which rounding has no time to grow."""
    one = shaken(make(4))
    judge = MEASURES[name].judge
    plain = Workspace(cast(one), judge, in_order=True)
    general = CellWork(cast_any(one), judge)
    n = len(one.points)
    a, moved = swept(plain, METHODS[method], n, plain.relocation)
    b, also = swept(general, METHODS[method], n, general.relocation)
    assert moved == also > 0
    assert a == pytest.approx(b, abs=1e-7)


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_simplices_climb_as_high_as_simplices(make):
    """The way up has kinks, at which rounding decides."""
    one = shaken(make(5))
    judge = MEASURES["aspect-ratio"].judge
    plain, general = Workspace(cast(one), judge), CellWork(cast_any(one), judge)
    for work in (plain, general):
        Smooth(method="optimize", sweeps=20).run(work)
    assert plain.standing().worst == pytest.approx(general.standing().worst, rel=0.03)
    assert plain.standing().mean == pytest.approx(general.standing().mean, rel=0.03)


@pytest.mark.parametrize("make", [quad_grid, hex_grid, wedge_grid])
@pytest.mark.parametrize("method", [*METHODS, "global"])
def test_every_method_makes_them_better(make, method):
    one = make(4)
    part = cast_any(one)
    free = ~part.fixed
    by = np.random.default_rng(3).uniform(-0.07, 0.07, (free.sum(), 3))
    by[:, part.dimension :] = 0.0
    part.points[free] += by
    work = CellWork(part, MEASURES["scaled-jacobian"].judge)
    before, fixed = work.standing(), part.points[part.fixed].tobytes()
    Smooth(method=method).run(work)
    assert work.standing().is_better_than(before)
    assert work.mesh.points[part.fixed].tobytes() == fixed
    work.require_fresh()


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_all_vertices_of_simplices_move_at_once(make):
    one = shaken(make(4))
    work = Workspace(cast(one), MEASURES["aspect-ratio"].judge)
    before = work.standing()
    tally = Smooth(method="global").run(work)
    assert tally.applied > 0
    assert work.standing().is_better_than(before)


def test_what_gets_no_better_stays():
    work = CellWork(cast_any(hex_grid(3)), MEASURES["scaled-jacobian"].judge)
    points = work.mesh.points.copy()
    assert Smooth(method="global").run(work).applied == 0
    assert np.array_equal(work.mesh.points, points)
