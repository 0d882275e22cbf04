"""What a mesh is worth, and whether its boundary is still there, in numpy alone.

It shares no code with what it judges: the formulas are written down again from chapter 18.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

Array = np.ndarray

RANKS = (1, 2, 3, 10)
# What coordinates may differ by, for tools and text formats round them: parts of the extent of
# the mesh, and units in the last place of the greatest coordinate, whichever is more.
SAME, LAST_PLACES = 1e-9, 4
# Part of the volume of the mesh that the volume of a region may differ by.
VOLUME = 1e-6
# Facets of a triangle and a tetrahedron, each opposite to the vertex of its number, turned
# outwards.
FACETS = {2: ((1, 2), (2, 0), (0, 1)), 3: ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))}


@dataclass
class Part:
    """Triangles in the plane or tetrahedra.

    Attributes
    ----------
    points : (np, d) float64
    cells : (ne, d + 1) int64
    region : (ne,) int64
        Counted from 1.
    """

    points: Array
    cells: Array
    region: Array

    @property
    def dimension(self) -> int:
        return self.cells.shape[1] - 1


@dataclass
class Verdict:
    """What there is to say of a mesh.

    Attributes
    ----------
    percent, counts : list
        Of the cells, in the ranks 1-2, 2-3, 3-10 and above of Table 18.3.
    worst, mean : float
        Of the aspect ratio; infinite with a flat or an inverted cell.
    angle_min, angle_max : float
        In degrees: dihedral angles of tetrahedra, angles of triangles.
    invalid : int
        Flat or inverted cells.
    boundary : str
        "kept", or what changed of the facets of the boundary and between regions.
    """

    cells: int
    vertices: int
    percent: list[float]
    counts: list[int]
    worst: float
    mean: float
    angle_min: float
    angle_max: float
    invalid: int
    boundary: str = "kept"


def volumes(part: Part) -> Array:
    """Signed volume, in the plane area, of each cell, (ne,)."""
    corners = part.points[part.cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2, 6)[part.dimension - 2]


def aspect_ratios(part: Part) -> Array:
    """Aspect ratio (18.6), (18.7) of each cell, (ne,); infinite where it is flat or inverted."""
    volume = volumes(part)
    lengths = np.stack([_length(part, a, b) for a, b in _edges(part)], axis=1)
    if part.dimension == 2:
        factor, size = np.sqrt(3) / 6, lengths.sum(axis=1) / 2
    else:
        factor, size = np.sqrt(6) / 36, sum(np.linalg.norm(n, axis=1) / 2 for n in _normals(part))
    ratio = np.full(len(volume), np.inf)
    np.divide(factor * lengths.max(axis=1) * size, volume, out=ratio, where=volume > 0)
    return ratio


def angles(part: Part) -> Array:
    """Angles of triangles, (ne, 3), or dihedral angles of tetrahedra, (ne, 6), in degrees."""
    normals = _normals(part)
    found = []
    for one, other in combinations(normals, 2):
        dot = -np.sum(one * other, axis=1)
        if part.dimension == 2:
            sine = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
        else:
            sine = np.linalg.norm(np.cross(one, other), axis=1)
        found.append(np.degrees(np.arctan2(sine, dot)))
    return np.stack(found, axis=1)


def walls(part: Part) -> tuple[Array, Array, Array]:
    """Facets of the boundary and between regions, each once.

    Returns
    -------
    facets : (n, d) int64
        As the first of their cells turns them: outwards.
    inside, outside : (n,) int64
        The lesser region beside them, and the greater; 0 is the outside of the mesh.
    """
    local = FACETS[part.dimension]
    every = np.concatenate([part.cells[:, f] for f in local])
    region = np.tile(part.region, len(local))
    key = np.sort(every, axis=1)
    order = np.lexsort((region, *key.T))
    same = np.all(key[order][1:] == key[order][:-1], axis=1)
    first = np.r_[True, ~same]
    inside = region[order]
    outside = np.r_[np.where(same, inside[1:], 0), 0]
    wanted = first & (inside != outside)
    return every[order][wanted], inside[wanted], outside[wanted]


def judge(part: Part, before: Part | None = None) -> Verdict:
    """Measure a mesh, and compare its boundary with that of another."""
    ratio = aspect_ratios(part)
    # Regular cells may have less than 1 by rounding.
    rank = np.searchsorted(RANKS[1:], ratio, side="right")
    counts = np.bincount(rank, minlength=len(RANKS))
    angle = angles(part)
    return Verdict(
        cells=len(ratio),
        vertices=len(np.unique(part.cells)),
        percent=[100 * float(n) / len(ratio) for n in counts],
        counts=[int(n) for n in counts],
        worst=float(ratio.max()),
        mean=float(ratio.mean()),
        angle_min=float(angle.min()),
        angle_max=float(angle.max()),
        invalid=int(np.count_nonzero(~(volumes(part) > 0))),
        boundary="kept" if before is None else compare(before, part),
    )


def compare(before: Part, after: Part) -> str:
    """Say "kept", or what changed of the boundary, the interfaces or the regions."""
    extent, greatest = np.max(np.ptp(before.points, axis=0)), np.max(np.abs(before.points))
    tolerance = max(SAME * extent, LAST_PLACES * np.spacing(greatest))
    old, new = walls(before)[0], walls(after)[0]
    known = before.points[np.unique(old)]
    sets = []
    for part, facets in ((before, old), (after, new)):
        used, place = np.unique(facets, return_inverse=True)
        names = find(part.points[used], known, tolerance)
        if np.any(names < 0):
            return f"{np.count_nonzero(names < 0)} vertices moved or new"
        sets.append({tuple(row) for row in np.sort(names[place.reshape(facets.shape)]).tolist()})
    lost, added = len(sets[0] - sets[1]), len(sets[1] - sets[0])
    if lost or added:
        return f"{lost} facets lost, {added} new"
    n_regions = max(before.region.max(), after.region.max()) + 1
    one, other = (np.bincount(p.region, volumes(p), n_regions) for p in (before, after))
    if np.max(np.abs(one - other)) > VOLUME * np.sum(np.abs(one)):
        return "volume of a region changed"
    return "kept"


def find(points: Array, known: Array, tolerance: float) -> Array:
    """Number of the known point where each point is, (n,); -1 where there is none.

    Of known points that coincide, all are found as the same one.
    """
    direction = np.random.default_rng(0).normal(size=known.shape[1])
    direction /= np.linalg.norm(direction)
    height = known @ direction
    order = np.argsort(height, kind="stable")
    at = points @ direction
    low = np.searchsorted(height[order], at - 2 * tolerance)
    high = np.searchsorted(height[order], at + 2 * tolerance, side="right")
    result = np.full(len(points), -1)
    for step in range(int(np.max(high - low, initial=0))):
        open_ = np.flatnonzero((low + step < high) & (result < 0))
        candidate = order[low[open_] + step]
        near = np.max(np.abs(points[open_] - known[candidate]), axis=1) <= tolerance
        result[open_[near]] = candidate[near]
    return result


def _edges(part: Part) -> list[tuple[int, int]]:
    return list(combinations(range(part.dimension + 1), 2))


def _length(part: Part, a: int, b: int) -> Array:
    return np.linalg.norm(part.points[part.cells[:, a]] - part.points[part.cells[:, b]], axis=1)


def _normals(part: Part) -> list[Array]:
    """Normals of the facets of each cell, as long as the facets, in space twice that."""
    corners = part.points[part.cells]
    found = []
    for facet in FACETS[part.dimension]:
        sides = [corners[:, i] - corners[:, facet[0]] for i in facet[1:]]
        if part.dimension == 2:
            found.append(np.stack([sides[0][:, 1], -sides[0][:, 0]], axis=1))
        else:
            found.append(np.cross(sides[0], sides[1]))
    return found
