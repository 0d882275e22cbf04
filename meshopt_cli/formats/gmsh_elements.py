"""The elements of Gmsh's MSH 4.1 and 2.2.

meshio discards their numbers, by which views go, refuses physical groups on part of the
entities, and fails on the node 0 or one beyond the last. Of version 2.2 it reads one
element at a time.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..mesh.model import Array, Block
from ..mesh.tags import GEOMETRICAL, PHYSICAL
from .sniff import UnreadableError
from .text import numbers

# Blocks with numbers of nodes in the place of cells, and the numbers of the elements of each.
Elements = tuple[list[Block], list[Array]]

_FIRST_STEP = 64  # rows that are compared at once, at first


def cell_types() -> dict[str, int]:
    """Gmsh's number of each type of element, by its name in a Block."""
    from meshio.gmsh.common import _meshio_to_gmsh_type

    return _meshio_to_gmsh_type


def _known() -> dict[int, tuple[str, int]]:
    """Name and number of nodes of each type of element."""
    from meshio._common import num_nodes_per_cell

    return {code: (kind, num_nodes_per_cell[kind]) for kind, code in cell_types().items()}


def read_22(content: bytes, text: bool, lost: list[str]) -> Elements:
    """Read what stands in $Elements of a file of version 2.2.

    An element is a number, a type, a count of tags, tags and nodes. In binary, type and count
    stand before one or more elements. What is left out is added to `lost`.
    """
    first, rest = content.split(b"\n", 1)
    n = int(first)
    flat = numbers(rest, np.int64) if text else np.frombuffer(rest, "<i4", len(rest) // 4)
    known = _known()
    parts: list[tuple[str, Array, Array]] = []  # type, rows of number, tags and nodes
    at, found, cut = 0, 0, False
    while found < n:
        head = flat[at : at + 3].tolist()
        if len(head) < 3:
            raise UnreadableError(f"truncated: {n} elements are announced, and {found} found")
        code, n_tags = (head[1], head[2]) if text else (head[0], head[2])
        if code not in known:
            raise UnreadableError(f"elements of type {code} are not supported")
        kind, n_nodes = known[code]
        width = 1 + n_tags + n_nodes
        if text or head[1] == 1:  # a head for every element
            alike = np.array([1, 2] if text else [0, 1, 2])
            rows = _alike(flat[at:], 2 + width if text else 3 + width, alike, n - found)
            used = rows.size
            rows = np.delete(rows, [1, 2] if text else [0, 1, 2], axis=1)
        else:
            used = 3 + head[1] * width
            rows = flat[at + 3 : at + used].reshape(-1, width)
        if not len(rows):
            raise UnreadableError(f"truncated: {n} elements are announced, and {found} found")
        tags = np.zeros((len(rows), 2), np.int64)
        tags[:, : min(n_tags, 2)] = rows[:, 1 : 1 + min(n_tags, 2)]
        cut |= n_tags > 2
        parts.append((kind, tags, np.delete(rows, np.s_[1 : 1 + n_tags], axis=1)))
        at += used
        found += len(rows)
    if cut:
        lost.append("the partitions of the elements")
    starts = [i for i in range(len(parts)) if not i or parts[i][0] != parts[i - 1][0]]
    blocks, labels = [], []
    for start, end in pairwise([*starts, len(parts)]):
        tags = np.concatenate([tags for _, tags, _ in parts[start:end]])
        rows = np.concatenate([rows for _, _, rows in parts[start:end]]).astype(np.int64)
        named = {PHYSICAL: tags[:, 0].copy(), GEOMETRICAL: tags[:, 1].copy()}
        blocks.append(Block(parts[start][0], rows[:, 1:], named))
        labels.append(rows[:, 0])
    return blocks, labels


def _alike(flat: Array, width: int, columns: Array, most: int) -> Array:
    """The rows at the beginning, (n, width), that have the same numbers in some columns."""
    most = min(most, len(flat) // width)
    n, step = min(1, most), _FIRST_STEP
    while n < most:
        rows = flat[n * width : min(n + step, most) * width].reshape(-1, width)
        same = np.all(rows[:, columns] == flat[columns], axis=1)
        if not same.all():
            n += int(same.argmin())
            break
        n, step = n + len(rows), 2 * step
    return flat[: n * width].reshape(n, width)


def read_41(
    content: bytes, text: bool, size: int, groups: list[dict], bounds: list[dict]
) -> Elements:
    """Read what stands in $Elements of a file of version 4.1, block by block.

    Parameters
    ----------
    size : int
        Bytes of a count in binary.
    groups, bounds : list of dict
        Physical groups, and bounding entities, of the entities of each dimension by tag.
    """
    flat = numbers(content, np.int64) if text else np.empty(0)
    at = 0

    def take(kind: str, count: int) -> Array:
        nonlocal at
        start = at
        if text:
            at += count
            found = flat[start:at]
        else:
            at += count * int(kind[1:])
            found = np.frombuffer(content[start:at], "<" + kind)
        if len(found) != count:
            raise UnreadableError("truncated: more elements are announced than found")
        return found

    known = _known()
    found = [group for groups_of in groups for group in groups_of.values() if group]
    n_blocks, n, _, _ = take(f"i{size}", 4).tolist()
    blocks, labels = [], []
    for _ in range(n_blocks):
        dimension, tag, code = take("i4", 3).tolist()
        (count,) = take(f"i{size}", 1).tolist()
        if code not in known:
            raise UnreadableError(f"elements of type {code} are not supported")
        kind, n_nodes = known[code]
        rows = take(f"i{size}", count * (1 + n_nodes)).reshape(count, 1 + n_nodes)
        tags = {GEOMETRICAL: np.full(count, tag, np.int64)}
        if found:
            physical = next(iter(groups[dimension].get(tag, ())), 0)
            tags = {PHYSICAL: np.full(count, physical, np.int64), **tags}
        bound = bounds[dimension].get(tag, ()) if bounds else ()
        bound = np.array(bound, np.int64) if len(bound) else None
        blocks.append(Block(kind, rows[:, 1:], tags, bound))
        labels.append(rows[:, 0])
    if sum(map(len, labels)) != n:
        raise UnreadableError(f"{n} elements are announced, and another number found")
    return blocks, labels
