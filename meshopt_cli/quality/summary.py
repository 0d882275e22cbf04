"""How good a mesh is: the table of measures, the rows of Table 18.3, `target`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..cells import SIMPLICES
from ..errors import ConfigError
from ..kernels.search.target import best_over_face, estimate_targets
from ..kernels.shape import simplex
from ..kernels.shape.angles import REGULAR_ANGLE_3, angle_range
from ..kernels.types import Judge
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.sizes import angles_between, area_vectors, contents

Array = np.ndarray


@dataclass(frozen=True)
class Measure:
    """One quality measure: Q is 1 for the regular cell and grows as the cell degrades.

    Attributes
    ----------
    code : int
        What the kernels call it.
    equations : (str, str)
        Where the chapter defines it for triangles and for tetrahedra.
    formula : str
    drives : bool
        Whether it tells all bad shapes from good ones, so that it can steer an optimization.
    """

    name: str
    code: int
    equations: tuple[str, str]
    formula: str
    drives: bool = True

    @property
    def judge(self) -> Judge:
        """What the kernels judge by, where this measure alone counts."""
        return Judge(self.code, 0.0)


MEASURES: dict[str, Measure] = {
    m.name: m
    for m in (
        Measure("aspect-ratio", simplex.ASPECT_RATIO, ("18.6", "18.7"), "h_max S / V"),
        Measure("volume-length", simplex.VOLUME_LENGTH, ("18.8", "18.9"), "h_s^3 / V"),
        Measure("radius-ratio", simplex.RADIUS_RATIO, ("18.2.2", "18.2.2"), "r / rho"),
        Measure("mean-edge", simplex.MEAN_EDGE, ("18.2.2", "18.2.2"), "h_mean^3 / V"),
        Measure("volume-area", simplex.VOLUME_AREA, ("18.2.2", "18.2.2"), "(sum S_i^2)^3 / V^4"),
        Measure("angle-min", simplex.ANGLE_MIN, ("Exercise 18.3", "Definition 18.1"),
                "regular angle / least angle"),
        Measure("angle-max", simplex.ANGLE_MAX, ("Exercise 18.3", "Definition 18.1"),
                "(pi - regular angle) / (pi - greatest angle)"),
        Measure("solid-angle-min", simplex.SOLID_ANGLE_MIN, ("Exercise 18.3", "Definition 18.2"),
                "regular solid angle / least solid angle"),
        Measure("radius-edge", simplex.RADIUS_EDGE, ("18.2.2", "18.2.2"), "r / h_min",
                drives=False),
        Measure("edge-ratio", simplex.EDGE_RATIO, ("18.2.2", "18.2.2"), "h_max / h_min",
                drives=False),
    )
}  # fmt: skip

DEFAULT_MEASURE = "aspect-ratio"

# Shapes of boundary faces that are searched for the angles they force, among so many times as
# many of the thinnest faces.
N_SHAPES = 20
FACES_PER_SHAPE = 50

# Upper ends of the ranks of Table 18.3; the last one has none.
RANKS = (1.0, 2.0, 3.0, 10.0, math.inf)


def measure_named(name: str) -> Measure:
    """The measure of this name.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    if name not in MEASURES:
        raise ConfigError(f"no measure {name!r}: choose one of {', '.join(MEASURES)}")
    return MEASURES[name]


@dataclass(frozen=True)
class Summary:
    """The figures of one mesh, as Table 18.3 has them and a few more.

    Q of a flat or inverted cell is infinite; such cells count in `n_invalid` and in the last
    rank, and are left out of the mean.
    """

    measure: str
    dimension: int
    n_cells: int
    n_points: int
    counts: tuple[int, ...]  # cells in each rank
    n_invalid: int
    worst: float
    mean: float
    best: float
    target: float
    angle_min: float  # degrees; dihedral angles in 3-D
    angle_max: float
    worst_by_measure: dict[str, float] = field(default_factory=dict)
    forced: tuple[float, float] | None = None  # see `forced_angles`; None where not asked for

    @property
    def equation(self) -> str:
        """Where the chapter defines the measure in this dimension."""
        return MEASURES[self.measure].equations[self.dimension - 2]

    @property
    def percent(self) -> tuple[float, ...]:
        return tuple(100.0 * c / max(self.n_cells, 1) for c in self.counts)


def cell_quality(points: Array, cells: Array, measure: Measure) -> Array:
    """q = 1/Q of each cell, (ne,); points (np, 3) with z = 0 for triangles."""
    q = np.empty(len(cells))
    simplex.measure_cells(measure.judge, points, cells, q)
    return q


def as_degradation(q: Array) -> Array:
    """Q = 1/q, infinite for flat and inverted cells (Remark 18.3)."""
    result = np.full(len(q), math.inf)
    np.divide(1.0, q, out=result, where=q > 0.0)
    return result


def histogram(degradation: Array) -> tuple[int, ...]:
    """Number of cells in each rank of Table 18.3; the upper end belongs to a rank."""
    inner = np.array(RANKS[1:-1])
    rank = np.searchsorted(inner, degradation, side="left")
    return tuple(int(n) for n in np.bincount(rank, minlength=len(inner) + 1))


