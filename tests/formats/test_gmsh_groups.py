"""Physical groups of Gmsh: their names, and elements that are in several."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, read, write
from meshopt_cli.validity import check
from support.encodings import GEOMETRICAL, PHYSICAL, assert_unreadable
from support.gmsh import POINTS, Builder, two_tets

TARGETS = [Encoding(name, "", binary) for name in ("gmsh", "gmsh22") for binary in (False, True)]


def put(tmp_path, content):
    path = tmp_path / "mesh.msh"
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("target", TARGETS)
def test_one_name_in_two_dimensions(tmp_path, target):
    mesh, _ = read(put(tmp_path, two_tets(Builder("4.1"), names=('2 3 "x"', '3 7 "x"'))))
    assert mesh.names == {(2, 3): "x", (3, 7): "x"}
    lost = write(tmp_path / "again.msh", mesh, target).lost
    assert not any("name" in what for what in lost)
    assert read(tmp_path / "again.msh")[0].names == mesh.names


def test_names_without_a_dimension_are_of_the_cells_in_their_group(tmp_path):
    names = '3 "wall"', '7 "steel"', '8 "nowhere"'
    mesh, _ = read(put(tmp_path, two_tets(Builder("2"), names=names)))
    assert mesh.names == {(2, 3): "wall", (3, 7): "steel", (3, 8): "nowhere"}


@pytest.mark.parametrize("coding", ["latin-1", "utf-8"])
def test_names_in_any_letters(tmp_path, coding):
    content = two_tets(Builder("2.2")).replace(b"wall", "béton naïf".encode(coding))
    mesh, _ = read(put(tmp_path, content))
    assert mesh.names[2, 3] == "béton naïf"
    write(tmp_path / "again.msh", mesh, FORMATS["gmsh22"].default)
    assert "béton naïf".encode() in (tmp_path / "again.msh").read_bytes()


def test_a_second_name_of_a_group_is_named(tmp_path):
    mesh, source = read(put(tmp_path, two_tets(Builder("4.1"), names=('3 7 "a"', '3 7 "b"'))))
    assert mesh.names == {(3, 7): "a"}
    assert source.lost == ("the name b of a group that has another",)


def test_fewer_names_than_announced(tmp_path):
    content = two_tets(Builder("4.1")).replace(b"$PhysicalNames\n2\n", b"$PhysicalNames\n3\n")
    assert_unreadable(put(tmp_path, content), "$PhysicalNames", "3 names", "2 are found")


def test_sections_in_any_order_and_comments_between(tmp_path):
    builder = Builder("4.1")
    content = two_tets(builder)
    names = content[content.index(b"$PhysicalNames") : content.index(b"$Entities")]
    moved = content.replace(names, b"\n$Comments\n$Nodes are below\n$EndComments\nmore\n") + names
    mesh, source = read(put(tmp_path, moved))
    assert mesh.names == {(2, 3): "wall", (3, 7): "steel"}
    assert source.lost == ()


def listed(builder, *rows):
    """Two tets, listed by (number, group, entity, which)."""
    cells = [(1, 2, 3, 4), (2, 3, 4, 5)]
    elements = [(3, entity, 4, group, {i: cells[which]}) for i, group, entity, which in rows]
    points = dict(enumerate(POINTS, 1))
    return builder.header() + builder.nodes(points) + builder.elements(*elements)


@pytest.mark.parametrize("builder", [Builder("1"), Builder("2"), Builder("2.2", True)])
def test_elements_listed_once_for_each_group_are_one_cell(tmp_path, builder):
    rows = (1, 7, 1, 0), (2, 8, 1, 0), (3, 7, 1, 1), (4, 8, 1, 1)
    mesh, source = read(put(tmp_path, listed(builder, *rows)))
    (block,) = mesh.blocks
    assert block.cells.tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]
    assert block.data[PHYSICAL].tolist() == [7, 7]
    assert block.numbers.tolist() == [0, 2]
    assert mesh.more_groups == {(3, 1): (8,)}
    assert source.lost == ()
    assert "M201" not in {group.rule.code for group in check(mesh).groups}


@pytest.mark.parametrize("target", TARGETS)
def test_cells_in_several_groups_come_back(tmp_path, target):
    rows = (1, 7, 1, 0), (2, 8, 1, 0), (3, 9, 1, 0), (4, 5, 2, 1)
    mesh, _ = read(put(tmp_path, listed(Builder("2.2"), *rows)))
    assert mesh.more_groups == {(3, 1): (8, 9)}
    mesh.blocks[0].data["v"] = np.array([1.5, 2.5])
    assert write(tmp_path / "again.msh", mesh, target).lost == ()
    again, _ = read(tmp_path / "again.msh")
    assert again.more_groups == mesh.more_groups
    cells = np.concatenate([block.cells for block in again.blocks])
    assert cells.tolist() == mesh.blocks[0].cells.tolist()
    values = np.concatenate([block.data["v"] for block in again.blocks])
    assert values.tolist() == [1.5, 2.5]


def test_a_group_of_some_cells_of_an_entity_is_named(tmp_path):
    rows = (1, 7, 1, 0), (2, 8, 1, 0), (3, 7, 1, 1)
    mesh, source = read(put(tmp_path, listed(Builder("2.2"), *rows)))
    assert mesh.more_groups == {}
    assert source.lost == ("group 8 of some elements that are in another one too",)


@pytest.mark.parametrize("second", [(2, 7, 1, 0), (2, 8, 2, 0), (2, 0, 1, 0)])
def test_a_cell_that_is_there_twice_stays_so(tmp_path, second):
    """In the same group, in none, or on another entity, it is not what Gmsh writes for groups."""
    mesh, _ = read(put(tmp_path, listed(Builder("2.2"), (1, 7, 1, 0), second)))
    (block,) = mesh.blocks
    assert len(block.cells) == 2
    assert block.data[GEOMETRICAL].tolist() == [1, second[2]]
    assert "M201" in {group.rule.code for group in check(mesh).groups}


def test_types_that_are_no_cells_are_named(tmp_path):
    builder = Builder("2.2")
    row = b"9 20 2 0 2 1 2 3 4 5 1 2 3 4\n"
    content = two_tets(builder).replace(b"$Elements\n3\n", b"$Elements\n4\n" + row)
    mesh, source = read(put(tmp_path, content))
    assert [block.type for block in mesh.blocks] == ["triangle", "tetra"]
    assert source.lost == ("elements of type 20 (Triangle 9) (1)",)
    only = builder.header() + builder.nodes(dict(enumerate(POINTS, 1)))
    path = put(tmp_path, only + builder.section("Elements", b"1\n" + row))
    assert_unreadable(path, "20 (Triangle 9)", "not supported")
    for code in ("34", "999"):
        changed = content.replace(b"9 20 2", f"9 {code} 2".encode())
        assert_unreadable(put(tmp_path, changed), f"type {code}", "not supported")
