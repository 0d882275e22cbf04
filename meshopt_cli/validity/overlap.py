"""Cells that overlap, for the rules of `check`.

Where cells are positive and neighbours agree, the number of cells around a point changes at the
boundary only. So if any cells overlap, then some cell with a boundary facet overlaps another
near that facet, and it is enough to look there. Two convex cells do not overlap if they lie on
different sides of a plane: one normal to a facet of theirs, or parallel to an edge of each.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..mesh.adjacency import distinct, same_direction
from ..mesh.facets import CellSet, FacetSet
from ..mesh.model import Array
from ..mesh.sizes import chunks
from .boxes import bounding, extents, grid_widths, near_any, overlapping
from .contact import unmatched
from .examination import Examination
from .geometry import Pairs
from .study import MANY

FLAT_SIDED = {name for name, family in FAMILIES.items() if family.has_flat_facets}
WARP = 1e-3  # parts of cells with warped faces may reach this part of their size into others
DOUBT = 1e4  # pairs less deep in each other than so many tolerances are looked at exactly
MOST_EXACT = 500
MOST_FOUND = 20_000


def overlapping_cells(study: Examination) -> Pairs:
    """Numbers of cells that overlap, the later and the earlier ones, each pair once.

    The search ends after `MOST_FOUND` pairs, which only meshes reach whose cells lie across each
    other everywhere.
    """
    later, earlier = [], []
    if study.plane is not None:
        points, noise, _ = study.plane
    elif study.dimension == 3:
        points, noise = study.points, study.noise
    else:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    sets = [_good(study, group) for group in study.distinct_sets]
    sizes = {group.family: _sizes(points, group.cells) for group in sets}
    errors = {group.family: _greatest(noise, group.cells) for group in sets}
    neighbours = _neighbours(study, {group.family for group in sets})
    for candidates in _candidates(study, points, noise, sets):
        # A pair meets at several of its facets.
        one, other = divmod(distinct(_pair_keys(study, *candidates)), study.n_cells)
        for mine in sets:
            for others in sets:
                rows, columns = _rows_in(mine, one), _rows_in(others, other)
                both = (rows >= 0) & (columns >= 0)
                a, b = rows[both], columns[both]
                families = mine.family, others.family
                if not {*families} <= FLAT_SIDED:
                    # Of neighbours, the hulls of warped faces overlap.
                    apart = ~np.isin(
                        _pair_keys(study, mine.numbers[a], others.numbers[b]), neighbours
                    )
                    a, b = a[apart], b[apart]
                limit = study.touch * np.minimum(sizes[mine.family][a], sizes[others.family][b])
                limit += 2 * np.maximum(errors[mine.family][a], errors[others.family][b])
                hit = _overlap(study, points, mine.cells[a], others.cells[b], limit, families)
                if not {*families} <= FLAT_SIDED:
                    hit = hit[_parts_overlap(points, mine, a[hit], others, b[hit], limit[hit])]
                pair = np.stack([mine.numbers[a[hit]], others.numbers[b[hit]]])
                later.append(pair.max(axis=0))
                earlier.append(pair.min(axis=0))
        if sum(len(numbers) for numbers in later) > MOST_FOUND:
            break
    none = np.empty(0, np.int64)
    pairs = np.stack([np.concatenate([none, *later]), np.concatenate([none, *earlier])])
    found = np.unique(pairs, axis=1)
    return found[0], found[1]


def _neighbours(study: Examination, families: set[str]) -> Array:
    """Keys of the pairs of cells with a facet in common, if there are any with warped faces."""
    keys = [np.empty(0, np.int64)]
    if not families <= FLAT_SIDED:
        for facets in study.distinct_facets:
            for lag in (1, 2):
                same = np.repeat(np.arange(len(facets.count)), facets.count)
                at = np.flatnonzero(same[lag:] == same[:-lag])
                one, other = facets.order[at], facets.order[at + lag]
                keys.append(_pair_keys(study, facets.owners[one], facets.owners[other]))
    return np.concatenate(keys)


def _pair_keys(study: Examination, one: Array, other: Array) -> Array:
    return np.minimum(one, other) * study.n_cells + np.maximum(one, other)


def _good(study: Examination, group: CellSet) -> CellSet:
    """The cells whose own shape is not wrong, nor that of one at their vertices.

    Around a cell that is inverted, the others overlap because of it.
    """
    wrong = study.corners_of(np.flatnonzero(study.shape.inverted | (study.shape.quads > 0)))
    tangled = np.zeros(study.n_points, dtype=bool)
    tangled[wrong[wrong >= 0]] = True
    good = ~study.explained[group.numbers] & ~tangled[group.cells].any(axis=1)
    return group if good.all() else type(group)(
        group.family, group.cells[good], group.numbers[good]
    )  # fmt: skip


def _rows_in(group: CellSet, numbers: Array) -> Array:
    """Rows of cells in a set by their numbers, -1 for those of other sets."""
    if not len(group.numbers):
        return np.full(len(numbers), -1)
    row = np.minimum(np.searchsorted(group.numbers, numbers), len(group.numbers) - 1)
    return np.where(group.numbers[row] == numbers, row, -1)


def _candidates(
    study: Examination, points: Array, noise: Array, sets: list[CellSet]
) -> Iterator[Pairs]:
    """Numbers of cells with a boundary facet, and of the cells whose boxes meet this facet's."""
    lows, highs, owners = [], [], []
    for facets in study.distinct_facets:
        rows = unmatched(study, facets, study.first_points)
        rows = np.concatenate([rows, _doubtful(study, facets)])
        rows = rows[~study.explained[facets.owners[rows]]]
        low, high = bounding(points, noise, facets.rows[rows], study.touch)
        lows.append(low)
        highs.append(high)
        owners.append(facets.owners[rows])
    if not owners:
        return
    low, high, owner = np.concatenate(lows), np.concatenate(highs), np.concatenate(owners)
    all_numbers = np.concatenate([group.numbers for group in sets])
    boxes = [bounding(points, noise, group.cells, 0.0) for group in sets]
    cell_low = np.concatenate([pair[0] for pair in boxes])
    cell_high = np.concatenate([pair[1] for pair in boxes])
    near = near_any(low, high, cell_low, cell_high)
    cell_low, cell_high, all_numbers = cell_low[near], cell_high[near], all_numbers[near]
    cubes = _cubes(cell_low, cell_high)
    for facet, cell in overlapping(low, high, cell_low, cell_high, cubes):
        apart = owner[facet] != all_numbers[cell]
        yield owner[facet[apart]], all_numbers[cell[apart]]
    # Facets that are larger than the cells near them, which that search left out.
    width = grid_widths(cubes)[0][:, 0]
    size = (high - low).max(axis=1)
    large = np.flatnonzero(size > width.min(initial=np.inf))
    low, high, owner, size = low[large], high[large], owner[large], size[large]
    for cell, facet in overlapping(cell_low, cell_high, low, high, _cubes(low, high)):
        apart = (owner[facet] != all_numbers[cell]) & (size[facet] > width[cell])
        yield owner[facet[apart]], all_numbers[cell[apart]]


