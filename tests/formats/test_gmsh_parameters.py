"""Where nodes of Gmsh lie on their curves and surfaces."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, read, write
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from support.encodings import DIM_TAGS, assert_unreadable
from support.gmsh import Builder, shaken_square

PARAMETRIC = "gmsh:parametric"
# Number, point, dimension and tag of the entity, and parameters on it.
NODES = [
    (1, (0.0, 0.0, 0.0), 0, 3, ()),
    (2, (1.0, 0.0, 0.0), 1, 4, (0.25,)),
    (3, (0.0, 1.0, 0.0), 1, 4, (0.75,)),
    (4, (0.0, 0.0, 1.0), 2, 5, (0.5, -0.5)),
    (5, (0.2, 0.2, 0.2), 3, 6, ()),
]
BUILDERS = [Builder(v) for v in ("2.2", "3", "4.0", "4.1")]
BUILDERS += [Builder(v, True, order) for v in ("2.2", "3", "4.1") for order in "<>"]


def nodes_of(builder, nodes):
    count = f"{len(nodes)}\n".encode()
    if builder.version < 3:
        rows = [
            builder.line(("i4", number), ("f8", x), ("i4", (dimension, tag)), ("f8", uv))
            for number, x, dimension, tag, uv in nodes
        ]
        return builder.section("ParametricNodes", count, *rows)
    if builder.version < 4:
        rows = [
            builder.line(
                ("i4", number),
                ("f8", x),
                ("i4", (tag, dimension)),
                ("f8", uv if dimension < 3 else (0.0, 0.0, 0.0)),
            )
            for number, x, dimension, tag, uv in nodes
        ]
        return builder.section("Nodes", count, *rows)
    new = builder.version > 4
    n = len(nodes)
    lines = [builder.line(("c", (n, n, 1, n)[: 4 if new else 2]))]
    for number, x, dimension, tag, uv in nodes:
        head = (dimension, tag) if new else (tag, dimension)
        lines.append(builder.line(("i4", (*head, len(uv) > 0)), ("c", 1)))
        lines.append(builder.line(("c" if new else "i4", number)).rstrip(b"" if new else b"\n"))
        lines.append(b" " * (not new) + builder.line(("f8", (*x, *uv))))
    return builder.section("Nodes", *lines)


def put(tmp_path, builder, nodes=NODES):
    path = tmp_path / "mesh.msh"
    cells = builder.elements((3, 6, 4, 1, {1: (1, 2, 3, 4), 2: (1, 3, 2, 5)}))
    entities = builder.entities((3, 6, [1], [])) if builder.version >= 3 else b""
    path.write_bytes(builder.header() + entities + nodes_of(builder, nodes) + cells)
    return path


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda b: f"{b.spelled}{b.order * b.binary}")
@pytest.mark.parametrize("binary", [False, True])
def test_parameters_are_read_and_come_back_in_the_last_version(tmp_path, builder, binary):
    mesh, source = read(put(tmp_path, builder))
    nan = np.nan
    expected = [[nan, nan], [0.25, nan], [0.75, nan], [0.5, -0.5], [nan, nan]]
    np.testing.assert_array_equal(mesh.point_data[PARAMETRIC], expected)
    assert mesh.point_data[DIM_TAGS].tolist() == [[0, 3], [1, 4], [1, 4], [2, 5], [3, 6]]
    assert mesh.points.tolist() == [list(node[1]) for node in NODES]
    assert source.lost == ()
    written = write(tmp_path / "again.msh", mesh, Encoding("gmsh", "4.1", binary))
    assert written.lost == ()
    again, _ = read(tmp_path / "again.msh")
    np.testing.assert_array_equal(again.point_data[PARAMETRIC], expected)
    np.testing.assert_array_equal(again.points, mesh.points)


@pytest.mark.parametrize("name", ["gmsh22", "vtk", "vtu", "medit", "meditb"])
def test_other_formats_name_them(tmp_path, name):
    mesh, _ = read(put(tmp_path, BUILDERS[0]))
    assert "the parameters of nodes" in write(tmp_path / "out", mesh, FORMATS[name].default).lost


def test_nodes_of_version_3_on_no_entity(tmp_path):
    builder = Builder("3")
    path = put(tmp_path, builder)
    row = builder.line(("i4", 5), ("f8", NODES[4][1]), ("i4", 0))
    at = path.read_bytes().index(b"5 0.2 0.2 0.2")
    end = path.read_bytes().index(b"\n", at) + 1
    path.write_bytes(path.read_bytes()[:at] + row + path.read_bytes()[end:])
    mesh, _ = read(path)
    assert mesh.points.tolist() == [list(node[1]) for node in NODES]
    assert set(mesh.point_data) == set()


def test_an_entity_of_no_dimension_is_refused(tmp_path):
    wrong = [*NODES[:4], (5, NODES[4][1], 4, 6, ())]
    for builder in BUILDERS:
        assert_unreadable(put(tmp_path, builder, wrong), "dimension 4")


def test_a_node_that_moves_has_no_parameters(tmp_path):
    points, cells, _ = shaken_square(6)
    builder = Builder("4.1")
    blocks = [(number, x, 2, 1, x[:2]) for number, x in points.items()]
    path = tmp_path / "mesh.msh"
    content = builder.header() + builder.entities((2, 1, [5], []))
    content += nodes_of(builder, blocks) + builder.elements((2, 1, 2, 5, cells))
    path.write_bytes(content)
    assert optimize_file(FileTask(path, tmp_path / "out.msh")).written
    mesh, _ = read(tmp_path / "out.msh")
    parameters = mesh.point_data[PARAMETRIC]
    known = np.isfinite(parameters).all(axis=1)
    assert 24 <= np.count_nonzero(known) < len(points)  # those of the boundary, at least
    np.testing.assert_array_equal(parameters[known], mesh.points[known, :2])
