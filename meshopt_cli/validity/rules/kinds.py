"""Meshes of more than one kind of thing: M214 to M216.

Surfaces in space that branch or are put together from sheets, and beams and shells beside cells.
"""

from __future__ import annotations

import numpy as np

from ...cells import FAMILIES
from ...mesh.adjacency import distinct_rows
from ..examination import Examination
from ..model import WARNING, Places, at_cells, rule
from .conformity import crowded


@rule(
    "M214",
    WARNING,
    "surface branches",
    explanation="Three or more faces of a surface in space meet in an edge.",
    source="18.7.1",
    fix="Nothing needs to be done for shells that meet; what bounds a solid must not branch.",
    on_request=True,
)
def find_branches(study: Examination) -> Places:
    cells, ends = crowded(study.distinct_facets if study.may_branch else [])
    return Places(
        ("more than two faces meet in an edge of the cell",),
        cells=study.cells_by(cells[:, 0]),
        other_cells=study.cells_by(cells[:, 1:]),
        other_points=ends,
    )


@rule(
    "M215",
    WARNING,
    "sheets disagree in orientation",
    explanation="Sheets of a surface disagree where they meet in a fold, or a sheet with itself.",
    source="18.7.1",
    calls=("repair --orientation",),
    fix="Where sides do not matter, nothing needs to be done.",
)
def find_seams(study: Examination) -> Places:
    one, other = (numbers[study.sheets.is_seam] for numbers in study.disagreeing)
    sheet = study.sheets.sheet
    both = np.sort(np.stack([sheet[one], sheet[other]], axis=1), axis=1)
    pairs, number, count = distinct_rows(both)
    first = np.unique(number, return_index=True)[1]
    itself = (pairs[:, 0] == pairs[:, 1]).astype(np.int64)
    texts, kinds = np.unique(np.stack([itself, count], axis=1), axis=0, return_inverse=True)
    messages = tuple(_seam(*text) for text in texts.tolist()) or ("",)
    return at_cells(study, one[first], *messages, kinds=kinds.ravel(), others=other[first][:, None])


def _seam(is_itself: int, n_edges: int) -> str:
    """What is said of the edges in which two sheets, or the ends of one, disagree."""
    where = "an edge" if n_edges == 1 else f"{n_edges:,} edges"
    if is_itself:
        return f"the sheet of the cell has one side only: it meets itself turned over in {where}"
    return f"the sheet of the cell and another, which meet in {where}, disagree in orientation"


@rule(
    "M216",
    WARNING,
    "cells of lower dimension that bound no cell",
    explanation="Lines or faces stand by themselves beside cells: beams and shells, not facets.",
    fix="Nothing needs to be done if they are parts of the model: optimize keeps them as they are.",
)
def find_standing(study: Examination) -> Places:
    sets, none = study.lower.sets, np.empty(0, np.int64)
    numbers = np.concatenate([none, *(group.numbers for group in sets)])
    part = np.concatenate([none, *study.lower.parts])
    kind = np.repeat(np.arange(len(sets)), [len(group.numbers) for group in sets])
    families = list(dict.fromkeys(group.family for group in sets))
    family = np.array([families.index(group.family) for group in sets], dtype=np.int64)[kind]
    parts, number = np.unique(part, return_inverse=True)
    count = np.zeros((len(parts), len(families)), dtype=np.int64)
    np.add.at(count, (number, family), 1)
    least = np.full(len(parts), study.n_cells)
    np.minimum.at(least, number, numbers)
    order = np.argsort(least)
    texts, kinds = np.unique(count[order], axis=0, return_inverse=True)
    messages = tuple(_standing(families, text) for text in texts.tolist()) or ("",)
    return at_cells(study, least[order], *messages, kinds=kinds.ravel())


def _standing(families: list[str], counts: list[int]) -> str:
    """What is said of a part by the number of its cells of each family."""
    there = [(name, n) for name, n in zip(families, counts, strict=True) if n]
    if sum(counts) == 1:
        return f"the {there[0][0]} stands by itself: it bounds no cell"
    named = [FAMILIES[name].counted(n) for name, n in there]
    return f"{' and '.join(named)} stand by themselves, from this one on: they bound no cell"
