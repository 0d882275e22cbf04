"""The nodes of a Gmsh file, of all versions, with the entities and parameters they have there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.model import Array
from ..sniff import GmshHeader, UnreadableError
from .numbers import COUNT, INTEGER, REAL, Numbers

N_PARAMETERS = 2  # of a node on a surface, the most that there are
_NODE = ((INTEGER, 1), (REAL, 3))  # number and coordinates


@dataclass
class Nodes:
    """What stands in $Nodes, in the order of the file.

    Attributes
    ----------
    numbers : (n,) int64
    points : (n, 3) float64
    dim_tags : (n, 2) int64, optional
        Dimension and tag of the entity that each lies on; None where the file does not say it.
    parameters : (n, 2) float64, optional
        Where a node lies on its curve or surface, NaN where that is not said.
    """

    numbers: Array
    points: Array
    dim_tags: Array | None = None
    parameters: Array | None = None


def read_nodes(name: str, content: bytes, header: GmshHeader) -> Nodes:
    """Read $Nodes, or the $ParametricNodes of versions before 3."""
    numbers = Numbers(name, content, header)
    if header.version >= 4:
        return _by_entity(numbers, header.version < 4.1)
    n = numbers.line_count()
    if header.version >= 3 or name == "ParametricNodes":
        return _by_runs(numbers, n, header.version >= 3)
    labels, points = numbers.rows(n, (INTEGER, 1), (REAL, 3))
    return Nodes(labels[:, 0], points)


def _by_entity(numbers: Numbers, old: bool) -> Nodes:
    """Versions 4: in blocks, each with one entity; before 4.1 node by node, and tag first."""
    n_blocks, n, *_ = numbers.take(COUNT, 2 if old else 4).tolist()
    labels, points, dim_tags, parameters = [], [], [], []
    for _ in range(n_blocks):
        dimension, tag, parametric = numbers.take(INTEGER, 3).tolist()
        if old:
            dimension, tag = tag, dimension
        if not 0 <= dimension <= 3:
            raise UnreadableError(f"$Nodes has an entity of dimension {dimension}")
        count = numbers.one()
        more = (REAL, dimension if parametric else 0)
        if old:
            label, xyz, uv = numbers.rows(count, (INTEGER, 1), (REAL, 3), more)
        else:
            (label,) = numbers.rows(count, (COUNT, 1))
            xyz, uv = numbers.rows(count, (REAL, 3), more)
        labels.append(label[:, 0])
        points.append(xyz)
        dim_tags.append(np.tile(np.array([dimension, tag]), (count, 1)))
        parameters.append(_padded(uv, dimension))
    found = sum(map(len, labels))
    if found != n:
        raise UnreadableError(f"$Nodes announces {n} nodes, and {found} are found")
    return _joined(labels, points, dim_tags, parameters)


def _padded(parameters: Array, dimension: int) -> Array:
    """Parameters of nodes on an entity, (n, 2): those inside a volume mean nothing."""
    wide = np.full((len(parameters), N_PARAMETERS), np.nan)
    width = parameters.shape[1] if dimension <= N_PARAMETERS else 0
    wide[:, :width] = parameters[:, :width]
    return wide


def _by_runs(numbers: Numbers, n: int, new: bool) -> Nodes:
    """Nodes with an entity, and as many parameters as it has dimensions.

    Parameters
    ----------
    new : bool
        As in version 3, where the tag comes before the dimension, nothing follows a tag of 0,
        and nodes inside volumes have three parameters; before, they have none.
    """
    labels, points, dim_tags, parameters = [], [], [], []
    done = 0
    while done < n:
        alone = new and numbers.peek(*_NODE, (INTEGER, 1))[2] == [0]
        entity = (INTEGER, 1 if alone else 2)
        tag, dimension = [*numbers.peek(*_NODE, entity)[2], -1][:2][:: 1 if new else -1]
        if not -1 + (not alone) <= dimension <= 3:
            raise UnreadableError(f"${numbers.name} has an entity of dimension {dimension}")
        width = 0 if dimension == 3 and not new else max(dimension, 0)
        label, xyz, _, uv = numbers.run(n - done, [*_NODE, entity, (REAL, width)], (2,))
        labels.append(label[:, 0])
        points.append(xyz)
        dim_tags.append(np.tile(np.array([dimension, tag]), (len(label), 1)))
        parameters.append(_padded(uv, dimension))
        done += len(label)
    nodes = _joined(labels, points, dim_tags, parameters)
    if any((entity[:, 0] < 0).any() for entity in dim_tags):
        return Nodes(nodes.numbers, nodes.points)
    return nodes


def _joined(
    labels: list[Array], points: list[Array], dim_tags: list[Array], parameters: list[Array]
) -> Nodes:
    """One table of many blocks."""
    given = any(np.isfinite(uv).any() for uv in parameters)
    return Nodes(
        np.concatenate([np.empty(0, np.int64), *labels]),
        np.concatenate([np.empty((0, 3)), *points]),
        np.concatenate([np.empty((0, 2), np.int64), *dim_tags]),
        np.concatenate(parameters) if given else None,
    )
