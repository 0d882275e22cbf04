"""The same mesh in every version of Gmsh's format, text and binary."""

import numpy as np
import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import FORMATS, read, write
from support.encodings import GEOMETRICAL, PHYSICAL, assert_unreadable, warnings_of
from support.gmsh import POINTS, Builder, two_tets

TEXT = [Builder(v) for v in ("1", "2", "2.1", "2.2", "2.20", "3", "3.0", "4", "4.0", "4.1", "4.10")]
BINARY = [Builder(v, True, o) for v in ("2", "2.2", "3", "4.1") for o in "<>"]
BUILDERS = pytest.mark.parametrize(
    "builder", TEXT + BINARY, ids=lambda b: f"{b.spelled}{b.order if b.binary else ''}"
)


def put(tmp_path, content):
    path = tmp_path / "mesh.msh"
    path.write_bytes(content)
    return path


@BUILDERS
def test_every_version_holds_the_same(tmp_path, caplog, builder):
    mesh, source = read(put(tmp_path, two_tets(builder)))
    assert mesh.points.tolist() == [list(point) for point in POINTS]
    triangles, tets = mesh.blocks
    assert triangles.cells.tolist() == [[0, 1, 2]]
    assert tets.cells.tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]
    assert [b.data[PHYSICAL].tolist() for b in mesh.blocks] == [[3], [7, 7]]
    assert [b.data[GEOMETRICAL].tolist() for b in mesh.blocks] == [[2], [1, 1]]
    if builder.version >= 2:
        assert mesh.names == {(2, 3): "wall", (3, 7): "steel"}
    assert source.encoding.format == ("gmsh" if builder.version >= 4 else "gmsh22")
    assert source.encoding.binary == builder.binary
    assert source.lost == ()
    assert warnings_of(caplog) == []


@BUILDERS
def test_every_version_is_written_as_one_of_two(tmp_path, builder):
    path = put(tmp_path, two_tets(builder))
    mesh, _ = read(path)
    for name in ("gmsh", "gmsh22"):
        write(tmp_path / "again.msh", mesh, FORMATS[name].default)
        again, second = read(tmp_path / "again.msh")
        assert second.encoding.version == FORMATS[name].default.version
        assert again.names == mesh.names
        np.testing.assert_array_equal(again.points, mesh.points)
        for one, other in zip(again.blocks, mesh.blocks, strict=True):
            np.testing.assert_array_equal(one.cells, other.cells)
            np.testing.assert_array_equal(one.data[PHYSICAL], other.data[PHYSICAL])
            np.testing.assert_array_equal(one.data[GEOMETRICAL], other.data[GEOMETRICAL])


@pytest.mark.parametrize("version", ["0.9", "4.2", "5", "12"])
def test_other_versions_are_refused_with_the_command_that_converts_them(tmp_path, version):
    content = b"$MeshFormat\n" + version.encode() + b" 0 8\n$EndMeshFormat\n"
    assert_unreadable(put(tmp_path, content), version, "gmsh -save -format msh41")


@BUILDERS
def test_numbers_may_be_sparse_and_in_any_order(tmp_path, builder):
    mesh, _ = read(put(tmp_path, two_tets(builder, (30, 7, 1000, 2, 8))))
    assert mesh.numbers.tolist() == [1, 6, 7, 29, 999]
    assert mesh.points[[3, 1, 4, 0, 2]].tolist() == [list(point) for point in POINTS]
    assert mesh.blocks[1].cells.tolist() == [[3, 1, 4, 0], [1, 4, 0, 2]]


@BUILDERS
def test_a_file_that_is_cut_off_is_refused_with_one_clear_line(tmp_path, builder):
    content = two_tets(builder).rstrip()
    for end in range(1, len(content)):
        path = put(tmp_path, content[:end])
        with pytest.raises(ReadError) as caught:
            read(path)
        assert "(" not in str(caught.value).removeprefix(str(path))


@pytest.mark.parametrize("builder", [Builder("2.2"), Builder("2.2", True), Builder("3")])
def test_no_count_is_believed(tmp_path, builder):
    content = two_tets(builder)
    for section in (b"$Nodes\n", b"$Elements\n"):
        at = content.index(section) + len(section)
        huge = content[:at] + b"999999999999" + content[at + 1 :]
        assert_unreadable(put(tmp_path, huge), section.strip().decode())


@pytest.mark.parametrize("binary", [False, True])
def test_no_count_of_version_4_is_believed(tmp_path, binary):
    builder = Builder("4.1", binary)
    content = two_tets(builder)
    four = builder.line(("c", (2, 3, 1, 3)))
    for wrong in ((1 << 40, 3, 1, 3), (2, 1 << 40, 1, 3), (2, 2, 1, 3)):
        assert four in content
        changed = content.replace(four, builder.line(("c", wrong)))
        assert_unreadable(put(tmp_path, changed), "$Elements")


@pytest.mark.parametrize("before", [b"\xef\xbb\xbf", b"made by hand\n", b"\n \n"])
def test_what_comes_before_the_header_is_passed_over(tmp_path, before):
    mesh, source = read(put(tmp_path, before + two_tets(Builder("4.1"))))
    assert len(mesh.points) == len(POINTS)
    assert source.lost == ()


def test_a_node_that_is_there_twice(tmp_path):
    content = two_tets(Builder("2.2")).replace(b"$Nodes\n5\n", b"$Nodes\n6\n3 9 9 9\n")
    mesh, source = read(put(tmp_path, content))
    assert mesh.points[2].tolist() == [9, 9, 9]
    assert len(mesh.points) == len(POINTS)
    assert source.lost == ("nodes with the number of another (1)",)


def test_a_section_that_is_there_twice(tmp_path):
    """As where a view was written with its mesh once more."""
    content = two_tets(Builder("4.1"))
    assert read(put(tmp_path, content + content))[1].lost == ()
    other = content[content.index(b"$Nodes") :].replace(b"1.0 1.0 1.0", b"2.0 2.0 2.0")
    mesh, source = read(put(tmp_path, content + other))
    assert mesh.points[4].tolist() == [1, 1, 1]
    assert source.lost == ("all but the first of the sections $Nodes",)


def test_what_is_no_entity_is_refused(tmp_path):
    text = two_tets(Builder("4.1")).replace(b"\n3 1 0 2\n", b"\n4 1 0 2\n")
    assert_unreadable(put(tmp_path, text), "$Nodes", "dimension 4")
    text = two_tets(Builder("4.1")).replace(b"\n3 1 4 2\n", b"\n4 1 4 2\n")
    assert_unreadable(put(tmp_path, text), "$Elements", "dimension 4")
