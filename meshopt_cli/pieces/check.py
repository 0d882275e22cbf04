"""The check of a mesh in pieces: of each by itself, and of how they fit together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import formats
from ..errors import EXIT_BAD_MESH, EXIT_DONE, MeshoptError
from ..formats.vtk.parallel import sources_of
from ..formats.vtk.pieces import ALIASES
from ..jobs.check import Task, examine_mesh
from ..jobs.split_file import own_cells
from ..mesh.adjacency import distinct_rows, same_direction
from ..mesh.model import Array, Mesh, top_blocks
from ..mesh.pieces import border_facets
from ..mesh.plane import with_depth
from ..mesh.sizes import contents, flux
from ..reports.verdict import Finding, Verdict
from ..validity.rules import RULES
from .engines import Engine, Facts
from .steps import OF_PIECES

# Rules that say something of a piece that need not hold for the whole: how its parts hang together.
OF_PARTS = ("M212", "M213")
ROUNDING = 1e-9  # of the volume: how far that of the cells may be from what the boundary encloses


def check_pieces(path: Path, task: Task, engine: Engine) -> Iterator[Verdict]:
    """Verdicts on each piece by itself, and then on the whole: how the pieces fit together.

    Parameters
    ----------
    path : Path
        Of the index of the pieces.

    Raises
    ------
    ReadError
        It cannot be read.
    StepError
    """
    sources = sources_of(path)
    found: dict[int, Facts] = {}
    following = 0
    for i, facts in engine.map(look, [(source, task) for source in sources]):
        found[i] = facts
        while following in found:
            yield found[following]["verdict"]
            following += 1
    sides = [found[i]["sides"] for i in range(len(sources))]
    if not all(sides):
        return
    yield _verdict(path, task, _together(sides))


def look(path: Path, task: Task) -> Facts:
    """Judge a piece, and tell of its border what has to fit to others."""
    try:
        mesh, source = formats.read(path, task.input_format, task.max_size)
        mesh = own_cells(mesh)
        alone = replace(task, ignore=(*task.ignore, *OF_PIECES, *OF_PARTS))
        verdict = examine_mesh(mesh, source, alone)
    except MeshoptError as error:
        text = str(error)
        text = text if text.startswith(str(path)) else f"{path}: {text}"
        return {"verdict": Verdict(str(path), error.exit_status, error=text), "sides": None}
    sides = _sides(mesh) if "M001" not in (verdict.counts or {}) else None
    return {"verdict": verdict, "sides": sides}


def _sides(mesh: Mesh) -> dict[str, Any] | None:
    """The border of a piece: its points by number and place, its facets by these, its volume."""
    top = top_blocks(mesh)
    n = len(mesh.points)
    if not top or not all(((b.cells >= 0) & (b.cells < n)).all() for b in top):
        return None
    name = next((name for name in mesh.point_data if name.lower() in ALIASES), None)
    points = with_depth(mesh.points)
    facets = border_facets(mesh)
    used = np.unique(np.concatenate([rows.ravel() for rows in facets.values()]))
    number = np.searchsorted(used, np.arange(n))
    measured = points if mesh.dimension() == 3 else points[:, :2]
    return {
        "dimension": mesh.dimension(),
        "is_flat": mesh.dimension() == 3 or len(np.unique(points[:, 2])) == 1,
        "ids": None if name is None else mesh.point_data[name][used].astype(np.int64),
        "places": points[used],
        "facets": {width: number[rows] for width, rows in facets.items()},
        "volume": math.fsum(float(contents(measured, b.cells, _family(b.type)).sum()) for b in top),
    }


def _family(cell_type: str) -> str:
    from ..cells import family_of

    family = family_of(cell_type)
    return cell_type if family is None else family.name


def _together(sides: Sequence[dict[str, Any]]) -> list[Finding]:
    """What is wrong with a mesh whose pieces are right."""
    places = np.concatenate([one["places"] for one in sides])
    at = np.unique(places + 0.0, axis=0, return_inverse=True)[1].ravel()
    if any(one["ids"] is None for one in sides):
        ids, found = at, []
    else:
        ids = np.concatenate([one["ids"] for one in sides])
        found = _misplaced(ids, at, places)
        ids = np.unique(ids, return_inverse=True)[1].ravel()
    starts = np.cumsum([0, *(len(one["places"]) for one in sides)])
    skin: list[Array] = []
    for width in sorted({w for one in sides for w in one["facets"]}):
        rows = np.concatenate([
            start + one["facets"][width]
            for start, one in zip(starts, sides, strict=False) if width in one["facets"]
        ])  # fmt: skip
        alone, wrong = _matched(rows, ids, places)
        skin.append(rows[alone])
        found += wrong
    if not found:
        found += _open_edges(skin, ids, places)
    volume = math.fsum(one["volume"] for one in sides)
    if not found and all(one["is_flat"] for one in sides):
        found += _excess(skin, places, volume, sides[0]["dimension"])
    return found


def _finding(code: str, message: str, where: Array | None = None) -> Finding:
    place = None if where is None else tuple(where.tolist())
    return Finding(code, RULES[code].severity, message, (), (), place)


def _misplaced(ids: Array, at: Array, places: Array) -> list[Finding]:
    """Points with one number in two places, and with two numbers in one."""
    pairs = distinct_rows(np.stack([ids, at], axis=1))[0]
    twice = np.flatnonzero(pairs[1:, 0] == pairs[:-1, 0])
    found = [
        _finding("M205", f"the point with the number {n} lies in several places",
                 places[np.flatnonzero(ids == n)[0]])
        for n in np.unique(pairs[twice, 0]).tolist()
    ]  # fmt: skip
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    for k in np.flatnonzero(pairs[1:, 1] == pairs[:-1, 1]).tolist():
        a, b = pairs[k, 0], pairs[k + 1, 0]
        where = places[np.flatnonzero(at == pairs[k, 1])[0]]
        found.append(_finding("M202", f"points with the numbers {a} and {b} are in one place",
                              where))  # fmt: skip
    return found


def _matched(rows: Array, ids: Array, places: Array) -> tuple[Array, list[Finding]]:
    """Which facets bound one cell of all pieces alone, (n,) bool, and what is wrong with others."""
    of_points = ids[rows]
    _, number, count = distinct_rows(np.sort(of_points, axis=1))
    centre = places[rows].mean(axis=1)
    found = [
        _finding("M204", "more than two cells of several pieces have a facet in common", centre[k])
        for k in _first_of(number, count > 2)
    ]
    order = np.argsort(number, kind="stable")
    start = (np.cumsum(count) - count)[count == 2]
    one, other = order[start], order[start + 1]
    wrong = same_direction(of_points[one], of_points[other])
    found += [
        _finding("M207", "cells of two pieces run round their common facet in one direction",
                 centre[k])
        for k in one[wrong].tolist()
    ]  # fmt: skip
    return count[number] == 1, found


def _first_of(number: Array, chosen: Array) -> list[int]:
    """The first row of each of some groups."""
    first = np.full(len(chosen), len(number))
    np.minimum.at(first, number, np.arange(len(number)))
    rows: list[int] = first[chosen].tolist()
    return rows


def _open_edges(skin: list[Array], ids: Array, places: Array) -> list[Finding]:
    """Where facets of the boundary meet otherwise than in pairs."""
    ends = []
    for rows in skin:
        width = rows.shape[1]
        if width == 2:
            ends += [rows[:, [0]], rows[:, [1]]]
        else:
            ends += [rows[:, [k, (k + 1) % width]] for k in range(width)]
    if not ends:
        return []
    edges = np.concatenate(ends)
    _, number, count = distinct_rows(np.sort(ids[edges], axis=1))
    odd = _first_of(number, count % 2 == 1)
    return [
        _finding("M206", "facets of the boundary of all pieces do not meet in pairs here",
                 places[edges[k]].mean(axis=0))
        for k in odd
    ]  # fmt: skip


def _excess(skin: list[Array], places: Array, volume: float, dimension: int) -> list[Finding]:
    """Whether the cells have the volume that the boundary of all pieces encloses."""
    points = places - places.mean(axis=0)
    if dimension == 3:
        inside = math.fsum(float(flux(points[rows]).sum()) for rows in skin)
        what = "volumes"
    else:
        a, b = (points[np.concatenate(skin)[:, k], :2] for k in (0, 1))
        inside = float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / 2
        what = "areas"
    if abs(abs(volume) - abs(inside)) <= ROUNDING * abs(volume):
        return []
    message = (
        f"the {what} of all cells are {abs(volume):.6g}, the boundary encloses {abs(inside):.6g}"
    )
    return [_finding("M210", message)]


def _verdict(path: Path, task: Task, found: list[Finding]) -> Verdict:
    codes = set(task.checked)
    found = [one for one in found if one.code in codes]
    counts: dict[str, int] = {}
    for one in found:
        counts[one.code] = counts.get(one.code, 0) + 1
    listed: list[Finding] = []
    for code in counts:
        listed += [one for one in found if one.code == code][: task.limit]
    severities = {code: RULES[code].severity for code in counts}
    status = EXIT_BAD_MESH if found else EXIT_DONE
    return Verdict(str(path), status, task.checked, counts, severities, tuple(listed), "pvtu", "")
