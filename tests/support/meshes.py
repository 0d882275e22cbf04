"""Grids to break, and small local patches by name."""

from __future__ import annotations

from functools import cache
from itertools import permutations, product

import numpy as np

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.model import Block, Mesh


def mesh(points, **cells):
    """A mesh of blocks, each named by its type."""
    blocks = [Block(kind, np.array(rows, dtype=np.int64)) for kind, rows in cells.items()]
    return Mesh(np.array(points, dtype=float), blocks)


def grid_points(n, dimension):
    """Points of a grid of n cells a side in the unit square or cube, the last axis fastest."""
    axis = np.linspace(0, 1, n + 1)
    return np.stack(np.meshgrid(*[axis] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)


def _number(n, *index):
    return int(np.ravel_multi_index(index, (n + 1,) * len(index)))


def tet_grid(n):
    """Kuhn's division of a cube, six tets for each cell of a grid, all positive."""
    cells = []
    for corner in product(range(n), repeat=3):
        for order in permutations(range(3)):
            path = [np.array(corner)]
            for axis in order:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            tet = [_number(n, *step) for step in path]
            odd = order in [(0, 2, 1), (1, 0, 2), (2, 1, 0)]
            cells.append([tet[0], tet[2], tet[1], tet[3]] if odd else tet)
    return mesh(grid_points(n, 3), tetra=cells)


def hex_grid(n):
    """Cubes."""
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [
        [_number(n, i + a, j + b, k + c) for c in (0, 1) for a, b in square]
        for i, j, k in product(range(n), repeat=3)
    ]
    return mesh(grid_points(n, 3), hexahedron=cells)


def quad_grid(n):
    """Squares, two columns of coordinates."""
    cells = [
        [_number(n, i, j), _number(n, i + 1, j), _number(n, i + 1, j + 1), _number(n, i, j + 1)]
        for i, j in product(range(n), repeat=2)
    ]
    return mesh(grid_points(n, 2), quad=cells)


def tri_grid(n):
    """Squares cut in two, two columns of coordinates."""
    quads = quad_grid(n).blocks[0].cells
    return mesh(grid_points(n, 2), triangle=np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))


def in_space(flat, height=0.0):
    """A mesh of two columns with a third one: a number, or one a point."""
    flat.points = np.column_stack([flat.points, np.broadcast_to(height, len(flat.points))])
    return flat


def octahedron():
    """A closed surface, all triangles seen anticlockwise from outside."""
    points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    upper = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]]
    return mesh(points, triangle=upper + [[b, a, 5] for a, b, _ in upper])


def joined(*parts):
    """Meshes of one type as one, with one point where there are several in a place."""
    points = np.concatenate([part.points for part in parts])
    points, number = np.unique(points.round(9), axis=0, return_inverse=True)
    first = np.cumsum([0] + [len(part.points) for part in parts])
    cells = [number[part.blocks[0].cells + at] for part, at in zip(parts, first, strict=False)]
    return mesh(points, **{parts[0].blocks[0].type: np.concatenate(cells)})


def ring(n: int) -> np.ndarray:
    """Corners of a regular polygon around the origin, (n, 2)."""
    angle = 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def spindle(n: int, height: float = 1.0, shake: float = 0.0, seed: int = 0) -> Mesh:
    """n tets around the edge from vertex 0 up to vertex 1: a closed shell, and nothing else."""
    generator = np.random.default_rng(seed)
    polygon = np.column_stack([ring(n), np.zeros(n)])
    polygon += generator.uniform(-shake, shake, polygon.shape)
    i = np.arange(n)
    cells = np.stack([0 * i, 0 * i + 1, 2 + i, 2 + (i + 1) % n], axis=1)
    return mesh([[0, 0, -height], [0, 0, height], *polygon], tetra=cells)


def open_spindle(n: int, of: int, height: float = 1.0) -> Mesh:
    """n tets of a spindle of so many: an open shell around the edge from vertex 0 to vertex 1."""
    polygon = np.column_stack([ring(of)[: n + 1], np.zeros(n + 1)])
    i = np.arange(n)
    cells = np.stack([0 * i, 0 * i + 1, 2 + i, 3 + i], axis=1)
    return mesh([[0, 0, -height], [0, 0, height], *polygon], tetra=cells)


def double_pyramid(height: float, lean: float = 0.0) -> Mesh:
    """Two tets on both sides of an equilateral triangle: not convex when they lean by > 1."""
    corners = np.column_stack([ring(3), np.zeros(3)])
    apexes = [[lean, 0, height], [lean, 0, -height]]
    return mesh([*corners, *apexes], tetra=[[0, 1, 2, 3], [0, 2, 1, 4]])


