"""Make the sample meshes beside this file: ``python make_samples.py [FOLDER]``.

Needs numpy, meshio and scipy (the extra ``samples``). Seeds are fixed, so running it twice gives
the same bytes. Quality is the aspect ratio (18.6) / (18.7) of Frey & George, 1 when regular.
"""

import contextlib
import io
import itertools
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from geometry import (
    DECIMALS,
    Floats,
    Ints,
    aspect_ratio,
    boundary_facets,
    directed_facets,
    measure,
    oriented,
    perturb,
)
from numpy.typing import NDArray
from quadtree import quadtree
from scipy.spatial import Delaunay

# --- raw_ball.mesh ------------------------------------------------------------------------------


def sphere(n: int) -> Floats:
    """Points of a Fibonacci lattice on the unit sphere."""
    k = np.arange(n) + 0.5
    z = 1 - 2 * k / n
    angle = np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def inner_lattice(n: int, axes: Floats, margin: float) -> tuple[Floats, float]:
    """The `n` innermost points of a face-centred lattice, sized to fill an ellipsoid; its side."""
    side = float(np.cbrt(16 / 3 * np.pi * np.prod(axes) * (1 - margin) ** 3 / n))
    count = int(2 / side)
    corner = side * np.array(list(itertools.product(range(-count, count + 1), repeat=3)))
    centred = side / 2 * np.array([[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]])
    lattice = (corner + centred[:, None]).reshape(-1, 3) + side * np.array([0.1, 0.17, 0.23])
    depth = np.linalg.norm(lattice / axes, axis=1)
    return lattice[np.argsort(depth, kind="stable")[:n]], side


def raw_ball() -> meshio.Mesh:
    """Delaunay mesh of jittered points on and in an ellipsoid, with the slivers that come along.

    The points of cells beyond `limit` are drawn again, so that no cell is all but flat.
    """
    n_surface, n_inner, limit = 718, 286, 800.0
    axes = np.array([1.1, 1.0, 0.9])
    rng = np.random.default_rng(3)
    spacing = np.sqrt(4 * np.pi / n_surface)
    inner, side = inner_lattice(n_inner, axes, 0.85 * spacing)
    seats = np.concatenate([sphere(n_surface), inner])
    jitter = np.repeat([0.1 * spacing, 0.27 * side], [n_surface, n_inner])

    points = np.zeros_like(seats)
    redrawn = np.arange(len(seats))
    while redrawn.size:
        drawn = seats[redrawn] + jitter[redrawn, None] * rng.uniform(-1, 1, (redrawn.size, 3))
        surface = redrawn < n_surface
        drawn[surface] *= axes / np.linalg.norm(drawn[surface], axis=1, keepdims=True)
        points[redrawn] = np.round(drawn, DECIMALS)
        tets = oriented(points, Delaunay(points).simplices.astype(np.int64))
        redrawn = np.unique(tets[aspect_ratio(points, tets) > limit])
    return meshio.Mesh(
        points, [("tetra", tets)], cell_data={"medit:ref": [np.ones(len(tets), np.int64)]}
    )


# --- grids: two_regions, grid, plate, tangled, broken -------------------------------------------


def kuhn(counts: tuple[int, int, int]) -> tuple[Floats, Ints]:
    """Points of a grid of unit cubes and its tetrahedra, six along the diagonal of each cube."""
    shape = tuple(n + 1 for n in counts)
    points = np.argwhere(np.ones(shape)).astype(np.float64)
    cubes = np.argwhere(np.ones(counts))
    tets = []
    for axes in itertools.permutations(range(3)):
        path = np.concatenate([np.zeros((1, 3), int), np.cumsum(np.eye(3, dtype=int)[[*axes]], 0)])
        nodes = cubes[:, None] + path
        tets.append(np.ravel_multi_index(tuple(np.moveaxis(nodes, 2, 0)), shape))
    return points, oriented(points, np.concatenate(tets))


def free_vertices(points: Floats, facets: Ints) -> NDArray[np.bool_]:
    """Mask of the points on none of the facets."""
    free = np.ones(len(points), bool)
    free[facets] = False
    return free


def grid() -> meshio.Mesh:
    """Perturbed Kuhn grid; the boundary is left alone."""
    points, tets = kuhn((7, 6, 6))
    free = free_vertices(points, boundary_facets(tets))
    rng = np.random.default_rng(6)
    points = perturb(points, tets, free, np.full(3, 0.7), 60.0, rng)
    return meshio.Mesh(points, [("tetra", tets)])


def tangled() -> meshio.Mesh:
    """Kuhn grid with two vertices dragged outside their balls: cells there are inverted."""
    points, tets = kuhn((4, 4, 4))
    for where, by in (([1, 1, 1], [1.3, 0.2, 0.1]), ([3, 3, 2], [-0.4, -1.2, 0.3])):
        points[(points == where).all(axis=1)] += by
    return meshio.Mesh(points, [("tetra", tets)])


