"""Section 18.4 of Frey & George, "Mesh Generation": relocation, swaps, degrees."""

from __future__ import annotations

import contextlib
import math
import sys
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.kernels import accept
from meshopt_cli.kernels.judge import q_of_tet
from meshopt_cli.kernels.operators import ring
from meshopt_cli.kernels.operators.relocate import Relocation
from meshopt_cli.kernels.shape.ideal import TET_HEIGHT, TRI_HEIGHT
from meshopt_cli.kernels.types import APPLIED
from meshopt_cli.mesh import adjacency
from meshopt_cli.passes.relax import target_degrees
from meshopt_cli.passes.smooth import METHODS, RELAXATION, WEIGHTS
from meshopt_cli.quality.measures import cell_quality
from support import drivers
from support.chapter18 import ASPECT_RATIO, TET, TRIANGLE, lengths, size
from support.edits import with_regions
from support.invariants import workspace
from support.meshes import fan, hexagon, icosahedron, mesh, spindle
from support.settings import examples

BALLS = {"plane": fan(7, (0.2, 0.1)), "space": icosahedron((0.3, 0.1, -0.2))}


def relocated(work, method, weight="uniform", relaxation=1.0, vertex=0):
    """Where a vertex goes when everything valid is accepted."""
    how = Relocation(METHODS[method], WEIGHTS[weight], relaxation, accept.VALID, 0.0, 2.0)
    plan = drivers.plan_relocation(work.mesh, vertex, how, work.scratch)
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
    work = workspace(BALLS[name])
    p, neighbours = work.mesh.points[0], work.mesh.points[1:]
    expected = (1 - omega) * p + omega * neighbours.mean(axis=0)
    np.testing.assert_allclose(relocated(work, "laplace", relaxation=omega), expected, atol=1e-12)


@pytest.mark.parametrize("name", BALLS)
def test_weighted_smoothing(name):
    """(18.23): the neighbours weigh what they are away."""
    work = workspace(BALLS[name])
    p, neighbours = work.mesh.points[0], work.mesh.points[1:]
    alpha = np.linalg.norm(neighbours - p, axis=1)
    expected = alpha @ neighbours / alpha.sum()
    np.testing.assert_allclose(relocated(work, "weighted"), expected, atol=1e-12)


@pytest.mark.parametrize("name", BALLS)
@pytest.mark.parametrize("weight", WEIGHTS)
def test_ideal_points(name, weight):
    """(18.24) with the four weights: 1, the worst only, Q, Q squared."""
    work = workspace(BALLS[name])
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
    chevron = mesh(
        [[0, -0.15], [0, -0.3], [1, 1], [0, 0], [-1, 1]],
        triangle=[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    )
    work = workspace(chevron)
    p, mean = work.mesh.points[0], work.mesh.points[1:].mean(axis=0)
    assert mean[1] > 0
    gone = (relocated(work, "laplace")[1] - p[1]) / (mean[1] - p[1])
    assert 0 < gone < 0.5
    assert math.log2(gone) == pytest.approx(round(math.log2(gone)))


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
    patch = spindle(n, generator.uniform(0.3, 2), generator.uniform(0, 0.7), seed)
    work = workspace(patch)
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
@examples(30)
@given(seed=st.integers(0, 2**32 - 1), stop=st.floats(-1, 1))
def test_best_triangulation(n, seed, stop):
    """The dynamic programme finds the optimum over all triangulations of a shell."""
    work = ring_of(n, seed)
    quality = triangle_quality(work, n)
    optimum = max(min(quality[t] for t in found) for found in triangulations(0, n - 1))
    found = drivers.best_of_ring(work.mesh, 0, 1, n, -2.0, work.scratch)
    assert found == pytest.approx(optimum, abs=1e-12)
    found = drivers.best_of_ring(work.mesh, 0, 1, n, stop, work.scratch)
    assume(abs(optimum - stop) > 1e-9)
    assert found == pytest.approx(max(optimum, stop), abs=1e-12)


@contextlib.contextmanager
def noting(function, *names):
    """Note those arguments of all calls of a Python function."""
    calls, code = [], function.__code__

    def note(frame, event, _):
        if event == "call" and frame.f_code is code:
            calls.append(tuple(frame.f_locals[name] for name in names))

    sys.setprofile(note)
    try:
        yield calls
    finally:
        sys.setprofile(None)


@pytest.mark.parametrize("n", TR_N)
def test_no_triangle_is_looked_at_twice(n):
    """Exercise 18.12: Tr_n triangles are enough, whatever the number of triangulations."""
    work = ring_of(n, 0)
    quality, search = (getattr(code, "py_func", code) for code in (q_of_tet, ring.triangulate_ring))
    with noting(quality, "a", "b", "c", "d") as calls:
        search(work.mesh, 0, 1, n, -2.0, work.scratch)
    seen = {frozenset(call) for call in calls}
    assert n - 2 <= len(seen) == len(calls) <= 2 * TR_N[n]


def degrees(patch):
    """Degree of every vertex of a patch, and what it should be."""
    work = workspace(patch)
    cells = work.mesh.cells[work.living()]
    return adjacency.degrees(cells, len(work.mesh.points)), target_degrees(work)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_degree_of_triangles(n):
    """6 is the degree inside equilateral triangles; on their boundary the angle decides."""
    degree, wanted = degrees(hexagon(n))
    assert degree[0] == 6
    np.testing.assert_array_equal(degree, wanted)


def test_degree_on_an_interface():
    """Where two regions meet, triangles go on all around: 6 is the degree there, too."""
    plain = hexagon(3)
    middle = plain.points[plain.blocks[0].cells].mean(axis=1)
    degree, wanted = degrees(with_regions(plain, middle[:, 1] > 0.0))
    np.testing.assert_array_equal(degree, wanted)


def test_degree_of_tets():
    """12 is the degree of the centre of an icosahedron, the ball of 20 tets (footnote 9)."""
    degree, wanted = degrees(icosahedron())
    assert degree[0] == wanted[0] == 12
    np.testing.assert_array_equal(degree, wanted)
