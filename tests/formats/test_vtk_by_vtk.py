"""Files that VTK writes are read as VTK reads them: every kind of data set, array and encoding."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("vtk")

from meshopt_cli.formats import read
from support.encodings import assert_unreadable
from support.settings import examples
from support.vtkfiles import (
    KINDS,
    OUT,
    STRINGS,
    assert_read_as_by_vtk,
    read_legacy,
    write_legacy,
    write_xml,
)

seeds = st.integers(0, 2**32 - 1)
LZ4 = importlib.util.find_spec("lz4") is not None
ZLIB, LZ4_CODE, LZMA = 1, 2, 3
# Data mode (text, base64, appended), compressor, and whether appended data is base64.
FORMS = [(0, 0, False)]
FORMS += [(1, compressor, False) for compressor in (0, ZLIB, LZ4_CODE, LZMA)]
FORMS += [(2, compressor, on) for compressor in (0, ZLIB, LZ4_CODE, LZMA) for on in (False, True)]


def assert_names_what_is_lost(source, data):
    assert f"the strings {STRINGS}" in source.lost
    types = {data.GetCellType(i) for i in range(data.GetNumberOfCells())}
    for number, name in OUT.items():
        assert (number in types) == any(name in what for what in source.lost)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("binary", [False, True], ids=["text", "binary"])
@examples(4)
@given(seed=seeds)
def test_without_xml(tmp_path_factory, kind, version, binary, seed):
    path = tmp_path_factory.mktemp("vtk") / "mesh.vtk"
    write_legacy(path, KINDS[kind][0](np.random.default_rng(seed)), version, binary)
    mesh, source = read(path)
    data = read_legacy(path)
    assert_read_as_by_vtk(mesh, data)
    assert_names_what_is_lost(source, data)
    assert source.encoding.binary == binary


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("form", FORMS, ids=str)
@examples(3)
@given(seed=seeds, wide=st.booleans(), big=st.booleans())
def test_with_xml(tmp_path_factory, kind, form, seed, wide, big):
    mode, compressor, encoded = form
    make, writer, extension = KINDS[kind]
    path = tmp_path_factory.mktemp("vtk") / f"mesh.{extension}"
    data = make(np.random.default_rng(seed))
    write_xml(path, data, writer, mode, compressor, wide, big, encoded)
    if compressor == LZ4_CODE and not LZ4:
        assert_unreadable(path, "pip install lz4")
        return
    mesh, source = read(path)
    assert_read_as_by_vtk(mesh, data)
    assert_names_what_is_lost(source, data)


def test_an_image_that_is_turned(tmp_path):
    import vtk

    data = vtk.vtkImageData()
    data.SetDimensions(3, 4, 5)
    data.SetOrigin(1, 2, 3)
    data.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
    path = Path(tmp_path, "turned.vti")
    write_xml(path, data, vtk.vtkXMLImageDataWriter, 0, 0, False, False, False)
    assert_read_as_by_vtk(read(path)[0], data)
