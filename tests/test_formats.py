"""Round trips over FORMATS, conversions between them, and what goes wrong with files."""

import contextlib
import gzip
import hashlib
import logging
import os
import re
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import tet_grid
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from meshopt_cli.errors import ConfigError, ReadError, WriteError
from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, sniff, write
from meshopt_cli.mesh.model import Block, Mesh

PHYSICAL, GEOMETRICAL, REF = "gmsh:physical", "gmsh:geometrical", "medit:ref"
DIM_TAGS = "gmsh:dim_tags"

# every format, as text and as binary
ENCODINGS = [
    encoding
    for row in FORMATS.values()
    for encoding in (
        [row.default]
        if row.family == "medit"
        else [replace(row.default, binary=binary, compressed=False) for binary in (False, True)]
    )
]
ENCODINGS += [
    Encoding("vtu", "1.0", binary=True, compressed=True),
    Encoding("vtu", "0.1", binary=True, compressed=True),
    Encoding("vtu", "0.1", binary=True),
    Encoding("vtk", "2.0", binary=False),
    Encoding("vtk", "3.0", binary=True),
    Encoding("vtk", "4.2", binary=False),
    Encoding("vtk", "4.2", binary=True),
    *(Encoding("meditb", version, binary=True) for version in ("3", "4")),
    *(Encoding("medit", version, binary=False) for version in ("3", "4")),
]


def name_of(encoding):
    kind = "zlib" if encoding.compressed else "binary" if encoding.binary else "text"
    return f"{encoding.format}-{encoding.version}-{kind}"


every_encoding = pytest.mark.parametrize("encoding", ENCODINGS, ids=name_of)


def ints(*values):
    return np.array(values, dtype=np.int64)


POINTS = np.array(
    [[0, 0, 0], [1 / 3, 0, 0], [0, 0.1, 0], [1e-300, 5e-324, 1e300], [-0.0, 2**0.5, np.pi]]
)


def tets():
    """Two tetrahedra in two regions, a triangle, two edges and a corner; no tags yet."""
    return Mesh(
        POINTS.copy(),
        [
            Block("vertex", ints([0])),
            Block("line", ints([0, 1], [1, 2])),
            Block("triangle", ints([0, 1, 2])),
            Block("tetra", ints([0, 1, 2, 3])),
            Block("tetra", ints([1, 2, 3, 4])),
        ],
    )


def plane():
    """Two triangles, with coordinates in the plane."""
    points = np.array([[0, 0], [1, 0], [1 / 3, 1], [2, 0.7]])
    return Mesh(points, [Block("triangle", ints([0, 1, 2], [1, 3, 2]))])


def zoo():
    """One cell of each linear type in space."""
    counts = {"tetra": 4, "hexahedron": 8, "wedge": 6, "pyramid": 5, "quad": 4, "triangle": 3}
    points = np.random.default_rng(3).random((8, 3))
    return Mesh(points, [Block(name, np.arange(n)[None]) for name, n in counts.items()])


def tagged(mesh, encoding):
    """Give a mesh all that a format holds, in the way it comes back from a file."""
    row = FORMATS[encoding.format]
    blocks, point_data, names = [], {}, {}
    for i, block in enumerate(mesh.blocks):
        n = len(block.cells)
        if row.family == "gmsh":
            physical = i if len(mesh.blocks) > 1 else 8  # in several, the first has no group
            data = {PHYSICAL: np.full(n, physical), GEOMETRICAL: np.full(n, 10 + i)}
            if block.type == "tetra":
                data["stress"] = np.linspace(1, 1 / 3, 9 * n).reshape(n, 9)
            entities = ints(-(9 + i)) if encoding.format == "gmsh" and i else None
            blocks.append(Block(block.type, block.cells, data, entities))
            names = {"a name, with: blanks": (3, 3), "wall": (2, 2)}
            point_data = {"T": np.linspace(0, 1 / 7, len(mesh.points))}
        elif row.family == "medit":
            blocks.append(Block(block.type, block.cells, {REF: np.full(n, 3 * i - 2)}))
            point_data = {REF: np.arange(len(mesh.points)) - 1}
        else:
            data = {
                PHYSICAL: np.full(n, i),
                REF: np.full(n, -i, np.int32),
                "flag": np.full(n, 255, np.uint8),
                "a name": np.full((n, 3), 1 / 3),
                "pair": np.full((n, 2), np.float32(0.1)),
            }
            blocks.append(Block(block.type, block.cells, data))
            point_data = {REF: np.arange(len(mesh.points)), "u v": mesh.points / 7}
            point_data["short"] = np.arange(len(mesh.points), dtype=np.int16)
    if row.family == "medit":
        blocks = merged([block for block in blocks if block.type != "vertex"])
    if row.family in ("vtk", "vtu"):
        blocks = merged(blocks)
    if encoding.format == "gmsh22":
        blocks = merged(blocks)
    points = mesh.points
    if row.family != "medit" and points.shape[1] == 2:
        points = np.pad(points, ((0, 0), (0, 1)))
    if encoding.format == "gmsh":
        point_data[DIM_TAGS] = np.tile(ints(3, 10), (len(points), 1))
        point_data[DIM_TAGS][0] = (0, 10)
    return Mesh(points, blocks, point_data, names)


def merged(blocks):
    """Join blocks of one type that follow each other."""
    joined = []
    for block in blocks:
        if joined and joined[-1].type == block.type:
            last = joined[-1]
            data = {name: np.concatenate([last.data[name], block.data[name]]) for name in last.data}
            joined[-1] = Block(block.type, np.concatenate([last.cells, block.cells]), data)
        else:
            joined.append(block)
    return joined


def assert_same_array(one, other):
    assert one.dtype == other.dtype
    assert one.shape == other.shape
    assert one.tobytes() == other.tobytes()


def assert_same(one, other):
    assert_same_array(one.points, other.points)
    assert [block.type for block in one.blocks] == [block.type for block in other.blocks]
    for a, b in zip(one.blocks, other.blocks, strict=True):
        assert_same_array(a.cells, b.cells)
        assert a.data.keys() == b.data.keys()
        for name in a.data:
            assert_same_array(a.data[name], b.data[name])
        assert (a.entities is None) == (b.entities is None)
        if a.entities is not None:
            assert_same_array(a.entities, b.entities)
    assert one.point_data.keys() == other.point_data.keys()
    for name in one.point_data:
        assert_same_array(one.point_data[name], other.point_data[name])
    assert one.names == other.names


