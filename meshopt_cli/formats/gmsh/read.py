"""Reading Gmsh's MSH files, versions 1 to 4.1, section by section.

meshio would do this in part: it knows neither partitions, parameters, periodic nodes, steps of
views nor the older versions, discards the numbers of elements, by which views go, and takes every
count in a file for true. Of it, the table of types and the orders of their nodes are used.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...mesh.model import Mesh
from ...mesh.periodic import Link
from ...mesh.tags import DIM_TAGS, PARAMETRIC, PARTITION
from ..sniff import Encoding, GmshHeader, UnreadableError
from .elements import read_elements
from .entities import Entities, read_entities, read_partitioned
from .names import Names, attach_names, read_names
from .nodes import Nodes, read_nodes
from .order import from_gmsh
from .periodic import placed, read_periodic
from .places import Places
from .repeats import without_repeats
from .sections import header_of, sections
from .views import AT_ELEMENTS, AT_NODES, Values, attach_views, read_view

# The sections that a file has once.
_MODEL = {"MeshFormat", "PhysicalNames", "Entities", "PartitionedEntities"}
_ONCE = _MODEL | {"Nodes", "Elements", "Periodic"}


@dataclass
class _Parts:
    """The sections of a file as they are read."""

    names: Names = field(default_factory=list)
    entities: Entities = field(default_factory=Entities)
    nodes: Nodes | None = None
    elements: bytes | None = None
    periodic: list[Link] = field(default_factory=list)
    views: list[Values] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a mesh, and what of its file is left out.

    Points are in the order of their numbers in the file. An element that names a node which
    is not there has a number out of range in its place. Views become arrays under their
    names; where they have no value there is a NaN.
    """
    header = header_of(data)
    parts = _parts(data, header)
    if parts.nodes is None or parts.elements is None:
        missing = "Nodes" if parts.nodes is None else "Elements"
        raise UnreadableError(f"there is no section ${missing} in it")
    elements = read_elements(parts.elements, header, parts.entities)
    parts.elements = None
    mesh, nodes = _with_points(parts.nodes, parts.entities, parts.lost)
    if header.version < 4:
        mesh.more_groups = without_repeats(elements)
    mesh.more_groups |= {
        key: tuple(groups[1:]) for key, groups in parts.entities.groups.items() if len(groups) > 1
    }
    mesh.blocks = elements.blocks
    for block in mesh.blocks:
        block.cells = from_gmsh(block.type, nodes.of(block.cells))
    attach_names(mesh, parts.names, parts.lost)
    lost = parts.lost + elements.lost
    mesh.periodic = placed(parts.periodic, nodes, parts.entities, lost)
    numbers = Places(np.concatenate([np.empty(0, np.int64), *elements.numbers]))
    if not nodes.count_on:
        mesh.numbers = nodes.numbers - 1
    if not numbers.count_on:
        for block, labels in zip(mesh.blocks, elements.numbers, strict=True):
            block.numbers = labels - 1
    if parts.views:
        lost += attach_views(mesh, parts.views, nodes, numbers)
    return mesh, lost


def _parts(data: bytes, header: GmshHeader) -> _Parts:
    """Read all sections but the elements, which need the entities wherever these stand."""
    parts = _Parts()
    seen: dict[str, slice] = {}
    for name, content, start in sections(data):
        once = "Nodes" if name == "ParametricNodes" else name
        if once in _ONCE and once in seen:  # views of a mesh may come with the mesh again
            if data[seen[once]] != content:
                parts.lost.append(f"all but the first of the sections ${once}")
            continue
        seen[once] = slice(start, start + len(content))
        if name == "PhysicalNames":
            parts.names = read_names(content)
        elif name == "Entities" and header.version >= 3:
            read_entities(content, header, parts.entities)
        elif name == "PartitionedEntities":
            read_partitioned(content, header, parts.entities)
            parts.lost.append(f"the entities of partitions, but for their numbers ({PARTITION})")
        elif once == "Nodes":
            parts.nodes = read_nodes(name, content, header)
        elif name == "Elements":
            parts.elements = content
        elif name == "Periodic" and (header.text or header.version != 4.0):
            parts.periodic = read_periodic(content, header)
        elif name in (AT_NODES, AT_ELEMENTS):
            parts.views.append(read_view(name, content, header, len(parts.views) + 1))
        elif name not in ("MeshFormat", "Comments"):
            parts.lost.append(_NAMED.get(name, f"the section ${name}"))
    return parts


_NAMED = {
    "GhostElements": "the ghost cells of partitions",
    "ElementNodeData": "values at the nodes of each element ($ElementNodeData)",
}


def _with_points(nodes: Nodes, entities: Entities, lost: list[str]) -> tuple[Mesh, Places]:
    """A mesh of points only, in the order of their numbers, on entities of the model.

    Of several nodes with one number the first counts, as with Gmsh.
    """
    order = np.argsort(nodes.numbers, kind="stable")
    again = np.flatnonzero(np.diff(nodes.numbers[order]) == 0) + 1
    if len(again):
        order = np.delete(order, again)
        lost.append(f"nodes with the number of another ({len(again)})")
    mesh = Mesh(nodes.points[order], [])
    if nodes.dim_tags is not None:
        dim_tags = nodes.dim_tags[order]
        if entities.parents:
            keys, place = np.unique(dim_tags, axis=0, return_inverse=True)
            homes = [entities.home((int(d), int(tag))) for d, tag in keys]
            dim_tags = np.array(homes, np.int64).reshape(-1, 2)[place.ravel()]
        mesh.point_data[DIM_TAGS] = dim_tags
    if nodes.parameters is not None:
        mesh.point_data[PARAMETRIC] = nodes.parameters[order]
    return mesh, Places(nodes.numbers[order])
