"""Every format as text and as binary, and meshes with all that they hold."""

import logging
from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import FORMATS, Encoding, read
from meshopt_cli.mesh.model import Block, Mesh

PHYSICAL, GEOMETRICAL, REF = "gmsh:physical", "gmsh:geometrical", "medit:ref"
DIM_TAGS, PARTITION = "gmsh:dim_tags", "gmsh:partition"

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
            names = {(3, 3): "a name, with: blanks", (2, 2): "wall"}
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


def assert_unreadable(path, *words):
    with pytest.raises(ReadError) as caught:
        read(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def text_mesh(tmp_path, text, name="mesh.msh"):
    path = tmp_path / name
    path.write_text(text)
    return path


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
