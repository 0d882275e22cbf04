"""From one format to another."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.errors import WriteError
from meshopt_cli.formats import FORMATS, read, write
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import (
    DIM_TAGS,
    ENCODINGS,
    GEOMETRICAL,
    PHYSICAL,
    POINTS,
    REF,
    assert_same,
    assert_same_array,
    ints,
    name_of,
    path_for,
    tagged,
    tets,
    warnings_of,
)


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
    mesh = Mesh(np.zeros((9, 3)), [Block("quad9", ints(range(9)))])
    with pytest.raises(WriteError, match="quad9"):
        write(tmp_path / "mesh.mesh", mesh, FORMATS["medit"].default)
    assert list(tmp_path.iterdir()) == []


def test_writing_leaves_the_mesh_alone(tmp_path):
    for encoding in ENCODINGS:
        for target in ENCODINGS:
            mesh, twin = tagged(tets(), encoding), tagged(tets(), encoding)
            write(path_for(tmp_path, target), mesh, target)
            assert_same(mesh, twin)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["gmsh", "gmsh22", "medit", "vtu"])
def test_regions_of_any_numbers_are_no_tags_of_a_format(tmp_path, name):
    """What an array with halves, and none for some cells, makes regions of has no group."""
    mesh = tets()
    for block in mesh.blocks:
        block.data = {"density": np.full(len(block.cells), 0.5)}
    mesh.blocks[-1].data["density"][:] = np.nan
    encoding = FORMATS[name].default
    written = write(path_for(tmp_path, encoding), replace(mesh, regions=("density",)), encoding)
    again, _ = read(path_for(tmp_path, encoding))
    kept = any("density" in block.data for block in again.blocks)
    assert kept != ("density" in written.lost)
