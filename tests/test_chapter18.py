"""The numbers of chapter 18 of Frey & George, "Mesh Generation", that the code rests on."""

from __future__ import annotations

import math
from functools import cache
from itertools import combinations

import numpy as np
import patches
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.kernels import accept
from meshopt_cli.kernels.operators import swap
from meshopt_cli.kernels.operators.relocate import Relocation
from meshopt_cli.kernels.search.target import best_over_face, estimate_targets
from meshopt_cli.kernels.shape import simplex
from meshopt_cli.kernels.shape.ideal import TET_HEIGHT, TRI_HEIGHT
from meshopt_cli.kernels.types import APPLIED
from meshopt_cli.mesh import adjacency
from meshopt_cli.passes.relax import target_degrees
from meshopt_cli.passes.smooth import METHODS, RELAXATION, WEIGHTS
from meshopt_cli.quality.summary import (
    MEASURES,
    RANKS,
    Summary,
    as_degradation,
    cell_quality,
    histogram,
    summarize,
    target,
)

ASPECT_RATIO = MEASURES["aspect-ratio"]
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0.5, math.sqrt(3) / 2, 0]])
TET = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], dtype=float)
coordinate = st.floats(-1, 1, width=32)


def corners_of_cell(dimension):
    """Corners of a cell at random places."""
    corner = st.tuples(*[coordinate] * dimension)
    return st.lists(corner, min_size=dimension + 1, max_size=dimension + 1).map(
        lambda rows: np.column_stack([np.array(rows), np.zeros((len(rows), 3 - dimension))])
    )


def lengths(corners):
    """Lengths of all edges of a cell."""
    return np.array([np.linalg.norm(a - b) for a, b in combinations(corners, 2)])


def size(corners):
    """Signed area or volume of a cell."""
    return float(patches.volumes(corners, np.arange(len(corners))[None])[0])


def surface(corners):
    """Sum of the areas of the faces of a tet."""
    triples = combinations(corners, 3)
    return sum(np.linalg.norm(np.cross(b - a, c - a)) / 2 for a, b, c in triples)


def quality(corners, name):
    """q of one cell."""
    return float(cell_quality(corners, np.arange(len(corners))[None], MEASURES[name])[0])


# 18.1, 18.2: measurement and measures ---------------------------------------------------


@patches.examples(50)
@given(corners_of_cell(2), corners_of_cell(3))
def test_both_forms_of_area_and_volume(triangle, tet):
    """(18.1) is (18.2) and (18.3) is (18.4)."""
    bordered = np.column_stack([np.ones(3), triangle[:, :2]])
    assert size(triangle) == pytest.approx(np.linalg.det(bordered) / 2, abs=1e-12)
    bordered = np.column_stack([np.ones(4), tet])
    assert size(tet) == pytest.approx(np.linalg.det(bordered) / 6, abs=1e-12)


def test_the_regular_cells():
    """A unit triangle has the area sqrt(3)/4 (Remark 18.7), a unit tet sqrt(2)/12 of volume."""
    assert size(TRIANGLE) == pytest.approx(math.sqrt(3) / 4)
    assert size(TET / math.sqrt(8)) == pytest.approx(math.sqrt(2) / 12)
    assert lengths(TET / math.sqrt(8)) == pytest.approx(1)


def test_constants_of_the_aspect_ratio():
    """Exercise 18.1: alpha of (18.6), with p the half-perimeter, and of (18.7)."""
    edges = lengths(TRIANGLE)
    assert size(TRIANGLE) / (edges.max() * edges.sum() / 2) == pytest.approx(simplex.ALPHA_2)
    assert size(TET) / (lengths(TET).max() * surface(TET)) == pytest.approx(simplex.ALPHA_3)
    assert pytest.approx(math.sqrt(3) / 6) == simplex.ALPHA_2
    assert pytest.approx(math.sqrt(6) / 36) == simplex.ALPHA_3


def test_constants_of_the_edge_lengths():
    """Exercise 18.2: beta of (18.8) and (18.9)."""
    assert size(TRIANGLE) / (lengths(TRIANGLE) ** 2).sum() == pytest.approx(simplex.BETA_2)
    assert size(TET) / (lengths(TET) ** 2).sum() ** 1.5 == pytest.approx(simplex.BETA_3)
    assert pytest.approx(math.sqrt(3) / 12) == simplex.BETA_2
    assert pytest.approx(math.sqrt(3) / 216) == simplex.BETA_3


