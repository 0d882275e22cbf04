"""quadtree.vtk: a raw quadtree mesh of a planar domain with a hole."""

import itertools
from collections.abc import Callable

import meshio
import numpy as np
from geometry import DECIMALS, Floats, Ints, boundary_facets, oriented
from numpy.typing import NDArray
from scipy.spatial import Delaunay

Leaf = tuple[int, int, int]  # level, column, row


def outline(t: Floats) -> Floats:
    """The outer curve of the planar domain."""
    radius = 1 + 0.16 * np.cos(2 * t) + 0.1 * np.cos(3 * t + 0.6)
    return np.column_stack([radius * np.cos(t), radius * np.sin(t)])


def hole(t: Floats) -> Floats:
    """The inner curve: a thin tilted ellipse, walked clockwise."""
    x, y = 0.5 * np.cos(t), -0.07 * np.sin(t)
    c, s = np.cos(0.35), np.sin(0.35)
    return np.column_stack([c * x - s * y - 0.05, s * x + c * y])


def sample_curve(
    curve: Callable[[Floats], Floats], finest: float, coarsest: float
) -> tuple[Floats, Floats]:
    """Points along a closed curve, denser where it bends, and the spacing wanted at each."""
    t = np.linspace(0, 2 * np.pi, 4096, endpoint=False)
    dense = curve(t)
    ahead = np.roll(dense, -1, axis=0) - dense
    length = np.hypot(*ahead.T)
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    turn = np.angle(np.exp(1j * (heading - np.roll(heading, 1))))
    spacing = np.clip(0.5 * length / np.abs(turn).clip(1e-12), finest, coarsest)
    for i in 2 * list(range(len(t))):  # grows by at most a fifth of the arc walked, both ways
        spacing[i] = min(spacing[i], spacing[i - 1] + 0.2 * length[i - 1])
    for i in 2 * list(reversed(range(len(t)))):
        spacing[i - 1] = min(spacing[i - 1], spacing[i] + 0.2 * length[i - 1])
    walked = np.concatenate([[0], np.cumsum(length / spacing)])
    n = round(walked[-1])
    at = np.interp(np.arange(n) * walked[-1] / n, walked, np.append(t, 2 * np.pi))
    return np.round(curve(at), DECIMALS), np.interp(at, t, spacing)


def inside(points: Floats, loops: list[Floats]) -> NDArray[np.bool_]:
    """Even-odd rule: is each point within the closed polygons?"""
    crossings = np.zeros(len(points), np.int64)
    for a in loops:
        b = np.roll(a, -1, axis=0)
        spans = (a[:, 1] > points[:, 1:]) != (b[:, 1] > points[:, 1:])
        with np.errstate(divide="ignore", invalid="ignore"):
            x = a[:, 0] + (points[:, 1:] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        crossings += (spans & (points[:, :1] < x)).sum(axis=1)
    return crossings % 2 == 1


def distance(points: Floats, loops: list[Floats]) -> Floats:
    """Distance of each point to the closed polygons."""
    nearest = np.full(len(points), np.inf)
    for a in loops:
        edge = np.roll(a, -1, axis=0) - a
        away = points[:, None] - a
        along = np.clip((away * edge).sum(axis=2) / (edge * edge).sum(axis=1), 0, 1)
        gap = np.linalg.norm(away - along[..., None] * edge, axis=2)
        nearest = np.minimum(nearest, gap.min(axis=1))
    return nearest


class Quadtree:
    """A quadtree over the square [-half, half]^2, held as the set of its leaves."""

    def __init__(self, half: float) -> None:
        """Start from one leaf, the whole square."""
        self.half = half
        self.leaves: set[Leaf] = {(0, 0, 0)}

    def corners(self, leaf: Leaf) -> Floats:
        """The four corners, counter-clockwise from the lower left."""
        level, i, j = leaf
        grid = np.array([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]])
        return grid * (2 * self.half / 2**level) - self.half

    def split(self, leaf: Leaf) -> list[Leaf]:
        """Replace a leaf by its four children."""
        level, i, j = leaf
        children = [(level + 1, 2 * i + a, 2 * j + b) for b in (0, 1) for a in (0, 1)]
        self.leaves.remove(leaf)
        self.leaves.update(children)
        return children

    def refine(self, points: Floats, sizes: Floats, coarsest: float) -> None:
        """Split until no leaf is larger than `coarsest`, or than the size wanted at its points."""
        pending = list(self.leaves)
        while pending:
            leaf = pending.pop()
            lower, upper = self.corners(leaf)[[0, 2]]
            side = upper[0] - lower[0]
            here = ((points >= lower) & (points <= upper)).all(axis=1)
            if side > min(coarsest, sizes[here].min(initial=np.inf)):
                pending += self.split(leaf)

    def balance(self) -> None:
        """Split until leaves that touch differ by one level at most."""
        pending = sorted(self.leaves)
        while pending:
            level, i, j = pending.pop()
            for di, dj in itertools.product((-1, 0, 1), repeat=2):
                a, b = i // 2 + di, j // 2 + dj
                for coarser in range(level - 1):
                    shift = level - 1 - coarser
                    leaf = (coarser, a >> shift, b >> shift)
                    if leaf in self.leaves:
                        pending += self.split(leaf)


