"""Compressed files."""

import gzip
import hashlib

import pytest

from meshopt_cli.formats import FORMATS, encoding_for, read, sniff, write
from support.encodings import (
    MEDIT,
    assert_same,
    assert_unreadable,
    every_encoding,
    path_for,
    tagged,
    tets,
)


@every_encoding
def test_compressed_files_hold_the_same(tmp_path, encoding):
    mesh = tagged(tets(), encoding)
    plain = path_for(tmp_path, encoding)
    path = plain.with_name(plain.name + ".gz")
    write(plain, mesh, encoding)
    written = write(path, mesh, encoding)
    assert gzip.decompress(path.read_bytes()) == plain.read_bytes()
    assert written.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    again, source = read(path)
    assert_same(mesh, again)
    assert (source.encoding, source.sha256) == (encoding, written.sha256)
    assert sniff(path) == encoding
    assert encoding_for(path, source.encoding) == encoding_for(plain, source.encoding)
    first = path.read_bytes()
    write(path, mesh, encoding)
    assert path.read_bytes() == first


@pytest.mark.parametrize("cut", [0.3, 0.9, 0.999])
def test_compressed_files_that_are_truncated(tmp_path, cut):
    path = tmp_path / "mesh.mesh.gz"
    write(path, tets(), FORMATS["medit"].default)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(cut * len(whole))])
    assert_unreadable(path, "truncated", "gzip")


def test_compressed_content_is_known_by_itself(tmp_path):
    path = tmp_path / "mesh.mesh"
    path.write_bytes(gzip.compress(MEDIT.encode()))
    assert len(read(path)[0].points) == 4
