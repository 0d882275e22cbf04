"""Ranks, figures of real meshes, and what their boundary forces."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality.measures import OF_SIMPLICES, measure_named
from meshopt_cli.quality.summary import RANKS, histogram, summarize
from meshopt_cli.quality.target import forced_angles
from meshopt_cli.reports.json import to_json
from meshopt_cli.reports.rows import percent_row
from support.meshes import mesh, tet_grid, tri_grid
from support.reports import INFINITE, ranks, report, summary
from support.samples import sample


def test_the_upper_end_belongs_to_a_rank():
    for k, (low, high) in enumerate(pairwise(RANKS)):
        own = [0] * (len(RANKS) - 1)
        own[k] = 1
        assert histogram(np.array([np.nextafter(low, INFINITE)])) == tuple(own)
        assert histogram(np.array([high])) == tuple(own)


def test_a_regular_cell_is_in_the_first_rank_whatever_its_rounding():
    values = np.array([1.0 - 1e-15, 1.0, 1.0 + 1e-15])
    assert histogram(values) == (3, 0, 0, 0)


@given(st.lists(st.floats(1.0, 20.0) | st.sampled_from(RANKS), max_size=50))
def test_every_cell_is_in_the_rank_of_its_quality(values):
    counts = histogram(np.array(values, dtype=float))
    assert len(counts) == len(RANKS) - 1
    assert sum(counts) == len(values)
    for k, high in enumerate(RANKS[1:]):
        assert sum(counts[: k + 1]) == sum(value <= high for value in values)


@given(ranks)
def test_percentages_sum_to_a_hundred(counts):
    one = summary(counts)
    assert sum(one.percent) == pytest.approx(100.0, abs=1e-9)
    shown = [float(cell) for cell in percent_row(one)[: len(counts)]]
    assert sum(shown) == pytest.approx(100.0, abs=0.21)


@pytest.mark.parametrize("grid", [tri_grid(3), tet_grid(2)], ids=["triangles", "tetrahedra"])
@pytest.mark.parametrize("name", OF_SIMPLICES)
def test_a_summary_agrees_with_itself(grid, name):
    simplices = cast(grid)
    one = summarize(simplices, measure_named(name), tuple(OF_SIMPLICES.values()))
    assert sum(one.counts) == one.n_cells == len(simplices.cells)
    assert one.n_points == len(simplices.points)
    assert 1.0 - 1e-9 <= one.best <= one.mean * (1 + 1e-9) <= one.worst * (1 + 2e-9)
    assert one.worst_by_measure[name] == one.worst
    assert set(one.worst_by_measure) == set(OF_SIMPLICES)
    assert 1.0 - 1e-9 <= one.target <= one.worst * (1 + 1e-9)
    assert 0 < one.angle_min <= one.angle_max < 180
    assert one.n_invalid == 0


def test_flat_and_inverted_cells_are_counted_and_infinite():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0], [0, 0, -1]]
    good, flat, inverted = [0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]
    one = summarize(cast(mesh(points, tetra=[good, flat, inverted])), OF_SIMPLICES["aspect-ratio"])
    assert one.n_invalid == 2
    assert one.worst == INFINITE
    assert one.counts[-1] == 2
    assert one.mean == pytest.approx(one.best)
    assert "NaN" not in to_json([report(one)])


def test_a_regular_tet_is_as_its_boundary_forces_it():
    corners = [[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]]
    regular = math.degrees(math.acos(1 / 3))
    forced = forced_angles(cast(mesh(corners, tetra=[[0, 1, 2, 3]])))
    assert forced == pytest.approx((regular, regular), abs=0.05)


@pytest.mark.parametrize("opening", [10.0, 25.0, 40.0])
def test_a_sharp_edge_forces_its_angle(opening):
    """No tet at the edge of a wedge has a greater angle there than the wedge."""
    turned = math.radians(opening)
    points = [[0, 0, 0], [0, 0, 1], [1, 0, 0.5], [math.cos(turned), math.sin(turned), 0.5]]
    least, _ = forced_angles(cast(mesh(points, tetra=[[0, 1, 2, 3]])))
    assert least == pytest.approx(opening, abs=1e-9)


def test_an_edge_has_one_tet_or_half_its_angle():
    """At a right angle of a flat box the tet between both facets has a sharper angle than 45."""
    box = tet_grid(4)
    box.points *= [1, 1, 0.6]
    least, _ = forced_angles(cast(box))
    assert least == pytest.approx(45.0, abs=1e-9)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "two_regions.msh", "grid.vtk"])
def test_no_mesh_is_better_than_its_boundary_forces(name):
    source = sample(name)
    least, greatest = forced_angles(source)
    one = summarize(source, OF_SIMPLICES["aspect-ratio"])
    assert one.angle_min <= least <= greatest <= one.angle_max