def path_for(folder, encoding):
    return folder / ("mesh" + FORMATS[encoding.format].extensions[0])


def warnings_of(caplog):
    return [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]


# ---- round trips


@every_encoding
@pytest.mark.parametrize("make", [tets, plane, zoo])
def test_round_trip_is_exact(tmp_path, caplog, encoding, make):
    mesh = tagged(make(), encoding)
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    again, source = read(path)
    assert_same(mesh, again)
    assert source.encoding == encoding
    assert source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert source.path == path
    assert warnings_of(caplog) == []
    assert list(tmp_path.iterdir()) == [path]
    write(tmp_path / "again", again, encoding)
    assert (tmp_path / "again").read_bytes() == path.read_bytes()


@every_encoding
def test_arrays_are_fit_for_work(tmp_path, encoding):
    path = path_for(tmp_path, encoding)
    write(path, tagged(tets(), encoding), encoding)
    mesh, _ = read(path)
    arrays = [mesh.points, *mesh.point_data.values()]
    for block in mesh.blocks:
        assert block.cells.dtype == np.int64
        arrays += [block.cells, *block.data.values()]
    for array in arrays:
        assert array.flags.c_contiguous
        assert array.flags.writeable
        assert array.dtype.isnative


@every_encoding
def test_single_precision_is_kept_where_the_format_has_it(tmp_path, encoding):
    mesh = tagged(tets(), encoding)
    mesh.points = np.clip(mesh.points, -1, 1).astype(np.float32)
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    again, source = read(path)
    if FORMATS[encoding.format].family == "gmsh":
        assert_same_array(again.points, mesh.points.astype(np.float64))
    else:
        assert_same_array(again.points, mesh.points)
    if FORMATS[encoding.format].family == "medit":
        assert source.encoding.version == "1"


@every_encoding
@settings(max_examples=25, deadline=None)
@given(points=hnp.arrays(np.float64, (4, 3), elements=st.floats(allow_nan=False)))
def test_coordinates_keep_every_bit(tmp_path_factory, encoding, points):
    mesh = Mesh(points, [Block("tetra", ints([0, 1, 2, 3]))])
    path = path_for(tmp_path_factory.mktemp("bits"), encoding)
    write(path, mesh, encoding)
    assert_same_array(read(path)[0].points, points)


@every_encoding
def test_points_that_are_not_finite_are_read(tmp_path, encoding):
    mesh = tets()
    mesh.points[0] = (np.nan, np.inf, -np.inf)
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    np.testing.assert_array_equal(read(path)[0].points, mesh.points)


@every_encoding
def test_vertex_numbers_out_of_range_are_read(tmp_path, encoding):
    mesh = Mesh(POINTS.copy(), [Block("tetra", ints([0, 1, 2, 3], [-1, 1, 2, 77]))])
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    assert_same_array(read(path)[0].blocks[-1].cells, mesh.blocks[0].cells)


@pytest.mark.parametrize("name", ["gmsh", "gmsh22", "vtk", "medit", "meditb"])
@pytest.mark.parametrize("blocks", [[], [Block("line", ints([0, 1]))]], ids=["points", "lines"])
def test_meshes_without_faces(tmp_path, name, blocks):
    encoding = FORMATS[name].default
    path = path_for(tmp_path, encoding)
    write(path, Mesh(POINTS.copy(), blocks), encoding)
    mesh, _ = read(path)
    assert_same_array(mesh.points, POINTS)
    assert [block.type for block in mesh.blocks] == [block.type for block in blocks]


@pytest.mark.parametrize("name", ["gmsh", "gmsh22", "vtk", "vtu"])
@pytest.mark.parametrize("kind", ["line3", "triangle6", "tetra10", "hexahedron20", "wedge15"])
def test_quadratic_cells(tmp_path, name, kind):
    n = int(re.sub("[a-z]", "", kind))
    points = np.random.default_rng(1).random((n, 3))
    encoding = FORMATS[name].default
    path = path_for(tmp_path, encoding)
    write(path, Mesh(points, [Block(kind, np.arange(n)[None])]), encoding)
    (block,) = read(path)[0].blocks
    assert (block.type, block.cells.tolist()) == (kind, [list(range(n))])


# ---- from one format to another


def refs_of(mesh):
    """The integer tag of each cell, by type: physical group or reference."""
    found = {}
    for block in mesh.blocks:
        tags = block.data.get(PHYSICAL, block.data.get(REF))
        found.setdefault(block.type, []).extend(tags.tolist())
    return {cell_type: tags for cell_type, tags in found.items() if cell_type != "vertex"}


@pytest.mark.parametrize("target", ENCODINGS, ids=name_of)
@pytest.mark.parametrize("origin", ["gmsh", "gmsh22", "medit", "meditb", "vtk", "vtu"])
def test_conversion_keeps_tags_cells_and_points(tmp_path, origin, target):
    source = FORMATS[origin].default
    family = FORMATS[origin].family
    mesh = tets()
    for i, block in enumerate(mesh.blocks):
        n = len(block.cells)
        block.data = {REF: np.full(n, 5 + i)}
        if family == "gmsh" or origin == "vtu":
            block.data = {PHYSICAL: np.full(n, 5 + i), GEOMETRICAL: np.full(n, 1 + i)}
    first = path_for(tmp_path, source)
    write(first, mesh, source)
    second = path_for(tmp_path, target).with_stem("second")
    write(second, read(first)[0], target)
    again, _ = read(second)
    assert refs_of(again) == {"line": [6, 6], "triangle": [7], "tetra": [8, 9]}
    assert_same_array(again.points, mesh.points)
    for cell_type in ("line", "triangle", "tetra"):
        cells = [b.cells for b in again.blocks if b.type == cell_type]
        wanted = [b.cells for b in mesh.blocks if b.type == cell_type]
        assert_same_array(np.concatenate(cells), np.concatenate(wanted))


