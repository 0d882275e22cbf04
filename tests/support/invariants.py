"""What must hold after an operator, a pass or a run."""

from __future__ import annotations

import numpy as np

from meshopt_cli.kernels.audit import WHOLE, audit
from meshopt_cli.kernels.judge import measure_cells
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import Simplices, cast
from meshopt_cli.mesh.model import Mesh
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.session import Workspace


def volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Signed volume of each cell, area in the plane, by the determinants (18.1) and (18.3)."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    if cells.shape[1] == 3:
        return np.linalg.det(edges[:, :, :2]) / 2
    return np.linalg.det(edges) / 6


def workspace(patch: Mesh | Simplices, measure: str = "aspect-ratio") -> Workspace:
    """A patch as the kernels see it."""
    source = cast(patch) if isinstance(patch, Mesh) else patch
    return Workspace(source, QUALITIES[measure].judge, in_order=True)


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
    assert np.all(volumes(work.places, work.mesh.cells[rows]) > 0)
    fresh = np.empty(len(rows))
    measure_cells(work.mesh.judge, work.mesh.points, work.mesh.cells[rows], fresh)
    np.testing.assert_allclose(work.mesh.quality[rows], fresh, atol=1e-9)


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
