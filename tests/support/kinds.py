"""Meshes of more than one kind of thing: surfaces that branch, beams and shells beside cells, cells
with points of their own."""

from __future__ import annotations

import numpy as np

from meshopt_cli.mesh.model import Block, Mesh
from support.edits import declaring, shifted, turned
from support.meshes import hex_grid, joined, mesh, octahedron, quad_grid, tet_grid, tri_grid

X, Y, Z = np.eye(3)


def plate(n, u, v, origin=(0, 0, 0), grid=tri_grid):
    """A grid of n cells a side over two vectors of space; u x v is its normal."""
    flat = grid(n)
    points = np.asarray(origin) + flat.points @ np.stack([u, v])
    return Mesh(points, [Block(b.type, b.cells) for b in flat.blocks])


def star(n, directions, grid=tri_grid):
    """Plates that meet in one edge along z, each in a direction of its own."""
    return joined(*(plate(n, u, Z, grid=grid) for u in directions))


def tee(n, grid=tri_grid):
    """Three plates that meet in an edge."""
    return star(n, [X, Y, -Y], grid)


def fold(n, grid=tri_grid):
    """Two plates that meet at a right angle, one seen from above, the other from below."""
    return star(n, [X, Y], grid)


def box(n, outwards):
    """The six sides of a cube, each turned outwards or not."""
    sides = [(Y, X, 0 * X), (X, Y, Z), (Z, Y, 0 * X), (Y, Z, X), (X, Z, 0 * X), (Z, X, Y)]
    turned_so = [(u, v) if out else (v, u) for (u, v, _), out in zip(sides, outwards, strict=True)]
    places = [origin for _, _, origin in sides]
    return joined(*(plate(n, u, v, at) for (u, v), at in zip(turned_so, places, strict=True)))


def band(n, twists):
    """A band of 2 n triangles around the z axis, with so many half turns."""
    angle = 2 * np.pi * np.arange(n) / n
    lean = twists * angle / 2
    out = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    across = np.cos(lean)[:, None] * Z + np.sin(lean)[:, None] * out
    points = np.concatenate([3 * out - across, 3 * out + across])
    i = np.arange(n)
    last, flip = i == n - 1, twists % 2 == 1
    low = np.where(last, n if flip else 0, i + 1)
    high = np.where(last, 0 if flip else n, n + i + 1)
    return mesh(points, triangle=np.concatenate([np.stack([i, low, high], axis=1),
                                                 np.stack([i, high, n + i], axis=1)]))  # fmt: skip


def plate_with_beam(n=3, length=2):
    """Triangles in the plane z = 0, and lines that lead away from one of their corners."""
    base = plate(n, X, Y)
    first = int(np.argmax(base.points @ [1, -1, 0]))
    nodes = [first, *range(len(base.points), len(base.points) + length)]
    away = np.array([[1 + 0.5 * k, 0, 0] for k in range(1, length + 1)])
    lines = np.stack([nodes[:-1], nodes[1:]], axis=1)
    return Mesh(np.concatenate([base.points, away]), [*base.blocks, Block("line", lines)])


