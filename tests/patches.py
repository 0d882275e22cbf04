"""Small local patches by name, drivers for the operators, and what must hold after them."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
from builders import mesh
from hypothesis import settings

from meshopt_cli import formats
from meshopt_cli.compiled.decorators import entry
from meshopt_cli.kernels.audit import WHOLE, audit
from meshopt_cli.kernels.gather import ball, star
from meshopt_cli.kernels.operators import collapse, face_removal, flip, insert, mend, relocate, swap
from meshopt_cli.kernels.shape import classify
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import Simplices, cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.quality.summary import MEASURES
from meshopt_cli.work.workspace import Workspace

ROOT = Path(__file__).parent.parent
SAMPLE_NAMES = ("raw_ball.mesh", "quadtree.vtk", "two_regions.msh", "plate.vtu", "grid.vtk")


# Meshes ---------------------------------------------------------------------------------


@cache
def sample(name: str) -> Simplices:
    """The cells of a sample mesh. The only place of these tests that reads a file."""
    read, _ = formats.read(ROOT / "samples" / name)
    return cast(read)


def workspace(patch: Mesh | Simplices, measure: str = "aspect-ratio") -> Workspace:
    """A patch as the kernels see it."""
    source = cast(patch) if isinstance(patch, Mesh) else patch
    return Workspace(source, MEASURES[measure].judge, in_order=True)


def volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Signed volume of each cell, area in the plane, by the determinants (18.1) and (18.3)."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    if cells.shape[1] == 3:
        return np.linalg.det(edges[:, :, :2]) / 2
    return np.linalg.det(edges) / 6


def shaken(patch: Mesh, amount: float, seed: int = 0) -> Mesh:
    """The patch with its inner vertices moved at random, all cells still positive."""
    source = cast(patch)
    generator = np.random.default_rng(seed)
    width = patch.points.shape[1]
    step = np.zeros((len(source.points), 3))
    step[:, :width] = generator.uniform(-amount, amount, (len(source.points), width))
    step[np.unique(source.skin)] = 0.0
    least = 1e-2 * volumes(source.points, source.cells)
    while True:
        inverted = volumes(source.points + step, source.cells) < least
        if not inverted.any():
            return Mesh((source.points + step)[:, :width], patch.blocks, patch.point_data)
        step[source.cells[inverted]] *= 0.5


def with_regions(patch: Mesh, regions: np.ndarray) -> Mesh:
    """The patch with a region for each cell of its first block."""
    patch.blocks[0].data = {"gmsh:physical": np.asarray(regions, dtype=np.int64)}
    return patch


def halves(patch: Mesh) -> Mesh:
    """The patch cut in two regions near the plane x = 1/2."""
    centres = patch.points[patch.blocks[0].cells].mean(axis=1)
    return with_regions(patch, centres[:, 0] > 0.5)


def declaring(patch: Mesh, **cells) -> Mesh:
    """The patch with cells of lower dimension that its file declares."""
    blocks = [Block(kind, np.array(rows, dtype=np.int64)) for kind, rows in cells.items()]
    return Mesh(patch.points, patch.blocks + blocks)


def declaring_some(patch: Mesh) -> Mesh:
    """The patch with a few edges and a vertex inside it declared."""
    source = cast(patch)
    edges = adjacency.edges(source.cells, len(source.points))
    outside = np.isin(edges, source.skin)
    inside = edges[~outside.all(axis=1)]
    vertex = inside[-1][~np.isin(inside[-1], source.skin)][0]
    return declaring(patch, line=inside[:: len(inside) // 5], vertex=[[vertex]])


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


# Drivers: what only kernels can call, made callable -------------------------------------


@entry
def plan_relocation(mesh, vertex, how, scratch):
    """`simulate_relocation` for Python."""
    return relocate.simulate_relocation(mesh, vertex, how, scratch)


@entry
def do_relocation(mesh, vertex, plan, scratch):
    """`apply_relocation` for Python."""
    relocate.apply_relocation(mesh, vertex, plan, scratch)


@entry
def plan_flip(mesh, handle, rule, floor):
    """`simulate_flip` for Python."""
    return flip.simulate_flip(mesh, handle, rule, floor)


@entry
def do_flip(mesh, plan, scratch):
    """`apply_flip` for Python."""
    flip.apply_flip(mesh, plan, scratch)


@entry
def plan_face_swap(mesh, handle, rule, floor, scratch):
    """`simulate_face_swap` for Python."""
    return swap.simulate_face_swap(mesh, handle, rule, floor, scratch)


@entry
def plan_edge_swap(mesh, handle, rule, floor, scratch):
    """`simulate_edge_swap` for Python."""
    return swap.simulate_edge_swap(mesh, handle, rule, floor, scratch)


@entry
def plan_face_removal(mesh, handle, rule, floor, scratch):
    """`simulate_face_removal` for Python."""
    return face_removal.simulate_face_removal(mesh, handle, rule, floor, scratch)


@entry
def mended(mesh, cell, remedies, how, scratch):
    """`mend_cell` for Python."""
    return mend.mend_cell(mesh, cell, remedies, how, scratch)


@entry
def type_of(points, cell_vertices):
    """`cell_type` for Python."""
    return classify.cell_type(points, cell_vertices)


@entry
def best_of_ring(mesh, a, b, n, stop, scratch):
    """`triangulate_ring` for Python."""
    return swap.triangulate_ring(mesh, a, b, n, stop, scratch)


@entry
def do_swap(mesh, plan, scratch):
    """`apply_swap` for Python."""
    swap.apply_swap(mesh, plan, scratch)


@entry
def plan_any_swap(mesh, cell, handle, how, scratch):
    """`simulate_swap` for Python."""
    return swap.simulate_swap(mesh, cell, handle, how, scratch)


@entry
def plan_collapse(mesh, vertex, onto, how, scratch):
    """`simulate_midpoint_collapse` for Python, or `simulate_collapse` without `how.midpoint`."""
    if how.midpoint:
        return collapse.simulate_midpoint_collapse(mesh, vertex, onto, how, scratch)
    return collapse.simulate_collapse(mesh, vertex, onto, how, scratch)


@entry
def do_collapse(mesh, plan, scratch):
    """`apply_collapse` for Python."""
    collapse.apply_collapse(mesh, plan, scratch)


@entry
def plan_insertion(mesh, cell, urgent, scratch):
    """`simulate_insertion` for Python."""
    how = insert.Splitting(mesh.points.shape[0], 0.0, urgent, 0.0)
    return insert.simulate_insertion(mesh, cell, how, scratch)


@entry
def measured_star(mesh, vertex, p, scratch):
    """`measure_star` of the ball of a vertex: number of cells and worst q."""
    n, _ = ball.gather_ball(mesh, vertex, scratch.ball, scratch)
    star.load_star(mesh, scratch.ball, n, scratch)
    return n, star.measure_star(mesh, n, p, scratch)


@entry
def do_insertion(mesh, plan, scratch):
    """`apply_insertion` for Python."""
    insert.apply_insertion(mesh, plan, scratch)


# What must hold -------------------------------------------------------------------------


def snapshot(work: Workspace) -> dict[str, bytes]:
    """Every byte of a working mesh, by array."""
    arrays = work.mesh._asdict().items()
    return {name: a.tobytes() for name, a in arrays if isinstance(a, np.ndarray)}


def sorted_skin(mesh: Simplices, origin: np.ndarray | None = None) -> np.ndarray:
    """Facets on the boundary, on interfaces and declared ones, in the numbers of the input."""
    rows = mesh.skin if origin is None else origin[mesh.skin]
    return np.unique(np.sort(rows, axis=1), axis=0)


def region_volumes(mesh: Simplices) -> np.ndarray:
    """Volume of each region."""
    return np.bincount(mesh.region, weights=volumes(mesh.points, mesh.cells))


def assert_whole(work: Workspace) -> None:
    """The mesh passes the audit, its cells are positive, and it knows how good they are."""
    assert audit(work.mesh, 0.0) == (WHOLE, -1)
    rows = work.living()
    fresh = Workspace(work.result()[0], work.mesh.judge)
    assert np.all(volumes(work.mesh.points, work.mesh.cells[rows]) > 0)
    stored = np.sort(work.mesh.quality[rows])
    np.testing.assert_allclose(stored, np.sort(fresh.mesh.quality[fresh.living()]), atol=1e-9)


def assert_kept(before: Simplices, work: Workspace) -> None:
    """Nothing is gone that a pass may not touch: skin, fixed vertices, edges, volumes."""
    assert_whole(work)
    after, origin = work.result()
    np.testing.assert_array_equal(sorted_skin(before), sorted_skin(after, origin))
    number = np.full(len(before.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    pinned = np.zeros(len(before.points), dtype=bool)
    pinned[np.concatenate([before.skin.ravel(), before.edges.ravel()])] = True
    pinned |= before.fixed
    assert np.all(number[pinned] >= 0)
    assert after.points[number[pinned]].tobytes() == before.points[pinned].tobytes()
    if len(before.edges):
        n = len(after.points)
        there = adjacency.row_keys(adjacency.edges(after.cells, n), n)
        assert np.isin(adjacency.row_keys(number[before.edges], n), there).all()
    old, new = region_volumes(before), region_volumes(after)
    np.testing.assert_allclose(new, old, rtol=0, atol=1e-9 * old.sum())


def examples(n: int) -> settings:
    """Try n examples, however long the first one takes: it may have to compile."""
    return settings(max_examples=n, deadline=None)


def run_python(code: str, **environment: str) -> str:
    """What a fresh Python prints that can import the tests; fails when it fails."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
