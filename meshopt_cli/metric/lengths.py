"""Lengths of edges in a metric, and the efficiency index (18.12)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..mesh.model import Array
from ..mesh.sizes import chunks, norms
from .field import Metric, matrices

# An edge is unit, as far as meshes can have such, when its length is within these limits.
UNIT = (math.sqrt(0.5), math.sqrt(2.0))
# Ranks of lengths: whichever length l is in one, 1 / l is in the one across from it.
RANKS = (0.0, 0.2, 0.5, UNIT[0], 0.9, 1.0 / 0.9, UNIT[1], 2.0, 5.0, math.inf)

# Gauss points along an edge: so many where log M changes by less than this (Frobenius norm).
POINTS = ((0.1, 2), (2.0, 8), (math.inf, 32))


def gauss(n: int) -> tuple[Array, Array]:
    """Points and weights of Gauss on [0, 1], (n,) each."""
    places, weights = np.polynomial.legendre.leggauss(n)
    return (places + 1.0) / 2.0, weights / 2.0


def edge_lengths(points: Array, metric: Metric, edges: Array) -> Array:
    """Lengths of edges in a metric, (n,): the integral of sqrt(e^t M e) along each edge e.

    Sizes h are linear along an edge, and the integral is exact: |e| log(h1 / h0) / (h1 - h0).
    Tensors are interpolated by their logarithms, M(t) = exp((1 - t) log M0 + t log M1), and
    integrated by Gauss points, as many as `POINTS` says, which leaves six digits where sizes change
    by a factor of twenty along an edge; where both ends have the same tensor, the length is
    sqrt(e^t M e), and exact.

    Parameters
    ----------
    points : (np, 3) float64
        In a plane z = const where the metric is one of the plane.
    edges : (n, 2) int64
    """
    found = [_lengths(points, metric, edges[rows]) for rows in chunks(len(edges))]
    return np.concatenate([np.empty(0), *found])


def _lengths(points: Array, metric: Metric, edges: Array) -> Array:
    one, other = edges.T
    vectors = points[other] - points[one]
    if metric.is_isotropic:
        return norms(vectors) * mean_of_inverse(metric.values[one, 0], metric.values[other, 0])
    result = np.empty(len(edges))
    change = matrices(metric.logarithms[one] - metric.logarithms[other])
    apart = np.sqrt(np.einsum("nij,nij->n", change, change))
    same = (metric.values[one] == metric.values[other]).all(axis=1)
    result[same] = norms(np.einsum("nij,nj->ni", metric.maps[one[same]], vectors[same]))
    rank = np.searchsorted([limit for limit, _ in POINTS], apart)
    for k, (_, n) in enumerate(POINTS):
        some = ~same & (rank == k)
        start, end = metric.logarithms[one[some]], metric.logarithms[other[some]]
        along = vectors[some, None, : metric.width]
        total = np.zeros(len(start))
        for place, weight in zip(*gauss(n), strict=True):
            total += weight * norms(mapped((1.0 - place) * start + place * end, along)[:, 0])
        result[some] = total
    return result


def mean_of_inverse(h0: Array, h1: Array) -> Array:
    """Mean of 1 / h where h goes from h0 to h1: log(h1 / h0) / (h1 - h0), without cancellation."""
    middle = (h0 + h1) / 2.0
    part = (h1 - h0) / (h0 + h1)
    near = np.abs(part) < 1e-3
    series = 1.0 + part**2 / 3.0 + part**4 / 5.0
    # log(h1 / h0) = 2 artanh(part); one end may be as good as nothing beside the other
    large = np.where(near, 0.5, part)
    with np.errstate(divide="ignore"):
        whole = np.where(np.abs(large) < 0.9, np.arctanh(np.clip(large, -0.9, 0.9)),
                         0.5 * (np.log(h1) - np.log(h0)))  # fmt: skip
    return np.where(near, series, whole / large) / middle


def mapped(logarithms: Array, vectors: Array) -> Array:
    """Vectors as the square roots of tensors map them, in the axes of these: lengths are those of
    the metric.

    Parameters
    ----------
    logarithms : (n, 3) or (n, 6) float64
        Components of log M.
    vectors : (n, k, d) float64
    """
    values, axes = np.linalg.eigh(matrices(logarithms))
    return np.exp(values / 2.0)[:, None, :] * np.einsum("nij,nki->nkj", axes, vectors)


def shares(lengths: Array) -> Array:
    """e of (18.12): l for edges that are too short, 1 / l for those that are too long, (n,)."""
    long = lengths > 1.0
    return np.where(long, 1.0 / np.where(long, lengths, 1.0), lengths)


def efficiency(lengths: Array) -> float:
    """The efficiency index tau (18.12): 1 if all edges have length 1; not a number without any."""
    return float(1.0 - np.mean((1.0 - shares(lengths)) ** 2)) if len(lengths) else math.nan


def is_unit(lengths: Array) -> Array:
    """Which lengths are within `UNIT`, (n,) bool."""
    return (lengths >= UNIT[0]) & (lengths <= UNIT[1])


@dataclass(frozen=True)
class Lengths:
    """What is told of the lengths of some edges; figures are not a number without any.

    Attributes
    ----------
    n_edges : int
    tau : float
        The efficiency index.
    share : float
        Part of them within `UNIT`, of 1.
    least, mean, greatest : float
    counts : tuple of int
        How many there are in each rank of `RANKS`; the upper end belongs to a rank.
    """

    n_edges: int
    tau: float
    share: float
    least: float
    mean: float
    greatest: float
    counts: tuple[int, ...]


def told_of(lengths: Array) -> Lengths:
    """What is told of lengths, (n,)."""
    inner = np.array(RANKS[1:-1])
    counts = np.bincount(np.searchsorted(inner, lengths), minlength=len(inner) + 1)
    least, mean, greatest, share = math.nan, math.nan, math.nan, math.nan
    if len(lengths):
        least, mean, greatest = lengths.min(), lengths.mean(), lengths.max()
        share = is_unit(lengths).mean()
    return Lengths(
        n_edges=len(lengths),
        tau=efficiency(lengths),
        share=float(share),
        least=float(least),
        mean=float(mean),
        greatest=float(greatest),
        counts=tuple(int(n) for n in counts),
    )