def _cubes(low: Array, high: Array) -> Array:
    return np.broadcast_to((high - low).max(axis=1, keepdims=True, initial=0.0), low.shape)


def _doubtful(study: Examination, facets: FacetSet) -> Array:
    """Rows of facets inside where the cells on both sides may still overlap."""
    one, other = facets.pairs()
    same = same_direction(facets.rows[one], facets.rows[other])
    moot = study.explained[facets.owners[one]] | study.explained[facets.owners[other]]
    odd = np.concatenate([one[same | moot], other[same | moot]])
    crowded = np.repeat(facets.count > 2, facets.count)
    return np.concatenate([odd, facets.order[crowded]])


def _overlap(
    study: Examination,
    points: Array,
    one: Array,
    other: Array,
    limit: Array,
    families: tuple[str, str],
) -> Array:
    """Which pairs of cells overlap, as rows of `one` and `other`, their corners.

    Parameters
    ----------
    one, other : (n, k) int64
    limit : (n,) float64
        How deep cells may reach into each other, from the tolerance and the rounding.
    """
    tables = axes_of(families[0]), axes_of(families[1])
    hit = []
    for rows in chunks(len(one)):
        a, b, allowed = one[rows], other[rows], limit[rows]
        if study.n_cells >= MANY and points.shape[1] == 3:
            depth = _compiled_depths(points, a, b, allowed, tables)
            left = np.flatnonzero(depth > allowed)
        else:
            left, depth = _not_separated(_columns(points, a), _columns(points, b), allowed, tables)
        doubtful = left[depth[left] < DOUBT * allowed[left]]
        # Cells with warped faces are looked at part by part in any case.
        if {*families} <= FLAT_SIDED and len(doubtful) <= MOST_EXACT:
            apart = [
                row
                for row in doubtful.tolist()
                if exactly_separated(points[a[row]].T, points[b[row]].T, tables)
            ]
            left = np.setdiff1d(left, np.array(apart, dtype=np.int64))
        hit.append(rows.start + left)
    return np.concatenate([np.empty(0, np.int64), *hit])


