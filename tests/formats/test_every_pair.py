"""From every format to every other: nothing is lost without a word."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.formats import FORMATS, read, write
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import (
    DIM_TAGS,
    ENCODINGS,
    GEOMETRICAL,
    PHYSICAL,
    REF,
    assert_same_array,
    path_for,
)
from support.settings import examples


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
    mesh.names = draw(st.sampled_from([{}, {(2, 1): "wall", (3, 2): "a name"}]))
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


@examples(120)
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
    assert again.names == mesh.names or all(name in listed for name in mesh.names.values())
