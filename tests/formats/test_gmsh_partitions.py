"""Meshes of Gmsh that are cut up for parallel computing."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, write
from meshopt_cli.mesh.tags import tags_of
from support.encodings import DIM_TAGS, GEOMETRICAL, PARTITION, PHYSICAL, warnings_of
from support.gmsh import POINTS, Builder

BUILDERS = [Builder("4.0"), Builder("4.1"), Builder("4.1", True), Builder("4.1", True, ">")]
OLD = [Builder(v, binary) for v in ("2", "2.2", "3") for binary in (False, True)]


def name_of(builder):
    return f"{builder.spelled}{builder.order if builder.binary else ''}"


def partitioned(builder, ghosts=()):
    """Two tets of one volume in two partitions, with the triangle between them and one outside."""
    points = dict(enumerate(POINTS, 1))
    return b"".join(
        (
            builder.header(),
            builder.names('2 3 "wall"', '3 7 "steel"'),
            builder.entities((2, 2, [3], []), (3, 1, [7], [2])),
            builder.partitioned(
                2,
                ghosts,
                (2, 9, 2, 2, [1], [3]),
                (2, 10, 3, 1, [1, 2], []),
                (3, 5, 3, 1, [1], [7]),
                (3, 6, 3, 1, [2], [7]),
            ),
            builder.nodes(points, [(2, 9, (1,)), (2, 10, (2, 3, 4)), (3, 6, (5,))]),
            builder.elements(
                (2, 9, 2, 0, {1: (1, 2, 3)}),
                (2, 10, 2, 0, {2: (2, 3, 4)}),
                (3, 5, 4, 0, {3: (1, 2, 3, 4)}),
                (3, 6, 4, 0, {4: (2, 3, 4, 5)}),
            ),
        )
    )


@pytest.mark.parametrize("builder", BUILDERS, ids=name_of)
def test_cells_belong_to_the_entities_and_groups_of_the_model(tmp_path, caplog, builder):
    path = tmp_path / "mesh.msh"
    path.write_bytes(partitioned(builder, ghosts=[(11, 1), (12, 2)]))
    mesh, source = read(path)
    triangles, tets = mesh.blocks
    assert triangles.cells.tolist() == [[0, 1, 2]]
    assert tets.cells.tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]
    assert [b.data[PHYSICAL].tolist() for b in mesh.blocks] == [[3], [7, 7]]
    assert [b.data[GEOMETRICAL].tolist() for b in mesh.blocks] == [[2], [1, 1]]
    assert [b.data[PARTITION].tolist() for b in mesh.blocks] == [[1], [1, 2]]
    assert tets.entities.tolist() == [2]
    assert mesh.point_data[DIM_TAGS].tolist() == [[2, 2], *[[3, 1]] * 4]
    assert mesh.names == {(2, 3): "wall", (3, 7): "steel"}
    entities, between = source.lost
    assert "entities of partitions" in entities
    assert between == "elements between partitions (1)"
    assert between in warnings_of(caplog)[0]


def test_partitions_are_no_regions(tmp_path):
    path = tmp_path / "mesh.msh"
    path.write_bytes(partitioned(Builder("4.1")))
    mesh, _ = read(path)
    assert set(tags_of(mesh.blocks[1:])) == {PHYSICAL, GEOMETRICAL}
    for end in ("vtu", "vtk", "msh"):
        new = tmp_path / f"again.{end}"
        write(new, mesh, encoding_for(new))
        again, _ = read(new)
        tets = [block for block in again.blocks if block.type == "tetra"]
        assert np.concatenate([b.data[PARTITION] for b in tets]).tolist() == [1, 2]
        assert PARTITION not in tags_of(tets)


@pytest.mark.parametrize("builder", BUILDERS, ids=name_of)
@pytest.mark.parametrize("target", [Encoding(n, "", b) for n in ("gmsh", "gmsh22") for b in (0, 1)])
def test_partitions_come_back_as_numbers(tmp_path, builder, target):
    path = tmp_path / "mesh.msh"
    path.write_bytes(partitioned(builder))
    mesh, _ = read(path)
    lost = write(tmp_path / "again.msh", mesh, target).lost
    assert not any("partition" in what for what in lost)
    again, _ = read(tmp_path / "again.msh")
    assert again.names == mesh.names
    for one, other in zip(again.blocks, mesh.blocks, strict=True):
        for name in (PHYSICAL, GEOMETRICAL, PARTITION):
            assert one.data[name].tolist() == other.data[name].tolist()
            assert one.data[name].dtype == np.int64


def test_what_cannot_hold_partitions_says_so(tmp_path):
    path = tmp_path / "mesh.msh"
    path.write_bytes(partitioned(Builder("4.1")))
    mesh, _ = read(path)
    for name in ("medit", "meditb"):
        assert PARTITION in write(tmp_path / "out", mesh, FORMATS[name].default).lost


@pytest.mark.parametrize("builder", OLD, ids=name_of)
def test_older_versions_have_a_partition_with_each_element(tmp_path, builder):
    content = builder.header()
    if builder.version >= 3:
        content += builder.entities((3, 1, [7], []))
    content += builder.nodes(dict(enumerate(POINTS, 1)))
    cells = {1: (1, 2, 3, 4)}, {2: (2, 3, 4, 5)}
    content += builder.elements((3, 1, 4, 7, cells[0], 4), (3, 1, 4, 7, cells[1], 6))
    path = tmp_path / "mesh.msh"
    path.write_bytes(content)
    (block,) = read(path)[0].blocks
    assert block.data[PARTITION].tolist() == [4, 6]
    assert block.data[PHYSICAL].tolist() == [7, 7]


@pytest.mark.parametrize(
    "builder", [Builder("2.2"), Builder("2.2", True), Builder("2.2", True, ">")]
)
def test_elements_that_differ_in_the_number_of_their_tags(tmp_path, builder):
    random = np.random.default_rng(3)
    rows, expected = [], []
    for number in range(1, 301):
        n_tags, triangle = int(random.integers(0, 8)), number % 100 < 50
        cell = (random.permutation(5)[: 3 + (not triangle)] + 1).tolist()
        partition = int(random.integers(1, 9))
        tags = [7, 1, max(1, n_tags - 3), partition, -1, -2, -3][:n_tags]
        code = 2 if triangle else 4
        head = (code, 1, n_tags, number) if builder.binary else (number, code, n_tags)
        rows.append(builder.line(("i4", (*head, *tags, *cell))))
        expected.append((number, [c - 1 for c in cell], partition if n_tags > 3 else 0, n_tags > 0))
    content = builder.header() + builder.nodes(dict(enumerate(POINTS, 1)))
    path = tmp_path / "mesh.msh"
    path.write_bytes(content + builder.section("Elements", b"300\n", *rows))
    mesh, source = read(path)
    found = [
        (cell.tolist(), int(partition), bool(group == 7))
        for block in mesh.blocks
        for cell, partition, group in zip(
            block.cells, block.data[PARTITION], block.data[PHYSICAL], strict=True
        )
    ]
    assert found == [row[1:] for row in expected]
    assert source.lost == ("the ghost cells of partitions",)


def test_ghost_cells_are_named(tmp_path):
    text = "1 4 5 7 1 2 3 -4 1 2 3 4\n2 4 4 7 1 1 4 2 3 4 5\n"
    builder = Builder("2.2")
    content = builder.header() + builder.nodes(dict(enumerate(POINTS, 1)))
    path = tmp_path / "mesh.msh"
    path.write_bytes(content + builder.section("Elements", f"2\n{text}".encode()))
    mesh, source = read(path)
    assert mesh.blocks[0].data[PARTITION].tolist() == [3, 4]
    assert source.lost == ("the ghost cells of partitions",)
    ghosts = builder.section("GhostElements", b"1\n1 1 1 2\n")
    path.write_bytes(partitioned(Builder("4.1")) + ghosts)
    assert "the ghost cells of partitions" in read(path)[1].lost
