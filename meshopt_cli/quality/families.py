"""The figures of meshes of any cells, a family at a time and all together."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ..cells import FAMILIES
from ..errors import ConfigError
from ..mesh import adjacency
from ..mesh.model import Array, Mesh
from .census import census
from .measurable import Part
from .measures import MEASURES, Measure
from .summary import Summary, count_vertices, figures, summarize, types_of
from .worst import in_space, worst_cells, worst_of


def summarize_mesh(
    mesh: Mesh, part: Part, measure: Measure, others: tuple[Measure, ...] = ()
) -> Summary:
    """All figures of what can be measured of a mesh.

    Parameters
    ----------
    part : Part
        What `measurable` takes from it.
    measure : Measure
        Families that do not have it are left out.
    others : tuple of Measure
        Measures whose worst Q is wanted as well.

    Raises
    ------
    ConfigError
        No cell of the mesh has the measure.
    """
    families = [family for family in part.cells if family in measure.ways]
    if not families:
        kinds = " and ".join(FAMILIES[family].plural for family in part.cells)
        raise ConfigError(f"{measure.name} is no measure of {kinds}: see meshopt list measures")
    if part.simplices is not None and measure.is_direct(families[0]):
        return summarize(part.simplices, measure, others)
    parts = tuple(_of_family(mesh, part, family, measure, others) for family in families)
    summary = parts[0] if len(parts) == 1 else _whole(part, parts)
    return replace(summary, census=census(mesh if part.simplices is None else part.simplices))


def _of_family(
    mesh: Mesh, part: Part, family: str, measure: Measure, others: tuple[Measure, ...]
) -> Summary:
    points, cells = part.points, part.cells[family]
    turned = part.is_turned(family)
    kind = "dihedral" if FAMILIES[family].dimension == 3 else "corner"
    least, greatest = (
        MEASURES[f"{kind}-{end}"].of(points, cells, family) for end in ("min", "max")
    )
    degradation = np.where(turned, math.inf, measure.of(points, cells, family))
    if part.simplices is None:
        centres = partial(_centres, mesh, cells)
    else:
        centres = partial(in_space, part.simplices)
    return Summary(
        measure=measure.name,
        dimension=FAMILIES[family].dimension,
        family=family,
        n_points=count_vertices(cells, len(points)),
        **figures(degradation),
        # Over an edge of the plane stands a square, or a regular triangle.
        target=1.0 if FAMILIES[family].dimension == 2 else math.nan,
        angle_min=float(least.min()),
        angle_max=float(greatest.max()),
        worst_by_measure={
            m.name: math.inf if turned.any() else float(m.of(points, cells, family).max())
            for m in others
            if family in m.ways
        },
        types=types_of(points, cells) if FAMILIES[family].is_simplex else {},
        worst_cells=worst_cells(degradation, points, cells, family, centres),
    )


def _centres(mesh: Mesh, cells: Array, rows: Array) -> Array:
    """Where some of the cells of a family are, (n, 3)."""
    centres = np.zeros((len(rows), 3))
    centres[:, : mesh.points.shape[1]] = mesh.points[cells[rows]].mean(axis=1)
    return centres


def _whole(part: Part, parts: tuple[Summary, ...]) -> Summary:
    """The figures of all families together."""
    used = np.zeros(len(part.points), dtype=bool)
    for summary in parts:
        used |= adjacency.is_used(part.cells[summary.family], len(part.points))
    sound = [summary.n_cells - summary.n_invalid for summary in parts]
    named = dict.fromkeys(name for summary in parts for name in summary.worst_by_measure)
    return Summary(
        measure=parts[0].measure,
        dimension=parts[0].dimension,
        family="",
        n_cells=sum(summary.n_cells for summary in parts),
        n_points=int(np.count_nonzero(used)),
        counts=tuple(int(n) for n in np.sum([summary.counts for summary in parts], axis=0)),
        n_invalid=sum(summary.n_invalid for summary in parts),
        worst=max(summary.worst for summary in parts),
        mean=_mean(parts, sound),
        best=min(summary.best for summary in parts),
        target=float(np.max([summary.target for summary in parts])),
        angle_min=min(summary.angle_min for summary in parts),
        angle_max=max(summary.angle_max for summary in parts),
        worst_by_measure={
            name: max(s.worst_by_measure[name] for s in parts if name in s.worst_by_measure)
            for name in named
        },
        types={kind: n for summary in parts for kind, n in summary.types.items()},
        parts=parts,
        worst_cells=worst_of(summary.worst_cells for summary in parts),
    )


def _mean(parts: tuple[Summary, ...], sound: list[int]) -> float:
    """Mean Q of all cells that have one."""
    if not any(sound):
        return math.inf
    return sum(n * s.mean for n, s in zip(sound, parts, strict=True) if n) / sum(sound)
