"""The steps of a run in pieces: each reads files, writes files, and says a little of them.

A step depends on nothing else, so it may run anywhere, in any order, and again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import formats, validity
from ..cells import SIMPLICES
from ..errors import BadMeshError, UnsupportedMeshError, naming
from ..formats import Encoding, Source
from ..formats.vtk.pieces import ALIASES
from ..jobs.admission import READABLE, not_valid
from ..jobs.optimize_mesh import Task, accepted, optimize_mesh
from ..jobs.quality_arrays import Q, with_quality
from ..jobs.split_file import own_cells
from ..mesh.adjacency import distinct_rows, places_in
from ..mesh.cast import cast
from ..mesh.model import Array, Mesh, top_blocks
from ..mesh.pieces import (
    IDS,
    border_facets,
    border_vertices,
    merged,
    part_of,
    with_lower_cells,
)
from ..mesh.second_order import is_second_order
from ..mesh.tags import OWN, labels, tags_of
from ..quality.target import target
from .figures import figures_of, to_json
from .layers import given_by, near
from .numbering import Numbered, count_new, numbered_in, settled
from .store import Store

# What a piece may look like that the whole does not: its border meets itself, or has a hole in it
# where another piece has a cell.
OF_PIECES = ("M206", "M211")
WAS_SHARED = f"{OWN}shared"  # points that several pieces had before cells were given


@dataclass(frozen=True)
class Job:
    """What all steps know.

    Attributes
    ----------
    sources : tuple of Path
        The files of the pieces.
    store : Store
    task : Task
        What to make of each piece.
    regions : tuple of str
        The arrays that make regions.
    numbered : tuple of Numbered
        The arrays that number points or cells.
    """

    sources: tuple[Path, ...]
    store: Store
    task: Task
    regions: tuple[str, ...] = ()
    numbered: tuple[Numbered, ...] = ()

    def __len__(self) -> int:
        return len(self.sources)


def survey(job: Job, i: int) -> dict[str, Any]:
    """Take a piece over: its own cells, and the numbers of its points through all pieces.

    Where its file has no such numbers, the places of the points on its border are written.
    """
    path = job.sources[i]
    mesh, source = formats.read(path, None, job.task.max_size)
    mesh = own_cells(mesh)
    with naming(path):
        report = validity.check(mesh, READABLE)
        if not report.is_valid:
            raise BadMeshError(not_valid(report))
        if is_second_order(mesh):
            raise UnsupportedMeshError("pieces are of cells of first order")
    ids = next((name for name in mesh.point_data if name.lower() in ALIASES), None)
    if ids is not None:
        values = mesh.point_data.pop(ids)
        mesh.point_data[IDS] = values.astype(np.int64)
    top = top_blocks(mesh)
    job.store.put(0, f"in{i}", mesh)
    facts = _border(job, 0, i, mesh)
    return facts | {
        "has_ids": ids is not None,
        "n_points": len(mesh.points),
        "n_cells": sum(len(block.cells) for block in top),
        "types": sorted({block.type for block in top}),
        "numbered": numbered_in(mesh),
        "arrays": sorted({*mesh.point_data, *(n for b in mesh.blocks for n in b.data)}),
        "labels": {n: None if v is None else v.tolist() for n, v in labels(top).items()},
        "binary": source.encoding.binary,
        "compressed": source.encoding.compressed,
    }


def number(job: Job, i: int, first: int) -> dict[str, Any]:
    """Give the points of a piece numbers: those on its border as the store has them, the others
    from a first one on."""
    mesh = job.store.get(0, f"in{i}")
    border = border_vertices(mesh)
    ids = np.full(len(mesh.points), -1)
    ids[border] = job.store.array(0, f"numbers{i}")
    inside = np.flatnonzero(ids < 0)
    ids[inside] = np.arange(first, first + len(inside))
    mesh.point_data[IDS] = ids
    job.store.put(0, f"in{i}", mesh)
    _border(job, 0, i, mesh)
    return {"numbered": numbered_in(mesh)}


def improve(
    job: Job,
    turn: int,
    i: int,
    givers: Sequence[int],
    first: int,
    bad: float,
    near_shared: bool,
) -> dict[str, Any]:
    """Put a piece together, and optimize it; later than at first near some of its cells alone.

    Parameters
    ----------
    givers : sequence of int
        The pieces that gave it cells in the turn before.
    first : int
        The first number of what is new.
    bad : float
        It is worked on near cells with a greater Q.
    near_shared : bool
        And near points that several pieces had.
    """
    store = job.store
    if turn == 0:
        mesh = store.get(0, f"in{i}")
    else:
        gifts = [store.get(turn - 1, f"gift{j}to{i}") for j in givers]
        mesh = merged([store.get(turn - 1, f"rest{i}"), *gifts])
        store.put(turn, f"in{i}", mesh)
    facts = _border(job, turn, i, mesh)
    given = accepted(replace(job.task, request=replace(
        job.task.request, allow=(*(job.task.request.allow or ()), *OF_PIECES))))  # fmt: skip
    marked = (mesh.point_data.pop(WAS_SHARED, np.zeros(0)) != 0) & near_shared
    stays = None
    if turn > 0:
        for block in top_blocks(with_quality(mesh, given.plan.measure)):
            marked[block.cells[~(block.data[Q] <= bad)]] = True
        masks = [~mask for mask in near(mesh, marked)]
        stays = masks if any(mask.any() for mask in masks) else None
    mesh = replace(mesh, regions=job.regions)
    encoding = Encoding("vtu", "1.0", binary=True)
    source = Source(job.sources[i], encoding, "")
    done = optimize_mesh(given, mesh, source, stays=stays, any_gain=not near_shared)
    result = done.result.mesh
    n_new = count_new(mesh, result, job.numbered, first)
    store.put(turn, f"out{i}", replace(result, regions=None))
    before, after = (figures_of(s, i) for s in (done.result.before, done.result.after))
    return facts | {
        "n_new": n_new,
        "before": to_json(before),
        "after": to_json(after),
        "target": done.result.before.target,
        "regions": _regions(mesh),
    }


def _regions(mesh: Mesh) -> list[list[float]]:
    """The regions that a piece has cells of, each by the values of the arrays that make it."""
    tags = tags_of(top_blocks(mesh), mesh.regions)
    if not tags:
        return [[]]
    values = np.stack([tag.reshape(len(tag), -1)[:, 0] for tag in tags.values()], axis=1)
    rows: list[list[float]] = distinct_rows(values)[0].tolist()
    return rows


def give(
    job: Job, turn: int, i: int, taken: str, owner: Array, near_shared: bool
) -> dict[str, Any]:
    """Give cells near the points that several pieces have to the pieces that own these.

    Parameters
    ----------
    taken : str
        Whether the piece is as it came in ("in") or out ("out") of the turn.
    owner : (m, 2) int64
        Shared points of the piece by their number, and the owner of each.
    near_shared : bool
        Whether to look at what the boundary of the whole allows.

    Returns
    -------
    facts : dict
        To whom cells went, what the boundary of the whole allows where the piece has it, and the
        worst Q of its cells that are not near shared points.
    """
    mesh = job.store.get(turn, f"{taken}{i}")
    facts: dict[str, Any] = {"target": _target(job, turn, i, mesh) if near_shared else math.nan}
    ids = mesh.point_data[IDS]
    place = np.minimum(np.searchsorted(owner[:, 0], ids), max(len(owner) - 1, 0))
    of_point = np.full(len(ids), -1)
    if len(owner):
        of_point = np.where(owner[place, 0] == ids, owner[place, 1], -1)
    to = [np.where(own < 0, i, own) for own in given_by(mesh, i, of_point)]
    facts["apart"] = _worst(job, mesh, [~mask for mask in near(mesh, of_point >= 0)])
    mesh.point_data[WAS_SHARED] = (of_point >= 0).astype(np.uint8)
    pieces = with_lower_cells(mesh, to)
    others = sorted({int(p) for own in to for p in np.unique(own)} - {i})
    for j in others:
        job.store.put(turn, f"gift{i}to{j}", part_of(mesh, [own == j for own in pieces]))
    job.store.put(turn, f"rest{i}", part_of(mesh, [own == i for own in pieces], True))
    return facts | {"others": others}


def near_bad(job: Job, turn: int, i: int, taken: str, limit: float) -> dict[str, Any]:
    """Write down the points on the border of a piece that are near cells worse than a Q."""
    mesh = job.store.get(turn, f"{taken}{i}")
    bad = np.zeros(len(mesh.points), dtype=bool)
    for block in top_blocks(with_quality(mesh, accepted(job.task).plan.measure)):
        bad[block.cells[~(block.data[Q] <= limit)]] = True
    reached = np.zeros(len(mesh.points), dtype=bool)
    for block, mask in zip(top_blocks(mesh), near(mesh, bad), strict=True):
        reached[block.cells[mask]] = True
    job.store.put_array(turn, f"bad{i}", np.sort(mesh.point_data[IDS][reached]))
    return {}


def _worst(job: Job, mesh: Mesh, chosen: list[Array]) -> float:
    """The worst Q of some cells of a mesh, 1 where there are none."""
    judged = top_blocks(with_quality(mesh, accepted(job.task).plan.measure))
    return max(
        float(block.data[Q][mask].max(initial=1.0))
        for block, mask in zip(judged, chosen, strict=True)
    )


def _target(job: Job, turn: int, i: int, mesh: Mesh) -> float:
    """The row `target` of Table 18.3, of the facets of a piece that are the boundary of the whole,
    or lie between regions; not a number for other cells than tetrahedra and triangles."""
    measure = accepted(job.task).plan.measure
    if any(block.type not in SIMPLICES for block in top_blocks(mesh)):
        return math.nan
    part = cast(replace(mesh, regions=job.regions))
    if part.dimension == 2:
        return target(part, measure)
    ids = mesh.point_data[IDS]
    order = np.argsort(ids)
    among = order[np.searchsorted(ids, job.store.array(turn, f"among{i}"), sorter=order)]
    inside = places_in(among, part.skin, len(ids)) >= 0
    return target(part, measure, faces=part.skin[~inside])


def publish(
    job: Job,
    turn: int,
    i: int,
    taken: str,
    firsts: Array,
    counts: dict[str, Array],
    path: Path,
    encoding: Encoding,
) -> dict[str, Any]:
    """Write a piece as it is in the end.

    Parameters
    ----------
    firsts, counts
        See `numbering.settled`.
    """
    mesh = job.store.get(turn, f"{taken}{i}")
    mesh.point_data.pop(WAS_SHARED, None)
    settled(mesh, job.numbered, firsts, counts)
    formats.write(path, mesh, encoding)
    return {}


def _border(job: Job, turn: int, i: int, mesh: Mesh) -> dict[str, Any]:
    """Write down the points on the border of a piece, by number, or by place without any, and the
    triangles there."""
    vertices = border_vertices(mesh)
    known = mesh.point_data.get(IDS)
    if known is not None:
        faces = border_facets(mesh).get(3, np.empty((0, 3), np.int64))
        job.store.put_array(turn, f"faces{i}", np.sort(known[faces], axis=1))
    rows = np.sort(known[vertices]) if known is not None else mesh.points[vertices]
    job.store.put_array(turn, f"border{i}", rows)
    return {"n_border": len(vertices)}