def test_gmsh_from_medit_has_groups_and_entities(tmp_path):
    mesh = tets()
    del mesh.blocks[0]
    for block, ref in zip(mesh.blocks, (0, 4, -2, 4), strict=True):
        block.data = {REF: np.full(len(block.cells), ref)}
    for name in ("gmsh", "gmsh22"):
        path = tmp_path / f"{name}.msh"
        write(path, mesh, FORMATS[name].default)
        blocks = read(path)[0].blocks
        physical = [tag for block in blocks for tag in block.data[PHYSICAL].tolist()]
        entities = [tag for block in blocks for tag in block.data[GEOMETRICAL].tolist()]
        assert physical == [0, 0, 4, -2, 4]
        assert entities == [1, 1, 4, 7, 4]  # Gmsh takes positive ones only


def test_medit_from_gmsh_has_entities_where_there_are_no_groups(tmp_path):
    mesh = tets()
    for i, block in enumerate(mesh.blocks):
        n = len(block.cells)
        group = 7 * (i == 3)
        block.data = {PHYSICAL: np.full(n, group), GEOMETRICAL: np.full(n, 1 + i)}
    write(tmp_path / "mesh.mesh", mesh, FORMATS["medit"].default)
    blocks = read(tmp_path / "mesh.mesh")[0].blocks
    assert [block.data[REF].tolist() for block in blocks] == [[2, 2], [3], [7, 0]]


def test_gmsh_41_nodes_lie_on_the_lowest_entity(tmp_path):
    path = tmp_path / "mesh.msh"
    write(path, tets(), FORMATS["gmsh"].default)
    dim_tags = read(path)[0].point_data[DIM_TAGS]
    assert dim_tags[:, 0].tolist() == [0, 1, 1, 3, 3]


def test_gmsh_41_entities_have_one_group_each(tmp_path):
    data = {PHYSICAL: ints(1, 2, 1, 0), GEOMETRICAL: ints(5, 5, 6, 5)}
    cells = ints([0, 1, 2], [1, 2, 3], [2, 3, 4], [0, 3, 4])
    mesh = Mesh(POINTS.copy(), [Block("triangle", cells, data)])
    path = tmp_path / "mesh.msh"
    write(path, mesh, FORMATS["gmsh"].default)
    again, _ = read(path)
    groups = {int(b.data[GEOMETRICAL][0]): int(b.data[PHYSICAL][0]) for b in again.blocks}
    assert sorted(groups.values()) == [0, 1, 1, 2]
    assert len(groups) == 4
    assert sum(len(block.cells) for block in again.blocks) == 4


def test_gmsh_41_entity_with_triangles_and_quads(tmp_path):
    mesh = Mesh(POINTS.copy(), [Block("triangle", ints([0, 1, 2])), Block("quad", ints(range(4)))])
    for block in mesh.blocks:
        block.data = {PHYSICAL: ints(9), GEOMETRICAL: ints(1)}
    path = tmp_path / "mesh.msh"
    write(path, mesh, FORMATS["gmsh"].default)
    again, _ = read(path)
    assert [(b.type, b.data[GEOMETRICAL][0]) for b in again.blocks] == [
        ("triangle", 1),
        ("quad", 1),
    ]


def test_what_is_dropped_is_named(tmp_path, caplog):
    mesh = tagged(tets(), FORMATS["gmsh"].default)
    write(tmp_path / "mesh.mesh", mesh, FORMATS["medit"].default)
    (message,) = warnings_of(caplog)
    for what in ("names a name, with: blanks = 3, wall = 2", "stress", "T", GEOMETRICAL, "bounds"):
        assert what in message
    assert "\n" not in message

    caplog.clear()
    mesh = tagged(tets(), FORMATS["vtu"].default)
    write(tmp_path / "mesh.msh", mesh, FORMATS["gmsh"].default)
    (message,) = warnings_of(caplog)
    assert "pair" in message
    assert "a name" not in message
    again, _ = read(tmp_path / "mesh.msh")
    assert_same_array(again.blocks[-1].data["a name"], np.full((1, 3), 1 / 3))


def test_arrays_on_part_of_the_cells_are_filled_up_for_vtk(tmp_path):
    mesh = tets()
    mesh.blocks[3].data = {"n": np.array([7], np.int16), "x": np.array([0.5], np.float32)}
    write(tmp_path / "mesh.vtu", mesh, FORMATS["vtu"].default)
    blocks = {block.type: block for block in read(tmp_path / "mesh.vtu")[0].blocks}
    assert_same_array(blocks["line"].data["n"], np.zeros(2, np.int16))
    assert_same_array(blocks["tetra"].data["n"], np.array([7, 0], np.int16))
    np.testing.assert_array_equal(blocks["tetra"].data["x"], np.array([0.5, np.nan], np.float32))


@pytest.mark.parametrize("name", ["vtk", "vtu"])
def test_names_that_vtk_cannot_hold(tmp_path, name):
    mesh = tets()
    names = ["a\0b\n", "\udcff", '<&">', "50%", "größe"]
    mesh.point_data = {name: np.arange(5.0) + i for i, name in enumerate(names)}
    encoding = FORMATS[name].default
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    arrays = read(path)[0].point_data
    assert list(arrays) == ["a_b_", "_", '<&">', "50%", "größe"]
    assert [array[0] for array in arrays.values()] == [0, 1, 2, 3, 4]


def test_cells_that_a_format_has_not(tmp_path):
    mesh = Mesh(np.zeros((6, 3)), [Block("triangle6", ints(range(6)))])
    with pytest.raises(WriteError, match="triangle6"):
        write(tmp_path / "mesh.mesh", mesh, FORMATS["medit"].default)
    assert list(tmp_path.iterdir()) == []


def test_writing_leaves_the_mesh_alone(tmp_path):
    for encoding in ENCODINGS:
        for target in ENCODINGS:
            mesh, twin = tagged(tets(), encoding), tagged(tets(), encoding)
            write(path_for(tmp_path, target), mesh, target)
            assert_same(mesh, twin)


# ---- which encoding