@patches.examples(50)
@given(corners_of_cell(2))
def test_aspect_ratio_of_triangles(corners):
    """(18.5) with the inradius and sqrt(3)/6 is (18.6)."""
    edges = lengths(corners)
    area = size(corners)
    if abs(area) > 1e-3:
        inradius = 2 * area / edges.sum()
        expected = inradius / (math.sqrt(3) / 6 * edges.max())
        assert quality(corners, "aspect-ratio") == pytest.approx(expected)
        expected = area / (math.sqrt(3) / 12 * (edges**2).sum())
        assert quality(corners, "volume-length") == pytest.approx(expected)


@patches.examples(50)
@given(corners_of_cell(3))
def test_aspect_ratio_of_tets(corners):
    """(18.5) with the inradius and sqrt(6)/12 is (18.7)."""
    volume = size(corners)
    if abs(volume) > 1e-3:
        inradius = 3 * volume / surface(corners)
        expected = inradius / (math.sqrt(6) / 12 * lengths(corners).max())
        assert quality(corners, "aspect-ratio") == pytest.approx(expected)
        expected = volume / (math.sqrt(3) / 216 * (lengths(corners) ** 2).sum() ** 1.5)
        assert quality(corners, "volume-length") == pytest.approx(expected)


def circumradius(corners):
    """Radius of the circle or the sphere through the corners."""
    corners = corners[:, : len(corners) - 1]
    edges = corners[1:] - corners[0]
    return float(np.linalg.norm(np.linalg.solve(2 * edges, (edges**2).sum(axis=1))))


def dihedral_angles(corners):
    """Angles between the faces of a tet, or between the edges of a triangle."""
    inverse = np.linalg.inv(corners[1:, : len(corners) - 1] - corners[0, : len(corners) - 1])
    normals = np.column_stack([-inverse.sum(axis=1), inverse])
    normals = normals / np.linalg.norm(normals, axis=0)
    cosines = [np.dot(a, b) for a, b in combinations(normals.T, 2)]
    return np.pi - np.arccos(np.clip(cosines, -1, 1))


def solid_angles(corners):
    """Solid angles of a tet: at each vertex, the sum of three dihedral angles less pi."""
    angle = dict(zip(combinations(range(4), 2), dihedral_angles(corners), strict=True))
    at = [sum(a for faces, a in angle.items() if k not in faces) for k in range(4)]
    return np.array(at) - np.pi


def ratios(corners):
    """The ratios of 18.2.2, before they are normalised: 1 / Q up to a factor."""
    edges = lengths(corners)
    volume = abs(size(corners))
    flat = len(corners) == 3
    faces = edges if flat else np.array([_area(face) for face in combinations(corners, 3)])
    inradius = (2 if flat else 3) * volume / faces.sum()
    angles = dihedral_angles(corners)
    corner_angles = angles if flat else solid_angles(corners)
    return {
        "radius-ratio": inradius / circumradius(corners),
        "radius-edge": edges.min() / circumradius(corners),
        "edge-ratio": edges.min() / edges.max(),
        "volume-area": volume**2 / (faces**2).sum() ** 2
        if flat
        else volume**4 / (faces**2).sum() ** 3,
        "mean-edge": volume / edges.mean() ** (2 if flat else 3),
        "angle-min": angles.min(),
        "angle-max": np.pi - angles.max(),
        "solid-angle-min": corner_angles.min(),
    }


def _area(face):
    a, b, c = face
    return np.linalg.norm(np.cross(b - a, c - a)) / 2


@pytest.mark.parametrize("regular", [TRIANGLE, TET], ids=["triangle", "tet"])
@patches.examples(50)
@given(data=st.data())
def test_the_other_measures(regular, data):
    """Exercises 18.3 and 18.4: every ratio of 18.2.2, divided by that of the regular cell."""
    corners = data.draw(corners_of_cell(len(regular) - 1))
    if abs(size(corners)) > 1e-2:
        sign = math.copysign(1, size(corners))
        best = ratios(regular)
        for name, value in ratios(corners).items():
            assert quality(corners, name) == pytest.approx(sign * value / best[name], rel=1e-6)


def test_the_list_of_measures_is_covered():
    """Every measure has a test above."""
    assert set(MEASURES) == {"aspect-ratio", "volume-length", *ratios(TET)}


# 18.3.3, Table 18.3: a mesh -------------------------------------------------------------


def test_ranks():
    """The ranks of Table 18.3: 1 to 2, 2 to 3, 3 to 10, above 10; a limit ends its rank."""
    assert list(RANKS) == [1, 2, 3, 10, math.inf]
    degradation = np.array([1.0, 2.0, 2.0001, 3.0, 3.0001, 10.0, 10.0001, math.inf])
    assert histogram(degradation) == (2, 2, 2, 2)
    assert histogram(np.empty(0)) == (0, 0, 0, 0)