def broken() -> meshio.Mesh:
    """Kuhn grid with a vertex dragged outside its ball, and with one cell twice."""
    points, tets = kuhn((3, 3, 3))
    dragged = np.flatnonzero((points == [1, 1, 1]).all(axis=1))[0]
    points[dragged] += [1.3, 0.2, 0.1]
    return meshio.Mesh(points, [("tetra", np.concatenate([tets, tets[100:101]]))])


def flip_some(
    points: Floats, cells: Ints, group: Ints, worst: float, rng: np.random.Generator
) -> Ints:
    """Flip edges within a group in random order, each triangle at most once."""
    cells = cells.copy()
    owner: dict[tuple[int, int], tuple[int, int]] = {}
    pairs = []
    for t, triangle in enumerate(cells):
        for k in range(3):
            a, b, apex = (int(triangle[(k + s) % 3]) for s in range(3))
            if (b, a) in owner:
                pairs.append((a, b, apex, t, *owner[b, a]))
            owner[a, b] = (apex, t)
    touched: set[int] = set()
    for pick in rng.permutation(len(pairs)):
        a, b, apex, t, other, u = pairs[pick]
        flipped = np.array([[apex, other, b], [other, apex, a]])
        if group[t] != group[u] or touched & {t, u}:
            continue
        if aspect_ratio(points, flipped).max() < worst:
            cells[[t, u]] = flipped
            touched |= {t, u}
    return cells


def plate() -> meshio.Mesh:
    """Plate of two materials that meet along a wave; diagonals flipped, vertices perturbed."""
    nx, ny, joint = 30, 25, 12
    rng = np.random.default_rng(5)
    x, y = np.divmod(np.arange((nx + 1) * (ny + 1)), ny + 1)
    wave = 1.5 * np.sin(2 * np.pi * x / nx) * np.minimum(y / joint, (ny - y) / (ny - joint))
    points = np.round(np.column_stack([x, y + wave, 0 * x]) / 10, DECIMALS)

    corner = (np.arange(nx)[:, None] * (ny + 1) + np.arange(ny)).reshape(-1, 1)
    square = corner + np.array([0, ny + 1, ny + 2, 1])
    cells = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
    material = np.tile(np.where(y[corner.ravel()] < joint, 1, 2), 2)

    free = free_vertices(points, boundary_facets(cells)) & (y != joint)
    points = perturb(points, cells, free, np.array([0.06, 0.06, 0.0]), 60.0, rng)
    for _ in range(2):
        cells = flip_some(points, cells, material, 60.0, rng)
    return meshio.Mesh(points, [("triangle", cells)], cell_data={"material": [material]})


CORE, SHELL = 1, 2  # volumes
INTERFACE = 7  # the surface between them; surfaces 1 to 6 are the sides of the box
PHYSICAL = {"outside": (1, 2), "interface": (2, 2), "core": (3, 3), "shell": (4, 3)}


def two_regions() -> meshio.Mesh:
    """Perturbed box with an inner box of another region; physical names, one block per entity."""
    counts = np.array([7, 7, 6])
    points, tets = kuhn((7, 7, 6))
    centre = points[tets].mean(axis=1)
    in_core = ((centre > 2) & (centre < 5)).all(axis=1)

    outside = boundary_facets(tets)
    interface = boundary_facets(tets[in_core])
    side = np.zeros(len(outside), np.int64)
    for axis in range(3):
        for end, at in enumerate((0, counts[axis])):
            side[(points[outside, axis] == at).all(axis=1)] = 2 * axis + end + 1

    dim_tags = np.full((len(points), 2), (3, SHELL))
    dim_tags[np.unique(tets[in_core])] = (3, CORE)
    dim_tags[np.unique(interface)] = (2, INTERFACE)
    for tag in range(6, 0, -1):
        dim_tags[np.unique(outside[side == tag])] = (2, tag)

    rng = np.random.default_rng(3)
    points = perturb(points, tets, dim_tags[:, 0] == 3, np.full(3, 0.7), 60.0, rng)
    order = np.lexsort(dim_tags.T[::-1])
    number = np.argsort(order)
    blocks = [("triangle", outside[side == tag], tag, "outside") for tag in range(1, 7)]
    blocks += [("triangle", interface, INTERFACE, "interface")]
    blocks += [("tetra", tets[in_core], CORE, "core"), ("tetra", tets[~in_core], SHELL, "shell")]
    return meshio.Mesh(
        points[order],
        [(kind, number[cells]) for kind, cells, _, _ in blocks],
        point_data={"gmsh:dim_tags": dim_tags[order]},
        cell_data={
            "gmsh:physical": [np.full(len(c), PHYSICAL[name][0]) for _, c, _, name in blocks],
            "gmsh:geometrical": [np.full(len(c), tag) for _, c, tag, _ in blocks],
        },
        field_data={name: np.array(value) for name, value in PHYSICAL.items()},
    )