def diamond(height: float, lean: float = 0.0) -> Mesh:
    """Two triangles on both sides of an edge of length 2: not convex when they lean by > 1."""
    apexes = [[lean, height], [lean, -height]]
    return mesh([[-1, 0], [1, 0], *apexes], triangle=[[0, 1, 2], [1, 0, 3]])


def fan(n: int, centre: tuple[float, float] = (0.0, 0.0)) -> Mesh:
    """n triangles around vertex 0: a closed ball in the plane."""
    i = np.arange(n)
    cells = np.stack([0 * i, 1 + i, 1 + (i + 1) % n], axis=1)
    return mesh([centre, *ring(n)], triangle=cells)


def _icosahedron_faces() -> tuple[np.ndarray, np.ndarray]:
    """Corners (12, 3) around the origin, and faces (20, 3) seen anticlockwise from outside."""
    golden = (1 + np.sqrt(5)) / 2
    corners = np.array(
        [np.roll([0, i, j * golden], k) for k in range(3) for i in (-1, 1) for j in (-1, 1)]
    )
    near = np.linalg.norm(corners[:, None] - corners, axis=2) < 2.1
    triples = ((a, b, c) for a in range(12) for b in range(a) for c in range(b))
    faces = np.array([t for t in triples if near[t[0], t[1]] and near[t[1:]] and near[t[::2]]])
    inwards = np.linalg.det(corners[faces]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return corners, faces


def icosahedron(centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """20 tets around vertex 0: the ball of a vertex of degree 12 (footnote 9)."""
    corners, faces = _icosahedron_faces()
    cells = np.column_stack([np.zeros(20, dtype=int), faces + 1])
    return mesh([centre, *corners], tetra=cells)


def hollow_icosahedron() -> Mesh:
    """The tets from a corner of an icosahedron to its faces: it lacks a vertex in the middle."""
    corners, faces = _icosahedron_faces()
    cells = np.column_stack([np.zeros(20, dtype=int), faces])
    return mesh(corners, tetra=cells[(faces > 0).all(axis=1)])


def hollow_polygon(n: int) -> Mesh:
    """The triangles from a corner of a regular polygon to its sides: no vertex in the middle."""
    return mesh(ring(n), triangle=[[0, i, i + 1] for i in range(1, n - 1)])


def hexagon(n: int) -> Mesh:
    """Equilateral triangles that fill a hexagon of side n; vertex 0 is its centre."""
    places = [(i, j) for i in range(-n, n + 1) for j in range(-n, n + 1) if abs(i + j) <= n]
    places.sort(key=lambda place: place != (0, 0))
    number = {place: k for k, place in enumerate(places)}
    up = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in places]
    down = [[(i, j), (i + 1, j - 1), (i + 1, j)] for i, j in places]
    cells = [[number[p] for p in cell] for cell in up + down if all(p in number for p in cell)]
    return mesh([[i + j / 2, j * np.sqrt(3) / 2] for i, j in places], triangle=cells)


def large_grid(n):
    """A shaken grid of 6 n^3 tetrahedra, too much work for a blink."""
    small = tet_grid(1).blocks[0].cells
    axis = np.arange(n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3) * 1.0
    corner = np.stack(np.unravel_index(small, (2, 2, 2)), -1)
    cubes = np.stack(np.meshgrid(axis[:-1], axis[:-1], axis[:-1], indexing="ij"), -1).reshape(-1, 3)
    places = (cubes[:, None, None] + corner).reshape(-1, 4, 3)
    cells = np.ravel_multi_index(np.moveaxis(places, -1, 0), (n + 1,) * 3)
    inner = np.all((points > 0) & (points < n), axis=1)
    points[inner] += np.random.default_rng(0).uniform(-0.22, 0.22, (inner.sum(), 3))
    return Mesh(points, [Block("tetra", cells)])


@cache
def rotations(family):
    """The ways to number the corners of a cell anew that leave it as it is, (n, k)."""
    corners = FAMILIES[family].reference - FAMILIES[family].reference.mean(axis=0)
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    found = []

    def go_on(chosen):
        k = len(chosen)
        if k == len(corners):
            turn = corners.T @ corners[chosen]
            d = FAMILIES[family].dimension
            if np.linalg.det(turn[:d, :d]) > 0:
                found.append(chosen)
            return
        for v in range(len(corners)):
            if v not in chosen and np.allclose(apart[v, chosen], apart[k, :k]):
                go_on([*chosen, v])

    go_on([])
    return np.array(found)
