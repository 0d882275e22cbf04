"""A boundary whose edges may be split: which of them, what became of them, and that it stayed."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from ..cells import SIMPLICES
from ..errors import ConfigError, InvariantError
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Mesh, main_blocks, main_type
from ..mesh.tags import REQUIRED, flagged
from .proof import prove_vertices

Array = np.ndarray

# How far from its edge a new vertex may lie, as a part of the extent of the mesh.
OFF = {False: 1e-12, True: 1e-6}  # by whether coordinates are stored in single precision


def splittable(mesh: Mesh, source: Simplices) -> Array:
    """Edges of the boundary and of interfaces that may be split, (n, 2) int64.

    All may, but those that the file requires, those of required cells, and those between vertices
    of periodic sides or of cells that are no simplices: what they match stays as it is.

    Parameters
    ----------
    source : Simplices
        What `cast` gave for the mesh.

    Raises
    ------
    ConfigError
        The mesh is not of triangles.
    """
    if source.dimension != 2:
        raise ConfigError("--boundary split is for triangles of a plane: leave it out here")
    n_points = len(source.points)
    held = np.zeros(n_points, bool)
    for block in mesh.blocks:
        if block.type not in SIMPLICES:
            held[block.cells.ravel()] = True
    for link in mesh.periodic:
        held[link.pairs.ravel()] = True
    blocks = [*main_blocks(mesh, main_type(mesh)), *(b for b in mesh.blocks if b.type == "line")]
    kept = [b.cells[flagged(b.data[REQUIRED])] for b in blocks if REQUIRED in b.data]
    required = [adjacency.facets(rows) if rows.shape[1] == 3 else rows for rows in kept]
    edges = source.skin[~held[source.skin].all(axis=1)]
    if required:
        edges = edges[adjacency.places_in(np.concatenate(required), edges, n_points) < 0]
    return edges


def chains(before: Simplices, worked: Simplices, origin: Array) -> dict[tuple[int, int], list[int]]:
    """What became of the edges of a boundary: by its two vertices, all that lie on each now.

    Parameters
    ----------
    worked : Simplices
        New vertices of its skin lie on one edge of `before` each.
    origin : (np',) int64
        The point of `before` that each point of `worked` was, -1 for a new one.

    Returns
    -------
    chains : dict
        Keys are points of `before`, the lesser one first; values points of `worked`, from there
        to the other one.
    """
    pairs = np.sort(worked.skin, axis=1)
    around: dict[int, set[int]] = {}
    for a, b in pairs.tolist():
        around.setdefault(a, set()).add(b)
        around.setdefault(b, set()).add(a)
    found: dict[tuple[int, int], list[int]] = {}
    for start, others in around.items():
        if origin[start] < 0:
            continue
        for other in others:
            chain = [start, other]
            while origin[chain[-1]] < 0:
                ahead = around[chain[-1]] - {chain[-2]}
                if len(ahead) != 1:
                    raise InvariantError("a new vertex of the boundary lies on no edge of it")
                chain.append(ahead.pop())
            ends = int(origin[start]), int(origin[chain[-1]])
            if ends[0] < ends[1]:
                found[ends] = chain
    return found


def declared_anew(
    mesh: Mesh, result: Mesh, before: Simplices, worked: Simplices, origin: Array
) -> Mesh:
    """Declare what the declared edges of a mesh were split into as they were declared.

    Parameters
    ----------
    mesh, result : Mesh
        Before the work, and after it as `cast.with_simplices` gives it.
    """
    if not np.any(origin[worked.skin] < 0):
        return result
    found = chains(before, worked, origin)
    blocks = []
    for block in result.blocks:
        if block.type != "line" or not len(block.cells):
            blocks.append(block)
            continue
        cells: list[list[int]] = []
        rows: list[int] = []
        for row, (a, b) in enumerate(block.cells.tolist()):
            ends = int(origin[a]), int(origin[b])
            chain = found.get((min(ends), max(ends)), [a, b])
            chain = chain if chain[0] == a else chain[::-1]
            cells += [[p, q] for p, q in itertools.pairwise(chain)]
            rows += [row] * (len(chain) - 1)
        data = {name: values[rows] for name, values in block.data.items()}
        blocks.append(replace(block, cells=np.array(cells, np.int64), data=data, numbers=None))
    return replace(result, blocks=blocks)


def prove_split(
    before: Simplices,
    worked: Simplices,
    points_before: Array,
    points_after: Array,
    origin: Array,
) -> None:
    """Compare a boundary that was split with that of the input.

    Parameters
    ----------
    worked : Simplices
        In the frame of `before`.
    points_before, points_after : (np, 2 or 3) array
        As the files have them.

    Raises
    ------
    InvariantError
        An edge is not covered by what it was split into, or a vertex of the boundary moved.
    """
    found = chains(before, worked, origin)
    wanted = {(min(a, b), max(a, b)) for a, b in before.skin.tolist()}
    if wanted != set(found):
        raise InvariantError("the edges of the boundary or of an interface changed")
    prove_vertices(before, points_before, points_after, origin)
    extent = float(np.ptp(before.points[before.skin].reshape(-1, 3), axis=0).max())
    for (a, b), chain in found.items():
        if len(chain) == 2:
            continue
        start, along = before.points[a], before.points[b] - before.points[a]
        places = worked.points[chain] - start
        part = places @ along / (along @ along)
        off = np.abs(places - part[:, None] * along).max()
        if off > OFF[before.single] * extent or np.any(np.diff(part) <= 0.0):
            raise InvariantError("a new vertex of the boundary does not lie on its edge")
