"""What is counted of the entities of a mesh: constraints, degrees, obtuse cells, cases of quads.

The chapter defines most of it for simplices; here cells of every family are counted, by their
corners (see `are_constrained` and `full_degrees` for what the definitions become).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..kernels.gather.edges import LEAST, N_KINDS, RIM, count_degrees, count_ends, list_ends
from ..kernels.shape.angles import angle_sums
from ..kernels.shape.obtuse import count_obtuse
from ..mesh import degrees
from ..mesh.borders import Bordered, of_mesh, of_simplices
from ..mesh.cast import Simplices
from ..mesh.constrained import are_constrained, between_bound, constrained_edges
from ..mesh.facets import CellSet
from ..mesh.model import Array, Mesh
from ..mesh.plane import in_plane, precision_of, with_depth
from ..mesh.quads import QuadCase, corner_areas, quad_cases, signs_of
from ..mesh.sizes import contents

# The kinds of edges of solids, by the angles that they claim: below RIM in number.
_ANGLES = sorted({a for name, row in FAMILIES.items() if row.dimension == 3
                  for a in degrees.edge_angles(name)})  # fmt: skip


@dataclass(frozen=True)
class Degrees:
    """How many entities there are of each degree (Definition 18.7).

    Attributes
    ----------
    counts : dict of int to int
        By degree, ascending; none that no entity has.
    excess : dict of int to int
        By how much the degree is above (over-connected) or below (under-connected) the target.
    """

    counts: dict[int, int] = field(default_factory=dict)
    excess: dict[int, int] = field(default_factory=dict)

    @property
    def total(self) -> int:
        return sum(self.counts.values())

    @property
    def under(self) -> int:
        return sum(n for off, n in self.excess.items() if off < 0)

    @property
    def over(self) -> int:
        return sum(n for off, n in self.excess.items() if off > 0)


@dataclass(frozen=True)
class Census:
    """What is counted of a mesh.

    Interfaces between regions and declared facets are boundary where it constrains, but end no
    mesh: vertices and edges on them are inner ones.

    Attributes
    ----------
    constrained_cells : int
        With all facets in the boundary but one at most (Definition 18.8).
    constrained_edges, constrained_faces : int
        Inside, with all vertices in the boundary (Definition 18.9); of faces, 0 in the plane.
    inner_vertices, boundary_vertices : Degrees
        By the number of edges. The target is 6 for triangles, 4 for quads, 12 for tets, and 6 for
        hexahedra inside, and follows from angles elsewhere: see `degrees.target_degrees`.
    inner_edges : Degrees
        Of solids, by the number of cells around them: 5 or 6 tets, 4 hexahedra, in general as many
        as fit around by their ideal angles, or one more.
    n_simplices : int
        To which the next two refer.
    obtuse : int
        With an angle, or dihedral angle, above 90 degrees (Definition 18.10).
    self_centered : int
        That contain their circumcentre: triangles that are not obtuse, but not all such tets.
    quads : dict of str to int
        By the case of Figure 18.5, for all of the cases; empty without quads. In space each is seen
        from where its mean normal points to, and none is negative.
    """

    constrained_cells: int
    constrained_edges: int
    constrained_faces: int
    inner_vertices: Degrees
    boundary_vertices: Degrees
    inner_edges: Degrees
    n_simplices: int
    obtuse: int
    self_centered: int
    quads: dict[str, int]


def census(part: Simplices | Mesh) -> Census:
    """Count the entities of a mesh, or of the part of it that is optimized.

    Parameters
    ----------
    part : Simplices or Mesh
        Of a mesh the cells of the greatest dimension count, those of higher order by their corners.
        Vertex numbers are in range. Simplices know their neighbours, which takes less time.
    """
    if isinstance(part, Simplices):
        return _counted(part.points, of_simplices(part), {})
    points = with_depth(part.points)
    bordered = of_mesh(part)
    quads = _cases(points, bordered.cell_sets, precision_of(part.points), part.points.shape[1] == 2)
    return _counted(points, bordered, quads)


def _counted(points: Array, of: Bordered, quads: dict[str, int]) -> Census:
    if of.dimension < 2:
        return Census(0, 0, 0, Degrees(), Degrees(), Degrees(), 0, 0, 0, quads)
    n_constrained = sum(
        int(np.count_nonzero(are_constrained(of.n_bound[group.numbers], group.family)))
        for group in of.cell_sets
    )
    keys, _ = between_bound(of.cell_sets, of.bound)
    n_edges = len(constrained_edges(keys, of.boundary, len(points)))
    del keys
    simplices = [group.cells for group in of.cell_sets if FAMILIES[group.family].is_simplex]
    counts = np.zeros(2, dtype=np.int64)
    for cells in simplices:
        count_obtuse(points, cells, counts)
    return Census(
        n_constrained,
        n_edges,
        of.n_constrained_facets if of.dimension == 3 else 0,
        *_degrees(points, of),
        sum(map(len, simplices)),
        int(counts[0]),
        int(counts[1]),
        quads,
    )


def _degrees(points: Array, of: Bordered) -> tuple[Degrees, Degrees, Degrees]:
    """Of the inner vertices, those of the boundary, and the inner edges."""
    n = len(points)
    degree, inner_edges = _edges_of(of, n)
    rim = np.zeros(n, dtype=np.int64)
    for facets in of.outer:
        rim += np.bincount(facets.ravel(), minlength=n)
    alike = {group.family for group in of.cell_sets} == {SIMPLICES[of.dimension]}
    full = degrees.FULL[of.dimension] if alike else degrees.full_degrees(of.cell_sets, n)
    target = degrees.target_degrees(of.dimension, _angles(points, of.cell_sets, rim > 0), rim, full)
    excess = degree - target.astype(np.int64)
    inner, outer = (degree > 0) & (rim == 0), rim > 0
    return (
        Degrees(_tally(degree[inner]), _tally(excess[inner])),
        Degrees(_tally(degree[outer]), _tally(excess[outer])),
        inner_edges,
    )


def _edges_of(of: Bordered, n_points: int) -> tuple[Array, Degrees]:
    """The degree of each vertex, (np,) int64, and those of the inner edges of solids."""
    tables = []
    for group in of.cell_sets:
        edges = FAMILIES[group.family].edges
        kinds = np.zeros(len(edges), dtype=np.int64)
        if of.dimension == 3:
            kinds[:] = np.searchsorted(_ANGLES, degrees.edge_angles(group.family))
        tables.append((group.cells, edges, kinds))
    if of.dimension == 3:
        for facets in of.outer:
            around = np.arange(facets.shape[1])
            edges = np.stack([around, np.roll(around, -1)], axis=1)
            tables.append((facets, edges, np.full(len(edges), RIM)))
    start = np.zeros(n_points + 2, dtype=np.int64)
    for cells, edges, _ in tables:
        count_ends(cells, edges, start)
    most = int(start.max())
    np.cumsum(start, out=start)
    ends = np.empty(int(start[-1]), dtype=np.int64)
    for cells, edges, kinds in tables:
        list_ends(cells, edges, kinds, start, ends)
    angles = np.zeros(N_KINDS)
    if of.dimension == 3:
        angles[: len(_ANGLES)] = _ANGLES
    degree = np.zeros(n_points, dtype=np.int64)
    counts, excess = np.zeros(most + 1, np.int64), np.zeros(most + LEAST, np.int64)
    place, around, claimed = np.full(n_points, -1), np.empty(most, np.int64), np.empty(most)
    count_degrees(start, ends, angles, place, around, claimed, degree, counts, excess)
    return degree, Degrees(_by_value(counts, 0), _by_value(excess, -LEAST))


def _angles(points: Array, cell_sets: list[CellSet], wanted: Array) -> Array:
    """Angle that the cells fill around some vertices, by a mask; others have less than is there."""
    angle = np.zeros(len(points))
    for group in cell_sets:
        cells = group.cells[wanted[group.cells].any(axis=1)]
        for simplex in FAMILIES[group.family].partitions[0]:
            angle_sums(points, np.ascontiguousarray(cells[:, simplex]), angle)
    return angle


def _tally(values: Array) -> dict[int, int]:
    """How often each integer occurs, ascending."""
    if not len(values):
        return {}
    least = int(values.min())
    return _by_value(np.bincount(values - least), least)


def _by_value(counts: Array, first: int) -> dict[int, int]:
    """Counts of the integers from a first one on, without those that do not occur."""
    return {int(first + k): int(counts[k]) for k in np.flatnonzero(counts)}


def _cases(
    points: Array, cell_sets: list[CellSet], precision: float, in_two: bool
) -> dict[str, int]:
    """How many quads there are of each case of Figure 18.5, by its name.

    A plane of x and y is seen from above, another one from where most of the area is positive.
    """
    quads = [group.cells for group in cell_sets if group.family == "quad"]
    if not quads:
        return {}
    noise = 4 * precision * np.abs(points).max(axis=1)
    sign = 1
    if in_two:
        points = points[:, :2]
    elif plane := in_plane(points, noise, cell_sets, precision):
        points, noise = plane.points, plane.noise
        whole = sum(float(contents(points, g.cells, g.family).sum()) for g in cell_sets)
        sign = -1 if whole < 0 and plane.normal != 2 else 1
    area, flat = corner_areas(points, noise, np.concatenate(quads), "quad")
    counts = np.bincount(quad_cases(*signs_of(sign * area, flat)), minlength=len(QuadCase))
    return {case.name.lower().replace("_", "-"): int(counts[case]) for case in QuadCase}
