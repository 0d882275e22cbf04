"""Where the Jacobian of cells is not positive: proven by bounds, for M105.

The Jacobian of an isoparametric cell, the determinant of the derivatives of its coordinates by
those of the reference cell, is a polynomial. Its Bernstein coefficients bound it from below; where
they leave a doubt the cell is divided until it is decided.

- Pyramids: by (a, b, w) of `elements` the determinant has the factor w squared, which the change
  from (x, y, z) takes away: what is left is a polynomial, and it is that which is bounded, up to
  the top, where it still depends on the direction.
- Surfaces in space: instead of the determinant, the part of the normal along the mean normal of
  the cell. A cell that is curved by 90 degrees or more to one side of that cannot be told from one
  that is folded, and is named.
- Triangles and tetrahedra of first order have one Jacobian, that of quads in the plane is linear,
  that of pyramids of first order is bilinear over the base (the parts with three derivatives of
  the base cancel): their corners decide, and M101, M102 and M104 look at these.

Sources: A. Johnen, J.-F. Remacle, C. Geuzaine, "Geometrical validity of curvilinear finite
elements", J. Comput. Phys. 233 (2013); A. Johnen, C. Geuzaine, "Geometrical validity of
curvilinear pyramidal finite elements", J. Comput. Phys. 299 (2015); A. Johnen, J.-C. Weill,
J.-F. Remacle, "Robust and efficient validation of the linear hexahedral element" (2017).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from ..cells import FAMILIES
from ..elements import ELEMENTS, Element, element_of
from ..mesh.model import Array, Mesh, top_blocks
from ..mesh.sizes import norms, triple
from .bernstein import NOT_ABOVE, UNDECIDED, Basis, basis
from .study import Study

# A Jacobian that is no more than this part of its greatest size in the cell is not positive.
POSITIVE = 1e-10

AT_CORNER, INSIDE, UNPROVEN = range(3)
KINDS = (
    "the Jacobian is as low as {:.2g} of its greatest size at a corner of the cell",
    "the Jacobian is as low as {:.2g} of its greatest size inside the cell",
    "the Jacobian is as low as {:.2g} of its greatest size inside the cell: not proven positive",
)

_CHUNK = 1 << 15  # points of all cells at which Jacobians are taken at a time
_CORNERS_DECIDE = ("triangle", "tetra", "pyramid")


class Doubtful(NamedTuple):
    """Cells whose Jacobian is not positive, or not proven to be.

    Attributes
    ----------
    numbers : (n,) int64
        Of the cells, in order.
    kinds : (n,) int64
        `AT_CORNER`, `INSIDE`, or `UNPROVEN`.
    ratio : (n,) float64
        The least value that was seen, at a corner or wherever, as a part of the greatest size.
    """

    numbers: Array
    kinds: Array
    ratio: Array


class Table(NamedTuple):
    """What is known of the Jacobian of an element before any cell is seen."""

    basis: Basis
    slopes: Array  # (k, d * m): derivatives of the shape functions at the points of the basis
    reach: float  # how far a derivative moves, at most, when all nodes do by 1


def not_positive(study: Study, explained: Array) -> Doubtful:
    """The cells whose Jacobian is not positive everywhere.

    The sign of a Jacobian is taken from the corners of its cell: which way they run is a matter
    of other rules. Where the rounding of the coordinates alone may have made a Jacobian negative,
    as in very thin cells, it counts as positive.

    Parameters
    ----------
    explained : (n_cells,) bool
        Cells with corners that are found wrong already: they are left out.
    """
    parts = [Doubtful(*(np.empty(0, kind) for kind in (np.int64, np.int64, np.float64)))]
    looked_at = [
        (element, np.asarray(block.cells), first)
        for block, first in zip(study.mesh.blocks, study.offsets, strict=False)
        if (element := element_of(block.type, np.shape(block.cells)[-1]))
        and not _is_settled(element, study)
    ]
    sound = _sound(study, ~explained) if looked_at else explained
    for element, cells, first in looked_at:
        rows = np.flatnonzero(sound[first : first + len(cells)])
        if not study.finite.all():
            rows = rows[study.finite[cells[rows]].all(axis=1)]
        parts.extend(_judged(study, element, cells[rows], rows + first))
    return Doubtful(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _sound(study: Study, among: Array) -> Array:
    """Mask of the sound cells of the top dimension among some."""
    sound = np.zeros(study.n_cells, dtype=bool)
    for group in study.cell_sets:
        sound[group.numbers] = True
    return sound & among


def not_looked_at(mesh: Mesh) -> dict[str, int]:
    """How many cells of the top dimension there are of types whose Jacobian is not known."""
    counts: dict[str, int] = {}
    for block in top_blocks(mesh):
        if element_of(block.type, np.shape(block.cells)[-1]) is None:
            counts[block.type] = counts.get(block.type, 0) + len(block.cells)
    return counts if mesh.dimension() > 1 else {}


def _is_settled(element: Element, study: Study) -> bool:
    """Whether the corners have decided already."""
    return element.name in _CORNERS_DECIDE or (element.name == "quad" and study.plane is not None)


def _judged(study: Study, element: Element, cells: Array, numbers: Array) -> Iterator[Doubtful]:
    """Those of some cells of one type that are not positive, a part of the cells at a time."""
    points, noise = (study.points, study.noise) if study.plane is None else study.plane[:2]
    table = table_of(element.name)
    step = max(1, _CHUNK // len(table.basis.points))
    for start in range(0, len(cells), step):
        part = cells[start : start + step]
        places = (points[part] - points[part[:, :1]]).transpose(0, 2, 1)
        found = _judge(table, element, places, noise[part].max(axis=1))
        yield found._replace(numbers=numbers[start + found.numbers])


def _judge(table: Table, element: Element, places: Array, noise: Array) -> Doubtful:
    """Look at cells by the places of their nodes, (n, c, k): their rows in place of numbers.

    Most cells are positive by their coefficients, and cost no more than these.
    """
    values = jacobians(table, element, places)
    coefficients = table.basis.coefficients(values)
    greatest = np.abs(values).max(axis=1)
    rows = np.flatnonzero(~(coefficients.min(axis=1) > POSITIVE * greatest))
    values, greatest = values[rows], greatest[rows]
    bound = POSITIVE * greatest - _rounding(table, places[rows], noise[rows])
    verdict, least = table.basis.judge(coefficients[rows], bound)
    least = np.minimum(least, values.min(axis=1))
    verdict[least <= bound] = NOT_ABOVE
    in_corners = values[:, table.basis.corners].min(axis=1)
    at_corner = in_corners <= bound
    kinds = np.where(at_corner, AT_CORNER, np.where(verdict == UNDECIDED, UNPROVEN, INSIDE))
    wrong = np.isin(verdict, [NOT_ABOVE, UNDECIDED])
    ratio = np.where(at_corner, in_corners, least) / np.where(greatest > 0.0, greatest, 1.0)
    return Doubtful(rows[wrong], kinds[wrong], ratio[wrong])


def jacobians(table: Table, element: Element, places: Array) -> Array:
    """Jacobians at the points of the basis, (n, m), positive where cells run as their corners do.

    Parameters
    ----------
    places : (n, c, k) float64
        Coordinates of the nodes, c of them: 2 in the plane.
    """
    columns = _columns(table, places)
    if len(columns) == 3:
        return triple(*columns) * _signs(element, places)
    a, b = columns
    if places.shape[1] == 2:
        return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * _signs(element, places)
    normals = np.cross(a, b, axis=1)
    mean = normals @ table.basis.weights
    length = norms(mean)[:, None]
    return np.einsum("ncm,nc->nm", normals, mean / np.where(length > 0.0, length, 1.0))


def _signs(element: Element, places: Array) -> Array:
    """1 where the first corner of a cell is positive, -1 where it is negative, (n, 1)."""
    apex, *others = FAMILIES[element.family].corners[0]
    return np.sign(np.linalg.det(places[..., others] - places[..., [apex]]))[:, None]


def _columns(table: Table, places: Array) -> list[Array]:
    """Derivatives of the coordinates by each of the reference cell, (n, c, m) each."""
    m = len(table.basis.points)
    # A small product for each cell, as in `Basis.coefficients`.
    slopes = places @ table.slopes
    return [slopes[..., start : start + m] for start in range(0, slopes.shape[2], m)]


def _rounding(table: Table, places: Array, noise: Array) -> Array:
    """How much the rounding of the coordinates may add to the Jacobian of each cell, (n,).

    To move three coordinates by half a unit in the last place moves a point by less than a
    quarter of `Study.noise`.
    """
    lengths = [np.sqrt(np.sum(column**2, axis=1)) for column in _columns(table, places)]
    if len(lengths) == 2:
        sides = lengths[0] + lengths[1]
    else:
        a, b, c = lengths
        sides = a * b + b * c + c * a
    return table.reach * noise / 4 * sides.max(axis=1)


@cache
def table_of(name: str) -> Table:
    """The row of a type of `elements.ELEMENTS`, made once."""
    element = ELEMENTS[name]
    found = basis(element.factors, _degrees(element))
    slopes = element.slopes(found.points)
    columns = np.concatenate(slopes).T
    return Table(found, columns, float(np.abs(columns).sum(axis=0).max()))


def _degrees(element: Element) -> tuple[int, ...]:
    """Degree of the Jacobian over each factor of the reference cell: that of a product of
    derivatives, one by each coordinate."""
    degrees, start = [], 0
    for width in element.factors:
        own = slice(start, start + width)
        degrees.append(
            sum(
                int(element.slope_powers(axis)[element.powers[:, axis] > 0, own].sum(axis=1).max())
                for axis in range(element.powers.shape[1])
            )
        )
        start += width
    return tuple(degrees)
