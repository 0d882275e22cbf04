"""What a run may not change of a mesh, told by coordinates alone and without the package's code.

The formulas of cells are those of the benchmarks' judge. Vertices are compared by their places, so
that no numbering and no bookkeeping of the package is believed.
"""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np
import pytest

import judge

MAIN = {2: "triangle", 3: "tetra"}
TAG = "gmsh:physical"
# What volumes and areas may differ by, as a part of the whole: rounding.
ROUNDING = 1e-9
# How near to a plane a facet is taken to lie in it, as a part of the extent of the mesh.
NEAR = 1e-4


class Domain:
    """A mesh of simplices with a tag for each cell of any dimension, seen by itself.

    Parameters
    ----------
    of : Mesh
    axes : (d, 3) array
        Directions of the coordinates to measure in: in space any three that make a right-handed
        frame, of a planar mesh two in its plane.
    """

    def __init__(self, of, axes):
        self.dimension = len(axes)
        self.points = np.zeros((len(of.points), 3))
        self.points[:, : of.points.shape[1]] = of.points
        self.places = [tuple(p) for p in self.points.tolist()]
        cells, tags = self._cells(of, MAIN[self.dimension])
        self.part = judge.Part(self.points @ np.asarray(axes, float).T, cells, tags)
        self.walls = judge.walls(self.part)
        self.lower = {
            kind: self._cells(of, kind)
            for kind in ("vertex", "line", "triangle")
            if kind != MAIN[self.dimension]
        }

    @staticmethod
    def _cells(of, kind):
        blocks = [b for b in of.blocks if b.type == kind and len(b.cells)]
        if not blocks:
            return np.empty((0, {"vertex": 1, "line": 2, "triangle": 3}[kind]), int), np.empty(0)
        tags = [b.data[TAG].astype(int) for b in blocks]
        return np.concatenate([b.cells for b in blocks]), np.concatenate(tags)

    def at(self, row):
        """The places of some vertices, in no order."""
        return frozenset(self.places[v] for v in row)

    @property
    def extent(self):
        return float(np.ptp(self.points, axis=0).max())

    def volumes(self):
        """Volume by region."""
        sums = defaultdict(float)
        for tag, volume in zip(self.part.region, judge.volumes(self.part), strict=True):
            sums[int(tag)] += volume
        return dict(sums)

    def borders(self):
        """Facets of the boundary and between regions, with the regions beside them."""
        return Counter(
            (self.at(row), int(one), int(other))
            for row, one, other in zip(*self.walls, strict=True)
        )

    def interfaces(self):
        return Counter({key: n for key, n in self.borders().items() if key[2] > 0})

    def outer(self):
        """Facets of the outer boundary: those without a region beyond."""
        facets, inside, outside = self.walls
        return facets[(inside == 0) | (outside == 0)]

    def rows(self, *kinds):
        """Cells of lower dimension of some kinds, each with its tag."""
        for kind in kinds:
            for row, tag in zip(*self.lower.get(kind, ((), ())), strict=True):
                yield row, int(tag)

    def declared(self, *kinds):
        """What the file declares of some kinds, with tags."""
        return Counter((self.at(row), tag) for row, tag in self.rows(*kinds))

    def planes(self):
        """The planes, in the plane the lines, that the outer boundary lies in: normal, offset."""
        found = []
        corners = self.part.points[self.outer()]
        for facet in sorted(corners, key=size, reverse=True):
            if not any(off(facet, plane) < NEAR * self.extent for plane in found):
                across = normal(facet)
                found.append((across, float(facet[0] @ across)))
        return found

    def sides(self, planes):
        """Extent of the outer boundary by plane and tag, and how far it is off those planes.

        Returns
        -------
        sides : dict of (plane, tag) to float
            A facet that the file does not declare has the tag 0.
        of_vertex : dict of int to set
            The sides that have a vertex.
        deviation : float
        """
        tags = {self.at(row): tag for row, tag in self.rows("line", "triangle")}
        sides, of_vertex, deviation = defaultdict(float), defaultdict(set), 0.0
        for row in self.outer():
            facet = self.part.points[row]
            distances = [off(facet, plane) for plane in planes]
            side = int(np.argmin(distances)), tags.get(self.at(row), 0)
            deviation = max(deviation, min(distances))
            sides[side] += size(facet)
            for vertex in row.tolist():
                of_vertex[vertex].add(side)
        return dict(sides), of_vertex, deviation


def off(facet, plane):
    """How far a facet is off a plane at most; infinite when it looks the other way."""
    across, offset = plane
    away = size(facet) > 0 and normal(facet) @ across < 0
    return np.inf if away else float(np.abs(facet @ across - offset).max())


def size(corners):
    """Length or area of a facet."""
    if len(corners) == 2:
        return float(np.linalg.norm(corners[1] - corners[0]))
    return float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2)


def normal(corners):
    """Unit normal of a facet, outwards."""
    if len(corners) == 2:
        along = corners[1] - corners[0]
        across = np.array([along[1], -along[0]])
    else:
        across = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return across / np.linalg.norm(across)


# Every measure that can steer, as q up to a factor: what 18.2.2 and its exercises say.


def _contents(part):
    """Lengths of edges, of triangles once more as facets, and areas of facets, by cell."""
    corners = part.points[part.cells]
    width = corners.shape[1]
    pairs = [(i, j) for i in range(width) for j in range(i)]
    lengths = np.stack([np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i, j in pairs], 1)
    if width == 3:
        return lengths, lengths
    triples = [[k for k in range(4) if k != left] for left in range(4)]
    sides = [corners[:, t[1:]] - corners[:, t[:1]] for t in triples]
    areas = [np.linalg.norm(np.cross(s[:, 0], s[:, 1]), axis=1) / 2 for s in sides]
    return lengths, np.stack(areas, axis=1)


