"""Points in one place, and points that no cell has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..cells import dimension_of
from ..mesh.model import Array, Mesh
from ..mesh.tags import FLAGS, is_identity
from ..validity.examination import Examination
from .edit import without_points
from .model import Mended


def merge(study: Examination) -> Mended:
    """Make one of the points in one place (M202): the first of them, with its arrays."""
    mesh, first = study.mesh, study.first_points
    gone = first != np.arange(len(first))
    n = int(gone.sum())
    if not n:
        return Mended(mesh, {"points merged": 0})
    notes = []
    if differing := _differing(mesh, first, gone):
        names = ", ".join(differing)
        notes.append(f"of points that were merged, the first one's values are kept: {names}")
    merged = without_points(_with_flags_of_all(mesh, first), first, gone)
    return Mended(merged, {"points merged": n}, tuple(notes))


def _with_flags_of_all(mesh: Mesh, first: Array) -> Mesh:
    """The mesh with each flag of a point on the one that takes its place."""
    data = dict(mesh.point_data)
    for name in data.keys() & set(FLAGS):
        values = data[name].copy()
        np.maximum.at(values, first, data[name])
        data[name] = values
    return replace(mesh, point_data=data)


def _differing(mesh: Mesh, first: Array, gone: Array) -> list[str]:
    """Arrays that say something else of a point than of the one that takes its place."""
    found = []
    for name, values in mesh.point_data.items():
        if name in FLAGS or is_identity(name, values):
            continue
        one, other = values[gone], values[first[gone]]
        same = one == other
        if values.dtype.kind == "f":
            same |= np.isnan(one) & np.isnan(other)
        if not np.all(same):
            found.append(name)
    return found


def drop_unused(study: Examination) -> Mended:
    """Drop the points that no cell has (M203), not even one of type vertex."""
    mesh = study.mesh
    unused = ~study.used
    declared = np.zeros(study.n_points, bool)
    for block in mesh.blocks:
        if dimension_of(block.type) == 0:
            rows = block.cells.ravel()
            declared[rows[(rows >= 0) & (rows < study.n_points)]] = True
    gone = unused & ~declared
    left = []
    if n_left := int((unused & declared).sum()):
        left.append(f"unused points that cells of type vertex declare: {n_left:,} left")
    dropped = without_points(mesh, np.arange(study.n_points), gone) if gone.any() else mesh
    return Mended(dropped, {"unused points dropped": int(gone.sum())}, left=tuple(left))
