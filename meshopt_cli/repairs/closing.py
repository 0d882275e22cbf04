"""A cell from the facets that bound it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..cells import FAMILIES, Family

Row = tuple[int, ...]


def cell_within(facets: Sequence[Row], dimension: int) -> tuple[str, Row] | None:
    """The cell that facets enclose, and its corners in the order of its family.

    Parameters
    ----------
    facets : sequence of tuple of int
        Vertices of edges in the plane, of faces in space, as seen from inside of the cell: as its
        neighbours have them.
    dimension : int

    Returns
    -------
    family : str
    corners : tuple of int
        None where no cell of any family has just these facets.
    """
    widths = Counter(len(facet) for facet in facets)
    n_corners = len({vertex for facet in facets for vertex in facet})
    for family in FAMILIES.values():
        own = {table.shape[1]: len(table) for table in family.facets}
        if family.dimension == dimension and own == widths and family.n_corners == n_corners:
            corners = _around(facets) if dimension == 2 else _on_base(facets, family)
            if corners is not None and _bounds(family, corners) == sorted(map(_plain, facets)):
                return family.name, corners
    return None


def _around(facets: Sequence[Row]) -> Row | None:
    """The vertices of a face in the order that its edges make, the other way round than these."""
    after = {end: start for start, end in facets}
    around = [facets[0][1]]
    while len(around) < len(facets):
        following = after.get(around[-1])
        if following is None:
            return None
        around.append(following)
    return tuple(around)


def _on_base(facets: Sequence[Row], family: Family) -> Row | None:
    """The corners of a solid: those of a facet, then what stands on them.

    All families start with the corners of a base: that of a pyramid is its quad, that of a wedge
    one of the triangles.
    """
    width = max(len(f) for f in facets) if family.name == "pyramid" else min(map(len, facets))
    base = next(facet for facet in facets if len(facet) == width)
    above: dict[int, set[int]] = {vertex: set() for vertex in base}
    for facet in facets:
        for one, other in zip(facet, facet[1:] + facet[:1], strict=True):
            for low, high in ((one, other), (other, one)):
                if low in above and high not in above:
                    above[low].add(high)
    if any(len(tops) != 1 for tops in above.values()):
        return None
    return (*base, *dict.fromkeys(top for tops in above.values() for top in tops))


def _bounds(family: Family, corners: Row) -> list[Row]:
    """The facets of a cell as seen from inside, in a form to compare."""
    if len(corners) != family.n_corners:
        return []
    rows = (row for table in family.facets for row in table.tolist())
    return sorted(_plain([corners[k] for k in reversed(row)]) for row in rows)


def _plain(facet: Sequence[int]) -> Row:
    """A facet from its least vertex on, in its direction."""
    first = facet.index(min(facet))
    return (*facet[first:], *facet[:first]) if len(facet) > 2 else tuple(facet)
