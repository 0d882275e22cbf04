"""Work on some cells of a mesh alone: which stay, and how they are put back as they were."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import validity
from ..boundary.policy import Policy, Split
from ..constraints.grammar import KeepOff
from ..errors import BadMeshError, ConfigError, UnsupportedMeshError, hint, shown
from ..mesh.adjacency import distinct
from ..mesh.groups import cells_named, names_of_groups
from ..mesh.model import Block, Mesh, top_blocks
from ..mesh.plane import with_depth
from ..mesh.second_order import is_second_order
from ..mesh.tags import is_identity, raised
from ..plans.config import Plan, Selection
from ..plans.pipeline import Pipeline
from ..quality.measures import Measure
from .admission import READABLE, InvalidMeshError, not_valid
from .quality_arrays import Q, with_quality

Array = np.ndarray

log = logging.getLogger("meshopt")

# So many rings of cells around those that are bad enough are worked on with them: with one, hardly
# any vertex around the bad ones may move.
RINGS = 2
MOST_NAMED = 20  # groups that a message offers
_NUMBER = r"\s*(?:[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)?\s*"
_BOX = re.compile(rf"{_NUMBER}:{_NUMBER}(?:,{_NUMBER}:{_NUMBER}){{1,2}}", re.ASCII)


@dataclass(frozen=True)
class Frozen:
    """Cells that stay as they are.

    Attributes
    ----------
    masks : tuple of (n,) bool
        Of each block of cells of the greatest dimension.
    """

    masks: tuple[Array, ...]

    @property
    def is_all(self) -> bool:
        """Whether nothing is left to be worked on."""
        return all(mask.all() for mask in self.masks)

    def vertices(self, mesh: Mesh) -> Array:
        """The vertices of the cells that stay, ascending."""
        return distinct(np.concatenate([block.cells.ravel() for block in self.blocks(mesh)]))

    def blocks(self, mesh: Mesh) -> list[Block]:
        """The cells that stay, in blocks."""
        return [_chosen(b, m) for b, m in zip(top_blocks(mesh), self.masks, strict=True) if m.any()]

    def left_out_of(self, mesh: Mesh) -> Mesh:
        """The mesh without the cells that stay; all points are there."""
        rest = {
            id(block): _chosen(block, ~mask)
            for block, mask in zip(top_blocks(mesh), self.masks, strict=True)
        }
        return replace(mesh, blocks=[rest.get(id(block), block) for block in mesh.blocks])

    def put_back(self, mesh: Mesh, result: Mesh, origin: Array) -> Mesh:
        """What came of the other cells, with those that stay.

        Parameters
        ----------
        mesh : Mesh
            The whole, before.
        origin : (np',) int64
            The point of `mesh` that each point of the result was, -1 for a new one.
        """
        number = np.full(len(mesh.points), -1)
        number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
        result = self._numbered_apart(mesh, result)
        top = top_blocks(result)
        known = set.union(*(set(block.data) for block in top))
        blocks = []
        for block in self.blocks(mesh):
            data = {name: values for name, values in block.data.items() if name in known}
            blocks.append(replace(block, cells=number[block.cells], data=data))
        last = max(i for i, b in enumerate(result.blocks) if any(b is one for one in top)) + 1
        blocks = [*result.blocks[:last], *blocks, *result.blocks[last:]]
        return replace(result, blocks=blocks, regions=mesh.regions)

    def _numbered_apart(self, mesh: Mesh, result: Mesh) -> Mesh:
        """The result, whose new cells have no number that one of the cells that stay has.

        They were numbered after the greatest of the cells that were worked on.
        """
        stay, worked = self.blocks(mesh), top_blocks(self.left_out_of(mesh))
        top = top_blocks(result)
        data = {id(block): dict(block.data) for block in top}
        for name in set.union(*(set(block.data) for block in top)):
            before = [_numbers(name, blocks) for blocks in (stay, worked)]
            if not all(map(len, before)) or not is_identity(name, np.concatenate(before)):
                continue
            taken, last = (int(numbers.max()) for numbers in before)
            for own in data.values():
                if name in own and taken > last:
                    own[name] = raised(own[name], last, taken - last)
        blocks = [replace(b, data=data[id(b)]) if id(b) in data else b for b in result.blocks]
        return replace(result, blocks=blocks)

    def require_same(self, before: Mesh, after: Mesh) -> None:
        """Refuse a mesh whose cells that stay are listed the other way round than others.

        Raises
        ------
        BadMeshError
        """
        for one, other in zip(self.blocks(before), self.blocks(after), strict=True):
            if not np.array_equal(one.cells, other.cells):
                raise BadMeshError(
                    "cells that are to stay are listed the other way round than others: turn them "
                    "first, by meshopt repair --orientation"
                )


def _numbers(name: str, blocks: list[Block]) -> Array:
    """An array of one number a cell over the blocks that have it; empty where it is not such."""
    arrays = [block.data[name] for block in blocks if name in block.data]
    one_each = arrays and all(values.ndim == 1 for values in arrays)
    return np.concatenate(arrays) if one_each else np.zeros(0, np.int64)


def _chosen(block: Block, mask: Array) -> Block:
    data = {name: values[mask] for name, values in block.data.items()}
    return replace(block, cells=block.cells[mask], data=data, numbers=None)


def frozen_in(
    mesh: Mesh, plan: Plan, policy: Policy, keep_offs: tuple[KeepOff, ...]
) -> Frozen | None:
    """Which cells of a mesh stay, as a plan says; None where all are worked on.

    Raises
    ------
    ConfigError, UnsupportedMeshError, InvalidMeshError
        As those of `frozen_by`; or something does not go with it.
    """
    found = frozen_by(plan.selection, mesh, plan.measure)
    if found is not None:
        _require_selectable(mesh, plan.pipeline, policy, keep_offs)
    return found


def frozen_by(selection: Selection, mesh: Mesh, measure: Measure) -> Frozen | None:
    """Which cells of a mesh stay; None where all are worked on.

    Parameters
    ----------
    measure : Measure
        By what cells are bad.

    Raises
    ------
    ConfigError
        No cell is in one of the groups or boxes.
    InvalidMeshError
        The mesh cannot be read as one: a vertex number is out of range, say.
    """
    if selection.is_whole:
        return None
    report = validity.check(mesh, READABLE)
    if not report.is_valid:
        raise InvalidMeshError(not_valid(report), mesh, report)
    stays = [np.zeros(len(block.cells), dtype=bool) for block in top_blocks(mesh)]
    if selection.only:
        inside = [_inside(mesh, name, "only") for name in selection.only]
        stays = [~np.logical_or.reduce(masks) for masks in zip(*inside, strict=True)]
    for name in selection.freeze:
        stays = [a | b for a, b in zip(stays, _inside(mesh, name, "freeze"), strict=True)]
    if selection.below is not None:
        near = _around_worse(mesh, selection.below, measure)
        stays = [a | ~b for a, b in zip(stays, near, strict=True)]
    if not any(mask.any() for mask in stays):
        return None
    frozen = Frozen(tuple(stays))
    if frozen.is_all:
        log.warning("no cell is selected: the mesh stays as it is")
    return frozen


def _around_worse(mesh: Mesh, below: float, measure: Measure) -> list[Array]:
    """Which cells are within `RINGS` of one that is worse, by blocks."""
    judged = with_quality(mesh, measure)
    near = [~(block.data[Q] <= below) for block in top_blocks(judged)]
    for _ in range(RINGS):
        near = _touching(mesh, top_blocks(mesh), near)
    return near


def _touching(mesh: Mesh, blocks: list[Block], masks: Sequence[Array]) -> list[Array]:
    """Which cells of the greatest dimension have a vertex of some cells of blocks."""
    vertices = np.zeros(len(mesh.points), dtype=bool)
    for block, mask in zip(blocks, masks, strict=True):
        vertices[block.cells[mask]] = True
    return [vertices[block.cells].any(axis=1) for block in top_blocks(mesh)]


def _inside(mesh: Mesh, name: str, option: str) -> list[Array]:
    """Which cells of the greatest dimension are in a group or a box, or at a group of others.

    Raises
    ------
    ConfigError
        None is.
    """
    top = top_blocks(mesh)
    named = cells_named(mesh, name)
    if named is not None:
        pairs = list(zip(mesh.blocks, named, strict=True))
        within = [next(mask for b, mask in pairs if b is block) for block in top]
        if any(mask.any() for mask in within):
            return within
        within = _touching(mesh, mesh.blocks, named)
        if any(mask.any() for mask in within):
            return within
    elif _BOX.fullmatch(name):
        within = _in_box(mesh, name)
        if any(mask.any() for mask in within):
            return within
        raise ConfigError(f"--{option} {name}: the centre of no cell is in this box")
    known = names_of_groups(mesh)[:MOST_NAMED]
    there = hint(name, known) if known else ": the mesh has none"
    raise ConfigError(f"--{option}: no cell is in a group {shown(repr(name))}{there}")


def _in_box(mesh: Mesh, text: str) -> list[Array]:
    """Which cells have their centre in a box, of which an end that is left out is open."""
    points = with_depth(mesh.points)
    limits = [part.split(":") for part in text.split(",")]
    low = np.array([float(a) if a.strip() else -math.inf for a, _ in limits])
    high = np.array([float(b) if b.strip() else math.inf for _, b in limits])
    found = []
    for block in top_blocks(mesh):
        centre = points[block.cells].mean(axis=1)[:, : len(limits)]
        found.append(np.all((low <= centre) & (centre <= high), axis=1))
    return found


def _require_selectable(
    mesh: Mesh, pipeline: Pipeline, policy: Policy, keep_offs: tuple[KeepOff, ...]
) -> None:
    """Refuse what cannot be done with some cells of a mesh alone.

    Raises
    ------
    ConfigError, UnsupportedMeshError
    """
    wrong = ""
    if pipeline.repairs:
        wrong = "the pass repair"
    elif policy.name == Split.name:
        wrong = f"--boundary {policy.name}"
    elif keep_offs:
        wrong = "--keep-off"
    if wrong:
        raise ConfigError(
            f"{wrong} is for the whole mesh: leave it out, or --only, --freeze and --below"
        )
    if is_second_order(mesh):
        raise UnsupportedMeshError(
            "--only, --freeze and --below are for cells of first order: leave them out here"
        )
