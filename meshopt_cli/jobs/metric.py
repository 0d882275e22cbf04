"""The metric that a user asks for, and a mesh judged by it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .. import formats
from ..cells import family_of
from ..errors import ConfigError, WriteError, hint, reason
from ..formats import MEMORY, Source
from ..formats.medit_sol import SCALAR, TENSOR, Solution, is_sol, read_sol, write_sol
from ..mesh.model import Array, Mesh, top_blocks
from ..mesh.tags import OWN
from ..metric.domain import Domain, domain_of
from ..metric.field import (
    MEDIT,
    VTK,
    Metric,
    fitted,
    from_array,
    in_order,
    require,
    require_definite,
)
from ..metric.formula import Formula
from ..metric.implied import implied
from ..metric.shaping import AS_IT_IS, Shaping
from ..metric.sizes import Sizes, sizes_of
from ..metric.summary import Judged, judge
from ..quality.measurable import Part
from ..quality.measures import Measure

log = logging.getLogger("meshopt")

IMPLIED = "implied"
# Formats whose symmetric tensors have the order of VTK.
OF_VTK = ("vtk", "vtu", MEMORY.format)

# Arrays on cells: Q in the metric, and how far a cell is from a unit one and an optimal one.
ARRAYS = tuple(f"{OWN}metric-{what}" for what in ("Q", "unit", "optimal"))


@dataclass(frozen=True)
class Asked:
    """Where a metric is to come from: formulas for sizes, or else what a name says.

    Attributes
    ----------
    name : str
        `IMPLIED`, a file called `.sol` or `.solb`, or an array on the points of the mesh.
    sizes : Sizes, optional
    shaping : Shaping
        What is made of it.
    values : (np,) or (np, k) array, optional
        The metric itself, tensors in the order of VTK.
    """

    name: str = ""
    sizes: Sizes | None = None
    shaping: Shaping = AS_IT_IS
    values: Array | None = field(default=None, compare=False)

    @property
    def path(self) -> Path | None:
        """The file that is named, if one is."""
        named = Path(self.name)
        return named if self.sizes is None and is_sol(named) else None

    @property
    def size(self) -> Formula | None:
        """The formula that says it all, in every point; else the metric is known at vertices."""
        return self.sizes.everywhere if self.sizes and self.shaping.is_idle else None


def asked_for(
    metric: str | None, size: str | Sequence[str] | None, **options: float | None
) -> Asked | None:
    """What `--metric` and `--size` say; None where there is neither.

    Parameters
    ----------
    size : str or sequence of str, optional
        See `metric.sizes.sizes_of`.
    options : float, optional
        Those of `Shaping`.

    Raises
    ------
    ConfigError
        There are both, a formula is none, or there is nothing to shape.
    """
    shaping = Shaping(**options)
    sizes = [size] if isinstance(size, str) else list(size or ())
    if metric is not None and sizes:
        raise ConfigError("--metric and --size exclude each other")
    if sizes:
        return Asked(sizes=sizes_of(sizes), shaping=shaping)
    if metric is not None:
        return Asked(metric, shaping=shaping)
    if not shaping.is_idle:
        raise ConfigError(f"{shaping.first} goes with --metric or --size")
    return None


def judge_by(
    asked: Asked,
    mesh: Mesh,
    source: Source,
    part: Part,
    measure: Measure,
    max_size: int | None = None,
) -> Judged:
    """Judge a mesh by the metric that is asked for.

    Parameters
    ----------
    source : Source
        The file that the mesh was read from.
    part : Part
        What `measurable` takes from the mesh: it knows which cells are turned the wrong way.
    max_size : int, optional
        See `formats.read`: for the file of the metric.

    Raises
    ------
    ConfigError
        There is no such metric, it does not fit the mesh, or is none at some vertices.
    ReadError
        Its file cannot be read.
    """
    domain = domain_of(mesh)
    metric = metric_on(asked, mesh, source, domain, max_size)
    turned = {family: part.is_turned(family) for family in domain.cells}
    return judge(domain, turned, metric, measure)


def metric_on(
    asked: Asked, mesh: Mesh, source: Source, domain: Domain, max_size: int | None = None
) -> Metric:
    """The metric that is asked for, with a row for each point of a mesh; see `judge_by`."""
    name = formats.numbering(source.encoding, mesh).point
    used = domain.used
    values: Array
    order: str | None = None
    if asked.sizes is not None:
        values, told = _of_sizes(asked.sizes, mesh, used, name), f"size {asked.sizes}"
    elif asked.values is not None:
        values, told, order = asked.values, "the array given", VTK
    elif asked.name == IMPLIED:
        made = implied(domain.points, domain.cells, domain.is_flat)
        values, told = made.values, made.source
    elif asked.path is not None:
        values, told = _of_file(asked.path, max_size)
        order = MEDIT
    elif asked.name in mesh.point_data:
        values, told = mesh.point_data[asked.name], f"array {asked.name}"
        order = VTK if source.encoding.format in OF_VTK else MEDIT
    else:
        known = [*mesh.point_data, IMPLIED]
        raise ConfigError(
            f"no array {asked.name!r} on the points{hint(asked.name, known)}; files of metrics "
            "end in .sol or .solb"
        )
    metric = fitted(from_array(values, used, told, order, name), domain.is_flat)
    metric = require_definite(metric, used, name)
    return metric if asked.shaping.is_idle else asked.shaping.of(metric, domain)


def _of_sizes(sizes: Sizes, mesh: Mesh, used: Array, name: Callable[[int], str]) -> Array:
    """Sizes at the points of a mesh; where no formula holds, the first vertices are named."""
    values = sizes.at(mesh)
    if sizes.rest is None:
        without = "no --size holds (one without a name is for all that has no other)"
        require(used, values != np.inf, without, name)
    return values


def _of_file(path: Path, max_size: int | None) -> tuple[Array, str]:
    """The field of a file that is the metric, and what it is called: the first tensor, else the
    first scalar."""
    fields = read_sol(path, max_size).fields
    for wanted, what in ((TENSOR, "tensor"), (SCALAR, "scalar")):
        for number, (kind, values) in enumerate(fields, 1):
            if kind == wanted:
                told = path.name
                if len(fields) > 1:
                    told += f", field {number}"
                    log.warning("%s: of %d fields, the first %s is the metric: field %d",
                                path, len(fields), what, number)  # fmt: skip
                return values, told
    raise ConfigError(f"{path}: no field in it is a scalar or a symmetric tensor")


def with_metric(mesh: Mesh, metric: Metric, where: str, file_format: str) -> Mesh:
    """Write a metric to a file of its own, or put it on the points of a mesh.

    Parameters
    ----------
    where : str
        A file called `.sol` or `.solb`, or else the name of the array.
    file_format : str
        Of the file that the mesh is to be in, by which tensors have their order.

    Raises
    ------
    WriteError
        The file cannot be written.
    """
    path = Path(where)
    if is_sol(path):
        kind = SCALAR if metric.is_isotropic else TENSOR
        try:
            write_sol(path, Solution(metric.width, [(kind, metric.values)]))
        except OSError as error:
            raise WriteError(f"{path}: cannot be written: {reason(error)}") from error
        return mesh
    values = in_order(metric, VTK if file_format in OF_VTK else MEDIT)
    return replace(mesh, point_data={**mesh.point_data, where: values})


def with_judged(mesh: Mesh, judged: Judged) -> Mesh:
    """A mesh with `ARRAYS` on its cells of greatest dimension, not a number where there is none."""
    top, blocks = top_blocks(mesh), []
    rows: dict[str, int] = {}
    for block in mesh.blocks:
        family = family_of(block.type)
        if family is None or not any(block is one for one in top):
            blocks.append(block)
            continue
        first = rows.get(family.name, 0)
        rows[family.name] = last = first + len(block.cells)
        parts = (judged.quality, judged.unit, judged.optimal)
        none = np.full(last, np.nan)
        data = {name: found.get(family.name, none)[first:last]
                for name, found in zip(ARRAYS, parts, strict=True)}  # fmt: skip
        blocks.append(replace(block, data={**block.data, **data}))
    return replace(mesh, blocks=blocks)
