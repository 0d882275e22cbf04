"""Fields at vertices in Medit's `.sol` and `.solb`."""

import gzip
import struct

import numpy as np
import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats.medit_sol import (
    MATRIX,
    SCALAR,
    TENSOR,
    VECTOR,
    Solution,
    is_sol,
    read_sol,
    width_of,
    write_sol,
)

rng = np.random.default_rng(0)


def solution(dimension, *kinds, n=5):
    return Solution(dimension, [(k, rng.normal(size=(n, width_of(k, dimension)))) for k in kinds])


@pytest.mark.parametrize("name", ["m.sol", "m.solb"])
@pytest.mark.parametrize("version", [1, 2, 3, 4])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kinds", [(SCALAR,), (TENSOR,), (SCALAR, VECTOR, TENSOR, MATRIX)])
def test_round_trip(tmp_path, name, version, dimension, kinds):
    one = solution(dimension, *kinds)
    write_sol(tmp_path / name, one, version)
    again = read_sol(tmp_path / name)
    assert again.dimension == dimension
    assert [kind for kind, _ in again.fields] == list(kinds)
    single = version == 1 and name.endswith("b")
    for (_, values), (_, read) in zip(one.fields, again.fields, strict=True):
        assert read.dtype == np.float64
        assert np.array_equal(read, values.astype(np.float32) if single else values)


def test_as_other_programs_write_it(tmp_path):
    path = tmp_path / "a.sol"
    path.write_text(
        "# made by hand\nMeshVersionFormatted 2\n\nDimension\n3\n\n"
        "SolAtVertices\n2\n1 1 \n\n0.5 \n 1e-3\n\nEnd\n"
    )
    ((kind, values),) = read_sol(path).fields
    assert (kind, values.tolist()) == (SCALAR, [[0.5], [0.001]])
    zipped = tmp_path / "a.sol.gz"
    zipped.write_bytes(gzip.compress(path.read_bytes()))
    assert is_sol(zipped)
    assert np.array_equal(read_sol(zipped).fields[0][1], values)


def test_bytes_in_the_other_order_and_sections_before(tmp_path):
    body = struct.pack(">iii", 2, 1, SCALAR) + struct.pack(">dd", 0.5, 2.0)
    data = struct.pack(">ii", 1, 2) + struct.pack(">iii", 3, 20, 2)
    data += struct.pack(">iii", 99, 32, 7)  # one that nobody knows
    data += struct.pack(">ii", 62, 40 + len(body)) + body + struct.pack(">ii", 54, 0)
    (tmp_path / "a.solb").write_bytes(data)
    found = read_sol(tmp_path / "a.solb")
    assert (found.dimension, found.fields[0][1].tolist()) == (2, [[0.5], [2.0]])


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "empty"),
        ("x", "malformed"),
        ("MeshVersionFormatted 2\nDimension 3\nEnd\n", "no SolAtVertices"),
        ("Dimension 3\nSolAtVertices\n2\n1 1\n0.5\nEnd\n", "1 numbers"),
        ("Dimension 3\nSolAtVertices\n2\n1 1\n0.5 a\nEnd\n", "something else"),
        ("Dimension 4\nSolAtVertices\n1\n1 1\n1\nEnd\n", "Dimension 4"),
        ("Dimension 3\nSolAtVertices\n1\n1 7\n1\nEnd\n", "type 7"),
        ("Dimension 3\nSolAtVertices\n1\n0\nEnd\n", "0 fields"),
        ("Dimension 3\nSolAtVertices\n1\n3 1\n", "malformed|type"),
        ("Dimension 3\nSolAtVertices\n", "malformed"),
        ("SolAtVertices\n1\n1 1\n1\nEnd\n", "before Dimension"),
        ("Dimension x\nSolAtVertices\n1\n1 1\n1\nEnd\n", "malformed"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path, text, what):
    path = tmp_path / "a.sol"
    path.write_text(text)
    with pytest.raises(ReadError, match=what) as error:
        read_sol(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_binary_files_that_are_cut_off(tmp_path):
    write_sol(tmp_path / "whole.solb", solution(3, TENSOR))
    data = (tmp_path / "whole.solb").read_bytes()
    path = tmp_path / "cut.solb"
    for n in range(len(data) - 8):
        path.write_bytes(data[:n])
        with pytest.raises(ReadError):
            read_sol(path)
    for at in range(4, 48, 4):  # numbers that are not so
        for number in (-1, 0x7FFFFFFF):
            path.write_bytes(data[:at] + struct.pack("<i", number) + data[at + 4 :])
            try:
                read_sol(path)
            except ReadError as error:
                assert str(path) in str(error)  # noqa: PT017
    with pytest.raises(ReadError, match="no such file"):
        read_sol(tmp_path / "missing.sol")
