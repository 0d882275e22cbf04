"""Global smoothing: no simplex is folded over where that can be, and the worst get better."""

from __future__ import annotations

import math

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.kernels.shape.distortion import Energy
from meshopt_cli.work.foldover import Corners, body_of, corners_of, is_better, relocate_all
from support import drivers
from support.corners import corners, thrown, wedge_grid
from support.edits import shaken
from support.meshes import hex_grid, mesh, quad_grid, tet_grid, tri_grid

GRIDS = {
    "triangle": (tri_grid, 8),
    "quad": (quad_grid, 8),
    "tetra": (tet_grid, 4),
    "wedge": (wedge_grid, 4),
    "hexahedron": (hex_grid, 4),
}
# Energies of all kinds: simplices folded over too, and those under a limit.
ENERGIES = [
    Energy(0.3, 0.5, 0.0, math.inf),
    Energy(0.3, 0.01, 0.8, math.inf),
    Energy(0.0, 0.5, 0.9, math.inf),
    Energy(0.0, 0.01, 0.9, 60.0),
]


@pytest.fixture(params=GRIDS)
def grid(request):
    build, n = GRIDS[request.param]
    return build(n)


def quality(of):
    return corners_of(of.points, of.simplices, of.shapes, of.shape, of.cell)


def thrown_quads(n):
    return thrown(quad_grid(n))


def turn():
    """A rotation of space, about no axis of coordinates."""
    return np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]


def test_cells_folded_over_are_unfolded(grid):
    """Whatever was done to the inside, the grid comes back: the boundary says where it was."""
    ideal, broken = corners(grid), corners(thrown(grid))
    points, record = relocate_all(*broken)
    assert record.n_bad_before > 0
    assert record.least_before < 0.0
    assert record.n_bad_after == 0
    assert record.least_after > 0.0
    after = quality(broken._replace(points=points))
    assert is_better(quality(broken), after)
    assert after.least > 0.99 * quality(ideal).least


def test_what_is_fixed_keeps_its_bytes(grid):
    broken = corners(thrown(grid))
    broken.points[broken.fixed] *= 1.0 / 3.0  # no short fractions
    broken.points[np.flatnonzero(broken.fixed)[0]] = -0.0
    before = broken.points.copy()
    points, _ = relocate_all(*broken)
    assert points[broken.fixed].tobytes() == before[broken.fixed].tobytes()
    assert broken.points.tobytes() == before.tobytes()


def test_the_plane_is_kept():
    broken = corners(thrown(quad_grid(6)))
    broken.points[:, 2] = 0.1
    points, _ = relocate_all(*broken)
    assert (points[:, 2] == 0.1).all()


def test_points_of_no_simplex_stay(grid):
    broken = corners(thrown(grid))
    points = np.vstack([broken.points, [[9.0, np.nan, 7.0]]])
    fixed = np.append(broken.fixed, False)
    moved, _ = relocate_all(points, *broken[1:4], fixed)
    assert moved[-1].tobytes() == points[-1].tobytes()


def test_the_same_bytes_every_time(grid):
    broken = corners(thrown(grid))
    one, other = relocate_all(*broken), relocate_all(*broken)
    assert one[0].tobytes() == other[0].tobytes()
    assert one[1] == other[1]


def test_an_ideal_grid_stays():
    for build, n in (GRIDS["quad"], GRIDS["hexahedron"]):
        ideal = corners(build(n))
        points, record = relocate_all(*ideal)
        np.testing.assert_allclose(points, ideal.points, atol=1e-12)
        assert record.n_bad_before == record.n_bad_after == 0


def test_a_mesh_and_its_double_go_the_same_way(grid):
    broken = corners(thrown(grid))
    points, _ = relocate_all(*broken)
    for factor in (2.0**40, 0.125):
        doubled, _ = relocate_all(broken.points * factor, *broken[1:])
        assert (doubled == points * factor).all()
    tripled, _ = relocate_all(broken.points * 3.0, *broken[1:])
    np.testing.assert_allclose(tripled, points * 3.0, atol=1e-2)


@pytest.mark.parametrize("build", [hex_grid, tet_grid, wedge_grid])
def test_a_turned_mesh_goes_the_same_way(build):
    """Steps end where they promise little: what is best is found to less than a hundredth."""
    broken = corners(thrown(build(4)))
    points, _ = relocate_all(*broken)
    turned, _ = relocate_all(broken.points @ turn().T, *broken[1:])
    np.testing.assert_allclose(turned @ turn(), points, atol=1e-2)


@pytest.mark.parametrize("how", ENERGIES, ids=str)
def test_the_gradient_is_that_of_the_energy(grid, how):
    of = corners(thrown(grid) if how.eps > 0.0 else shaken(grid, 0.1))
    body = body_of(of.points, of.simplices, of.shapes, of.shape)
    body = body._replace(scale=np.full(len(of.simplices), 0.9 * len(of.points) ** (1 / 3)))
    gradient, nothing = np.zeros((2, len(of.points), 3))
    assert math.isfinite(drivers.energy_of(body, of.points, how, gradient))
    generator = np.random.default_rng(2)
    for _ in range(4):
        direction = generator.normal(size=of.points.shape)
        direction[:, of.simplices.shape[1] - 1 :] = 0.0
        h = 1e-7
        ahead = drivers.energy_of(body, of.points + h * direction, how, nothing)
        behind = drivers.energy_of(body, of.points - h * direction, how, nothing)
        slope = np.sum(gradient * direction)
        assert (ahead - behind) / (2 * h) == pytest.approx(
            slope, rel=1e-4, abs=1e-5 * np.abs(gradient).sum()
        )