def _parts_overlap(
    points: Array, mine: CellSet, a: Array, others: CellSet, b: Array, limit: Array
) -> Array:
    """Which pairs of cells overlap as their faces run, (n,) bool, not only their hulls.

    Cells are divided into tetrahedra around the middles of cell and faces, which divides each
    face in the same way for both of its cells.
    """
    found = np.zeros(len(a), dtype=bool)
    tables = axes_of(SIMPLICES[3]), axes_of(SIMPLICES[3])
    step = 64
    for first in range(0, len(a), step):
        rows = slice(first, first + step)
        one = _divided(points, mine.cells[a[rows]], mine.family)
        other = _divided(points, others.cells[b[rows]], others.family)
        low, high = one.min(axis=2)[:, :, None], one.max(axis=2)[:, :, None]
        meet = (low < other.max(axis=2)[:, None]) & (other.min(axis=2)[:, None] < high)
        pair, k, m = np.nonzero(meet.all(axis=-1))
        one, other = one[pair, k], other[pair, m]
        sizes = (np.ptp(cells, axis=1).max(axis=1, initial=0.0) for cells in (one, other))
        allowed = limit[rows][pair] + WARP * np.minimum(*sizes)
        left, _ = _not_separated(one.transpose(2, 1, 0), other.transpose(2, 1, 0), allowed, tables)
        found[first + pair[left]] = True
    return found


def _divided(points: Array, cells: Array, family: str) -> Array:
    """Tetrahedra that solids are divided into, (n, m, 4, 3)."""
    corners = points[cells]
    if FAMILIES[family].is_simplex:
        return corners[:, None]
    middle = corners.mean(axis=1)
    tets = []
    for facet in (facet for table in FAMILIES[family].facets for facet in table):
        face = corners[:, facet]
        centre = face.mean(axis=1)
        if len(facet) == 3:
            tets.append(np.stack([*face.transpose(1, 0, 2), middle], axis=1))
        else:
            for k in range(len(facet)):
                following = face[:, (k + 1) % len(facet)]
                tets.append(np.stack([face[:, k], following, centre, middle], axis=1))
    return np.stack(tets, axis=1)


def _columns(points: Array, cells: Array) -> Array:
    """Corners of cells, (d, k, n): numpy is fast along the last axis."""
    return np.stack([points[vertices].T for vertices in cells.T], axis=1)


def _greatest(values: Array, cells: Array) -> Array:
    """The greatest value of a vertex of each cell."""
    return np.maximum.reduce([values[cells[:, k]] for k in range(cells.shape[1])])


def _sizes(points: Array, cells: Array) -> Array:
    """Greatest extent of each cell along an axis."""
    low, high = extents(points, cells)
    return (high - low).max(axis=1, initial=0.0)


def axes_of(family: str) -> Pairs:
    """Local triangles that facets of a family lie in, and local ends of its edges.

    In the plane, the edges are the facets.
    """
    row = FAMILIES[family]
    if row.dimension == 2:
        return np.empty((0, 3), np.int64), row.edges
    triangles = []
    for table in row.facets:
        name = "triangle" if table.shape[1] == 3 else "quad"
        halves = np.concatenate(FAMILIES[name].partitions)
        triangles.append(np.take(table, halves, axis=1).reshape(-1, 3))
    return np.concatenate(triangles), row.edges


