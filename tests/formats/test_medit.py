"""Medit files, as text and as binary."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, encoding_for, read, write
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import (
    ENCODINGS,
    MEDIT,
    PHYSICAL,
    REF,
    assert_same,
    assert_unreadable,
    merged,
    name_of,
    path_for,
    tagged,
    tets,
    text_mesh,
    warnings_of,
)


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
    assert message.endswith("dropped on reading: Geometry")


def test_medit_single_precision_keeps_large_references(tmp_path):
    text = MEDIT.replace("Formatted\n3", "Formatted 1")
    mesh, _ = read(text_mesh(tmp_path, text, "mesh.mesh"))
    assert mesh.points.dtype == np.float32
    assert mesh.point_data[REF][1] == 16777217


def test_bamg_counts_versions_from_zero(tmp_path):
    """Its sections of the geometry, with names of files and lists, are named."""
    text = MEDIT.replace("Formatted\n3", 'Formatted 0\nIdentifier\n"G=a.mesh;1"\nSubDomain\n1 2 3')
    path = text_mesh(tmp_path, text, "mesh.mesh")
    mesh, source = read(path)
    assert mesh.points.dtype == np.float64
    assert {"Identifier", "SubDomain"} <= set(source.lost)
    write(path, mesh, encoding_for(path, source.encoding))
    assert_same(read(path)[0], mesh)
    assert read(path)[1].encoding.version == "2"


@pytest.mark.parametrize("at", ["End", "Tetrahedra", "RequiredVertices"])
def test_a_medit_file_that_is_cut_off_between_sections_says_so(tmp_path, caplog, at):
    read(text_mesh(tmp_path, MEDIT, "mesh.mesh"))
    assert not any("cut off" in one for one in warnings_of(caplog))
    read(text_mesh(tmp_path, MEDIT[: MEDIT.index(at)], "mesh.mesh"))
    assert sum("the file may be cut off, without End" in one for one in warnings_of(caplog)) == 1


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
    assert "dropped on reading" in warnings_of(caplog)[0]


def test_medit_binary_rows_end_before_the_next_section(tmp_path):
    """A section may be longer than its rows: what is left of it is no part of the next."""
    path = tmp_path / "mesh.meshb"
    mesh = tagged(tets(), FORMATS["meditb"].default)
    write(path, mesh, FORMATS["meditb"].default)
    data = path.read_bytes()
    at, padded = 8, data[:8]
    while at + 8 < len(data):
        code, after = np.frombuffer(data, "<i4", 2, at)
        body = data[at + 8 : after] + bytes([255]) * 12
        padded += np.array([code, len(padded) + 8 + len(body)], "<i4").tobytes() + body
        at = after
    path.write_bytes(padded + data[at:])
    assert_same(read(path)[0], mesh)


def test_numbers_too_large_for_single_precision_are_infinite(tmp_path):
    """As they are to who reads them as such: check names the point."""
    text = MEDIT.replace("Formatted\n3", "Formatted 1").replace("\n4\n0 0", "\n4\n1e99 0")
    mesh, _ = read(text_mesh(tmp_path, text, "mesh.mesh"))
    assert mesh.points.dtype == np.float32
    assert np.isinf(mesh.points[0, 0])
    assert np.isfinite(mesh.points[1:]).all()


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
        if block.type in ("line", "triangle", "tetra"):
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


@pytest.mark.parametrize("name", ["medit", "meditb"])
def test_medit_cells_of_second_order(tmp_path, name):
    """The sections are those that Gmsh writes, with the nodes in the same order."""
    nodes = {"line3": 3, "triangle6": 6, "tetra10": 10}
    rows = [(kind, np.arange(n)[None], {REF: np.array([n])}) for kind, n in nodes.items()]
    points = np.random.default_rng(0).random((10, 3))
    mesh = Mesh(points, [Block(*row) for row in rows], {REF: np.zeros(10, int)})
    path = path_for(tmp_path, FORMATS[name].default)
    write(path, mesh, FORMATS[name].default)
    again, source = read(path)
    assert_same(again, mesh)
    assert source.lost == ()


@pytest.mark.parametrize("section", ["HexahedraQ2", "TrianglesP3", "TetrahedraP2Ordering"])
def test_medit_cells_that_cannot_be_read_are_no_less_of_a_mesh(tmp_path, section):
    text = MEDIT.replace("Corners\n0", f"{section}\n1\n1 2 3 4 1 2 3 4")
    assert_unreadable(text_mesh(tmp_path, text, "mesh.mesh"), section, "first order")