@patches.examples(50)
@given(st.lists(st.floats(-1, 1, allow_subnormal=False), max_size=50))
def test_every_cell_has_a_rank(q):
    """Flat and inverted cells count as infinitely bad (Remark 18.3)."""
    degradation = as_degradation(np.array(q))
    counts = histogram(degradation)
    assert sum(counts) == len(q)
    for count, low, high in zip(counts, (0, *RANKS[1:-1]), RANKS[1:], strict=True):
        assert count == sum(low < value <= high for value in degradation)


def test_percentages_are_rounded_not_truncated():
    """Table 18.3 prints 72 for 2,620 of 3,608; the counts tell the truth."""
    angles = {"angle_min": 1.0, "angle_max": 179.0}
    figures = {"n_invalid": 0, "worst": 11.44, "mean": 1.0, "best": 1.0, "target": 8.3, **angles}
    summary = Summary("aspect-ratio", 3, 3608, 1015, (2620, 759, 224, 5), **figures)
    assert [round(p, 2) for p in summary.percent] == [72.62, 21.04, 6.21, 0.14]


@pytest.mark.parametrize("name", patches.SAMPLE_NAMES)
def test_a_summary_adds_up(name):
    """Q_T is the worst Q (18.3.3), ranks hold every cell, and no mesh beats its own best."""
    source = patches.sample(name)
    summary = summarize(source, ASPECT_RATIO, tuple(MEASURES.values()))
    assert sum(summary.counts) == summary.n_cells == len(source.cells)
    assert sum(summary.percent) == pytest.approx(100)
    assert 1 <= summary.best <= summary.mean <= summary.worst
    assert summary.worst == pytest.approx(summary.worst_by_measure["aspect-ratio"])
    assert summary.worst >= summary.target * (1 - 1e-6) or summary.dimension == 2
    assert 0 < summary.angle_min <= summary.angle_max < 180


# The search for the best apex stops when it no longer gains: so far from the true optimum.
ACCURACY = 1e-3


def target_of(*corners):
    """Q of the best tet on a triangle."""
    points = np.array(corners, dtype=float)
    return 1 / best_over_face(ASPECT_RATIO.judge, points, 0, 1, 2)


def isosceles(height):
    """A triangle on a base of length 1."""
    return [0, 0, 0], [1, 0, 0], [0.5, height, 0]


def test_target_of_some_triangles():
    """The target is 1 over the equilateral triangle, and 1.255 over half a square."""
    assert target_of(*TRIANGLE) == pytest.approx(1, abs=1e-4)
    assert target_of([0, 0, 0], [1, 0, 0], [0, 1, 0]) == pytest.approx(1.255, abs=5e-4)


def test_target_grows_as_the_triangle_degrades():
    high = [target_of(*isosceles(h)) for h in np.linspace(math.sqrt(3) / 2, 6, 12)]
    flat = [target_of(*isosceles(h)) for h in np.linspace(math.sqrt(3) / 2, 0.1, 12)]
    for targets in (high, flat):
        assert np.all(np.diff(targets) > 0)


@patches.examples(50)
@given(corners_of_cell(2), corners_of_cell(3))
def test_no_tet_on_a_face_beats_its_target(face, other):
    """The search finds the best apex, wherever it is."""
    if abs(size(face)) > 0.05:
        face = face if size(face) > 0 else face[::-1]
        tet = np.concatenate([face, other[:1]])
        tet[3, 2] += 1
        assert quality(tet, "aspect-ratio") * target_of(*face) <= 1 + ACCURACY


@patches.examples(50)
@given(corners_of_cell(2), st.floats(0.01, 100), st.permutations(range(3)))
def test_target_knows_shape_only(face, scale, order):
    if abs(size(face)) > 0.05:
        turned = (scale * face[list(order)])[:, [2, 0, 1]] + 3
        assert target_of(*turned) == pytest.approx(target_of(*face), rel=ACCURACY)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "two_regions.msh", "grid.vtk"])
