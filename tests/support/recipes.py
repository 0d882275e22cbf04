"""Small meshes of many kinds, each from a recipe that says what is in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshopt_cli.mesh.model import Block, Mesh
from support.domain import TAG
from support.meshes import tet_grid, tri_grid
from support.planes import rotation


@dataclass(frozen=True)
class Recipe:
    """A small mesh: a box, or one without a corner, of triangles or tets.

    Attributes
    ----------
    n : int
        Cells of its grid along each axis.
    amount : float
        How far vertices move, over the distance between them, those of the boundary and of plane
        interfaces within these.
    regions : {"one", "halves", "corner", "layers", "many"}
        Two or three with plane interfaces, or three at random cell by cell.
    declared : tuple of str
        What is declared of "sides", "parts of sides", "some sides", inner "facets", "edges" and
        "vertices".
    stretch : float
        Factor of the last coordinate.
    place : {"as it is", "other plane", "tilted"}
    single : bool
        Whether coordinates are of single precision.
    tangled : bool
        Whether a vertex is thrown across the cells around it.
    """

    dimension: int
    n: int
    seed: int = 0
    amount: float = 0.0
    notched: bool = False
    regions: str = "one"
    declared: tuple[str, ...] = ()
    stretch: float = 1.0
    place: str = "as it is"
    single: bool = False
    tangled: bool = False


def content(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.linalg.det(edges)


def made(recipe):
    """The mesh of a recipe, and the directions to measure it in."""
    d, n = recipe.dimension, recipe.n
    random = np.random.default_rng(recipe.seed)
    grid = tri_grid(n) if d == 2 else tet_grid(n)
    points, (block,) = grid.points, grid.blocks
    cells = block.cells
    # Squares or cubes of the grid: what is cut by them has plane sides and hangs by no vertex.
    box = np.floor(points[cells].mean(axis=1) * n)
    if recipe.notched and n > 1:
        kept = ~(box[:, :2] >= n / 2).all(axis=1)
        cells, box = cells[kept], box[kept]
    tags = regions_of(recipe, box, random)
    skin = boundary(cells)
    moved = random.uniform(-recipe.amount / n, recipe.amount / n, points.shape)
    flat = [boundary(cells[tags == tag]) for tag in np.unique(tags)]
    moved *= ~held(points, skin if recipe.regions == "many" else np.concatenate(flat))
    while (bad := content(points + moved, cells) < 0.02 / n**d).any():
        moved[cells[bad]] *= 0.5
    points = points + moved
    inner = np.setdiff1d(cells, skin)
    if recipe.tangled and len(inner):
        points[random.choice(inner)] += random.uniform(-1, 1, d) * 1.5 / n
    points[:, -1] *= recipe.stretch
    blocks = [Block(block.type, cells, {TAG: tags})]
    blocks += declarations(recipe, cells, skin, random)
    points, axes = placed(recipe, points)
    return Mesh(points.astype(np.float32 if recipe.single else np.float64), blocks), axes


def boundary(cells):
    """Facets that have one cell only."""
    facets = np.concatenate([np.delete(cells, k, axis=1) for k in range(cells.shape[1])])
    rows, times = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    return rows[times == 1]


def held(points, skin):
    """Which coordinates a vertex keeps to stay on its sides, (np, d) of bool."""
    keeps = np.zeros(points.shape, dtype=bool)
    for facet in skin:
        for axis in np.flatnonzero(np.ptp(points[facet], axis=0) == 0):
            keeps[facet, axis] = True
    return keeps


def regions_of(recipe, box, random):
    """A tag for each cell, from the square or the cube of the grid that it is in."""
    n = recipe.n
    return {
        "one": lambda: np.ones(len(box), dtype=int),
        "halves": lambda: 1 + (box[:, 0] >= n / 2),
        "corner": lambda: 1 + (box >= n / 2).all(axis=1),
        "layers": lambda: 1 + box[:, -1].astype(int),
        "many": lambda: random.integers(1, 4, len(box)),
    }[recipe.regions]()


def declarations(recipe, cells, skin, random):
    """Blocks of cells of lower dimension, each with a tag of its own."""
    every = np.concatenate([np.delete(cells, k, axis=1) for k in range(cells.shape[1])])
    facets = np.unique(np.sort(every, axis=1), axis=0)
    inside = np.array([f for f in facets if not (skin == f).all(axis=1).any()])
    lines = [[a, b] for cell in cells for k, a in enumerate(cell) for b in cell[:k]]
    edges = np.unique(np.sort(lines, axis=1), axis=0)
    kind = "line" if recipe.dimension == 2 else "triangle"
    chosen = []
    if "sides" in recipe.declared:
        chosen.append((kind, skin, 11))
    elif "parts of sides" in recipe.declared:
        low = skin.mean(axis=1) < skin.mean()  # vertices are numbered along the first axis
        chosen += [(kind, skin[low], 16), (kind, skin[~low], 17)]
    elif "some sides" in recipe.declared:
        chosen.append((kind, skin[random.random(len(skin)) < 0.5], 12))
    if "facets" in recipe.declared and len(inside):
        chosen.append((kind, inside[random.random(len(inside)) < 0.1], 13))
    if "edges" in recipe.declared and recipe.dimension == 3:
        chosen.append(("line", edges[random.random(len(edges)) < 0.1], 14))
    if "vertices" in recipe.declared:
        chosen.append(("vertex", random.choice(np.unique(cells), 2, replace=False)[:, None], 15))
    return [Block(k, rows, {TAG: np.full(len(rows), t)}) for k, rows, t in chosen if len(rows)]


def placed(recipe, points):
    """Points in space, and the axes they had before."""
    d = recipe.dimension
    if recipe.place == "as it is":
        return points, np.eye(3)[:d]
    axes = rotation(recipe.seed)[:d] if recipe.place == "tilted" else np.eye(3)[[2, 0, 1][:d]]
    return points @ axes, axes
