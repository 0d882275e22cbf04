"""VTK files that are cut off, damaged, or lie about their size."""

import base64
import contextlib
import importlib.util
import re
import tracemalloc
import zlib

import numpy as np
import pytest

pytest.importorskip("vtk")

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import read
from support.encodings import assert_unreadable, text_mesh
from support.vtkfiles import KINDS, write_legacy, write_xml

# What Python calls its errors, which says nothing to people.
NAMES = re.compile(r"\w+Error|Exception|object has no|out of bounds|not subscriptable")
COMPRESSORS = [0, 1, 3, *([2] if importlib.util.find_spec("lz4") else [])]


@contextlib.contextmanager
def little_memory():
    """Prove that no more than some megabytes are taken at any time."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()


def files(folder):
    """A file of every kind, in several encodings."""
    for i, (kind, (make, writer, extension)) in enumerate(KINDS.items()):
        data = make(np.random.default_rng(i))
        for binary in (False, True):
            path = folder / f"{kind}-{binary}.vtk"
            write_legacy(path, data, 51 if i % 2 else 42, binary)
            yield path
        for j, (mode, encoded) in enumerate(((0, False), (1, False), (2, False), (2, True))):
            compressor = COMPRESSORS[(i + j) % len(COMPRESSORS)] if mode else 0
            path = folder / f"{kind}-{mode}-{encoded}.{extension}"
            write_xml(path, data, writer, mode, compressor, bool(i % 2), bool(j % 2), encoded)
            yield path


def said_of(path):
    """What is said of a file: a refusal, what is lost, or nothing. Any other error is a failure."""
    try:
        _, source = read(path)
    except ReadError as error:
        said = str(error)
        assert not NAMES.search(said)
        assert "malformed (" not in said
        return said
    return " ".join(source.lost)


def test_files_that_are_cut_off(tmp_path):
    random = np.random.default_rng(0)
    n_silent = n = 0
    for path in files(tmp_path):
        whole, said = path.read_bytes(), said_of(path)
        cut = path.with_stem("cut")
        for at in random.integers(1, len(whole), 40):
            cut.write_bytes(whole[:at])
            n += 1
            n_silent += said_of(cut) == said
    # of a text, as many lines as make whole sections, or blanks at its end
    assert n_silent <= n / 50


def test_files_with_damaged_bytes(tmp_path):
    random = np.random.default_rng(1)
    n_refused = 0
    for path in files(tmp_path):
        whole = path.read_bytes()
        for _ in range(40):
            damaged = bytearray(whole)
            for at in random.integers(len(whole), size=random.integers(1, 4)):
                damaged[at] = random.integers(256)
            path.write_bytes(damaged)
            n_refused += "not a readable" in said_of(path)
    assert n_refused > 100


HUGE = 10**15
LEGACY = """# vtk DataFile Version {version}
t
{form}
DATASET {kind}
"""


@pytest.mark.parametrize("form", ["ASCII", "BINARY"])
@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("UNSTRUCTURED_GRID", f"POINTS {HUGE} double\n0 0 0\n"),
        ("UNSTRUCTURED_GRID", f"POINTS 0 double\nCELLS {HUGE} {HUGE}\n1 0\n"),
        ("UNSTRUCTURED_GRID", f"POINTS 0 double\nCELLS {HUGE} {HUGE}\nOFFSETS vtktypeint64\n0 1\n"),
        ("UNSTRUCTURED_GRID", f"POINTS 0 double\nCELL_TYPES {HUGE}\n5\n"),
        ("UNSTRUCTURED_GRID", f"POINTS 0 double\nPOINT_DATA {HUGE}\nTENSORS t double\n0\n"),
        ("UNSTRUCTURED_GRID", f"FIELD f {HUGE}\n"),
        ("UNSTRUCTURED_GRID", f"FIELD f 1\na {HUGE} {HUGE} double\n"),
        ("UNSTRUCTURED_GRID", f"FIELD f 1\na 1 {HUGE} string\n"),
        ("STRUCTURED_POINTS", "DIMENSIONS 100000 100000 100000\n"),
        ("STRUCTURED_GRID", f"DIMENSIONS 100000 100000 100000\nPOINTS {HUGE} double\n0 0 0\n"),
        ("STRUCTURED_POINTS", "DIMENSIONS 100000 100000 100000\nPOINT_DATA 1\nSCALARS a char\n1\n"),
    ],
)
def test_counts_beyond_what_the_file_holds(tmp_path, form, kind, text):
    path = text_mesh(tmp_path, LEGACY.format(version="4.2", form=form, kind=kind) + text, "m.vtk")
    with little_memory():
        assert_unreadable(path)


def xml(points, n_points, n_cells=1):
    return (
        '<VTKFile type="UnstructuredGrid" compressor="vtkZLibDataCompressor"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{n_points}" NumberOfCells="{n_cells}"><Points>'
        f'<DataArray type="Float64" format="binary">{points}</DataArray></Points><Cells>'
        '<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>'
        '<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray>'
        '<DataArray type="UInt8" Name="types" format="ascii">5</DataArray>'
        "</Cells></Piece></UnstructuredGrid></VTKFile>"
    )


def packed(blocks, size, last=0):
    """Base64 of compressed blocks, of which each says to be `size` long."""
    counts = np.array([len(blocks), size, last, *map(len, blocks)], "<u4").tobytes()
    return (base64.b64encode(counts) + base64.b64encode(b"".join(blocks))).decode()


def test_compressed_data_that_says_to_be_larger_than_it_can_be(tmp_path):
    zeros = zlib.compress(bytes(24 * 3), 9)
    good = text_mesh(tmp_path, xml(packed([zeros], 72), 3), "good.vtu")
    assert len(read(good)[0].points) == 3
    for points, n in (
        (packed([zeros], 24 << 24), 1 << 24),
        (packed([zeros], 72), HUGE),
        (packed([zlib.compress(bytes(24 << 20), 9)], 24 << 20), 1 << 20),  # all at one place
        (packed([zeros], 48), 2),
        (packed([zeros[:-8]], 72), 3),
        (base64.b64encode(np.array([HUGE % 2**31, 72, 0, 9], "<u4").tobytes()).decode(), 3),
    ):
        path = text_mesh(tmp_path, xml(points, n), "bad.vtu")
        with little_memory():
            assert_unreadable(path, "Points")


def test_grids_without_values_have_an_end(tmp_path):
    text = (
        '<VTKFile type="ImageData"><ImageData WholeExtent="0 9999 0 9999 0 9999">'
        '<Piece Extent="0 9999 0 9999 0 9999"></Piece></ImageData></VTKFile>'
    )
    assert_unreadable(text_mesh(tmp_path, text, "m.vti"), str(10**12))
    small = text.replace("9999", "2")
    (block,) = read(text_mesh(tmp_path, small, "m.vti"))[0].blocks
    assert len(block.cells) == 8
