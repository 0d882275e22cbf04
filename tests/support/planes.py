"""Planar meshes put into space."""

from dataclasses import replace

import numpy as np
import pytest

# Where the two coordinates of a planar mesh go: two of the axes, and a height along the third.
AXIS_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2), "yx": (1, 0), "zx": (2, 0)}
every_axis_plane = pytest.mark.parametrize("axes", AXIS_PLANES.values(), ids=AXIS_PLANES)


def in_plane(flat, axes, height=0.0):
    """A mesh of two columns in a plane normal to an axis."""
    points = np.full((len(flat.points), 3), height, dtype=flat.points.dtype)
    points[:, axes] = flat.points
    return replace(flat, points=points)


def rotation(seed):
    """A random rotation, (3, 3)."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


def in_tilted_plane(flat, seed=0, shift=(0.3, -2.0, 5.0)):
    spatial = in_plane(flat, (0, 1))
    return replace(spatial, points=spatial.points @ rotation(seed).T + np.array(shift))
