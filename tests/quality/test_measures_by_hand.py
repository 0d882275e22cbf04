"""Measures of quads, solids and simplices, by values worked out by hand."""

import math

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.quality.measures import MEASURES, cell_quality


def value(name, corners, family):
    corners = np.array(corners, dtype=float)
    points = np.zeros((len(corners), 3))
    points[:, : corners.shape[1]] = corners
    (found,) = MEASURES[name].of(points, np.arange(len(points))[None], family)
    return found


RECTANGLE = [(0, 0), (2, 0), (2, 1), (0, 1)]
TRAPEZOID = [(-2, -1), (2, -1), (1, 1), (-1, 1)]
PARALLELOGRAM = [(0, 0), (2, 0), (3, 1), (1, 1)]
# Two right triangles at a right angle: along the other diagonal their normals have 1/3 in common.
FOLDED = [(0, 0, 0), (1, 1, 0), (0, 2, 0), (0, 1, 1)]
QUADS = [
    ("aspect-ratio", RECTANGLE, 5 / 4),  # (a^2 + b^2) / (2 a b)
    ("aspect-ratio", [(0, 0), (4, 0), (4, 1), (0, 1)], 17 / 8),
    # Half a square has h_max perimeter / area = 4 (1 + sqrt(2)).
    ("worst-simplex", RECTANGLE, math.sqrt(5) * (3 + math.sqrt(5)) / (4 + 4 * math.sqrt(2))),
    ("robinson-aspect", RECTANGLE, 2),
    ("robinson-aspect", TRAPEZOID, 1.5),
    ("robinson-skew", TRAPEZOID, 0),
    ("robinson-taper-x", TRAPEZOID, 0),
    ("robinson-taper-y", TRAPEZOID, 1 / 3),
    ("robinson-skew", PARALLELOGRAM, 1),
    ("robinson-taper-x", PARALLELOGRAM, 0),
    ("robinson-taper-y", PARALLELOGRAM, 0),
    ("smoothness", RECTANGLE, 1),
    ("smoothness", FOLDED, 0.5),
    ("torsion", RECTANGLE, 0),
    ("torsion", FOLDED, 90),
    ("edge-ratio", RECTANGLE, 2),
    ("edge-share", RECTANGLE, 0.5),
    ("content", TRAPEZOID, 6),
    ("corner-min", TRAPEZOID, math.degrees(math.atan(2))),
    ("corner-max", [(0, 0), (1, 1), (2, 0), (1, 3)], 270),  # a dart
]


@pytest.mark.parametrize(("name", "corners", "expected"), QUADS)
def test_quads(name, corners, expected):
    assert value(name, corners, "quad") == pytest.approx(expected, abs=1e-12)


# A taper along the long axis is one of the heights, wherever the numbering begins.
@pytest.mark.parametrize("first", range(4))
def test_tapers_go_by_the_longer_axis(first):
    corners = np.roll([(-4, -1.5), (4, -0.5), (4, 0.5), (-4, 1.5)], first, axis=0)
    assert value("robinson-taper-x", corners, "quad") == pytest.approx(0.5)
    assert value("robinson-taper-y", corners, "quad") == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("family", "expected"),
    [
        ("tetra", math.acos(23 / 27)),
        # Beside the base: twice half the angle between two sides, and that angle, less pi.
        ("pyramid", 2 * math.acos(-1 / 3) - math.pi),
        ("wedge", math.pi / 3),
        ("hexahedron", math.pi / 2),
    ],
)
def test_solid_angles(family, expected):
    assert value("solid-min", FAMILIES[family].reference, family) == pytest.approx(expected)


def test_the_solid_angle_at_the_top_of_a_pyramid():
    corners = FAMILIES["pyramid"].reference.copy()
    corners[4, 2] = 10.0
    # A square seen from above its middle: by the angles of its sides.
    half = math.atan(0.5 / 10.0)
    expected = 4 * math.asin(math.sin(half) ** 2)
    assert value("solid-min", corners, "pyramid") == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("family", "corners", "expected"),
    [
        ("triangle", [(0, 0), (1, 0), (0, 1)], math.sqrt(3) / 2 * math.sqrt(2)),
        ("tetra", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], math.sqrt(2)),
        ("quad", PARALLELOGRAM, math.sqrt(2)),
        ("quad", RECTANGLE, 1),
        ("hexahedron", FAMILIES["hexahedron"].reference * [1, 2, 3], 1),
    ],
)
def test_scaled_jacobians(family, corners, expected):
    """Right corners are ideal in quads and hexahedra, and 60 degrees in simplices."""
    assert value("scaled-jacobian", corners, family) == pytest.approx(expected)


def test_circumradii():
    assert value("radius-diameter", [(0, 0), (3, 0), (0, 4)], "triangle") == pytest.approx(0.5)
    corner = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)]  # of a box: half its diagonal
    expected = math.sqrt(14) / 2 / math.sqrt(13)
    assert value("radius-diameter", corner, "tetra") == pytest.approx(expected)
    flat = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    assert value("radius-diameter", flat, "tetra") == math.inf


@pytest.mark.parametrize(
    "name", ["aspect-ratio", "volume-length", "radius-ratio", "mean-edge", "volume-area"]
)
def test_a_box_is_as_good_as_the_regular_tetrahedron_is_stretched_with_it(name):
    box = np.array([1.0, 1.0, 2.5])
    # Unit edges, 60 degrees apart, around the diagonal of the cube: a on an axis, b on all.
    a = math.sqrt(0.5)
    edges = a * np.eye(3) + a / 3
    assert edges @ edges.T == pytest.approx(0.5 + 0.5 * np.eye(3))
    corners = np.concatenate([np.zeros((1, 3)), edges]) * box
    (q,) = cell_quality(corners, np.arange(4)[None], MEASURES[name])
    cube = FAMILIES["hexahedron"].reference * box
    assert value(name, cube, "hexahedron") == pytest.approx(1 / q)


def test_faces_of_a_box():
    assert value("face-aspect", FAMILIES["hexahedron"].reference * [1, 1, 2], "hexahedron") == (
        pytest.approx(5 / 4)
    )
    worst = value("worst-simplex", FAMILIES["hexahedron"].reference * [1, 1, 2], "hexahedron")
    assert worst >= 5 / 4


def test_a_twisted_wedge_has_torsion():
    corners = FAMILIES["wedge"].reference.copy()
    turn = math.radians(30)
    middle = corners[3:].mean(axis=0)
    rotate = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    corners[3:, :2] = (corners[3:] - middle)[:, :2] @ rotate + middle[:2]
    assert value("torsion", corners, "wedge") > 10
    assert value("smoothness", corners, "wedge") == pytest.approx(
        (1 + math.cos(math.radians(value("torsion", corners, "wedge")))) / 2
    )
