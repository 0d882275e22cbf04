"""Elements that are in several physical groups, which versions before 4 list once for each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...cells import dimension_of
from ...mesh.adjacency import distinct
from ...mesh.model import Array, Block
from ...mesh.tags import GEOMETRICAL, PHYSICAL
from .elements import Elements

Groups = dict[tuple[int, int], tuple[int, ...]]  # see `Mesh.more_groups`


def without_repeats(elements: Elements) -> Groups:
    """Take out the elements that repeat one of the same entity in another group.

    Returns
    -------
    Groups
        The other groups of entities that are in them as a whole. Those of a part of the cells
        of an entity are added to what was lost.
    """
    masks: list[Array] = [np.empty(0, bool)] * len(elements.blocks)
    for kind in dict.fromkeys(block.type for block in elements.blocks):
        places = [i for i, block in enumerate(elements.blocks) if block.type == kind]
        for i, mask in zip(places, _repeats([elements.blocks[i] for i in places]), strict=True):
            masks[i] = mask
    if not any(mask.any() for mask in masks):
        return {}
    counts: dict[tuple[int, int], int] = {}
    others: dict[tuple[int, int], dict[int, int]] = {}
    for i, (block, repeated) in enumerate(zip(elements.blocks, masks, strict=True)):
        dimension = dimension_of(block.type)
        physical, entity = block.data[PHYSICAL], block.data[GEOMETRICAL]
        for tag, group, n in _counted(entity[repeated], physical[repeated]):
            of = others.setdefault((dimension, tag), {})
            of[group] = of.get(group, 0) + n
        for tag, _, n in _counted(entity[~repeated], 0 * physical[~repeated]):
            counts[dimension, tag] = counts.get((dimension, tag), 0) + n
        data = {name: values[~repeated] for name, values in block.data.items()}
        elements.blocks[i] = replace(block, cells=block.cells[~repeated], data=data)
        elements.numbers[i] = elements.numbers[i][~repeated]
    result: Groups = {}
    for (dimension, tag), groups in others.items():
        whole = [group for group, n in groups.items() if n == counts.get((dimension, tag))]
        if whole:
            result[dimension, tag] = tuple(whole)
        elements.lost += [
            f"group {group} of some elements that are in another one too"
            for group in groups
            if group not in whole
        ]
    return result


def _counted(entity: Array, group: Array) -> list[tuple[int, int, int]]:
    """How many there are of each pair of entity and group: entity, group, number."""
    if not len(entity):
        return []
    pairs, n = np.unique(np.column_stack([entity, group]), axis=0, return_counts=True)
    return [(*pair, count) for pair, count in zip(pairs.tolist(), n.tolist(), strict=True)]


def _repeats(blocks: list[Block]) -> list[Array]:
    """Which cells of the blocks of one type repeat another, but for their group."""
    ends = np.cumsum([len(block.cells) for block in blocks])[:-1]
    group = np.concatenate([block.data[PHYSICAL] for block in blocks])
    repeated = np.zeros(len(group), bool)
    if len(distinct(group)) > 1:
        rows = np.concatenate(
            [np.column_stack([block.cells, block.data[GEOMETRICAL]]) for block in blocks]
        )
        # Rows are told apart by a sum with random weights, and then looked at.
        weights = np.random.default_rng(0).integers(2**62, size=rows.shape[1])
        keys = (rows * weights).sum(axis=1)
        order = np.argsort(keys, kind="stable")
        same = np.zeros(len(order), bool)
        close = np.flatnonzero(keys[order[1:]] == keys[order[:-1]]) + 1
        same[close] = (rows[order[close]] == rows[order[close - 1]]).all(axis=1)
        run = np.cumsum(~same) - 1
        # of a run, the first in each group, but those of the group of the first of all
        members = np.flatnonzero(same | np.append(same[1:], False))
        pairs = np.column_stack([run[members], group[order[members]]])
        _, first = np.unique(pairs, axis=0, return_index=True)
        chosen = members[first]
        chosen = chosen[same[chosen]]
        heads = order[np.flatnonzero(~same)[run[chosen]]]
        in_groups = (group[heads] != 0) & (group[order[chosen]] != 0)
        repeated[order[chosen[in_groups]]] = True
    return np.split(repeated, ends)


def with_repeats(blocks: list[Block], more_groups: Groups) -> list[Block]:
    """List the cells of entities in several groups once for each, after those of their block."""
    result = []
    for block in blocks:
        result.append(block)
        for (dimension, tag), groups in more_groups.items():
            if dimension != dimension_of(block.type):
                continue
            here = block.data[GEOMETRICAL] == tag
            for group in groups:
                again = here & (block.data[PHYSICAL] != group)
                if again.any():
                    data = {name: values[again] for name, values in block.data.items()}
                    data[PHYSICAL] = np.full(len(data[PHYSICAL]), group)
                    result.append(replace(block, cells=block.cells[again], data=data))
    return result