def test_target_of_a_mesh(name):
    """It is that of the worst facet of the boundary, and every other facet allows better."""
    source = patches.sample(name)
    faces = source.skin
    found = target(source, ASPECT_RATIO)
    every = [target_of(*source.points[face]) for face in faces[:: max(len(faces) // 200, 1)]]
    assert found >= max(every) * (1 - ACCURACY)
    bound = np.empty(len(faces))
    estimate_targets(ASPECT_RATIO.judge, source.points, faces, bound)
    assert 1 <= found <= (1 / bound).max()


def test_target_in_the_plane():
    """Over an edge of the plane stands the equilateral triangle."""
    assert target(patches.sample("plate.vtu"), ASPECT_RATIO) == 1


# 18.4.1: relocation ---------------------------------------------------------------------

BALLS = {"plane": patches.fan(7, (0.2, 0.1)), "space": patches.icosahedron((0.3, 0.1, -0.2))}


def relocated(work, method, weight="uniform", relaxation=1.0, vertex=0):
    """Where a vertex goes when everything valid is accepted."""
    how = Relocation(METHODS[method], WEIGHTS[weight], relaxation, accept.VALID, 0.0, 2.0)
    plan = patches.plan_relocation(work.mesh, vertex, how, work.scratch)
    assert plan.verdict == APPLIED
    return np.array(plan.position)


def ideal_points(work):
    """The ideal point I_j over the facet opposite vertex 0 of each cell of its ball."""
    found = []
    for cell in work.mesh.cells[work.living()]:
        p = work.mesh.points[cell[cell != 0]]
        if work.dimension == 2:
            edge = p[1] - p[0]
            normal, height = np.array([-edge[1], edge[0], 0]), TRI_HEIGHT
        else:
            normal, height = np.cross(p[1] - p[0], p[2] - p[0]), TET_HEIGHT
        inwards = np.sign(np.dot(normal, work.mesh.points[0] - p[0]))
        height *= inwards * lengths(p).mean() / np.linalg.norm(normal)
        found.append(p.mean(axis=0) + height * normal)
    return np.array(found)


@pytest.mark.parametrize("name", BALLS)
@pytest.mark.parametrize("omega", [1.0, 0.5, 0.1])
def test_relaxed_laplace(name, omega):
    """(18.19) and (18.22): part of the way to the mean of the neighbours."""
    work = patches.workspace(BALLS[name])
    p, neighbours = work.mesh.points[0], work.mesh.points[1:]
    expected = (1 - omega) * p + omega * neighbours.mean(axis=0)
    np.testing.assert_allclose(relocated(work, "laplace", relaxation=omega), expected, atol=1e-12)


@pytest.mark.parametrize("name", BALLS)
def test_weighted_smoothing(name):
    """(18.23): the neighbours weigh what they are away."""
    work = patches.workspace(BALLS[name])
    p, neighbours = work.mesh.points[0], work.mesh.points[1:]
    alpha = np.linalg.norm(neighbours - p, axis=1)
    expected = alpha @ neighbours / alpha.sum()
    np.testing.assert_allclose(relocated(work, "weighted"), expected, atol=1e-12)


@pytest.mark.parametrize("name", BALLS)
@pytest.mark.parametrize("weight", WEIGHTS)
def test_ideal_points(name, weight):
    """(18.24) with the four weights: 1, the worst only, Q, Q squared."""
    work = patches.workspace(BALLS[name])
    q = work.mesh.quality[work.living()]
    alpha = {"uniform": q**0, "worst": q == q.min(), "quality": 1 / q, "quality2": q**-2.0}[weight]
    expected = alpha @ ideal_points(work) / alpha.sum()
    np.testing.assert_allclose(relocated(work, "quality", weight), expected, atol=1e-12)


def test_the_ideal_point_of_a_regular_facet():
    """It makes the regular cell: height sqrt(3)/2 over an edge, sqrt(2/3) over a triangle."""
    assert size(TRIANGLE) == pytest.approx(TRI_HEIGHT / 2)
    assert size(TET / math.sqrt(8)) == pytest.approx(TET_HEIGHT * math.sqrt(3) / 4 / 3)


def test_relaxation_by_dimension():
    """Footnote 5: close to one in the plane, smaller in space."""
    assert 0.5 < RELAXATION[3] < RELAXATION[2] <= 1


def test_optimal_location_outside_of_the_ball():
    """Remarks 18.10 and 18.11: where the mean lies outside, part of the way is gone."""
    chevron = patches.mesh(
        [[0, -0.15], [0, -0.3], [1, 1], [0, 0], [-1, 1]],
        triangle=[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    )
    work = patches.workspace(chevron)
    p, mean = work.mesh.points[0], work.mesh.points[1:].mean(axis=0)
    assert mean[1] > 0
    gone = (relocated(work, "laplace")[1] - p[1]) / (mean[1] - p[1])
    assert 0 < gone < 0.5
    assert math.log2(gone) == pytest.approx(round(math.log2(gone)))


# 18.4.2: swaps --------------------------------------------------------------------------

N_N = {3: 1, 4: 2, 5: 5, 6: 14, 7: 42, 8: 132, 9: 429, 10: 1430, 11: 4862, 12: 16796, 13: 58786}
TR_N = {3: 1, 4: 4, 5: 10, 6: 20, 7: 35, 8: 56, 9: 84, 10: 120, 11: 165, 12: 220}


@cache
def triangulations(i, j):
    """All triangulations of the convex polygon i, i + 1, ... j, as lists of triangles."""
    if j - i < 2:
        return [()]
    return [
        ((i, k, j), *left, *right)
        for k in range(i + 1, j)
        for left in triangulations(i, k)
        for right in triangulations(k, j)
    ]


def catalan(n):
    """Cat(n) as the chapter counts it."""
    return math.factorial(2 * n - 2) // (math.factorial(n) * math.factorial(n - 1))


@pytest.mark.parametrize("n", N_N)
def test_number_of_triangulations(n):
    """Table 18.2: N_n = Cat(n - 1) (18.27), made of Tr_n different triangles."""
    assert N_N[n] == catalan(n - 1)
    if n <= 10:
        found = triangulations(0, n - 1)
        assert len(found) == len({frozenset(t) for t in found}) == N_N[n]
        assert all(len(t) == n - 2 for t in found)
        assert len({triangle for t in found for triangle in t}) == TR_N[n]


def ring_of(n, seed):
    """A shell with a random polygon, ready for the search of its best triangulation."""
    generator = np.random.default_rng(seed)
    patch = patches.spindle(n, generator.uniform(0.3, 2), generator.uniform(0, 0.7), seed)
    work = patches.workspace(patch)
    work.scratch.ring[:n] = np.arange(2, n + 2)
    return work


def triangle_quality(work, n):
    """Worst q of the two tets on each triangle of a polygon."""
    triples = np.array(list(combinations(range(n), 3)))
    p, k, r = triples.T + 2
    above = np.stack([p, k, r, 0 * p + 1], axis=1)
    below = np.stack([p, r, k, 0 * p], axis=1)
    q = [cell_quality(work.mesh.points, cells, ASPECT_RATIO) for cells in (above, below)]
    return dict(zip(map(tuple, triples.tolist()), np.minimum(*q).tolist(), strict=True))


@pytest.mark.parametrize("n", range(3, 9))
@patches.examples(30)
@given(seed=st.integers(0, 2**32 - 1), stop=st.floats(-1, 1))
def test_best_triangulation(n, seed, stop):
    """The dynamic programme finds the optimum over all triangulations of a shell."""
    work = ring_of(n, seed)
    quality = triangle_quality(work, n)
    optimum = max(min(quality[t] for t in found) for found in triangulations(0, n - 1))
    found = patches.best_of_ring(work.mesh, 0, 1, n, -2.0, work.scratch)
    assert found == pytest.approx(optimum, abs=1e-12)
    found = patches.best_of_ring(work.mesh, 0, 1, n, stop, work.scratch)
    if abs(optimum - stop) > 1e-9:
        assert found == pytest.approx(max(optimum, stop), abs=1e-12)


@pytest.mark.parametrize("n", TR_N)
def test_no_triangle_is_looked_at_twice(n, monkeypatch):
    """Exercise 18.12: Tr_n triangles are enough, whatever the number of triangulations."""
    seen = []

    def q_of_tet(_, p, q, r, apex):
        seen.append((frozenset((p, q, r)), apex))
        return 0.5 + 1e-3 * len(seen)

    monkeypatch.setattr(swap, "q_of_tet", q_of_tet)
    work = ring_of(n, 0)
    search = getattr(swap.triangulate_ring, "py_func", swap.triangulate_ring)
    search(work.mesh, 0, 1, n, 0.0, work.scratch)
    assert len(seen) == len(set(seen)) <= 2 * TR_N[n]
    assert len({triangle for triangle, _ in seen}) >= n - 2


# Definition 18.7: degrees ---------------------------------------------------------------


def degrees(patch):
    """Degree of every vertex of a patch, and what it should be."""
    work = patches.workspace(patch)
    cells = work.mesh.cells[work.living()]
    return adjacency.degrees(cells, len(work.mesh.points)), target_degrees(work)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_degree_of_triangles(n):
    """6 is the degree inside equilateral triangles; on their boundary the angle decides."""
    degree, wanted = degrees(patches.hexagon(n))
    assert degree[0] == 6
    np.testing.assert_array_equal(degree, wanted)


def test_degree_of_tets():
    """12 is the degree of the centre of an icosahedron, the ball of 20 tets (footnote 9)."""
    degree, wanted = degrees(patches.icosahedron())
    assert degree[0] == wanted[0] == 12
    np.testing.assert_array_equal(degree, wanted)
