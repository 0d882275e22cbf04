"""The smallest meshes that show something, and small grids to break."""

from itertools import permutations, product

import numpy as np

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
