"""Gmsh files of both versions."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, write
from support.encodings import (
    DIM_TAGS,
    GEOMETRICAL,
    PARTITION,
    PHYSICAL,
    assert_same,
    assert_unreadable,
    tets,
    text_mesh,
    warnings_of,
)

MESH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
3 7 "left one"
$EndPhysicalNames
$Entities
1 0 1 2
1 0 0 0 0
4 0 0 0 1 1 0 0 0
1 0 0 0 1 1 1 1 7 1 4
2 0 0 0 1 1 1 0 1 -4
$EndEntities
$Nodes
2 5 1 5
0 1 0 1
1
0 0 0
3 1 0 4
2
3
4
5
1 0 0
0 1 0
0 0 1
1 1 1
$EndNodes
$Elements
4 4 1 4
0 1 15 1
1 1
2 4 2 1
2 1 2 3
3 1 4 1
3 1 2 3 4
3 2 4 1
4 2 3 4 5
$EndElements
"""


def test_gmsh_groups_on_part_of_the_entities(tmp_path):
    mesh, _ = read(text_mesh(tmp_path, MESH_41))
    assert [block.data[PHYSICAL].tolist() for block in mesh.blocks] == [[0], [0], [7], [0]]
    assert [block.data[GEOMETRICAL].tolist() for block in mesh.blocks] == [[1], [4], [1], [2]]
    assert mesh.names == {(3, 7): "left one"}
    assert [None if b.entities is None else b.entities.tolist() for b in mesh.blocks] == [
        None,
        None,
        [4],
        [-4],
    ]
    assert mesh.point_data[DIM_TAGS].tolist() == [[0, 1]] + [[3, 1]] * 4


def test_gmsh_lines_may_end_as_on_windows(tmp_path):
    mesh, _ = read(text_mesh(tmp_path, MESH_41))
    path = tmp_path / "crlf.msh"
    path.write_bytes(MESH_41.replace("\n", "\r\n").encode())
    assert_same(read(path)[0], mesh)


def test_gmsh_numbers_of_nodes_may_be_sparse_and_in_any_order(tmp_path):
    text = MESH_41.replace("\n2\n3\n4\n5\n1 0 0", "\n9\n20\n3\n8\n1 0 0")
    text = text.replace("1 1 2 3\n", "").replace("2 1 2 3\n3 1 4 1", "2 1 9 20\n3 1 4 1")
    text = text.replace("3 1 2 3 4\n", "3 1 9 20 3\n").replace("4 2 3 4 5\n", "4 9 0 3 21\n")
    mesh, _ = read(text_mesh(tmp_path, text))
    assert mesh.points.tolist() == [[0, 0, 0], [0, 0, 1], [1, 1, 1], [1, 0, 0], [0, 1, 0]]
    assert [block.cells.tolist() for block in mesh.blocks[1:]] == [
        [[0, 3, 4]],
        [[0, 3, 4, 1]],
        [[3, -1, 1, -1]],
    ]


def test_gmsh_views_go_by_number(tmp_path):
    view = '$%s\n1\n"v"\n1\n0.0\n3\n0\n1\n2\n%d 0.25\n%d 0.5\n$End%s\n'
    text = MESH_41 + view % ("ElementData", 4, 3, "ElementData")
    mesh, _ = read(text_mesh(tmp_path, text + view % ("NodeData", 5, 2, "NodeData")))
    assert [block.data.get("v") for block in mesh.blocks[2:]] == [[0.5], [0.25]]
    assert "v" not in mesh.blocks[0].data
    np.testing.assert_array_equal(mesh.point_data["v"], [np.nan, 0.5, np.nan, np.nan, 0.25])


def test_gmsh_sections_that_are_dropped_are_named(tmp_path, caplog):
    read(text_mesh(tmp_path, "$Comments\nhello\n$EndComments\n" + MESH_41))
    assert warnings_of(caplog) == []
    read(text_mesh(tmp_path, MESH_41 + "$Parametrizations\n0 0\n$EndParametrizations\n"))
    assert "$Parametrizations" in warnings_of(caplog)[0]


def test_gmsh_22_elements_without_tags(tmp_path, caplog):
    text = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
