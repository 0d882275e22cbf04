"""The elements of a Gmsh file, of all versions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np

from ...mesh.adjacency import distinct
from ...mesh.model import Array, Block
from ...mesh.tags import GEOMETRICAL, PARTITION, PHYSICAL
from ..sniff import GmshHeader, UnreadableError
from .entities import Entities
from .mixed import SHORT, MixedRows, take_mixed
from .numbers import COUNT, INTEGER, Numbers, TruncatedError
from .types import Element, element_of

_GHOSTS = "the ghost cells of partitions"


@dataclass
class Part:
    """Elements of one type that stand together, on one entity or with tags of their own.

    Attributes
    ----------
    element : Element
    numbers : (n,) int64
    nodes : (n, k) int64
        As the file numbers them.
    tags : dict of str to (n,) int64 array
    block : object
        Parts that follow each other make one block where they agree in it.
    bounds : list of int, optional
        The entities that bound that of the elements.
    """

    element: Element
    numbers: Array
    nodes: Array
    tags: dict[str, Array]
    block: object
    bounds: list[int] | None = None


@dataclass
class Elements:
    """The elements of a file: blocks with numbers of nodes in the place of cells.

    Attributes
    ----------
    blocks : list of Block
    numbers : list of (n,) int64 array
        Of the elements of each block.
    lost : list of str
        What was left out.
    """

    blocks: list[Block] = field(default_factory=list)
    numbers: list[Array] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def read_elements(content: bytes, header: GmshHeader, entities: Entities) -> Elements:
    """Read $Elements, but of types that a mesh cannot hold, where they are not what it is of.

    Raises
    ------
    UnreadableError
        Also for elements of such a type that have the greatest dimension.
    """
    numbers = Numbers("Elements", content, header, real=False)
    found = Elements()
    if header.version >= 4:
        parts = _blocks(numbers, header.version < 4.1, entities, found.lost)
    else:
        parts = _rows(numbers, header, entities, found.lost)
    for part in _joined(_held(parts, found.lost)):
        bounds = np.array(part.bounds, np.int64) if part.bounds else None
        found.blocks.append(Block(part.element.kind, part.nodes, part.tags, bounds))
        found.numbers.append(part.numbers)
    return found


def _element(code: int) -> Element:
    element = element_of(code)
    if element is None or not element.n_nodes:
        raise UnreadableError(
            f"elements of type {element.name if element else code} are not supported"
        )
    return element


def _blocks(numbers: Numbers, old: bool, entities: Entities, lost: list[str]) -> list[Part]:
    """Versions 4: in blocks of one entity and type; before 4.1 the tag of the entity is first."""
    parts: list[Part] = []
    n_blocks, n, *_ = numbers.take(COUNT, 2 if old else 4).tolist()
    found = between = 0
    grouped = any(entities.groups.values())
    for _ in range(n_blocks):
        dimension, tag, code = numbers.take(INTEGER, 3).tolist()
        if old:
            dimension, tag = tag, dimension
        if not 0 <= dimension <= 3:
            raise UnreadableError(f"$Elements has an entity of dimension {dimension}")
        count, element = numbers.one(), _element(code)
        kind = INTEGER if old else COUNT
        labels, nodes = numbers.rows(count, (kind, 1), (kind, element.n_nodes))
        found += count
        key = dimension, tag
        if entities.is_interface(key):
            between += count
            continue
        home = entities.home(key)
        tags = {GEOMETRICAL: np.full(count, home[1], np.int64)}
        if grouped:
            group = next(iter(entities.groups.get(home, ())), 0)
            tags = {PHYSICAL: np.full(count, group, np.int64), **tags}
        if entities.partitions:
            tags[PARTITION] = np.full(count, entities.partition(key), np.int64)
        alike = (element, home) if entities.partitions else len(parts)
        bounds = entities.bounds.get(home)
        parts.append(Part(element, labels[:, 0], nodes, tags, alike, bounds))
    if found != n:
        raise UnreadableError(f"$Elements announces {n} elements, and {found} are found")
    if between:
        lost.append(f"elements between partitions ({between})")
    return parts


def _rows(numbers: Numbers, header: GmshHeader, entities: Entities, lost: list[str]) -> list[Part]:
    """Versions before 4: each element by itself, with its tags."""
    n = numbers.line_count()
    parts: list[Part] = []
    done = 0
    while done < n:
        try:
            if header.version >= 3:
                part = _row_3(numbers, n - done, lost)
            elif header.version >= 2:
                part = _row_2(numbers, n - done, header, lost)
            else:
                part = _row_1(numbers, n - done)
        except TruncatedError:
            raise UnreadableError(
                f"$Elements is truncated: {n} elements are announced, and {done} found"
            ) from None
        parts.append(part)
        done += len(part.numbers)
        if 2 <= header.version < 3 and len(part.numbers) < SHORT:
            for rows in take_mixed(numbers, n - done, header):
                parts.append(_part_2(rows, header, lost))
                done += len(rows.numbers)
    partitioned = any(part.tags[PARTITION].any() for part in parts)
    for part in parts:
        if not partitioned:
            del part.tags[PARTITION]
        if header.version >= 3 and any(entities.groups.values()):
            part.tags[PHYSICAL] = _groups(part, entities)
    return parts


def _part(element: Element, numbers: Array, nodes: Array, *tags: Array | None) -> Part:
    """Elements with a physical group, an entity and a partition, 0 for those left out."""
    names = (PHYSICAL, GEOMETRICAL, PARTITION)
    columns = {name: np.zeros(len(numbers), np.int64) for name in names}
    for name, values in zip(names, tags, strict=False):
        if values is not None:
            columns[name][:] = values
    return Part(element, numbers, nodes, columns, element)


def _row_1(numbers: Numbers, most: int) -> Part:
    """Number, type, group, entity, number of nodes, nodes."""
    element = _element(numbers.peek((INTEGER, 2))[0][1])
    columns = [(INTEGER, width) for width in (1, 1, 2, 1, element.n_nodes)]
    labels, _, tags, _, nodes = numbers.run(most, columns, (1, 3))
    return _part(element, labels[:, 0], nodes, tags[:, 0], tags[:, 1])


def _row_2(numbers: Numbers, most: int, header: GmshHeader, lost: list[str]) -> Part:
    """Number, type, number of tags, tags, nodes.

    In binary, type, number of elements and number of tags come before one element or more.
    """
    first, second, n_tags = numbers.peek((INTEGER, 3))[0]
    element = _element(second if header.text else first)
    if n_tags < 0:
        raise UnreadableError(f"$Elements has an element with {n_tags} tags")
    row = [(INTEGER, 1), (INTEGER, n_tags), (INTEGER, element.n_nodes)]
    if header.text:
        labels, _, tags, nodes = numbers.run(most, [row[0], (INTEGER, 2), *row[1:]], (1,))
    elif second == 1:
        _, labels, tags, nodes = numbers.run(most, [(INTEGER, 3), *row], (0,))
    else:
        numbers.take(INTEGER, 3)
        labels, tags, nodes = numbers.rows(second, *row)
    first_tags = np.zeros((len(labels), 4), np.int64)
    first_tags[:, : min(n_tags, 4)] = tags[:, :4]
    counts = np.full(len(labels), n_tags)
    return _part_2(MixedRows(element, labels[:, 0], nodes, counts, first_tags), header, lost)


def _part_2(rows: MixedRows, header: GmshHeader, lost: list[str]) -> Part:
    """Elements whose tags are group, entity, number of partitions, the first of them, others.

    Before version 2.2, the partition comes in the place of the number of partitions. The other
    partitions are those that have the element as a ghost, and come with a minus.
    """
    group, entity, several, partition = rows.tags.T
    if header.version < 2.2:
        partition = several
    else:
        if ((rows.counts > 4) & (several > 1)).any():
            lost.append(_GHOSTS)
        if ((rows.counts > 4) & (rows.counts > 3 + several)).any():
            lost.append("the parents of elements")
    return _part(rows.element, rows.numbers, rows.nodes, group, entity, partition)


def _row_3(numbers: Numbers, most: int, lost: list[str]) -> Part:
    """Number, type, entity, how many integers follow: nodes, and then a list of partitions."""
    _, code, _, n_more = numbers.peek((INTEGER, 4))[0]
    element = _element(code)
    if n_more < element.n_nodes:
        raise UnreadableError(
            f"$Elements has an element of type {element.name} with {n_more} nodes"
        )
    more = n_more - element.n_nodes
    columns = [(INTEGER, width) for width in (1, 1, 1, 1, element.n_nodes, more)]
    labels, _, entity, _, nodes, partitions = numbers.run(most, columns, (1, 3))
    if more > 2:
        lost.append(_GHOSTS)
    partition = partitions[:, 1] if more > 1 else None
    return _part(element, labels[:, 0], nodes, None, entity[:, 0], partition)


def _groups(part: Part, entities: Entities) -> Array:
    """The first group of the entity of each element, 0 without one."""
    groups = np.zeros(len(part.numbers), np.int64)
    for tag in distinct(part.tags[GEOMETRICAL]).tolist():
        found = entities.groups.get((part.element.dimension, tag))
        if found:
            groups[part.tags[GEOMETRICAL] == tag] = found[0]
    return groups


def _held(parts: list[Part], lost: list[str]) -> list[Part]:
    """The parts that a mesh can hold; the others are named, or refused if it consists of them."""
    held = [part for part in parts if part.element.kind]
    top = max((part.element.dimension for part in held), default=-1)
    others: dict[Element, int] = {}
    for part in parts:
        if not part.element.kind and len(part.numbers):
            others[part.element] = others.get(part.element, 0) + len(part.numbers)
    for element, count in others.items():
        if element.dimension >= top:
            raise UnreadableError(
                f"elements of type {element.name} are not supported: "
                "save it with elements of first or second order"
            )
        lost.append(f"elements of type {element.name} ({count})")
    return held


def _joined(parts: list[Part]) -> Iterator[Part]:
    """Put parts that follow each other, and are alike, into one."""
    for _, group in groupby(parts, key=lambda part: part.block):
        alike = list(group)
        first = alike[0]
        if len(alike) == 1:
            yield first
            continue
        yield replace(
            first,
            numbers=np.concatenate([part.numbers for part in alike]),
            nodes=np.concatenate([part.nodes for part in alike]),
            tags={n: np.concatenate([part.tags[n] for part in alike]) for n in first.tags},
        )
