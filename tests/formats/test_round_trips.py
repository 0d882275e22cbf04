"""What is written is read again, to the last bit."""

import hashlib
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from meshopt_cli.formats import FORMATS, read, write
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import (
    POINTS,
    assert_same,
    assert_same_array,
    every_encoding,
    ints,
    path_for,
    plane,
    tagged,
    tets,
    warnings_of,
    zoo,
)
from support.settings import examples


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
@examples(25)
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