7 0 0 1
$EndNodes
$Elements
4
1 2 0 1 2 3
2 2 2 6 5 1 2 7
5 4 4 8 9 1 1 1 2 3 7
6 4 0 7 3 2 0
$EndElements
"""
    mesh, source = read(text_mesh(tmp_path, text))
    triangles, tetras = mesh.blocks
    assert source.encoding.format == "gmsh22"
    assert triangles.cells.tolist() == [[0, 1, 2], [0, 1, 3]]
    assert tetras.cells.tolist() == [[0, 1, 2, 3], [3, 2, 1, -1]]
    assert triangles.data[PHYSICAL].tolist() == [0, 6]
    assert tetras.data[GEOMETRICAL].tolist() == [9, 0]
    assert tetras.data[PARTITION].tolist() == [1, 0]
    assert warnings_of(caplog) == []


def test_gmsh_22_many_elements_in_runs_of_all_lengths(tmp_path):
    random = np.random.default_rng(5)
    elements, expected = [], []
    for n in [1, 63, 64, 65, 255, 256, 257, 1000, 1, 1, 7]:
        n_tags, nodes = random.integers(1, 3), random.choice([3, 4])
        for _ in range(n):
            cell = random.integers(1, 6, nodes)
            tags = random.integers(1, 6, n_tags)
            tags[:1] = 5  # in another group, it would be the same cell
            line = [len(elements) + 1, {3: 2, 4: 4}[nodes], n_tags, *tags, *cell]
            elements.append(" ".join(map(str, line)))
            expected.append((cell - 1).tolist())
    nodes = "\n".join(f"{i} {i} 0 0" for i in range(1, 6))
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n{nodes}\n$EndNodes\n"
    text += f"$Elements\n{len(elements)}\n" + "\n".join(elements) + "\n$EndElements\n"
    mesh, _ = read(text_mesh(tmp_path, text))
    assert [cell for block in mesh.blocks for cell in block.cells.tolist()] == expected


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ("$NOD\n1\n1 0 0 0\n$ENDNOD\n", ("$Elements",)),
        ("$MeshFormat\n5 0 8\n$EndMeshFormat\n", ("Gmsh format 5", "gmsh -save -format msh41")),
        ("$MeshFormat\nfour 0 8\n$EndMeshFormat\n", ("Gmsh format four",)),
        ("$MeshFormat\n4.1 1 8\n\0\0\1\1\n$EndMeshFormat\n", ("order of bytes",)),
        ("$MeshFormat\n4.1 1 2\n\1\0\0\0\n$EndMeshFormat\n", ("2 bytes",)),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", ("$Nodes",)),
        (MESH_41.replace("3 2 4 1\n", "3 2 999 1\n"), ("type 999",)),
        (MESH_41.replace("4 4 1 4", "4 5 1 5"), ("announces 5 elements", "4 are found")),
        (MESH_41.replace("$EndNodes", ""), ("$Nodes has no end",)),
    ],
)
def test_gmsh_files_that_are_refused(tmp_path, start, words):
    assert_unreadable(text_mesh(tmp_path, start), *words)


def test_gmsh_entities_in_several_groups(tmp_path, caplog):
    text = MESH_41.replace("1 0 0 0 1 1 1 1 7 1 4", "1 0 0 0 1 1 1 3 7 9 5 1 4")
    mesh, _ = read(text_mesh(tmp_path, text))
    assert mesh.more_groups == {(3, 1): (9, 5)}
    for binary in (False, True):
        encoding = Encoding("gmsh", "4.1", binary)
        write(tmp_path / "again.msh", mesh, encoding)
        assert read(tmp_path / "again.msh")[0].more_groups == mesh.more_groups
    assert warnings_of(caplog) == []
    for name in ("vtk", "vtu", "medit", "meditb"):
        lost = write(tmp_path / "out", mesh, FORMATS[name].default).lost
        assert "all but the first physical group of an entity" in lost


def test_gmsh_sections_end_where_the_next_one_starts(tmp_path):
    """As in a file of Gmsh's own tutorial, where the end of a view is misspelt."""
    mesh = tets()
    for name in ("one", "two"):
        for block in mesh.blocks:
            block.data[name] = np.full(len(block.cells), float(len(name) + (name == "two")))
    path = tmp_path / "mesh.msh"
    write(path, mesh, FORMATS["gmsh"].default)
    text = path.read_text()
    path.write_text(text.replace("$EndElementData", "$EndElememtData", 1))
    again, source = read(path)
    assert {name for block in again.blocks for name in block.data} >= {"one", "two"}
    assert source.lost == ()


@pytest.mark.parametrize("section", ["Nodes", "Elements", "Entities"])
def test_gmsh_sections_that_are_empty(tmp_path, section):
    path = tmp_path / "mesh.msh"
    write(path, tets(), FORMATS["gmsh"].default)
    text = path.read_text()
    start, end = text.index(f"${section}\n"), text.index(f"$End{section}")
    path.write_text(text[:start] + f"${section}\n" + text[end:])
    assert_unreadable(path, f"${section} is empty")


@pytest.mark.parametrize(("extension", "version"), [(".msh2", "2.2"), (".msh4", "4.1")])
def test_gmsh_extensions_that_say_the_version(tmp_path, extension, version):
    path = tmp_path / f"mesh{extension}"
    written = write(path, tets(), encoding_for(path))
    assert written.encoding.version == version
    mesh, source = read(path)
    assert source.encoding.version == version
    assert len(mesh.points) == len(tets().points)
