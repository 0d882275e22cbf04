"""What a mesh and a user tell vertices: arrays on points, and what to keep off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..cells import FAMILIES
from ..errors import BadMeshError, ConfigError
from ..kernels.guide import LINE, PLANE, SPACE, STAYS
from ..mesh.borders import of_mesh
from ..mesh.model import Block, Mesh, top_blocks
from ..mesh.plane import Frame, with_depth
from ..mesh.tags import ALONG, LIMIT, PHYSICAL, TOLD, WITHIN, tags_of
from . import grammar
from .grammar import KeepOff
from .model import Constraints, meet, noise_of
from .near import HalfSpaces, around_home, nearest, off_faces, pairs_within

Array = np.ndarray

# A direction in a mesh of the plane whose part in the plane is shorter has none there.
SHORT = 1e-6
REACH = 2.0  # vertices so many of their longest edges away from what they keep off are told so


@dataclass(frozen=True)
class Place:
    """What is worked on, as far as it matters here.

    Attributes
    ----------
    points : (np, 3) float64
        In the coordinates of the work.
    edges : (n, 2) int64
        The edges of the cells, some of them more than once.
    frame : Frame or None
        Where the plane of a planar mesh lies in space.
    mirrored : bool
        Whether z has the other sign than in the file.
    single : bool
        Whether the file stores coordinates in single precision.
    """

    points: Array
    edges: Array
    frame: Frame | None
    mirrored: bool
    single: bool

    @property
    def dimension(self) -> int:
        return 3 if self.frame is None else 2

    @property
    def axes(self) -> Array:
        """What vectors of the file are multiplied by, (3, 3)."""
        if self.frame is not None:
            return self.frame.axes
        return np.diag([1.0, 1.0, -1.0 if self.mirrored else 1.0])

    def longest(self) -> Array:
        """The longest edge at each vertex, (np,)."""
        ends = self.points[self.edges]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        longest = np.zeros(len(self.points))
        np.maximum.at(longest, self.edges.ravel(), np.repeat(length, 2))
        return longest

    def middle(self, points: Array) -> Array:
        """The mean of the neighbours of each vertex, of some points (np, 3)."""
        one, other = np.concatenate([self.edges, self.edges[:, ::-1]]).T
        count = np.bincount(one, minlength=len(points))
        total = [np.bincount(one, points[other, k], len(points)) for k in range(3)]
        return np.stack(total, axis=1) / np.maximum(count, 1)[:, None]


def edges_of(cell_sets: Sequence[tuple[str, Array]]) -> Array:
    """The edges of cells, by their family, (n, 2); those of several cells so many times."""
    found = [cells[:, FAMILIES[name].edges].reshape(-1, 2) for name, cells in cell_sets]
    return np.concatenate([np.empty((0, 2), np.int64), *found])


def constraints_of(
    mesh: Mesh, place: Place, keep_offs: Sequence[KeepOff], near: Array | None = None
) -> Constraints | None:
    """What the vertices of a mesh are told; None where it is nothing.

    Parameters
    ----------
    mesh : Mesh
        By its corners, as it was read.
    place : Place
        The same as it is worked on.
    near : (np,) bool, optional
        Vertices that are told what to keep off however far they are; all others only if they are
        near it.

    Raises
    ------
    BadMeshError
        An array is not of the shape that it must have, or not finite.
    ConfigError
        There is no such group.
    """
    if not keep_offs and not any(name in mesh.point_data for name in TOLD):
        return None
    n = len(place.points)
    guide = _guides(mesh, place)
    found = [_limits_of_array(mesh)] if LIMIT in mesh.point_data else []
    points = with_depth(mesh.points)
    sizes = place.longest() if keep_offs else np.empty(0)
    for one in keep_offs:
        found += _limits(one, mesh, place, points, sizes, near)
    spaces = HalfSpaces(*map(np.concatenate, zip(*found, strict=True))) if found else None
    if spaces is None:
        return Constraints(guide, np.zeros(n + 1, np.int64), np.empty((0, 4)))
    rows, normals, offsets = _in_work(spaces, place)
    offsets = offsets + noise_of(points, place.single)
    order = np.argsort(rows, kind="stable")
    start = np.zeros(n + 1, dtype=np.int64)
    np.cumsum(np.bincount(rows, minlength=n), out=start[1:])
    limited = np.diff(start) > 0
    guide[limited & (guide[:, 0] == STAYS), 0] = SPACE
    return Constraints(guide, start, np.column_stack([normals, offsets])[order])


def _guides(mesh: Mesh, place: Place) -> Array:
    """What each vertex may move along, (n, 4), as the arrays say."""
    guide = np.zeros((len(place.points), 4))
    for name, kind in ((ALONG, LINE), (WITHIN, PLANE)):
        if name not in mesh.point_data:
            continue
        values = _array(mesh, name, 3)
        told = np.flatnonzero(values.any(axis=1))
        values = values[told]
        values = values / np.linalg.norm(values, axis=1)[:, None]
        values = values @ place.axes.T
        kinds = np.full(len(told), kind)
        if place.dimension == 2:
            # A line out of the plane of the mesh leaves a vertex where it is; a plane in it, free.
            out = np.abs(values[:, 2]) > SHORT
            values[:, 2] = 0.0
            length = np.linalg.norm(values, axis=1)
            values /= np.where(length > SHORT, length, 1.0)[:, None]
            if kind == PLANE:
                kinds = np.where(length > SHORT, kind, SPACE)
            else:
                values[out] = 0.0
        own = np.column_stack([kinds, values])
        before = guide[told]
        before[before[:, 0] == STAYS, 0] = SPACE
        guide[told] = _or_nowhere(meet(before, own))
    return guide


def _or_nowhere(guide: Array) -> Array:
    """Guides in which a vertex that may go nowhere is one that may go along nothing."""
    nowhere = guide[:, 0] == STAYS
    guide[nowhere] = LINE, 0.0, 0.0, 0.0
    return guide


def _array(mesh: Mesh, name: str, width: int) -> Array:
    """An array on points, as reals, (np, width).

    Raises
    ------
    BadMeshError
    """
    values = mesh.point_data[name]
    if values.dtype.kind not in "fiu" or values.shape != (len(mesh.points), width):
        raise BadMeshError(f"the array {name} must have {width} numbers for each point")
    values = values.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        raise BadMeshError(f"the array {name} is not finite at point {bad[0]}")
    return values


def _limits_of_array(mesh: Mesh) -> HalfSpaces:
    """The half-space of each vertex that the array gives one, by normal and offset."""
    values = _array(mesh, LIMIT, 4)
    rows = np.flatnonzero(values[:, :3].any(axis=1))
    length = np.linalg.norm(values[rows, :3], axis=1)
    return HalfSpaces(rows, values[rows, :3] / length[:, None], values[rows, 3] / length)


def _in_work(spaces: HalfSpaces, place: Place) -> HalfSpaces:
    """Half-spaces in the coordinates of the work; without those that have no part in its plane."""
    rows, normals, offsets = spaces
    if place.frame is not None:
        offsets = offsets - normals @ place.frame.origin
    normals = normals @ place.axes.T
    if place.dimension == 3:
        return HalfSpaces(rows, normals, offsets)
    normals[:, 2] = 0.0
    length = np.linalg.norm(normals, axis=1)
    kept = length > SHORT
    length = length[kept]
    return HalfSpaces(rows[kept], normals[kept] / length[:, None], offsets[kept] / length)


def _limits(
    one: KeepOff, mesh: Mesh, place: Place, points: Array, sizes: Array, near: Array | None
) -> list[HalfSpaces]:
    """The half-spaces of all vertices that are near what they are to keep off."""
    used = sizes > 0.0
    reach = one.distance + REACH * sizes
    if near is not None:
        reach[near] = np.inf
    if one.kind == grammar.PLANE:
        origin, normal = np.array(one.points)
        normal = normal / np.linalg.norm(normal)
        height = (points - origin) @ normal
        rows = np.flatnonzero(used & (np.abs(height) <= reach))
        middle = (place.middle(points)[rows] - origin) @ normal
        height = height[rows]
        noise = noise_of(points, place.single)
        side = np.sign(np.where(np.abs(height) > noise, height, middle))
        side[side == 0.0] = 1.0
        return [HalfSpaces(rows, side[:, None] * normal, side * (normal @ origin) + one.distance)]
    if one.kind in grammar.CORNERS:
        corners = np.array(one.points)[np.minimum(np.arange(3), len(one.points) - 1)]
        face = np.broadcast_to(corners, (len(points), 3, 3))
        there = nearest(face, points)
        distance = np.linalg.norm(points - there, axis=1)
        distance[distance <= noise_of(points, place.single)] = 0.0
        rows = np.flatnonzero(used & (distance <= reach))
        return [off_faces(rows, points[rows], there[rows], distance[rows], one.distance)]
    faces = faces_of(one, mesh)
    off = used.copy()
    off[faces] = False
    rows = np.flatnonzero(off)
    corners = points[faces]
    # A vertex that is near goes no farther than its longest edge: no other face matters to it.
    pairs = pairs_within(corners, points[rows], one.distance + sizes[rows])
    vertex = rows[pairs[0]]
    told = np.zeros(len(points), dtype=bool)
    told[vertex] = True
    if near is not None:
        told |= near & off
    rows = np.flatnonzero(told)
    home = around_home(rows, place.points[rows], sizes[rows], place.dimension)
    back = HalfSpaces(home.vertices, home.normals @ place.axes, home.offsets)
    if place.frame is not None:
        back = back._replace(offsets=back.offsets + back.normals @ place.frame.origin)
    return [off_faces(vertex, points[vertex], pairs[2], pairs[3], one.distance), back]


def faces_of(one: KeepOff, mesh: Mesh) -> Array:
    """Points, edges and triangles of the mesh to keep off, (n, 3): some corners are the same.

    Raises
    ------
    ConfigError
        There is no such group.
    """
    if one.kind == grammar.BOUNDARY:
        return _triangles(of_mesh(mesh).outer)
    top = top_blocks(mesh)
    groups: list[Block] = []
    for block in mesh.blocks:
        chosen = _in_group(block, one.name, mesh)
        if chosen.any():
            groups.append(replace(block, cells=block.cells[chosen], data={}))
    if not groups:
        raise ConfigError(f"--keep-off {one.text}: the mesh has no group or region {one.name}")
    names = {block.type for block in top}
    solid = [block for block in groups if block.type in names]
    rows = [block.cells for block in groups if block.type not in names]
    if solid:
        rows += of_mesh(replace(mesh, blocks=solid)).outer
    return _triangles(rows)


def _in_group(block: Block, name: str, mesh: Mesh) -> Array:
    """Which cells of a block are in a group, by its name or number, (n,) bool."""
    chosen = np.zeros(len(block.cells), dtype=bool)
    dimension = FAMILIES[block.type].dimension if block.type in FAMILIES else -1
    tags = {PHYSICAL: block.data[PHYSICAL]} if PHYSICAL in block.data else tags_of([block])
    for values in tags.values():
        for tag in np.unique(values):
            named = mesh.names.get((dimension, int(tag)))
            if name == named or (named != name and name == f"{tag:g}"):
                chosen |= values == tag
    return chosen


def _triangles(rows: list[Array]) -> Array:
    """Points, edges, triangles and quads as triangles, (n, 3)."""
    found = [np.empty((0, 3), np.int64)]
    for part in rows:
        width = part.shape[1]
        if width <= 3:
            found.append(part[:, np.minimum(np.arange(3), width - 1)])
        else:
            # A quad that is not flat is within the hull of its four triangles.
            found += [np.delete(part[:, :4], k, axis=1) for k in range(4)]
    return np.concatenate(found)