def _products(part):
    """Product of the lengths of the edges at each corner."""
    corners = part.points[part.cells]
    apart = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3)
    return np.where(np.eye(corners.shape[1], dtype=bool), 1.0, apart).prod(axis=2)


def _circumradii(part):
    corners = part.points[part.cells]
    edges = corners[:, 1:] - corners[:, :1]
    squares = (edges**2).sum(axis=2)[..., None]
    return np.linalg.norm(np.linalg.solve(2 * edges, squares)[..., 0], axis=1)


def _solid_angles(part):
    """Least angle at a corner, in degrees: of tetrahedra three dihedral angles less 180."""
    angles = judge.angles(part)
    if part.dimension == 2:
        return angles.min(axis=1)
    faces = [(i, j) for i in range(4) for j in range(i + 1, 4)]
    at = [sum(angles[:, n] for n, f in enumerate(faces) if k not in f) for k in range(4)]
    return np.min(at, axis=0) - 180.0


def worst_q(part, measure):
    """The least q of a mesh of positive cells by a measure, up to a factor."""
    volume, (lengths, facets) = judge.volumes(part), _contents(part)
    d = part.dimension
    return {
        "aspect-ratio": lambda: 1 / judge.aspect_ratios(part),
        "volume-length": lambda: volume / (lengths**2).sum(axis=1) ** (d / 2),
        "radius-ratio": lambda: volume / facets.sum(axis=1) / _circumradii(part),
        "volume-area": lambda: volume ** (2 * d - 2) / (facets**2).sum(axis=1) ** d,
        "mean-edge": lambda: volume / lengths.mean(axis=1) ** d,
        "scaled-jacobian": lambda: volume / _products(part).max(axis=1),
        "angle-min": lambda: judge.angles(part).min(axis=1),
        "angle-max": lambda: 180.0 - judge.angles(part).max(axis=1),
        "solid-angle-min": lambda: _solid_angles(part),
    }[measure]().min()


# What must be so ---------------------------------------------------------------------------


def assert_valid(after):
    """All cells are positive, and no facet has a third one."""
    assert (judge.volumes(after.part) > 0).all(), "a cell is flat or inverted"
    local = judge.FACETS[after.dimension]
    facets = Counter(after.at(cell[list(f)]) for cell in after.part.cells for f in local)
    assert max(facets.values()) <= 2, "a facet has three cells"


def assert_same_domain(before, after):
    """The boundary, the interfaces, the regions and what is declared are what they were."""
    assert after.borders() == before.borders(), "the boundary or an interface changed"
    everything = ("vertex", "line", "triangle")
    assert after.declared(*everything) == before.declared(*everything), "declared cells changed"
    assert_same_volumes(before, after)
    assert_declared_are_there(after)


def assert_same_volumes(before, after, tolerance=ROUNDING):
    old, new = before.volumes(), after.volumes()
    assert old.keys() == new.keys(), "a region came or went"
    whole = sum(abs(v) for v in old.values())
    for tag, volume in old.items():
        assert abs(new[tag] - volume) <= tolerance * whole, "the volume of a region changed"


def assert_declared_are_there(after):
    """Declared facets and edges are those of cells."""
    cells = [set(cell.tolist()) for cell in after.part.cells]
    of_vertex = defaultdict(list)
    for cell in cells:
        for vertex in cell:
            of_vertex[vertex].append(cell)
    for row, _ in after.rows("vertex", "line", "triangle"):
        assert any(set(row.tolist()) <= cell for cell in of_vertex[int(row[0])]), "hangs in the air"


def assert_same_shape(before, after, tolerance):
    """The boundary may have slid: its planes, corners, sides and their tags are what they were.

    Parameters
    ----------
    tolerance : float
        How far vertices may be off their planes, as a part of the extent of the mesh.
    """
    planes = before.planes()
    old, of_vertex, _ = before.sides(planes)
    new, _, deviation = after.sides(planes)
    assert deviation <= tolerance * before.extent, "the boundary left its planes"
    assert old.keys() == new.keys(), "a side came or went, or has other tags"
    for side, area in old.items():
        assert abs(new[side] - area) <= tolerance * sum(old.values()), (
            "the extent of a side changed"
        )
    assert after.interfaces() == before.interfaces(), "an interface changed"
    assert_same_volumes(before, after, tolerance)
    there = set(after.places)
    for vertex, sides in of_vertex.items():
        assert len(sides) < before.dimension or before.places[vertex] in there, "a corner moved"
    assert after.declared("vertex") == before.declared("vertex"), "declared vertices changed"
    assert inner(after) == inner(before), "declared facets inside changed"
    if before.dimension == 3:
        assert lengths_by_tag(after) == pytest.approx(lengths_by_tag(before)), "declared lines"
    assert_declared_are_there(after)


def inner(of):
    """Declared facets that are not on the outer boundary."""
    outer = {of.at(row) for row in of.outer()}
    declared = of.declared("line" if of.dimension == 2 else "triangle")
    return {key: n for key, n in declared.items() if key[0] not in outer}


def lengths_by_tag(of):
    """Length of the declared lines of a mesh of tetrahedra, by tag."""
    sums = defaultdict(float)
    for row, tag in of.rows("line"):
        sums[tag] += size(of.part.points[row])
    return dict(sums)