def test_encoding_keeps_what_the_family_of_the_source_had():
    binary = Encoding("gmsh22", "2.2", binary=True)
    assert encoding_for(Path("x.msh"), binary) == binary
    assert encoding_for(Path("x.MSH"), binary) == binary
    assert encoding_for(Path("x.msh"), binary, "gmsh") == Encoding("gmsh", "4.1", binary=True)
    assert encoding_for(Path("x.msh")) == Encoding("gmsh", "4.1", binary=False)
    assert encoding_for(Path("x.msh"), FORMATS["vtk"].default) == FORMATS["gmsh"].default
    assert encoding_for(Path("x.mesh"), Encoding("meditb", "3", binary=True)) == Encoding(
        "medit", "3", binary=False
    )
    for old, new in (("2.0", "2.0"), ("3.0", "3.0"), ("1.0", "4.2"), ("5.0", "5.1")):
        wanted = Encoding("vtk", new, binary=False)
        assert encoding_for(Path("x.vtk"), Encoding("vtk", old, binary=False)) == wanted
    assert encoding_for(Path("x.vtk"), FORMATS["medit"].default) == FORMATS["vtk"].default
    plain = Encoding("vtu", "0.1", binary=True)
    assert encoding_for(Path("x.vtu"), plain) == plain
    assert encoding_for(Path("x.vtu")).compressed
    assert encoding_for(Path("x.anything"), None, "meditb").format == "meditb"


def test_unknown_formats_are_refused_with_the_choices():
    with pytest.raises(ConfigError, match=r"gmsh, gmsh22, vtk, vtu, medit, meditb"):
        encoding_for(Path("x.msh"), None, "stl")
    with pytest.raises(WriteError, match=r"x\.stl: .*\.msh, \.vtk, \.vtu, \.mesh, \.meshb"):
        encoding_for(Path("x.stl"))
    with pytest.raises(WriteError, match=r"\.msh"):
        encoding_for(Path("x"))


@every_encoding
def test_sniffing_looks_into_the_file(tmp_path, caplog, encoding):
    path = tmp_path / "wrong_name.vtk"
    write(path, tagged(tets(), encoding), encoding)
    assert sniff(path) == encoding
    assert bool(warnings_of(caplog)) == (encoding.format != "vtk")


def test_formats_table():
    for name, row in FORMATS.items():
        assert row.name == row.default.format == name
        assert row.description
        assert encoding_for(Path("x" + row.extensions[0]), row.default) == row.default


def test_importing_is_cheap():
    code = "import sys, meshopt_cli.formats; sys.exit('meshio' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# ---- files that cannot be read