def two_regions_22() -> meshio.Mesh:
    """The mesh of `two_regions`, without what Gmsh 2.2 cannot hold."""
    mesh = two_regions()
    mesh.point_data.clear()
    return mesh


# --- writing and verifying ----------------------------------------------------------------------


@dataclass(frozen=True)
class Sample:
    """A file: how to make and write it, and what it must hold."""

    name: str
    make: Callable[[], meshio.Mesh]
    options: dict[str, Any]
    n_cells: tuple[int, int]
    worst: tuple[float, float]
    planted: frozenset[str] = frozenset()  # the faults it has on purpose


INVERTED, TWICE = "a cell is not positive", "a cell appears twice"
SHORT = {"float_fmt": ".9g"}
VTK = {"file_format": "vtk42", "binary": False}
GMSH = SHORT | {"file_format": "gmsh", "binary": False}  # without a format, meshio writes ANSYS
GMSH22 = GMSH | {"file_format": "gmsh22"}
SAMPLES = [  # counts and worst ratios are bounds
    Sample("raw_ball.mesh", raw_ball, SHORT, (3800, 4034), (300, 900)),
    Sample("quadtree.vtk", quadtree, VTK, (1000, 3000), (3, 20)),
    Sample("two_regions.msh", two_regions, GMSH, (1000, 2000), (20, 100)),
    Sample("two_regions_22.msh", two_regions_22, GMSH22, (1000, 2000), (20, 100)),
    Sample("plate.vtu", plate, {"compression": None}, (1400, 1600), (20, 100)),
    Sample("grid.vtk", grid, {}, (1300, 2000), (20, 100)),
    Sample("tangled.vtk", tangled, VTK, (300, 400), (-np.inf, np.inf), frozenset({INVERTED})),
    Sample("broken.vtk", broken, VTK, (100, 300), (-np.inf, np.inf), frozenset({INVERTED, TWICE})),
]


def faults(mesh: meshio.Mesh, cells: Ints) -> list[str]:
    """What makes a mesh invalid."""
    points = mesh.points
    facets = directed_facets(cells)
    ordered, n_cells = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    n = facets.shape[1]
    signs = [np.sign(facets[:, j] - facets[:, i]) for i, j in itertools.combinations(range(n), 2)]
    sides = np.column_stack([np.sort(facets, axis=1), np.prod(signs, axis=0)])
    boundary = boundary_facets(cells)
    ridges = directed_facets(boundary) if n == 3 else boundary.reshape(-1, 1)
    _, n_facets = np.unique(np.sort(ridges, axis=1), axis=0, return_counts=True)
    declared = [np.sort(b.data, axis=1) for b in mesh.cells if b.data.shape[1] < cells.shape[1]]
    everything = np.concatenate([ordered, *declared])
    tests = {
        INVERTED: measure(points, cells).min() <= 0,
        TWICE: len(np.unique(np.sort(cells, axis=1), axis=0)) < len(cells),
        "a facet is shared by more than two cells": n_cells.max() > 2,
        "neighbours disagree in orientation": len(np.unique(sides, axis=0)) < len(sides),
        "the boundary is open or not manifold": (n_facets != 2).any(),
        "a declared facet bounds no cell": len(np.unique(everything, axis=0)) > len(ordered),
        "two points coincide": len(np.unique(points, axis=0)) < len(points),
        "a point is unused": len(np.unique(cells)) < len(points),
    }
    return [message for message, bad in tests.items() if bad]


def verify(path: Path, sample: Sample) -> str:
    """Read a file back and test it; a line of numbers for the reader."""
    mesh = meshio.read(path, "gmsh" if path.suffix == ".msh" else None)
    kind = mesh.cells[-1].type
    cells = np.concatenate([b.data for b in mesh.cells if b.type == kind]).astype(np.int64)
    ratio = aspect_ratio(mesh.points, cells)
    found = faults(mesh, cells)
    if not sample.n_cells[0] <= len(cells) <= sample.n_cells[1]:
        found.append(f"{len(cells)} cells")
    if not sample.worst[0] <= ratio.max() <= sample.worst[1]:
        found.append(f"worst aspect ratio {ratio.max():.4g}")
    if (found and not sample.planted) or not sample.planted <= set(found):
        raise SystemExit(f"{path.name}: {'; '.join(found) or 'no fault'}")
    good = np.mean(ratio < 2)
    return (
        f"{path.name}: {len(cells)} {kind}, {len(mesh.points)} points, "
        f"worst {ratio.max():.4g}, {good:.1%} below 2, {np.sum(ratio > 10)} above 10"
    )


def main(folder: Path) -> None:
    """Write every sample into a folder, then read each back and verify it."""
    folder.mkdir(parents=True, exist_ok=True)
    for sample in SAMPLES:
        path = folder / sample.name
        with contextlib.redirect_stderr(io.StringIO()):  # meshio advises against ASCII VTK
            sample.make().write(path, **sample.options)
        print(verify(path, sample))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
