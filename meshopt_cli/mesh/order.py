"""The order in which vertices and cells stand in memory while they are worked on.

What is near in space should be near in memory: a ball or a shell then lies in a few lines of
the cache. The vertices go along a Hilbert curve, and each cell stands by its first vertex.
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray

BITS = 10  # of each coordinate: a grid of 1024 cells a side


def hilbert(points: Array) -> Array:
    """The order of points along a Hilbert curve (Skilling 2004), ties by number.

    Parameters
    ----------
    points : (n, 3) float64

    Returns
    -------
    order : (n,) int64
        The point that comes first, second, ...
    """
    low = points.min(axis=0, initial=np.inf)
    extent = float(np.max(points.max(axis=0, initial=-np.inf) - low, initial=0.0))
    if not 0.0 < extent < np.inf:
        return np.arange(len(points))
    scaled = (points - low) * ((2**BITS - 1) / extent)
    x, y, z = axes = [np.ascontiguousarray(axis) for axis in scaled.T.astype(np.int32)]
    # From the coarsest bit to the finest, turn the axes as the curve turns in each octant.
    for bit in range(BITS - 1, 0, -1):
        low_bits = (1 << bit) - 1
        for axis in axes:
            inverted = (axis >> bit & 1).astype(bool)
            exchanged = np.where(inverted, 0, (x ^ axis) & low_bits)
            x ^= np.where(inverted, low_bits, exchanged)
            if axis is not x:
                np.bitwise_xor(axis, exchanged, out=axis)
    y ^= x
    z ^= y
    turn = np.zeros_like(z)
    for bit in range(BITS - 1, 0, -1):
        turn ^= np.where(z >> bit & 1, (1 << bit) - 1, 0).astype(turn.dtype)
    key = np.zeros(len(points), np.int64)
    for bit in range(BITS - 1, -1, -1):
        for axis in axes:
            key = key << 1 | ((axis ^ turn) >> bit & 1)
    return np.argsort(key, kind="stable")