def _directions(d: int, tables: tuple[Pairs, Pairs]) -> Iterator[tuple]:
    """How to find each direction that may separate two cells."""
    if d == 2:
        for side, (_, edges) in enumerate(tables):
            for i, j in edges.tolist():
                yield "edge", side, (i, j)
        return
    for side, (triangles, _) in enumerate(tables):
        for i, j, k in triangles.tolist():
            yield "facet", side, (i, j, k)
    for i, j in tables[0][1].tolist():
        for k, m in tables[1][1].tolist():
            yield "edges", 0, (i, j, k, m)


def _direction(one: Array, other: Array, kind: str, side: int, local: tuple) -> Array:
    """The direction itself, (d, ...), from corners (d, k, ...)."""
    corners = other if side else one
    if kind == "edge":
        along = corners[:, local[1]] - corners[:, local[0]]
        return np.stack([-along[1], along[0]])
    if kind == "facet":
        i, j, k = local
        return _cross(corners[:, j] - corners[:, i], corners[:, k] - corners[:, i])
    i, j, k, m = local
    return _cross(one[:, j] - one[:, i], other[:, m] - other[:, k])


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _reach(corners: Array, axis: Array) -> Pairs:
    """Least and greatest coordinate of corners (d, k, ...) along an axis (d, ...)."""
    along = sum(corners[i] * axis[i] for i in range(1, len(axis))) + corners[0] * axis[0]
    return along.min(axis=0), along.max(axis=0)


def _not_separated(one: Array, other: Array, limit: Array, tables: tuple[Pairs, Pairs]) -> Pairs:
    """Rows of the pairs that no direction separates, and how deep each pair is at most, (n,).

    Parameters
    ----------
    one, other : (d, k, n) float64
        Corners: with the pairs along the last axis, which numpy works along.
    limit : (n,) float64
        Cells that reach less than this into each other only touch.
    """
    origin = one[:, :1].copy()
    one, other = one - origin, other - origin
    depth = np.full(len(limit), np.inf)
    left = np.arange(len(limit))
    for how in _directions(len(one), tables):
        if not len(left):
            break
        axis = _direction(one, other, *how)
        length = np.sqrt((axis * axis).sum(axis=0))
        (low, high), (other_low, other_high) = _reach(one, axis), _reach(other, axis)
        reach = np.minimum(high - other_low, other_high - low)
        # A direction that is nothing but rounding says nothing.
        spread = np.maximum(high - low, other_high - other_low)
        with np.errstate(all="ignore"):
            deep = np.where((length > 0) & (spread > 0), reach / length, np.inf)
        depth[left] = np.minimum(depth[left], deep)
        kept = np.flatnonzero(deep > limit[left])
        if len(kept) < len(left):
            left, one, other = left[kept], one[..., kept], other[..., kept]
    return left, depth


def _compiled_depths(
    points: Array, one: Array, other: Array, limit: Array, tables: tuple[Pairs, Pairs]
) -> Array:
    """How deep the cells of each pair reach into each other, (n,); see `kernels.separate`."""
    from ..kernels.search.separate import depths

    depth = np.empty(len(limit))
    one, other = np.ascontiguousarray(one), np.ascontiguousarray(other)
    (facets, edges), (other_facets, other_edges) = tables
    depths(points, one, other, limit, facets, other_facets, edges, other_edges, depth)
    return depth


def exactly_separated(one: Array, other: Array, tables: tuple[Pairs, Pairs]) -> bool:
    """Whether two convex cells have no point inside in common, in rational arithmetic.

    Parameters
    ----------
    one, other : (d, k) float64
    tables : pair of (triangles, edges)
        From `axes_of`.
    """
    from fractions import Fraction

    a = np.array([[Fraction(x) for x in row] for row in one.tolist()])
    b = np.array([[Fraction(x) for x in row] for row in other.tolist()])
    for how in _directions(len(a), tables):
        axis = _direction(a, b, *how)
        if not axis.any():
            continue
        (low, high), (other_low, other_high) = _reach(a, axis), _reach(b, axis)
        if high <= other_low or other_high <= low:
            return True
    return False
