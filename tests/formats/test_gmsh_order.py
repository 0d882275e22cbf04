"""Cells of second order in Gmsh files: their nodes in Gmsh's order, as its manual shows them."""

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.formats import Encoding
from meshopt_cli.validity import check
from support.elements import one, reference

# Gmsh's code, and the corners that the nodes beyond the corners are the middles of.
_WEDGE = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)]
_PYRAMID = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 4), (2, 3), (2, 4), (3, 4)]
_HEXAHEDRON = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7),
               (5, 6), (6, 7)]  # fmt: skip
_FACES = [(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)]
GMSH = {
    "triangle6": (9, [(0, 1), (1, 2), (2, 0)]),
    "quad8": (16, [(0, 1), (1, 2), (2, 3), (3, 0)]),
    "quad9": (10, [(0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3)]),
    "tetra10": (11, [(0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)]),
    "wedge15": (18, _WEDGE),
    "wedge18": (13, [*_WEDGE, (0, 1, 4, 3), (0, 3, 5, 2), (1, 2, 5, 4)]),
    "pyramid13": (19, _PYRAMID),
    "pyramid14": (14, [*_PYRAMID, (0, 1, 2, 3)]),
    "hexahedron20": (17, _HEXAHEDRON),
    "hexahedron27": (12, [*_HEXAHEDRON, *_FACES, range(8)]),
}
every = pytest.mark.parametrize("name", GMSH)


def in_space(places):
    """Places with three coordinates."""
    return np.column_stack([places, np.zeros((len(places), 3 - places.shape[1]))])


def in_gmsh_order(name):
    """Places of the nodes of the reference cell, in Gmsh's order, in space."""
    _, middles = GMSH[name]
    nodes = reference(name)
    corners = nodes[: len(nodes) - len(middles)]
    places = np.array([*corners, *(corners[list(m)].mean(axis=0) for m in middles)])
    return in_space(places)


@every
def test_nodes_are_read_in_our_order(tmp_path, name):
    places = in_gmsh_order(name)
    n = len(places)
    rows = "\n".join(f"{k} {x} {y} {z}" for k, (x, y, z) in enumerate(places, 1))
    path = tmp_path / "a.msh"
    path.write_text(
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{n}\n{rows}\n$EndNodes\n"
        f"$Elements\n1\n1 {GMSH[name][0]} 2 1 1 {' '.join(map(str, range(1, n + 1)))}\n"
        "$EndElements\n"
    )
    mesh, _ = formats.read(path)
    nodes = mesh.points[mesh.blocks[0].cells[0]]
    assert nodes[:, : reference(name).shape[1]] == pytest.approx(reference(name))
    assert check(mesh).is_valid


@pytest.mark.parametrize(("row", "version"), [("gmsh22", "2.2"), ("gmsh", "4.1")])
@pytest.mark.parametrize("binary", [False, True])
@every
def test_nodes_are_written_in_the_order_of_gmsh(tmp_path, name, row, version, binary):
    """What is written is read again as it was, and text has Gmsh's order."""
    mesh = one(name, in_space(reference(name)))
    path = tmp_path / "a.msh"
    formats.write(path, mesh, Encoding(row, version, binary))
    again, _ = formats.read(path)
    assert again.points[again.blocks[0].cells[0]] == pytest.approx(in_space(reference(name)))
    if not binary:
        last = path.read_text().split("$EndElements")[0].splitlines()[-1]
        numbers = np.array(last.split()[-len(mesh.points) :], dtype=int)
        assert mesh.points[numbers - 1] == pytest.approx(in_gmsh_order(name))
