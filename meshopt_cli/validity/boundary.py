"""The boundary of a mesh as its cells make it, and the parts that hang together by facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..mesh.adjacency import distinct, distinct_rows, first_of, row_ids
from ..mesh.facets import FacetSet
from ..mesh.model import Array
from ..mesh.quads import FLAT, corner_areas
from ..mesh.sizes import contents, flux
from . import geometry
from .geometry import Pairs
from .study import MANY, Study

# Cells other than simplices, by the facets that bound them: how many of each width.
VOIDS = {
    name: {table.shape[1]: len(table) for table in family.facets}
    for name, family in FAMILIES.items()
    if family.facets and not family.is_simplex
}


@dataclass(frozen=True)
class Skin:
    """Facets that bound one cell only, of all widths together.

    Attributes
    ----------
    rows : (m, 4) int64
        Vertices, turned outwards; -1 beyond the last.
    owners : (m,) int64
    width : (m,) int64
    """

    rows: Array
    owners: Array
    width: Array

    def take(self, rows: Array) -> Skin:
        return Skin(self.rows[rows], self.owners[rows], self.width[rows])


@dataclass(frozen=True)
class Sides:
    """The sides of facets: edges of faces in space, ends of edges in the plane.

    Attributes
    ----------
    facet : (n,) int64
        Row of the facet in its `Skin`.
    local : (n,) int64
        Position of the first vertex.
    side : (n,) int64
        Number of the side, the same for all facets that have it.
    sign : (n,) int64
        1 or -1: the direction in which the facet runs along it.
    count : (n_sides,) int64
        How many facets have it.
    """

    facet: Array
    local: Array
    side: Array
    sign: Array
    count: Array


def skin_of(study: Study) -> Skin:
    """The boundary of the distinct sound cells."""
    return _skin([(facets, facets.alone()) for facets in study.distinct_facets])


def crowd_of(study: Study) -> Skin:
    """Facets of more than two cells."""
    chosen = []
    for facets in study.distinct_facets:
        crowded = np.repeat(facets.count > 2, facets.count)
        chosen.append((facets, facets.order[crowded]))
    return _skin(chosen)


def _skin(chosen: list[tuple[FacetSet, Array]]) -> Skin:
    total = sum(len(rows) for _, rows in chosen)
    result = Skin(np.full((total, 4), -1), np.empty(total, np.int64), np.empty(total, np.int64))
    at = 0
    for facets, rows in chosen:
        width = facets.rows.shape[1]
        here = slice(at, at + len(rows))
        result.rows[here, :width] = facets.rows[rows]
        result.owners[here] = facets.owners[rows]
        result.width[here] = width
        at += len(rows)
    return result


def sides_of(skin: Skin, n_points: int, dimension: int) -> Sides:
    """The sides of facets, matched."""
    facet, local, first, second = [], [], [], []
    for width in distinct(skin.width).tolist():
        rows = np.flatnonzero(skin.width == width)
        corners = skin.rows[rows, :width]
        for k in range(width):
            facet.append(rows)
            local.append(np.full(len(rows), k))
            first.append(corners[:, k])
            # In the plane a side is a point: the edge leaves it, or arrives.
            second.append(corners[:, (k + 1) % width] if dimension == 3 else np.full(len(rows), k))
    if not facet:
        none = np.empty(0, np.int64)
        return Sides(none, none, none, none, none)
    start, end = np.concatenate(first), np.concatenate(second)
    if dimension == 3:
        sign = np.where(start < end, 1, -1)
        key = np.minimum(start, end) * n_points + np.maximum(start, end)
    else:
        sign, key = 1 - 2 * end, start
    _, side, count = np.unique(key, return_inverse=True, return_counts=True)
    return Sides(np.concatenate(facet), np.concatenate(local), side, sign, count)


def couples(sides: Sides) -> Pairs:
    """Positions in `sides` of the two facets wherever exactly two meet."""
    order = np.argsort(sides.side, kind="stable")
    start = np.cumsum(sides.count) - sides.count
    start = start[sides.count == 2]
    return order[start], order[start + 1]


def is_consistent(sides: Sides) -> bool:
    """Whether facets run along each side in one direction as often as in the other."""
    total = np.bincount(sides.side, weights=sides.sign, minlength=len(sides.count))
    return not total.any()


def missing_cells(
    study: Study, skin: Skin, sides: Sides, sign: float, explained: Array
) -> list[Array]:
    """Rows of the facets of each void that one cell would fill."""
    simplices = _missing_simplices(study, skin, sign)
    taken = np.zeros(len(skin.rows), dtype=bool)
    for rows in simplices:
        taken[rows] = True
    # Other cells: small closed pieces of boundary.
    one, other = couples(sides)
    label = first_of(len(skin.rows), sides.facet[one], sides.facet[other])
    n_facets = np.bincount(label, minlength=len(label))
    found = []
    open_ = np.zeros(len(label), dtype=bool)
    open_[label[sides.facet[sides.count[sides.side] != 2]]] = True
    order = np.argsort(label, kind="stable")
    ends = np.cumsum(n_facets)
    kinds = {name: w for name, w in VOIDS.items() if FAMILIES[name].dimension == study.dimension}
    sizes = [sum(widths.values()) for widths in kinds.values()]
    # The boundary of a cell alone is seen from outside.
    seen = sign * np.bincount(label, weights=fluxes(study, skin), minlength=len(label)) < 0
    for piece in np.flatnonzero(np.isin(n_facets, sizes) & ~open_ & seen).tolist():
        rows = order[ends[piece] - n_facets[piece] : ends[piece]]
        widths = {int(w): int(n) for w, n in zip(*np.unique(skin.width[rows], return_counts=True),
                                                 strict=True)}  # fmt: skip
        n_vertices = len(distinct(skin.rows[rows][skin.rows[rows] >= 0]))
        fits = any(
            widths == facets and n_vertices == FAMILIES[name].n_corners
            for name, facets in kinds.items()
        )
        if fits and not taken[rows].any() and _is_void(study, skin.take(rows), sign):
            found.append(rows)
    return [rows for rows in simplices + found if not explained[skin.owners[rows]].any()]


def _is_void(study: Study, skin: Skin, sign: float) -> bool:
    """Whether facets are seen from inside what they enclose, and enclose more than nothing."""
    points = study.centred[skin.rows[skin.rows >= 0]]
    size = np.ptp(points, axis=0).max()
    return sign * enclosed(study, skin) < -FLAT * size**study.dimension


def _missing_simplices(study: Study, skin: Skin, sign: float) -> list[Array]:
    """Rows of the d + 1 facets of each void in the form of a simplex, seen from inside."""
    d = study.dimension
    simple = np.flatnonzero(skin.width == d)
    rows = skin.rows[simple, :d]
    if not len(rows):
        return []
    # Facets that share all vertices but one, each pair from its facet with the least number.
    ridge, owner, apex = [], [], []
    for k in range(d):
        ridge.append(np.delete(rows, k, axis=1))
        owner.append(np.arange(len(rows)))
        apex.append(rows[:, k])
    key = row_ids(np.concatenate(ridge), study.n_points)
    facet, tip = np.concatenate(owner), np.concatenate(apex)
    order = np.argsort(key, kind="stable")
    key, facet, tip = key[order], facet[order], tip[order]
    pairs = []
    for lag in range(1, 4):
        same = np.flatnonzero(key[lag:] == key[:-lag]) if len(key) > lag else np.empty(0, np.int64)
        for a, b in ((same, same + lag), (same + lag, same)):
            pairs.append(np.stack([facet[a], tip[b]], axis=1))
    # A simplex is a facet and one more vertex that all its sides lead to.
    found, _, count = distinct_rows(np.concatenate(pairs))
    found = found[count >= d]
    if not len(found):
        return []
    corners = np.concatenate([rows[found[:, 0]], found[:, 1:]], axis=1)
    # The void lies before the facet, where the outward normal points to.
    points = study.plane[0] if study.plane is not None else study.points
    family = SIMPLICES[d]
    ahead = contents(points, corners, family) * sign * (1 if d == 3 else -1) > 0
    # A hanging node makes flat voids, which no cell could fill.
    found, corners = found[ahead], corners[ahead]
    at_corners = geometry.corner_volumes if d == 3 else corner_areas
    flat = at_corners(points, study.noise, corners, family)[1][:, 0]
    found, corners = found[~flat], corners[~flat]
    ids = row_ids(np.sort(corners, axis=1), study.n_points) if len(corners) else corners[:, 0]
    voids = []
    order = np.argsort(ids, kind="stable")
    for piece in np.split(order, np.flatnonzero(np.diff(ids[order])) + 1):
        if len(piece) == d + 1:
            voids.append(simple[found[piece, 0]])
    return voids


def fluxes(study: Study, skin: Skin) -> Array:
    """What each facet adds to the volume, or area in the plane, that all enclose, (m,)."""
    points = study.centred
    result = np.zeros(len(skin.rows))
    for width in distinct(skin.width).tolist():
        rows = skin.width == width
        result[rows] = flux(points[skin.rows[rows, :width]])
    return result


def enclosed(study: Study, skin: Skin) -> float:
    """Volume, or area in the plane, that facets enclose, by the divergence theorem."""
    return float(fluxes(study, skin).sum())


@dataclass(frozen=True)
class Domain:
    """The boundary of a mesh, with voids that one cell would fill taken for filled.

    Attributes
    ----------
    skin : Skin
    sides : Sides
        Of the facets of `skin`.
    voids : list of Skin
        The facets around each void that one cell would fill.
    sign : float
        -1 where all cells have the other orientation, else 1.
    """

    skin: Skin
    sides: Sides
    voids: list[Skin]
    sign: float

    @property
    def missing(self) -> list[Array]:
        """Numbers of the cells around each void."""
        return [void.owners for void in self.voids]


def domain_of(study: Study, explained: Array) -> Domain:
    """Find the boundary of the distinct sound cells.

    Parameters
    ----------
    explained : (n_cells,) bool
        Cells whose own shape is found wrong: what they bound is no void.
    """
    skin = skin_of(study)
    sides = sides_of(skin, study.n_points, study.dimension)
    sign = -1.0 if sum(float(c.sum()) for c in study.contents) < 0 else 1.0
    voids: list[Array] = []
    if study.dimension == 3 or study.plane is not None:
        voids = missing_cells(study, skin, sides, sign, explained)
    around = [skin.take(rows) for rows in voids]
    if voids:
        kept = np.ones(len(skin.rows), dtype=bool)
        kept[np.concatenate(voids)] = False
        skin = skin.take(np.flatnonzero(kept))
        sides = sides_of(skin, study.n_points, study.dimension)
    return Domain(skin, sides, around, sign)


def parts(study: Study, region: Array | None = None) -> Array:
    """A number for each cell, the same for cells that hang together by facets.

    Parameters
    ----------
    region : (n_cells,) int64, optional
        Facets between different regions do not count.

    Returns
    -------
    label : (n_cells,) int64
        The least number of a cell of the part.
    """
    ones, others = [], []
    for facets in study.distinct_facets:
        within = np.flatnonzero(np.diff(np.repeat(np.arange(len(facets.count)), facets.count)) == 0)
        one = facets.owners[facets.order[within]]
        other = facets.owners[facets.order[within + 1]]
        if region is not None:
            same = region[one] == region[other]
            one, other = one[same], other[same]
        ones.append(one)
        others.append(other)
    none = np.empty(0, np.int64)
    return components(study.n_cells, np.concatenate([none, *ones]), np.concatenate([none, *others]))


def components(n: int, one: Array, other: Array) -> Array:
    """For each of `n` items the least one that pairs link it to."""
    if n < MANY:
        return first_of(n, one, other)
    from ..kernels.search.unite import unite

    parent = np.arange(n)
    unite(parent, one, other)
    return parent
