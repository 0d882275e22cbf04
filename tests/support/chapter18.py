"""Cells and their sizes as chapter 18 has them, by formulas of the tests' own."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from hypothesis import strategies as st

from meshopt_cli.quality.measures import OF_SIMPLICES, cell_quality
from support.invariants import volumes

ASPECT_RATIO = OF_SIMPLICES["aspect-ratio"]
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0.5, math.sqrt(3) / 2, 0]])
TET = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], dtype=float)
coordinate = st.floats(-1, 1, width=32)


def corners_of_cell(dimension, least=0.0):
    """Corners of a cell at random places, whose size is more than `least` or less than its
    opposite.
    """
    corner = st.tuples(*[coordinate] * dimension)
    return (
        st.lists(corner, min_size=dimension + 1, max_size=dimension + 1)
        .map(lambda rows: np.column_stack([np.array(rows), np.zeros((len(rows), 3 - dimension))]))
        .filter(lambda corners: abs(size(corners)) >= least)
    )


def lengths(corners):
    """Lengths of all edges of a cell."""
    return np.array([np.linalg.norm(a - b) for a, b in combinations(corners, 2)])


def size(corners):
    """Signed area or volume of a cell."""
    return float(volumes(corners, np.arange(len(corners))[None])[0])


def surface(corners):
    """Sum of the areas of the faces of a tet."""
    triples = combinations(corners, 3)
    return sum(np.linalg.norm(np.cross(b - a, c - a)) / 2 for a, b, c in triples)


def quality(corners, name):
    """q of one cell."""
    return float(cell_quality(corners, np.arange(len(corners))[None], OF_SIMPLICES[name])[0])
