"""Declared facets that one more cell would bind: a cell with a vertex of its own that is gone.

Such facets have a point that no cell has, as beams and shells do. But they close, together with
facets that became boundary and that the file does not declare, around one cell.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable

import numpy as np

from ..cells import FAMILIES
from ..mesh.adjacency import distinct
from ..mesh.facets import CellSet
from ..mesh.model import Array
from .boundary import skin_of
from .study import Study

Facet = tuple[int, ...]


def closing_one_cell(
    study: Study, declared: list[CellSet], unbound: list[CellSet], parts: list[Array]
) -> Array:
    """Numbers of the parts of unbound facets that are left of one cell, (n,) int64.

    Parameters
    ----------
    declared, unbound : list of CellSet
        Facets that the file lists, and those of them that bound no cell.
    parts : list of (n,) int64
        A number for each cell of `unbound`, the same for those that hang together.
    """
    shapes = [f for f in FAMILIES.values() if f.dimension == study.dimension]
    counts = Counter(np.concatenate([np.empty(0, np.int64), *parts]).tolist())
    # At a vertex that only the cell had, it has as many facets as its dimension, or more. Lines
    # beside a surface in space may have no such vertex.
    least = 1 if study.may_branch else study.dimension
    most = max((sum(len(t) for t in shape.facets) for shape in shapes), default=0)
    some = {part for part, n in counts.items() if least <= n < most}
    by_part: dict[int, list[Facet]] = defaultdict(list)
    for group, part in zip(unbound, parts, strict=True):
        chosen = np.isin(part, list(some))
        for number, row in zip(part[chosen].tolist(), group.cells[chosen].tolist(), strict=True):
            by_part[number].append(tuple(row))
    exposed = _exposed(study, declared, by_part.values()) if by_part else {}
    wanted = {_signature(shape.n_corners, _widths(shape.facets)) for shape in shapes}
    found = []
    for number, facets in by_part.items():
        rim = [side for side, n in _sides(facets).items() if n % 2]
        closing = {facet for side in rim for facet in exposed.get(side, ())}
        whole = [*facets, *closing]
        vertices = {vertex for facet in whole for vertex in facet}
        is_closed = set(_sides(whole).values()) == {2}
        if closing and is_closed and _signature(len(vertices), map(len, whole)) in wanted:
            found.append(number)
    return np.array(found, dtype=np.int64)


def _widths(tables: tuple[Array, ...]) -> Iterable[int]:
    return (len(facet) for table in tables for facet in table.tolist())


def _signature(n_vertices: int, widths: Iterable[int]) -> tuple[int, tuple[int, ...]]:
    return n_vertices, tuple(sorted(widths))


def _sides(facets: Iterable[Facet]) -> Counter[Hashable]:
    """How many facets have each side: an edge of a face, an end of an edge."""
    count: Counter[Hashable] = Counter()
    for facet in facets:
        if len(facet) == 2:
            count.update(facet)
        else:
            count.update(map(frozenset, zip(facet, facet[1:] + facet[:1], strict=True)))
    return count


def _exposed(
    study: Study, declared: list[CellSet], parts: Iterable[list[Facet]]
) -> dict[Hashable, list[Facet]]:
    """The facets of the boundary that are not declared, near some parts, by their sides."""
    near = np.zeros(study.n_points, dtype=bool)
    near[[vertex for facets in parts for facet in facets for vertex in facet]] = True
    listed = set()
    for group in declared:
        rows = group.cells[near[group.cells].any(axis=1)]
        listed |= set(map(frozenset, rows.tolist()))
    skin = skin_of(study)
    found = defaultdict(list)
    for width in distinct(skin.width).tolist():
        rows = skin.rows[skin.width == width, :width]
        rows = rows[near[rows].sum(axis=1) >= study.dimension - 1]
        for facet in map(tuple, rows.tolist()):
            if frozenset(facet) not in listed:
                for side in _sides([facet]):
                    found[side].append(facet)
    return found