def test_the_energy_is_least_for_the_reference(grid):
    """Then it is d and twice theta a simplex, and nothing pulls at it, whatever the weights."""
    (block, *_) = grid.blocks
    family = FAMILIES[block.type]
    d = family.dimension
    of = corners(mesh(family.reference[:, :d], **{block.type: [range(family.n_corners)]}))
    body = body_of(of.points, of.simplices, of.shapes, of.shape)
    gradient = np.zeros((len(of.points), 3))
    for how in (Energy(0.0, 0.25, 0.0, math.inf), Energy(0.0, 0.25, 0.9, math.inf)):
        energy = drivers.energy_of(body, of.points, how, gradient)
        assert energy == pytest.approx((d + 0.5) * len(of.simplices))
        np.testing.assert_allclose(gradient, 0.0, atol=1e-12)
    assert quality(of) == pytest.approx((1.0, 1.0))


def test_a_barrier_lets_nothing_over():
    of = corners(thrown(tet_grid(3)))
    body = body_of(of.points, of.simplices, of.shapes, of.shape)
    gradient = np.zeros_like(of.points)
    assert drivers.energy_of(body, of.points, Energy(0.0, 0.1, 0.0, math.inf), gradient) == math.inf


def test_the_scaled_jacobian_of_a_corner():
    """Of a rhombus it is the sine of its angle; of one turned over it is negative."""
    for angle in (0.4, 1.3, -0.7):
        tip = np.array([math.cos(angle), math.sin(angle)])
        of = corners(mesh([[0, 0], [2, 0], [2 + tip[0], tip[1]], tip], quad=[[0, 1, 2, 3]]))
        assert quality(of) == pytest.approx((math.sin(angle), math.sin(angle)))


def test_a_good_mesh_gets_better():
    of = corners(shaken(hex_grid(4), 0.2))
    points, _ = relocate_all(*of)
    assert quality(of._replace(points=points)).least > 0.999


def test_graded_sizes():
    """Squares around a point, from 1 to twenty times as large: sizes are those of the boundary."""
    for build in (quad_grid, thrown_quads):
        of = corners(build(16))
        where = np.exp(3.0 * (of.points[:, 0] + 1j * of.points[:, 1]))
        of.points[:, :2] = np.column_stack([where.real, where.imag])
        points, record = relocate_all(*of)
        assert record.n_bad_after == 0
        assert quality(of._replace(points=points)).least > 0.95


def test_what_cannot_be_unfolded_is_no_error():
    """A vertex of the boundary beyond the next one folds the cells there over, for good.

    The rest gets as good as it can.
    """
    of = corners(shaken(quad_grid(6), 0.3))
    here = np.flatnonzero((of.points == [0.5, 0.0, 0.0]).all(axis=1))
    of.points[here, 0] += 0.2
    points, record = relocate_all(*of)
    assert 0 < record.n_bad_after <= record.n_bad_before
    moved = of._replace(points=points)
    assert quality(moved).mean > quality(of).mean + 0.05


def test_nothing_to_do():
    of = corners(hex_grid(1))
    points, record = relocate_all(*of)
    assert points.tobytes() == of.points.tobytes()
    assert record == (0, math.inf, math.inf, 0, 0)
    points, _ = relocate_all(of.points, of.simplices[:0], of.shapes, of.shape[:0], of.fixed)
    assert points.tobytes() == of.points.tobytes()


def test_all_vertices_free():
    """Without a boundary the sizes are those of the cells."""
    of = corners(shaken(hex_grid(3), 0.2))
    points, record = relocate_all(*of[:4], np.zeros(len(of.points), dtype=bool), of.cell)
    assert record.n_bad_after == 0
    assert quality(of._replace(points=points)).least > 0.99


def test_points_that_are_no_numbers():
    of = corners(quad_grid(3))
    of.points[5, 1] = math.inf
    with pytest.raises(ValueError, match="finite"):
        relocate_all(*of)


def test_a_weight_out_of_range():
    for angular in (-0.1, 1.1, math.nan):
        with pytest.raises(ValueError, match="between"):
            relocate_all(*corners(quad_grid(2)), angular=angular)


def test_angles_get_better_where_lengths_count_less():
    """Between slopes: the least is that of a corner of the boundary, and stays."""
    of = corners(quad_grid(6))
    of.points[:, 0] *= 1.0 + 2.0 * of.points[:, 1]
    means = [
        quality(of._replace(points=relocate_all(*of, angular=angular)[0])).mean
        for angular in (0.0, 0.5, 0.9)
    ]
    assert means == sorted(set(means))


def test_what_is_better():
    """The least decides, then the mean; noise does not."""
    base = Corners(0.2, 0.8)
    assert is_better(base, Corners(0.3, 0.5))
    assert is_better(base, Corners(0.2, 0.81))
    assert is_better(base, Corners(0.2 - 1e-12, 0.81))
    assert not is_better(base, base)
    assert not is_better(base, Corners(0.19, 0.9))
    assert not is_better(base, Corners(0.2, 0.8 + 1e-12))


def test_it_ends_when_it_is_told_to():
    of = corners(shaken(hex_grid(3), 0.2))
    points, record = relocate_all(*of, is_over=lambda: True)
    assert points.tobytes() == of.points.tobytes()
    assert record.n_steps == 0
    asked = iter([False, True])
    points, record = relocate_all(*of, is_over=lambda: next(asked))
    assert record.n_steps > 0
    assert is_better(quality(of), quality(of._replace(points=points)))
