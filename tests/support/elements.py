"""Single cells of any type of the table of elements, straight or bent."""

from __future__ import annotations

import numpy as np

from meshopt_cli.elements import ELEMENTS
from support.meshes import mesh

# All types that corners alone do not decide.
BENT = [name for name in ELEMENTS if name not in ("triangle", "tetra", "quad", "pyramid")]
SOLIDS = [name for name in BENT if ELEMENTS[name].nodes.shape[1] == 3]

# Whole numbers of tenths. All corners of both are positive; the Jacobian falls to -0.24 of its
# greatest size on an edge of the first, and to -0.034 inside a face of the second, whose edges
# are positive.
HEXAHEDRA = {
    "edge": np.array([[5, 5, -3], [8, 4, 6], [6, 5, 5], [-6, 8, 2], [4, 5, 5], [12, 0, 8],
                      [7, 13, 4], [2, 6, 12]]),
    "face": np.array([[0, 5, -5], [6, -5, 4], [6, 5, 0], [3, 8, 2], [5, 5, 8], [14, 5, 11],
                      [10, 10, 10], [-4, 12, 7]]),
}  # fmt: skip


def in_space(name, at):
    """Reference coordinates (n, d) as places: a pyramid's (a, b, w) as x, y and z."""
    if not ELEMENTS[name].is_collapsed:
        return np.asarray(at, dtype=float)
    a, b, w = np.transpose(at)
    return np.stack([a * w, b * w, 1 - w], axis=1)


def reference(name):
    """Places of the nodes of the reference cell."""
    return in_space(name, ELEMENTS[name].nodes)


def one(name, points):
    """A mesh of one cell."""
    return mesh(points, **{name: [range(len(points))]})


def grid(name, n):
    """Reference coordinates of many points of a cell, its boundary included."""
    element = ELEMENTS[name]
    axis = np.linspace(0, 1, n + 1)
    at = np.stack(np.meshgrid(*[axis] * element.nodes.shape[1], indexing="ij"), axis=-1)
    at = at.reshape(-1, element.nodes.shape[1])
    width = element.factors[0]
    return at[at[:, :width].sum(axis=1) < 1 + 1e-9] if width > 1 else at


def sampled(name, points, n=12):
    """Jacobians at many points of a cell with nodes at some places."""
    slopes = ELEMENTS[name].slopes(grid(name, n))
    return np.linalg.det(np.einsum("dmk,kc->mdc", slopes, points))


def shaken(name, amount, seed):
    """Places of the nodes of a reference cell, each moved by up to an amount."""
    points = reference(name)
    return points + np.random.default_rng(seed).uniform(-amount, amount, points.shape)


def middles_of(name, corners):
    """Places of all nodes of a straight cell with some corners."""
    element = ELEMENTS[name]
    corners = np.asarray(corners, dtype=float)
    return np.array([*corners, *(corners[list(m)].mean(axis=0) for m in element.middles)])
