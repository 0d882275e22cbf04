"""Quality as arrays on the cells of a mesh, to be looked at in ParaView or Gmsh."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..cells import FAMILIES, family_of
from ..mesh.model import Array, Mesh, top_blocks
from ..mesh.tags import OWN, regions_of
from ..quality.measurable import Part, measurable
from ..quality.measures import Measure
from ..quality.statistics import values_of
from ..quality.summary import classified

# Q by the measure; the number of the type of triangles and tetrahedra, -1 for other cells; the
# region, counted from 0.
Q, CLASS, REGION = ARRAYS = f"{OWN}Q", f"{OWN}class", f"{OWN}region"


def without_quality(mesh: Mesh) -> tuple[Mesh, tuple[str, ...]]:
    """A mesh without such arrays, which are those of a mesh that it was, and their names."""
    stale = [name for name in ARRAYS if any(name in block.data for block in mesh.blocks)]
    if not stale:
        return mesh, ()
    blocks = [
        replace(block, data={n: a for n, a in block.data.items() if n not in stale})
        for block in mesh.blocks
    ]
    return replace(mesh, blocks=blocks), tuple(stale)


def with_quality(mesh: Mesh, measure: Measure, others: Iterable[Measure] = ()) -> Mesh:
    """A mesh with arrays on its cells of greatest dimension.

    Parameters
    ----------
    measure : Measure
        What Q is; not a number for cells that do not have it.
    others : iterable of Measure
        More to be measured, as arrays by the names of the measures.
    """
    part = measurable(mesh)
    values = {Q: _by_family(part, measure)}
    values |= {f"{OWN}{other.name}": _by_family(part, other) for other in others}
    types = {
        family: classified(part.points, cells) if FAMILIES[family].is_simplex
        else np.full(len(cells), -1)
        for family, cells in part.cells.items()
    }  # fmt: skip
    top = top_blocks(mesh)
    region = regions_of(top, mesh.regions)
    blocks, first, rows = [], 0, dict.fromkeys(part.cells, 0)
    for block in mesh.blocks:
        if not any(block is one for one in top):
            blocks.append(block)
            continue
        n = len(block.cells)
        data = {REGION: region[first : first + n]}
        first += n
        if (family := family_of(block.type)) is not None:
            own = slice(rows[family.name], rows[family.name] + n)
            rows[family.name] += n
            data |= {name: found[family.name][own] for name, found in values.items()}
            data[CLASS] = types[family.name][own]
        else:
            data |= {name: np.full(n, np.nan) for name in values} | {CLASS: np.full(n, -1)}
        blocks.append(replace(block, data={**block.data, **data}))
    return replace(mesh, blocks=blocks)


def on_cells(mesh: Mesh, measure: Measure) -> Array:
    """A measure of every cell of a mesh, as its source numbers them, (n,); else NaN."""
    marked = with_quality(mesh, measure)
    values = [b.data.get(Q, np.full(len(b.cells), np.nan)) for b in marked.blocks]
    ends = np.cumsum([len(one) for one in values])
    numbers = [
        np.arange(end - len(block.cells), end) if block.numbers is None else block.numbers
        for block, end in zip(mesh.blocks, ends, strict=True)
    ]
    number = np.concatenate([np.empty(0, np.int64), *numbers])
    found = np.full(int(number.max(initial=-1)) + 1, np.nan)
    found[number] = np.concatenate([np.empty(0), *values])
    return found


def _by_family(part: Part, measure: Measure) -> dict[str, Array]:
    return {
        family: values_of(part, measure, family)
        if family in measure.ways
        else np.full(len(cells), np.nan)
        for family, cells in part.cells.items()
    }
