"""`meshopt repair`: what it asks for, says and writes, and its exit status."""

import json
from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.formats import FORMATS
from meshopt_cli.repairs import MENDS
from support.broken import BROKEN, VALID
from support.edits import declaring, halves, torn, without
from support.files import strict, untouched, write
from support.meshes import in_space, tet_grid, tri_grid


@pytest.fixture
def twice(tmp_path):
    """A file with a tet twice, and with points that no cell has."""
    one = BROKEN["tet twice"][0]
    points = np.concatenate([one.points, [[7, 7, 7]]])
    return write(tmp_path / "twice.vtk", replace(one, points=points))


def test_something_must_be_asked_for(meshopt, twice, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("repair", twice, tmp_path / "out.vtk")
    assert ran.status == 2
    assert all(f"--{mend}" in ran.err for mend in [*MENDS, "all"])


def test_each_change_is_counted_and_what_is_left_is_shown(meshopt, twice, tmp_path):
    out = tmp_path / "out.vtk"
    ran = meshopt("repair", twice, out, "--duplicates")
    assert (ran.status, ran.out.splitlines()) == (
        0,
        [
            f"{twice}: duplicate cells dropped: 1",
            f"{twice}: M201 duplicate cell: 1, none left",
            f"{twice}: M203 unused point: 1, 1 left",
        ],
    )
    assert ran.err == f"{out}:point 4: M203 the point is not used by any cell at (7, 7, 7)\n"
    ran = meshopt("repair", twice, out, "--all")
    assert "unused points dropped: 1" in ran.out
    assert ran.err == ""


def test_errors_that_are_left_make_the_status(meshopt, twice, tmp_path):
    """The mesh is written with what was asked for all the same."""
    out = tmp_path / "out.vtk"
    ran = meshopt("repair", twice, out, "--unused")
    assert ran.status == 1
    assert f"{out}:cell 1: M201" in ran.err
    assert len(formats.read(out)[0].points) == 4
    assert meshopt("check", out).status == 1


def test_a_sound_mesh_comes_out_as_it_was(meshopt, tmp_path):
    path = write(tmp_path / "in.vtk", VALID["tets"])
    ran = meshopt("repair", path, tmp_path / "out.vtk", "--all")
    assert (ran.status, ran.out, ran.err) == (0, f"{path}: nothing to mend\n", "")
    assert (tmp_path / "out.vtk").read_bytes() == path.read_bytes()


def test_the_report_as_json(meshopt, twice, tmp_path):
    out = tmp_path / "out.vtk"
    values = strict(meshopt("repair", twice, out, "--duplicates", "--flat", "--json").out)
    assert list(values) == ["meshopt", "input", "output", "mends", "notes", "before", "after",
                            "valid", "lost"]  # fmt: skip
    assert (values["input"], values["output"]) == (str(twice), str(out))
    assert list(values["mends"]) == ["duplicates", "flat"]
    assert values["mends"]["duplicates"] == {"duplicate cells dropped": 1}
    assert set(values["mends"]["flat"].values()) == {0}
    assert (values["before"], values["after"]) == ({"M201": 1, "M203": 1}, {"M203": 1})
    assert values["valid"] is True


def test_places_are_those_of_optimize(meshopt, twice, tmp_path):
    with untouched(tmp_path):
        assert meshopt("repair", twice, twice, "--all").status == 2
        assert meshopt("repair", twice, "--all").status == 2
        assert meshopt("repair", twice, tmp_path / "no" / "out.vtk", "--all").status == 3
        assert meshopt("repair", tmp_path / "none.vtk", tmp_path / "x.vtk", "--all").status == 3
        assert meshopt("repair", twice, tmp_path / "x.vtk", "--tolerance", "nan").status == 2
    assert meshopt("repair", twice, "--in-place", "--all", "-q").status == 0
    assert meshopt("check", twice).out == f"{twice}: valid\n"


def test_no_cell_would_be_left(meshopt, tmp_path):
    path = write(tmp_path / "flat.vtu", BROKEN["line to nowhere"][0])
    empty = write(tmp_path / "points.vtu", replace(VALID["one tet"], blocks=[]))
    with untouched(tmp_path):
        ran = meshopt("repair", empty, tmp_path / "out.vtu", "--all")
    assert (ran.status, ran.err) == (1, f"meshopt: {empty}: there are no cells in it\n")
    assert meshopt("repair", path, tmp_path / "out.vtu", "--all").status == 1


@pytest.mark.parametrize("name", FORMATS)
def test_tags_names_and_arrays_are_kept_in_every_format(meshopt, tmp_path, name):
    """Regions have the volume that they had, and facets of the boundary their tags."""
    grid = halves(tet_grid(3))
    whole = declaring(grid, triangle=[grid.blocks[0].cells[0, :3]])
    for block in whole.blocks:
        block.data["gmsh:physical"] = block.data.get(
            "gmsh:physical", np.full(len(block.cells), 9)
        ).astype(np.int64)
        block.data["gmsh:geometrical"] = block.data["gmsh:physical"].copy()
    whole.names = {(3, 0): "low", (3, 1): "high", (2, 9): "wall"}
    path = tmp_path / f"in{FORMATS[name].extensions[0]}"
    formats.write(path, whole, formats.encoding_for(path, file_format=name))
    read = formats.read(path)[0]
    (top,) = [k for k, block in enumerate(read.blocks) if block.type == "tetra"][:1]
    block = read.blocks[top]
    block.cells = np.concatenate([block.cells, block.cells[:1]])
    block.data = {n: np.concatenate([v, v[:1]]) for n, v in block.data.items()}
    formats.write(path, read, formats.encoding_for(path, file_format=name))
    out = tmp_path / f"out{FORMATS[name].extensions[0]}"
    options = ["--all", "--file-format", name]
    assert meshopt("repair", path, out, *options).status == 0
    assert meshopt("check", out).status == 0
    before, after = formats.read(path)[0], formats.read(out)[0]
    assert after.names == before.names
    for one, other in zip(before.blocks, after.blocks, strict=True):
        assert one.type == other.type
        assert list(one.data) == list(other.data)
        n = len(one.cells) - (one.type == "tetra" and len(one.cells) > len(other.cells))
        assert np.array_equal(one.cells[:n], other.cells)
        for array, values in one.data.items():
            assert np.array_equal(values[:n], other.data[array])


def test_a_mesh_with_everything_wrong(meshopt, tmp_path):
    whole = in_space(tri_grid(6))
    one = torn(without(whole, 20), 3)
    cells = one.blocks[0].cells
    cells[5] = cells[5, ::-1]
    one.blocks[0].cells = np.concatenate([cells, cells[7:9], [[0, 1, 1]]])
    one.points = np.concatenate([one.points, [[3, 3, 0]]])
    path = write(tmp_path / "all.vtu", one)
    ran = meshopt("repair", path, tmp_path / "out.vtu", "--all", "--json")
    assert ran.status == 0
    values = json.loads(ran.out)
    changed = {what: n for mend in values["mends"].values() for what, n in mend.items() if n}
    assert changed["duplicate cells dropped"] == 2
    assert changed["cells turned"] == 1
    assert changed["missing cells added"] == 1
    assert changed["flat cells dropped"] == 1
    assert values["after"] == {}
