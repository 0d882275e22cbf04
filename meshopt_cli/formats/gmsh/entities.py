"""The entities of a Gmsh file: of what groups they are, what bounds them, and their partitions.

A partitioned mesh lies on entities of its own, each of them a part of one of the model, or an
interface between parts, which is then of a lower dimension than the entity it comes from.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ..sniff import GmshHeader, UnreadableError
from .numbers import COUNT, INTEGER, REAL, Numbers

Key = tuple[int, int]  # dimension and tag


@dataclass
class Entities:
    """What stands in $Entities and $PartitionedEntities, by dimension and tag.

    Attributes
    ----------
    groups : dict
        Physical groups of the entities that are in one.
    bounds : dict
        Tags of the entities of the dimension below around an entity, negative where they run the
        other way.
    parents : dict
        The entity of the model that an entity of a partition is a part of.
    partitions : dict
        The partitions of an entity; interfaces have several.
    """

    groups: dict[Key, list[int]] = field(default_factory=dict)
    bounds: dict[Key, list[int]] = field(default_factory=dict)
    parents: dict[Key, Key] = field(default_factory=dict)
    partitions: dict[Key, list[int]] = field(default_factory=dict)

    def home(self, key: Key) -> Key:
        """The entity of the model that an entity is, or is a part of."""
        return self.parents.get(key, key)

    def is_interface(self, key: Key) -> bool:
        """Whether an entity is an interface between partitions."""
        return self.home(key)[0] != key[0]

    def partition(self, key: Key) -> int:
        """The first partition of an entity, 0 without one."""
        return next(iter(self.partitions.get(key, ())), 0)


def read_entities(content: bytes, header: GmshHeader, entities: Entities) -> None:
    """Read $Entities: of version 4.1, 4.0, where points have a box too, or 3, without boxes."""
    if header.version < 4:  # there, it is text in binary files too
        header = header._replace(text=True)
    numbers = Numbers("Entities", content, header)
    counts = numbers.take(COUNT, 4).tolist()
    for dimension, count in enumerate(counts):
        for _ in range(count):
            key = dimension, numbers.one(INTEGER)
            if header.version < 4:  # bounds come before the groups
                entities.bounds[key] = numbers.some(COUNT) if dimension else []
                entities.groups[key] = numbers.some(COUNT)
            else:
                _skip_box(numbers, dimension, header)
                _groups_and_bounds(numbers, key, entities)


def read_partitioned(content: bytes, header: GmshHeader, entities: Entities) -> None:
    """Read $PartitionedEntities; `entities` has those of the model already."""
    numbers = Numbers("PartitionedEntities", content, header)
    numbers.one()  # the number of partitions
    numbers.rows(numbers.one(), (INTEGER, 2))  # entities of ghost cells, and their partitions
    known = set(entities.groups)
    for dimension, count in enumerate(numbers.take(COUNT, 4).tolist()):
        for _ in range(count):
            tag, parent_dimension, parent = numbers.take(INTEGER, 3).tolist()
            key = dimension, tag
            entities.partitions[key] = numbers.some(INTEGER)
            _skip_box(numbers, dimension, header)
            part = Entities()
            _groups_and_bounds(numbers, key, part)
            home = (parent_dimension, parent) if parent > 0 else key
            if not dimension <= home[0] <= 3:
                raise UnreadableError(
                    f"$PartitionedEntities has a part of dimension {dimension} "
                    f"of an entity of dimension {home[0]}"
                )
            entities.parents[key] = home
            if home not in known and home[0] == dimension:
                entities.groups[home] = part.groups[key]


def _skip_box(numbers: Numbers, dimension: int, header: GmshHeader) -> None:
    numbers.take(REAL, 6 if dimension or header.version < 4.1 else 3)


def _groups_and_bounds(numbers: Numbers, key: Key, entities: Entities) -> None:
    entities.groups[key] = numbers.some(INTEGER)
    entities.bounds[key] = numbers.some(INTEGER) if key[0] else []
