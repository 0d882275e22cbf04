"""What is written: the same bytes each time, in every format, with all its tags."""

from collections import Counter

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.formats import FORMATS, Encoding
from support.files import worst_of, write
from support.options import PLAIN
from support.processes import outside


@pytest.mark.parametrize("preset", PLAIN)
@pytest.mark.parametrize("name", ["tets", "triangles"])
def test_the_same_bytes_twice(meshopt, request, tmp_path, name, preset):
    path = request.getfixturevalue(name)
    outputs = [tmp_path / f"{k}{path.suffix}" for k in ("one", "other")]
    for output in outputs:
        assert meshopt("optimize", path, output, "--preset", preset).status == 0
    assert outputs[0].read_bytes() == outputs[1].read_bytes()


def test_the_same_bytes_in_another_process(meshopt, tets, tmp_path):
    passes = "--passes=relax,swap,smooth"
    order = ["--set", "swap.order=random", "--set", "swap.seed=3"]
    here, there = tmp_path / "here.vtk", tmp_path / "there.vtk"
    assert meshopt("optimize", tets, here, passes, *order).status == 0
    assert outside("optimize", tets, there, passes, *order, PYTHONHASHSEED="77").status == 0
    assert here.read_bytes() == there.read_bytes()


CONVERTED = {
    "gmsh": None,
    "gmsh22": None,
    "vtk": Encoding("vtk", "5.1", binary=True),
    "vtk42": Encoding("vtk", "4.2", binary=False),
    "vtu": Encoding("vtu", "1.0", binary=True, compressed=True),
    "medit": Encoding("medit", "2", binary=False),
    "meditb": Encoding("meditb", "2", binary=True),
}
SUFFIXES = {"gmsh": ".msh", "gmsh22": ".msh", "vtk": ".vtk", "vtk42": ".vtk", "vtu": ".vtu",
            "medit": ".mesh", "meditb": ".meshb"}  # fmt: skip


@pytest.fixture(params=CONVERTED)
def two_regions(request, samples, tmp_path):
    """A mesh of two regions, with triangles on their boundaries, in every format."""
    source = samples / ("two_regions_22.msh" if request.param == "gmsh22" else "two_regions.msh")
    path = tmp_path / f"in{SUFFIXES[request.param]}"
    if CONVERTED[request.param] is None:
        path.write_bytes(source.read_bytes())
        return path
    return write(path, formats.read(source)[0], CONVERTED[request.param])


def lower_cells(one):
    """Cells of lower dimension with their tags, whatever their numbering."""
    return Counter(
        (block.type, frozenset(map(tuple, one.points[cell].tolist())),
         tuple((name, values[row].item()) for name, values in sorted(block.data.items())))
        for block in one.blocks if block.type != "tetra"
        for row, cell in enumerate(block.cells)
    )  # fmt: skip


def volumes_by_tags(one):
    volumes = {}
    for block in one.blocks:
        if block.type == "tetra":
            corners = one.points[block.cells]
            each = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
            assert np.all(each > 0)
            for row, volume in enumerate(each):
                tags = tuple((n, a[row].item()) for n, a in sorted(block.data.items()))
                volumes[tags] = volumes.get(tags, 0.0) + volume
    return volumes


def test_a_format_keeps_tags_and_cells_of_lower_dimension(meshopt, two_regions, tmp_path):
    output = tmp_path / f"out{two_regions.suffix}"
    ran = meshopt("optimize", two_regions, output)
    assert (ran.status, ran.err) == (0, "")
    old, source = formats.read(two_regions)
    new, written = formats.read(output)
    assert written.encoding == source.encoding
    assert new.names == old.names
    assert [b.type for b in new.blocks] == [b.type for b in old.blocks]
    assert lower_cells(new) == lower_cells(old)
    assert sum(lower_cells(new).values()) > 600
    before, after = volumes_by_tags(old), volumes_by_tags(new)
    assert len(before) == 2
    assert after == pytest.approx(before, rel=1e-9)
    assert worst_of(output) < worst_of(two_regions)


def test_a_format_by_name_goes_before_the_suffix(meshopt, tets, tmp_path):
    output = tmp_path / "out.msh"
    assert meshopt("optimize", tets, output, "--file-format", "gmsh22", "-q").status == 0
    assert formats.read(output)[1].encoding.format == "gmsh22"


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_can_be_written(meshopt, triangles, tmp_path, name):
    output = tmp_path / f"out{FORMATS[name].extensions[0]}"
    assert meshopt("optimize", triangles, output, "--file-format", name, "-q") == (0, "", "")
    assert formats.read(output)[1].encoding.format == name
    assert worst_of(output) < worst_of(triangles)