def solid_with_fin(n=3, kind="triangle", height=2):
    """A cube of tets, and faces that stand on the middle of its top."""
    solid = tet_grid(n)
    grid = {"triangle": tri_grid, "quad": quad_grid}[kind](n)
    fin = np.column_stack([grid.points[:, 0], np.full(len(grid.points), (n // 2) / n),
                           1 + height * grid.points[:, 1]])  # fmt: skip
    points = np.concatenate([solid.points, fin])
    place = np.array([int(np.argmin(np.linalg.norm(points - p, axis=1))) for p in fin])
    used = np.unique(np.concatenate([np.arange(len(solid.points)), place]))
    number = np.searchsorted(used, place)
    return Mesh(points[used], [*solid.blocks, Block(kind, number[grid.blocks[0].cells])])


def apart(of):
    """The same cells, each with points of its own."""
    points, blocks, n = [], [], 0
    for block in of.blocks:
        points.append(of.points[block.cells.ravel()])
        blocks.append(Block(block.type, n + np.arange(block.cells.size).reshape(block.cells.shape)))
        n += block.cells.size
    return Mesh(np.concatenate(points), blocks)


def cut(of, *ends):
    """A mesh with its points doubled where a line, or a plane, y = 1/2 cuts it: a crack.

    It goes from one x to another; its ends are not doubled, and neither is a crack of no length.
    """
    (block,) = of.blocks
    low, high = ends
    on = np.isclose(of.points[:, 1], 0.5) & (of.points[:, 0] > low) & (of.points[:, 0] < high)
    number = np.arange(len(of.points))
    number[on] = len(of.points) + np.arange(on.sum())
    above = of.points[block.cells].mean(axis=1)[:, 1] > 0.5
    cells = np.where(above[:, None], number[block.cells], block.cells)
    return Mesh(np.concatenate([of.points, of.points[on]]), [Block(block.type, cells)])


VALID_KINDS = {
    "three pages of a book": mesh(
        [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]],
        triangle=[[0, 1, 2], [1, 0, 3], [1, 0, 4]],
    ),
    "tee": tee(3),
    "tee of quads": tee(3, quad_grid),
    "four plates in a cross": star(2, [X, Y, -X, -Y]),
    "six plates in a star": star(2, [X, Y, -X, -Y, X + Y, X - Y]),
    "box of plates all turned outwards": box(2, [True] * 6),
    "band with a whole turn": band(24, 2),
    "solid with a shell on its boundary": declaring(
        tet_grid(2), triangle=tet_grid(2).blocks[0].cells[:1, :3]
    ),
    "line of lines": mesh(np.outer(np.arange(4), X), line=[[0, 1], [1, 2], [2, 3]]),
    "frame of lines": mesh([0 * X, X, Y, Z], line=[[0, 1], [0, 2], [0, 3], [1, 2]]),
    "points": mesh(np.eye(3), vertex=[[0], [1], [2]]),
}

# What is broken, and the codes for it: no more and no fewer.
BROKEN_KINDS = {
    "fold": (fold(3), "M215"),
    "fold of quads": (fold(3, quad_grid), "M215"),
    "box of plates turned at random": (box(2, [True, False, False, True, True, False]), "M215"),
    "band with one side": (band(24, 1), "M215"),
    "cell turned in a closed surface": (turned(octahedron(), 2), "M207"),
    "cell turned beside a branch": (turned(tee(4), 9), "M207"),
    "beam beside a plate": (plate_with_beam(), "M216"),
    "beams beside solids": (
        Mesh(
            np.concatenate([hex_grid(1).points, [[2, 0, 0], [3, 0, 0]]]),
            [*hex_grid(1).blocks, Block("line", np.array([[7, 8], [8, 9]]))],
        ),
        "M216",
    ),
    "shell beside tets": (solid_with_fin(), "M216"),
    "shell of quads beside tets": (solid_with_fin(3, "quad"), "M216"),
    "brace in a folded surface": (
        declaring(joined(plate(2, X, Z), plate(2, Z, Y)), line=[[3, 14]]),
        "M216",
    ),
    "line between two plates": (
        Mesh(
            np.concatenate([tri_grid(2).points, shifted(tri_grid(2), 2, 0).points]),
            [Block("triangle", np.concatenate([c, c + 9])) for c in [tri_grid(2).blocks[0].cells]]
            + [Block("line", np.array([[8, 9]]))],
        ),
        "M216",
    ),
    "beam listed twice": (
        declaring(plate_with_beam(3, 2), line=plate_with_beam(3, 2).blocks[1].cells[:1, ::-1]),
        "M201 M216",
    ),
    "beam with its ends in one point": (
        declaring(plate_with_beam(3, 2), line=[[17, 17]]),
        "M003 M216",
    ),
    "shell with a flat cell": (
        declaring(
            Mesh(
                np.concatenate([solid_with_fin().points, [[2, 2, 2], [3, 3, 3], [5, 5, 5]]]),
                solid_with_fin().blocks,
            ),
            triangle=[np.arange(3) + len(solid_with_fin().points)],
        ),
        "M102 M216",
    ),
    "line twice": (mesh(np.eye(3), line=[[0, 1], [1, 2], [1, 0]]), "M201"),
    "line with its ends in one point": (mesh(np.eye(3), line=[[0, 1], [1, 2], [2, 2]]), "M003"),
    "line without length": (
        mesh([*np.eye(3), X], line=[[0, 1], [1, 2], [0, 3]]),
        "M102 M202",
    ),
    "line that nothing joins to its neighbour": (
        mesh([*np.eye(3), Y], line=[[0, 1], [3, 2]]),
        "M202",
    ),
    "line and an unused point": (mesh(np.eye(3), line=[[0, 1]]), "M203"),
    "line to nowhere": (mesh([X, Y * np.nan], line=[[0, 1]]), "M001"),
    "line beyond the last point": (mesh(np.eye(3), line=[[0, 1], [1, 2], [2, 3]]), "M002"),
    "points twice": (mesh([*np.eye(3), Z], vertex=[[0], [1], [2], [3]]), "M202"),
    "tets apart": (apart(tet_grid(2)), "M202"),
    "hexahedra apart": (apart(hex_grid(3)), "M202"),
    "quads apart": (apart(quad_grid(4)), "M202"),
    "triangles of a surface apart": (apart(octahedron()), "M202"),
    "triangles of a surface apart, one turned": (turned(apart(octahedron()), 2), "M202 M207"),
    "crack in a plane": (cut(tri_grid(4), 0.1, 0.9), "M202 M205"),
    "crack between solids": (cut(tet_grid(4), 0.1, 0.9), "M202 M205"),
    "contact": (cut(tet_grid(2), -1, 2), "M202 M205"),
}