def target(simplices: Simplices, measure: Measure, most: int | None = None) -> float:
    """Q of the best cell that the worst boundary facet allows (Table 18.3).

    Over an edge of the plane this is the equilateral triangle. Over a triangle of space the
    apex is searched for: first above the centroid for all faces, which gives a bound, then
    everywhere for the faces whose bound is worst, until no other can be worse.

    Parameters
    ----------
    most : int, optional
        Search for no more shapes of faces than this, among the thinnest: what they force holds,
        and others may force more.
    """
    if simplices.dimension == 2:
        return 1.0
    # Seen from inside, so that an apex on the side of the cell is above.
    faces = simplices.skin
    if most is not None and len(faces) > FACES_PER_SHAPE * most:
        n = FACES_PER_SHAPE * most
        faces = faces[np.argpartition(_thinness(simplices.points[faces]), n)[:n]]
    bound = np.empty(len(faces))
    estimate_targets(measure.judge, simplices.points, faces, bound)
    worst = math.inf
    # Regular grids have a few shapes of faces, many times over: each is searched once.
    _, shape, _ = adjacency.distinct_rows(_shapes(simplices.points[faces]))
    seen: set[int] = set()
    for row in np.argsort(bound, kind="stable"):
        if bound[row] >= worst or len(seen) == most:
            break
        if int(shape[row]) not in seen:
            seen.add(int(shape[row]))
            i, j, k = (int(v) for v in faces[row])
            worst = min(worst, best_over_face(measure.judge, simplices.points, i, j, k))
    return 1.0 / worst if 0.0 < worst < math.inf else math.inf


def forced_angles(simplices: Simplices) -> tuple[float, float]:
    """The least dihedral angle that the boundary lets be exceeded nowhere, and the greatest.

    They follow from the worst boundary faces, as `target` does, and from the sharpest edges of
    the boundary and of interfaces.

    Returns
    -------
    least, greatest : float
        Degrees: no mesh has all angles above the one, nor all below the other. 0 and 180 set
        no limit.
    """
    if simplices.dimension == 2:
        return 60.0, 60.0
    regular = math.degrees(REGULAR_ANGLE_3)
    least = regular / target(simplices, MEASURES["angle-min"], N_SHAPES)
    greatest = 180.0 - (180.0 - regular) / target(simplices, MEASURES["angle-max"], N_SHAPES)
    return min(least, _forced_by_edges(simplices)), greatest


def _forced_by_edges(simplices: Simplices) -> float:
    """Least angle in degrees that the edges where two facets of a region meet let be exceeded.

    An edge has one tetrahedron, the one that both facets span, or several, of which one has at
    most half the angle between the facets.
    """
    points, skin = simplices.points, simplices.skin
    region = simplices.region[np.nonzero(simplices.neighbours < 0)[0]]
    ends = adjacency.edges_of_triangles(skin)
    keys = adjacency.row_keys(ends, len(points))
    _, edge, n_facets = adjacency.distinct_rows(np.stack([keys, np.repeat(region, 3)], axis=1))
    pairs = np.argsort(edge, kind="stable")
    pairs = pairs[n_facets[edge[pairs]] == 2].reshape(-1, 2)
    # Vertices of the tetrahedron that the facets span, seen from inside one of them.
    tets = np.column_stack([ends[pairs[:, 0]], np.roll(skin, 1, axis=1).ravel()[pairs]])
    is_convex = contents(points, tets, SIMPLICES[3]) > 0.0
    if not is_convex.any():
        return 180.0
    tets = tets[is_convex]
    one, other = (area_vectors(points, tets[:, [0, 1, apex]]) for apex in (2, 3))
    between = np.degrees(angles_between(one, other))
    alone = cell_quality(points, tets, MEASURES["angle-min"]) * math.degrees(REGULAR_ANGLE_3)
    return float(np.maximum(alone, 0.5 * between).min())


def _thinness(triangles: Array) -> Array:
    """Area over the square of the longest side, (n,); triangles are (n, 3, 3)."""
    sides = triangles - np.roll(triangles, 1, axis=1)
    square = np.einsum("ijk,ijk->ij", sides, sides).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.divide(area, square, out=np.zeros(len(area)), where=square > 0.0)


def _shapes(triangles: Array) -> Array:
    """Two numbers that are equal for similar triangles, (n, 2); triangles are (n, 3, 3)."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    sides.sort(axis=1)
    return np.round(sides[:, :2] / sides[:, 2:], 9)


def summarize(
    simplices: Simplices,
    measure: Measure,
    others: tuple[Measure, ...] = (),
    best_target: float | None = None,
) -> Summary:
    """All figures of a mesh.

    Parameters
    ----------
    others : tuple of Measure
        Measures whose worst Q is wanted as well.
    best_target : float, optional
        The target, when it is known already: it belongs to the boundary, which stays.
    """
    q = cell_quality(simplices.points, simplices.cells, measure)
    degradation = as_degradation(q)
    valid = degradation[np.isfinite(degradation)]
    least, greatest = angle_range(simplices.points, simplices.cells)
    return Summary(
        measure=measure.name,
        dimension=simplices.dimension,
        n_cells=len(simplices.cells),
        n_points=int(np.count_nonzero(adjacency.is_used(simplices.cells, len(simplices.points)))),
        counts=histogram(degradation),
        n_invalid=len(q) - len(valid),
        worst=float(degradation.max(initial=1.0)),
        mean=float(valid.mean()) if len(valid) else math.inf,
        best=float(degradation.min(initial=math.inf)),
        target=target(simplices, measure) if best_target is None else best_target,
        angle_min=math.degrees(least),
        angle_max=math.degrees(greatest),
        worst_by_measure={
            m.name: float(
                as_degradation(cell_quality(simplices.points, simplices.cells, m)).max(initial=1.0)
            )
            for m in others
        },
    )
