"""How much may come out of a file: `--max-size`."""

import gzip

import pytest

from meshopt_cli.formats import read, streams
from support.files import untouched, write
from support.meshes import tet_grid


@pytest.fixture
def packed(tmp_path):
    return write(tmp_path / "mesh.msh.gz", tet_grid(6))


@pytest.mark.parametrize("command", [["check"], ["report"], ["optimize"], ["repair", "--all"]])
def test_the_limit_is_kept_and_named(meshopt, packed, tmp_path, command):
    size = len(gzip.decompress(packed.read_bytes()))
    out = [tmp_path / "out.vtu"] * (command[0] in ("optimize", "repair"))
    with untouched(tmp_path):
        ran = meshopt(*command, packed, *out, "--max-size", str(size - 1))
    assert ran.status == 3
    assert "--max-size" in ran.complaint
    assert meshopt(*command, packed, *out, "--max-size", str(size)).status == 0


def test_what_is_not_compressed_is_limited_too(meshopt, tets):
    size = tets.stat().st_size
    assert meshopt("check", tets, "--max-size", size - 1).status == 3
    assert meshopt("check", tets, "--max-size", size).status == 0


@pytest.mark.parametrize(
    "size", ["", "-1", "nan", "many", "1e3", "5X", "1.2.3", "\u0663", "9" * 40]
)
def test_what_is_no_size(meshopt, packed, size):
    ran = meshopt("check", packed, "--max-size", size)
    assert ran.status == 2
    assert "500M" in ran.complaint


@pytest.mark.parametrize("size", ["1G", "1.5k", "2MB", "1TiB"])
def test_what_is_a_size(meshopt, packed, size):
    assert meshopt("check", packed, "--max-size", size).status in (0, 3)


def test_without_a_limit_a_thousandfold(packed, monkeypatch):
    """And less than some bytes in any case."""
    read(packed)
    monkeypatch.setattr(streams, "_LEAST_MOST", 100)
    read(packed)
    monkeypatch.setattr(streams, "_MOST_TIMES", 1)
    with pytest.raises(Exception, match="--max-size"):
        read(packed)


@pytest.mark.parametrize("cut", [0, 1, 5, 17])
def test_several_members_are_read_and_a_cut_one_is_not(packed, cut):
    data = packed.read_bytes()
    text = gzip.decompress(data)
    both = gzip.compress(text[:100]) + gzip.compress(text[100:])
    packed.write_bytes(both[: len(both) - cut])
    if not cut:
        assert len(read(packed)[0].points) == 7**3
    else:
        with pytest.raises(Exception, match="truncated or damaged gzip"):
            read(packed)