def assert_unreadable(path, *words):
    with pytest.raises(ReadError) as caught:
        read(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def is_refused(path):
    """Read a file that may be good or bad; any error but a ReadError fails the test."""
    with contextlib.suppress(ReadError):
        read(path)
        return False
    return True


def test_missing_folder_empty_and_unknown(tmp_path):
    assert_unreadable(tmp_path / "no.msh", "no such file")
    (tmp_path / "folder.msh").mkdir()
    assert_unreadable(tmp_path / "folder.msh", "directory")
    (tmp_path / "none.vtk").touch()
    assert_unreadable(tmp_path / "none.vtk", "empty")
    (tmp_path / "mesh.stl").write_text("solid")
    assert_unreadable(tmp_path / "mesh.stl", "extension", ".msh, .vtk, .vtu, .mesh, .meshb")
    (tmp_path / "lfs.mesh").write_text("version https://git-lfs.github.com/spec/v1\noid 1\n")
    assert_unreadable(tmp_path / "lfs.mesh", "git lfs pull")


def test_no_permission(tmp_path, monkeypatch):
    def refuse(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(ReadError, match="permission denied"):
        read(tmp_path / "mesh.msh")


@pytest.mark.parametrize("extension", [".msh", ".vtk", ".vtu", ".mesh", ".meshb"])
@pytest.mark.parametrize("content", [b"hello\n", b"\0\1\2\3" * 99, "é\n".encode("latin-1"), b"\n"])
def test_garbage(tmp_path, extension, content):
    path = tmp_path / ("mesh" + extension)
    path.write_bytes(content)
    assert_unreadable(path, "not a")


@every_encoding
def test_truncated_files(tmp_path, capfd, encoding):
    path = path_for(tmp_path, encoding)
    write(path, tagged(tets(), encoding), encoding)
    whole = path.read_bytes()
    n_refused = 0
    for eighth in range(1, 8):
        path.write_bytes(whole[: len(whole) * eighth // 8])
        n_refused += is_refused(path)
    assert n_refused >= 4
    assert capfd.readouterr() == ("", "")


@every_encoding
def test_damaged_files(tmp_path, encoding):
    path = path_for(tmp_path, encoding)
    write(path, tagged(tets(), encoding), encoding)
    whole = path.read_bytes()
    random = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(whole)
        damaged[random.integers(len(whole))] = random.integers(256)
        path.write_bytes(damaged)
        is_refused(path)


# ---- Gmsh

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


def text_mesh(tmp_path, text, name="mesh.msh"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_gmsh_groups_on_part_of_the_entities(tmp_path):
    mesh, _ = read(text_mesh(tmp_path, MESH_41))
    assert [block.data[PHYSICAL].tolist() for block in mesh.blocks] == [[0], [0], [7], [0]]
    assert [block.data[GEOMETRICAL].tolist() for block in mesh.blocks] == [[1], [4], [1], [2]]
    assert mesh.names == {"left one": (7, 3)}
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
    read(text_mesh(tmp_path, MESH_41 + "$Periodic\n0\n$EndPeriodic\n"))
    assert "Periodic" in warnings_of(caplog)[0]


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
    assert "partitions" in warnings_of(caplog)[0]


def test_gmsh_22_many_elements_in_runs_of_all_lengths(tmp_path):
    random = np.random.default_rng(5)
    elements, expected = [], []
    for n in [1, 63, 64, 65, 255, 256, 257, 1000, 1, 1, 7]:
        n_tags, nodes = random.integers(0, 3), random.choice([3, 4])
        for _ in range(n):
            cell = random.integers(1, 6, nodes)
            tags = random.integers(1, 6, n_tags)
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
        ("$NOD\n1\n1 0 0 0\n$ENDNOD\n", ("Gmsh format 1", "save it as 4.1 or 2.2")),
        ("$MeshFormat\n4 0 8\n$EndMeshFormat\n", ("Gmsh format 4.0", "save it as 4.1")),
        ("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", ("Gmsh format 4.0",)),
        ("$MeshFormat\n4.1 1 8\n\0\0\0\1\n$EndMeshFormat\n", ("big-endian",)),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", ("$Nodes",)),
        (MESH_41.replace("3 2 4 1\n", "3 2 999 1\n"), ("type 999",)),
        (MESH_41.replace("4 4 1 4", "4 5 1 5"), ("announced",)),
        (MESH_41.replace("$EndNodes", ""), ("$Nodes has no end",)),
    ],
)
def test_gmsh_files_that_are_refused(tmp_path, start, words):
    assert_unreadable(text_mesh(tmp_path, start), *words)


# ---- Medit

MEDIT = """# as Mmg writes it
MeshVersionFormatted
3
Dimension 3
Vertices
4
0 0 0 1
1 0 0 16777217
0 1e0 0 -3 # a comment
0 0 1 4
RequiredVertices
1
2
Edges 1
1 2 8
RequiredEdges
1
1
Corners
0
Geometry
"other.mesh"
Tetrahedra
1
1 2 3 0 7
End
"""


def test_medit_sections_that_mmg_writes(tmp_path, caplog):
    mesh, source = read(text_mesh(tmp_path, MEDIT, "mesh.mesh"))
    assert source.encoding.version == "3"
    assert mesh.point_data[REF].tolist() == [1, 16777217, -3, 4]
    assert [(b.type, b.cells.tolist(), b.data[REF].tolist()) for b in mesh.blocks] == [
        ("line", [[0, 1]], [8]),
        ("tetra", [[0, 1, 2, -1]], [7]),
    ]
    assert mesh.point_data["medit:required"].tolist() == [0, 1, 0, 0]
    assert mesh.blocks[0].data["medit:required"].tolist() == [1]
    (message,) = warnings_of(caplog)
    assert message == "of the Medit file are dropped: Geometry"


def test_medit_single_precision_keeps_large_references(tmp_path):
    text = MEDIT.replace("Formatted\n3", "Formatted 1")
    mesh, _ = read(text_mesh(tmp_path, text, "mesh.mesh"))
    assert mesh.points.dtype == np.float32
    assert mesh.point_data[REF][1] == 16777217


def test_medit_has_one_section_for_each_type(tmp_path):
    path = tmp_path / "mesh.mesh"
    write(path, tets(), FORMATS["medit"].default)
    assert path.read_text().count("Tetrahedra") == 1


def test_medit_binary_sections_are_skipped_by_their_length(tmp_path, caplog):
    path = tmp_path / "mesh.meshb"
    mesh = tagged(tets(), FORMATS["meditb"].default)
    write(path, mesh, FORMATS["meditb"].default)
    data = path.read_bytes()
    end = data[-8:]
    corners = np.array([13, len(data) - 8 + 16, 1, 2], "<i4").tobytes()
    path.write_bytes(data[:-8] + corners + end)
    mesh.point_data["medit:corner"] = np.array([0, 1, 0, 0, 0], np.uint8)
    assert_same(read(path)[0], mesh)
    periods = np.array([61 + 20, len(data) - 8 + 16, 1, 2], "<i4").tobytes()
    path.write_bytes(data[:-8] + periods + end)
    read(path)
    assert "are dropped" in warnings_of(caplog)[0]


def with_lists(mesh):
    """A mesh of tets with everything that Medit says of vertices and cells."""
    n = len(mesh.points)
    flags = np.arange(n) % 2
    mesh.point_data = {REF: np.arange(n), "medit:corner": (1 - flags).astype(np.uint8)}
    mesh.point_data["medit:required"] = flags.astype(np.uint8)
    for name in ("medit:normal", "medit:tangent"):
        vectors = mesh.points.clip(-1, 1) + 1 / 3
        vectors[flags == 0] = np.nan
        mesh.point_data[name] = vectors
    for i, block in enumerate(mesh.blocks):
        block.data = {REF: np.full(len(block.cells), i)}
        if block.type in ("line", "triangle"):
            block.data["medit:required"] = np.array([1] * len(block.cells), np.uint8)
        if block.type == "line":
            block.data["medit:ridge"] = np.array([0, 1], np.uint8)
    mesh.blocks = merged(mesh.blocks[1:])
    return mesh


def unlisted(arrays):
    """Arrays by name, without regard to their order and the kind of their numbers."""
    return {n: np.nan_to_num(np.asarray(a, float), nan=-9).tolist() for n, a in arrays.items()}


@pytest.mark.parametrize("target", ENCODINGS, ids=name_of)
def test_lists_of_medit_survive_in_every_format(tmp_path, caplog, target):
    mesh = with_lists(tets())
    original = FORMATS["medit"].default
    write(tmp_path / "one.mesh", mesh, original)
    first, _ = read(tmp_path / "one.mesh")
    assert_same(mesh, first)
    second = path_for(tmp_path, target).with_stem("two")
    write(second, first, target)
    write(tmp_path / "three.mesh", read(second)[0], original)
    last, _ = read(tmp_path / "three.mesh")
    assert unlisted(last.point_data) == unlisted(mesh.point_data)
    assert [b.type for b in last.blocks] == [b.type for b in mesh.blocks]
    for one, other in zip(mesh.blocks, last.blocks, strict=True):
        assert unlisted(one.data) == {
            n: a for n, a in unlisted(other.data).items() if n in one.data or np.any(a)
        }
    lost = [m for m in warnings_of(caplog) if "gmsh:" not in m and "entities of nodes" not in m]
    assert lost == []


@pytest.mark.parametrize("section", ["RequiredVertices", "Ridges", "NormalAtVertices"])
def test_medit_lists_of_what_is_not_there(tmp_path, caplog, section):
    """Mmg writes such tangents: they are no reason to refuse a mesh."""
    numbers = "3 2\n3 1" if section == "NormalAtVertices" else "9\n1"
    text = MEDIT.replace("RequiredVertices\n1\n2\n", "").replace("Geometry", "Comment")
    text = text.replace("Corners\n0", f"Normals\n1\n0 0 1\n{section}\n2\n{numbers}")
    mesh, _ = read(text_mesh(tmp_path, text, "mesh.mesh"))
    assert f"{section} with numbers of what is not there" in warnings_of(caplog)[0]
    if section == "NormalAtVertices":
        assert np.isfinite(mesh.point_data["medit:normal"]).all(axis=1).tolist() == [0, 0, 1, 0]
    elif section == "Ridges":
        assert mesh.blocks[0].data["medit:ridge"].tolist() == [1]
    else:
        assert mesh.point_data["medit:required"].tolist() == [1, 0, 0, 0]


def test_medit_normals_without_vertices_are_named(tmp_path, caplog):
    text = MEDIT.replace("Corners\n0", "Normals\n1\n0 0 1")
    mesh, _ = read(text_mesh(tmp_path, text, "mesh.mesh"))
    assert "medit:normal" not in mesh.point_data
    assert "Normals" in warnings_of(caplog)[0]


def test_gmsh_points_become_references_of_required_vertices(tmp_path, caplog):
    mesh = tets()
    for i, block in enumerate(mesh.blocks):
        block.data = {PHYSICAL: np.full(len(block.cells), 5 + i)}
    write(tmp_path / "mesh.mesh", mesh, FORMATS["medit"].default)
    assert warnings_of(caplog) == []
    again, _ = read(tmp_path / "mesh.mesh")
    assert again.point_data[REF].tolist() == [5, 0, 0, 0, 0]
    assert again.point_data["medit:required"].tolist() == [1, 0, 0, 0, 0]


@pytest.mark.parametrize(
    ("name", "key"), [("medit", REF), ("gmsh", PHYSICAL), ("gmsh22", PHYSICAL)]
)
def test_arrays_of_any_name_that_make_regions_become_groups(tmp_path, name, key):
    mesh = tets()
    for i, block in enumerate(mesh.blocks):
        block.data = {
            "x": np.full(len(block.cells), 0.5),
            "layer": np.full(len(block.cells), 3 + i),
        }
    path = path_for(tmp_path, FORMATS[name].default)
    write(path, mesh, FORMATS[name].default)
    tets_of = [b.data[key] for b in read(path)[0].blocks if b.type == "tetra"]
    assert np.concatenate(tets_of).tolist() == [6, 7]


def test_medit_binary_of_the_other_byte_order(tmp_path):
    path = tmp_path / "mesh.meshb"
    words = [1, 2, 3, 20, 3]
    vertices = np.array([1.5, 2.5, 3.5], ">f8").tobytes() + np.array([6], ">i4").tobytes()
    data = np.array(words, ">i4").tobytes() + np.array([4, 60, 1], ">i4").tobytes() + vertices
    path.write_bytes(data + np.array([54, 0], ">i4").tobytes())
    mesh, source = read(path)
    assert mesh.points.tolist() == [[1.5, 2.5, 3.5]]
    assert mesh.point_data[REF].tolist() == [6]
    assert source.encoding.binary


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("Vertices\n4", "Vertices\n5", ("malformed",)),
        ("Tetrahedra\n1", "Tetrahedra\n2", ("malformed",)),
        ("Dimension 3", "Dimension 4", ("Dimension",)),
        ("Formatted\n3", "Formatted\n9", ("MeshVersionFormatted",)),
        ("\nVertices", "\nSomethings", ("Vertices",)),
        ("1 2 3 0 7", "1 2 3 0.5 7", ("a number was expected",)),
    ],
)
def test_medit_files_that_are_refused(tmp_path, old, new, words):
    assert_unreadable(text_mesh(tmp_path, MEDIT.replace(old, new, 1), "mesh.mesh"), *words)


# ---- VTK

VTK_51 = """# vtk DataFile Version 5.1
title
ASCII
DATASET UNSTRUCTURED_GRID
FIELD FieldData 1
TIME 1 1 double
0.5
POINTS 4 float
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 3 7
OFFSETS vtktypeint64
0 4 7
CONNECTIVITY vtktypeint64
0 1 2 3 0 1 2
CELL_TYPES 2
10
5

CELL_DATA 2
SCALARS id int 1
LOOKUP_TABLE default
4 5
FIELD FieldData 2
a%20flag 1 2 unsigned_char
1 0
ids 1 2 vtkIdType
7 8
POINT_DATA 4
NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1
GLOBAL_IDS gid vtkIdType
9 8 7 6
TENSORS t double
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("UNSTRUCTURED_GRID", "POLYDATA"),
        ("10\n5", "10\n4"),
        ("10\n5", "42\n5"),
        ("POINTS 4", "POINTS 5"),
        ("0 4 7", "0 4 8"),
    ],
)
def test_vtk_files_that_are_refused(tmp_path, capfd, old, new):
    assert_unreadable(text_mesh(tmp_path, VTK_51.replace(old, new), "mesh.vtk"), "VTK")
    assert capfd.readouterr() == ("", "")


def test_vtk_list_of_types_that_ends_early(tmp_path):
    text = """# vtk DataFile Version 3.0
title
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 3 double
0 0 0 1 0 0 0 1 0
CELLS 2 8
3 0 1 2
3 2 1 0
CELL_TYPES 2
5
"""
    assert_unreadable(text_mesh(tmp_path, text, "mesh.vtk"), "truncated")


def test_vtu_of_later_versions(tmp_path):
    encoding = Encoding("vtu", "1.0", binary=False)
    path = tmp_path / "mesh.vtu"
    mesh = tagged(tets(), encoding)
    write(path, mesh, encoding)
    path.write_text(path.read_text().replace('version="1.0" byte', 'version="2.3" byte'))
    again, source = read(path)
    assert_same(again, mesh)
    assert source.encoding.version == "2.3"
    assert encoding_for(path, source.encoding).version == "1.0"


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("<Piece ", '<Piece NumberOfPoints="0" NumberOfCells="0"></Piece>\n<Piece ', "pieces"),
        ('compressor="vtkZLibDataCompressor"', 'compressor="vtkLZ4DataCompressor"', "LZ4"),
        ('NumberOfCells="6"', 'NumberOfCells="0"', "no cells"),
        ('"UnstructuredGrid"', '"PolyData"', "PolyData"),
        ("</UnstructuredGrid>", "", "malformed"),
    ],
)
def test_vtu_files_that_are_refused(tmp_path, old, new, word):
    path = tmp_path / "mesh.vtu"
    write(path, tets(), FORMATS["vtu"].default)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert_unreadable(path, word)


# ---- writing


def assert_unwritable(path, words):
    with pytest.raises(WriteError, match=words) as caught:
        write(path, tets(), FORMATS["medit"].default)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


class Halfway:
    """A writer that fails after a part of the file."""

    def __init__(self, error):
        self.error = error

    def __call__(self, path, mesh, encoding):
        Path(path).write_bytes(b"MeshVersionFormatted 2\n")
        raise self.error


@pytest.mark.parametrize("error", [ValueError("no\nway"), OSError(28, "No space left on device")])
def test_failure_leaves_the_old_file(tmp_path, monkeypatch, error):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    monkeypatch.setitem(FORMATS, "medit", replace(FORMATS["medit"], write=Halfway(error)))
    assert_unwritable(path, "cannot be written")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_interruption_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    halfway = replace(FORMATS["medit"], write=Halfway(KeyboardInterrupt()))
    monkeypatch.setitem(FORMATS, "medit", halfway)
    with pytest.raises(KeyboardInterrupt):
        write(path, tets(), FORMATS["medit"].default)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_folder_that_cannot_be_written_to(tmp_path, monkeypatch):
    def refuse(*args):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    assert_unwritable(tmp_path / "mesh.mesh", "permission denied")
    assert list(tmp_path.iterdir()) == []
    assert_unwritable(tmp_path / "none" / "mesh.mesh", "no such folder")


def test_only_regular_files_that_may_be_written_are_replaced(tmp_path, monkeypatch):
    (tmp_path / "folder.mesh").mkdir()
    assert_unwritable(tmp_path / "folder.mesh", "regular file")
    os.mkfifo(tmp_path / "pipe.mesh")
    assert_unwritable(tmp_path / "pipe.mesh", "regular file")
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    monkeypatch.setattr(os, "access", lambda *args: False)
    assert_unwritable(path, "write-protected")
    assert path.read_text() == "old"


def test_permissions_are_kept(tmp_path):
    path = tmp_path / "mesh.mesh"
    old = os.umask(0o027)
    try:
        write(path, tets(), FORMATS["medit"].default)
        assert path.stat().st_mode & 0o777 == 0o640
        path.chmod(0o604)
        write(path, tets(), FORMATS["medit"].default)
        assert path.stat().st_mode & 0o777 == 0o604
    finally:
        os.umask(old)


def test_symbolic_links_are_written_through(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    link = tmp_path / "mesh.mesh"
    link.symlink_to(folder / "real.mesh")
    for _ in range(2):  # first where there is nothing behind it
        write(link, tets(), FORMATS["medit"].default)
        assert link.is_symlink()
        assert list(folder.iterdir()) == [folder / "real.mesh"]
        assert len(read(link)[0].points) == len(POINTS)


@pytest.mark.parametrize("suffix", [".mesh", ".meshb", ".msh", ".vtk", ".vtu"])
def test_a_block_without_cells(tmp_path, suffix):
    """A file may announce cells of a type and have none of them."""
    mesh = tet_grid(1)
    mesh.blocks.append(Block("line", np.empty((0, 2), np.int64)))
    path = tmp_path / f"mesh{suffix}"
    write(path, mesh, encoding_for(path))
    again, _ = read(path)
    assert sum(len(block.cells) for block in again.blocks) == len(mesh.blocks[0].cells)


def test_owner_and_group_are_kept(tmp_path):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    try:
        os.chown(path, 12345, 23456)
    except PermissionError:
        pytest.skip("only root may do that")
    write(path, tets(), FORMATS["medit"].default)
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 23456)


LIMITED = """
import resource, sys
from pathlib import Path
from meshopt_cli.errors import WriteError
from meshopt_cli.formats import FORMATS, read, write
mesh, source = read(Path(sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))
try:
    write(Path(sys.argv[2]), mesh, FORMATS[sys.argv[3]].default)
except WriteError as error:
    sys.exit(str(error))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
@pytest.mark.parametrize("name", FORMATS)
def test_no_room_leaves_the_old_file(tmp_path, name):
    write(tmp_path / "in.mesh", tet_grid(4), FORMATS["medit"].default)
    folder = tmp_path / "folder"
    folder.mkdir()
    path = folder / f"out{FORMATS[name].extensions[0]}"
    path.write_text("old")
    arguments = [sys.executable, "-c", LIMITED, str(tmp_path / "in.mesh"), str(path), name]
    ran = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert ran.returncode == 1
    (line,) = ran.stderr.splitlines()
    assert line.startswith(f"{path}: cannot be written")
    assert path.read_text() == "old"
    assert list(folder.iterdir()) == [path]


FOREVER = """
import sys
from pathlib import Path
from meshopt_cli.formats import encoding_for, read, write
meshes = [read(Path(name))[0] for name in sys.argv[1:3]]
path = Path(sys.argv[3])
while True:
    for mesh in meshes:
        write(path, mesh, encoding_for(path))
        print("written", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
@pytest.mark.parametrize("name", ["mesh.mesh", "mesh.msh", "mesh.vtu", "mesh.vtk.gz"])
def test_a_process_that_is_killed_leaves_the_old_file_or_the_new_one(tmp_path, name):
    whole = []
    inputs = [tmp_path / "one.mesh", tmp_path / "two.mesh"]
    for path, n in zip(inputs, (6, 7), strict=True):
        write(path, tet_grid(n), FORMATS["medit"].default)
        write(tmp_path / name, read(path)[0], encoding_for(Path(name)))
        whole.append((tmp_path / name).read_bytes())
    command = [sys.executable, "-c", FOREVER, *map(str, inputs), str(tmp_path / name)]
    for delay in (0.0, 0.003, 0.011, 0.017):
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            process.stdout.readline()
            time.sleep(delay)
            process.kill()
        assert (tmp_path / name).read_bytes() in whole


# ---- compressed files


@every_encoding
def test_compressed_files_hold_the_same(tmp_path, encoding):
    mesh = tagged(tets(), encoding)
    plain = path_for(tmp_path, encoding)
    path = plain.with_name(plain.name + ".gz")
    write(plain, mesh, encoding)
    written = write(path, mesh, encoding)
    assert gzip.decompress(path.read_bytes()) == plain.read_bytes()
    assert written.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    again, source = read(path)
    assert_same(mesh, again)
    assert (source.encoding, source.sha256) == (encoding, written.sha256)
    assert sniff(path) == encoding
    assert encoding_for(path, source.encoding) == encoding_for(plain, source.encoding)
    first = path.read_bytes()
    write(path, mesh, encoding)
    assert path.read_bytes() == first


@pytest.mark.parametrize("cut", [0.3, 0.9, 0.999])
def test_compressed_files_that_are_truncated(tmp_path, cut):
    path = tmp_path / "mesh.mesh.gz"
    write(path, tets(), FORMATS["medit"].default)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(cut * len(whole))])
    assert_unreadable(path, "truncated", "gzip")


def test_compressed_content_is_known_by_itself(tmp_path):
    path = tmp_path / "mesh.mesh"
    path.write_bytes(gzip.compress(MEDIT.encode()))
    assert len(read(path)[0].points) == 4


# ---- every format to every other


@st.composite
def meshes(draw):
    """Tets with triangles, lines and points, in some groups, and arrays of all widths."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(5, 9))
    mesh = Mesh(random.normal(size=(n, 3)) * 10.0 ** random.integers(-9, 9), [])
    if draw(st.booleans()):
        mesh.points = mesh.points.astype(np.float32)
    tags = draw(st.sets(st.sampled_from([PHYSICAL, GEOMETRICAL, REF, "layer"])))
    arrays = draw(
        st.dictionaries(st.sampled_from(["a", "b c", "d"]), st.sampled_from([1, 2, 3, 9]))
    )
    for cell_type, width in (("vertex", 1), ("line", 2), ("triangle", 3), ("tetra", 4)):
        count = draw(st.integers(cell_type == "tetra", 3))
        cells = np.array([random.permutation(n)[:width] for _ in range(count)]).reshape(-1, width)
        cells = np.unique(np.sort(cells, axis=1), axis=0)
        data = {name: random.integers(1, 4, len(cells)) for name in sorted(tags)}
        data |= {a: random.normal(size=(len(cells), w)).squeeze(-1) if w == 1 else
                 random.normal(size=(len(cells), w)) for a, w in arrays.items()}  # fmt: skip
        if len(cells):
            mesh.blocks.append(Block(cell_type, cells, data))
    mesh.point_data = {
        f"p{a}": random.normal(size=(n, w) if w > 1 else n) for a, w in arrays.items()
    }
    mesh.names = draw(st.sampled_from([{}, {"wall": (1, 2), "a name": (2, 3)}]))
    return mesh


def by_cell(mesh, name):
    """Values of an array by type and vertices of a cell."""
    return {
        (block.type, *cell): np.asarray(value, float).tolist()
        for block in mesh.blocks
        if name in block.data
        for cell, value in zip(block.cells.tolist(), block.data[name], strict=True)
    }


def group_by_cell(mesh, family):
    """The tag that a family of formats has for a group."""
    names = {"gmsh": (PHYSICAL, REF), "medit": (REF, PHYSICAL, GEOMETRICAL)}
    return next((by_cell(mesh, n) for n in names[family] if by_cell(mesh, n)), {})


@settings(max_examples=120, deadline=None)
@given(mesh=meshes(), origin=st.sampled_from(ENCODINGS), target=st.sampled_from(ENCODINGS))
def test_nothing_is_lost_without_a_word(tmp_path_factory, mesh, origin, target):
    """From any format to any other: every array, group and name is there, or named as lost."""
    folder = tmp_path_factory.mktemp("matrix")
    first, second = path_for(folder, origin), path_for(folder, target).with_stem("second")
    write(first, mesh, origin)
    mesh, _ = read(first)
    lost = write(second, mesh, target).lost
    again, source = read(second)
    assert source.encoding.format == target.format
    if FORMATS[target.format].family == "gmsh":
        assert_same_array(again.points, mesh.points.astype(np.float64))
    else:
        assert_same_array(again.points, mesh.points)
    family = FORMATS[target.format].family
    listed = " ".join(lost)
    for block in mesh.blocks:
        if block.type == "vertex" and family == "medit":
            continue
        cells = [b.cells for b in again.blocks if b.type == block.type]
        found = set(map(tuple, np.concatenate(cells).tolist()))
        assert set(map(tuple, block.cells.tolist())) <= found
    for name in dict.fromkeys(name for block in mesh.blocks for name in block.data):
        values = {k: v for k, v in by_cell(mesh, name).items() if k[0] != "vertex"}
        kept = by_cell(again, name)
        # without a group, or in group 0, is the same
        same = all(kept.get(k, 0.0) == v for k, v in values.items())
        same |= name == GEOMETRICAL and "tags of entities" in listed
        groups = {} if family.startswith("vt") else group_by_cell(again, family)
        as_group = values.items() <= groups.items()
        assert same or name in listed or as_group, name
    for name, values in mesh.point_data.items():
        if name in listed or (name == DIM_TAGS and "entities" in listed):
            continue
        if name in (REF, DIM_TAGS) and name not in again.point_data:
            assert name == DIM_TAGS or not values.any()
            continue
        if name == REF and family == "medit" and not values.any():
            continue  # it has those of the points that are cells
        np.testing.assert_array_equal(again.point_data[name], values)
    assert again.names == mesh.names or all(name in listed for name in mesh.names)


def test_gmsh_entities_in_several_groups(tmp_path, caplog):
    text = MESH_41.replace("1 0 0 0 1 1 1 1 7 1 4", "1 0 0 0 1 1 1 3 7 9 5 1 4")
    mesh, _ = read(text_mesh(tmp_path, text))
    assert mesh.more_groups == {(3, 1): (9, 5)}
    for binary in (False, True):
        encoding = Encoding("gmsh", "4.1", binary)
        write(tmp_path / "again.msh", mesh, encoding)
        assert read(tmp_path / "again.msh")[0].more_groups == mesh.more_groups
    assert warnings_of(caplog) == []
    for name in ("gmsh22", "vtk", "vtu", "medit", "meditb"):
        lost = write(tmp_path / "out", mesh, FORMATS[name].default).lost
        assert "all but the first physical group of an entity" in lost
