"""Sections 18.1 to 18.3 of Frey & George, "Mesh Generation": measures, and a mesh."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.kernels.search.target import best_over_face, estimate_targets
from meshopt_cli.kernels.shape import simplex
from meshopt_cli.quality.measures import OF_SIMPLICES, as_degradation
from meshopt_cli.quality.summary import RANKS, Summary, histogram, summarize
from meshopt_cli.quality.target import target
from support.chapter18 import (
    ASPECT_RATIO,
    TET,
    TRIANGLE,
    corners_of_cell,
    lengths,
    quality,
    size,
    surface,
)
from support.samples import SAMPLE_NAMES, sample
from support.settings import examples


@examples(50)
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


@examples(50)
@given(corners_of_cell(2, least=1e-3))
def test_aspect_ratio_of_triangles(corners):
    """(18.5) with the inradius and sqrt(3)/6 is (18.6)."""
    edges = lengths(corners)
    area = size(corners)
    inradius = 2 * area / edges.sum()
    expected = inradius / (math.sqrt(3) / 6 * edges.max())
    assert quality(corners, "aspect-ratio") == pytest.approx(expected)
    expected = area / (math.sqrt(3) / 12 * (edges**2).sum())
    assert quality(corners, "volume-length") == pytest.approx(expected)


@examples(50)
@given(corners_of_cell(3, least=1e-3))
def test_aspect_ratio_of_tets(corners):
    """(18.5) with the inradius and sqrt(6)/12 is (18.7)."""
    volume = size(corners)
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
@examples(50)
@given(data=st.data())
def test_the_other_measures(regular, data):
    """Exercises 18.3 and 18.4: every ratio of 18.2.2, divided by that of the regular cell."""
    corners = data.draw(corners_of_cell(len(regular) - 1, least=1e-2))
    sign = math.copysign(1, size(corners))
    best = ratios(regular)
    for name, value in ratios(corners).items():
        assert quality(corners, name) == pytest.approx(sign * value / best[name], rel=1e-6)


def test_the_list_of_measures_is_covered():
    """Every measure of the chapter has a test above."""
    others = {"scaled-jacobian"}
    assert set(OF_SIMPLICES) - others == {"aspect-ratio", "volume-length", *ratios(TET)}


def test_ranks():
    """The ranks of Table 18.3: 1 to 2, 2 to 3, 3 to 10, above 10; a limit ends its rank."""
    assert list(RANKS) == [1, 2, 3, 10, math.inf]
    degradation = np.array([1.0, 2.0, 2.0001, 3.0, 3.0001, 10.0, 10.0001, math.inf])
    assert histogram(degradation) == (2, 2, 2, 2)
    assert histogram(np.empty(0)) == (0, 0, 0, 0)


@examples(50)
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
    summary = Summary("aspect-ratio", 3, "tetra", 3608, 1015, (2620, 759, 224, 5), **figures)
    assert [round(p, 2) for p in summary.percent] == [72.62, 21.04, 6.21, 0.14]


@pytest.mark.parametrize("name", SAMPLE_NAMES)
def test_a_summary_adds_up(name):
    """Q_T is the worst Q (18.3.3), ranks hold every cell, and no mesh beats its own best."""
    source = sample(name)
    summary = summarize(source, ASPECT_RATIO, tuple(OF_SIMPLICES.values()))
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


@examples(50)
@given(corners_of_cell(2, least=0.05), corners_of_cell(3))
def test_no_tet_on_a_face_beats_its_target(face, other):
    """The search finds the best apex, wherever it is."""
    face = face if size(face) > 0 else face[::-1]
    tet = np.concatenate([face, other[:1]])
    tet[3, 2] += 1
    assert quality(tet, "aspect-ratio") * target_of(*face) <= 1 + ACCURACY


@examples(50)
@given(corners_of_cell(2, least=0.05), st.floats(0.01, 100), st.permutations(range(3)))
def test_target_knows_shape_only(face, scale, order):
    turned = (scale * face[list(order)])[:, [2, 0, 1]] + 3
    assert target_of(*turned) == pytest.approx(target_of(*face), rel=ACCURACY)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "two_regions.msh", "grid.vtk"])
def test_target_of_a_mesh(name):
    """It is that of the worst facet of the boundary, and every other facet allows better."""
    source = sample(name)
    faces = source.skin
    found = target(source, ASPECT_RATIO)
    every = [target_of(*source.points[face]) for face in faces[:: max(len(faces) // 200, 1)]]
    assert found >= max(every) * (1 - ACCURACY)
    bound = np.empty(len(faces))
    estimate_targets(ASPECT_RATIO.judge, source.points, faces, bound)
    assert 1 <= found <= (1 / bound).max()


def test_target_in_the_plane():
    """Over an edge of the plane stands the equilateral triangle."""
    assert target(sample("plate.vtu"), ASPECT_RATIO) == 1