def fan(corners: list[tuple[int, int]], nodes: set[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """Template of a quadtree cell: triangles of the square with the hanging nodes of its sides."""
    ring = []
    for (x0, y0), (x1, y1) in itertools.pairwise([*corners, corners[0]]):
        middle = ((x0 + x1) // 2, (y0 + y1) // 2)
        ring += [(x0, y0), middle] if middle in nodes else [(x0, y0)]
    hanging = [k for k, node in enumerate(ring) if node not in corners]
    side = corners[1][0] - corners[0][0]
    first = hanging[0] if hanging else (corners[0][0] // side + corners[0][1] // side) % 2
    ring = ring[first:] + ring[:first]
    return [[ring[0], *pair] for pair in itertools.pairwise(ring[1:])]


def triangulate(tree: Quadtree, kept: list[Leaf]) -> tuple[Floats, Ints]:
    """Conforming triangulation of some leaves of a balanced quadtree."""
    depth = max(level for level, _, _ in kept) + 1  # one more, so that middles are integers
    squares = []
    for level, i, j in kept:
        s = 2 ** (depth - level)
        x, y = i * s, j * s
        squares.append([(x, y), (x + s, y), (x + s, y + s), (x, y + s)])
    nodes = {corner for square in squares for corner in square}
    triangles = np.array([t for square in squares for t in fan(square, nodes)])
    grid, cells = np.unique(triangles.reshape(-1, 2), axis=0, return_inverse=True)
    return grid * (2 * tree.half / 2**depth) - tree.half, cells.reshape(-1, 3)


def well_inside(tree: Quadtree, loops: list[Floats], clearance: float) -> list[Leaf]:
    """Leaves whose corners are in the domain, off its boundary by `clearance` of their side."""
    leaves = sorted(tree.leaves)
    corners = np.concatenate([tree.corners(leaf) for leaf in leaves])
    gap = np.where(inside(corners, loops), distance(corners, loops), -1).reshape(-1, 4)
    side = np.array([2 * tree.half / 2**level for level, _, _ in leaves])
    clear = gap.min(axis=1) > clearance * side
    return [leaf for leaf, keep in zip(leaves, clear, strict=True) if keep]


def strip(rim: Floats, loops: list[Floats], squares: list[Floats]) -> Ints:
    """Delaunay triangles of the points `rim` that lie in the domain but in no square."""
    cells = Delaunay(rim).simplices.astype(np.int64)
    centre = rim[cells].mean(axis=1)
    wanted = inside(centre, loops)
    for square in squares:
        lower, upper = square[0] - 1e-9, square[2] + 1e-9
        wanted &= ~((centre > lower) & (centre < upper)).all(axis=1)
    return cells[wanted]


def quadtree() -> meshio.Mesh:
    """Raw quadtree mesh: templates in the cells well inside, a strip from them to the boundary."""
    samples = [sample_curve(outline, 0.02, 0.038), sample_curve(hole, 0.008, 0.03)]
    loops = [points for points, _ in samples]
    tree = Quadtree(half=1.37)
    tree.refine(np.concatenate(loops), 1.4 * np.concatenate([size for _, size in samples]), 0.2)
    tree.balance()
    kept = well_inside(tree, loops, 0.15)
    inner, inner_cells = triangulate(tree, kept)

    front = np.unique(boundary_facets(inner_cells))
    number = np.append(front, len(inner) + np.arange(sum(map(len, loops))))
    flat = np.concatenate([inner, *loops])
    strip_cells = number[strip(flat[number], loops, [tree.corners(leaf) for leaf in kept])]

    points = np.round(np.column_stack([flat, np.zeros(len(flat))]), DECIMALS)
    cells = oriented(points, np.concatenate([inner_cells, strip_cells]))
    if boundary_facets(cells).min() < len(inner):
        raise SystemExit("quadtree.vtk: the strip and the cells do not join")
    return meshio.Mesh(points, [("triangle", cells)])
