"""Files that cannot be read or written, and meshes of no use: status 3."""

import os
from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.formats import encoding_for
from meshopt_cli.mesh.model import Block, Mesh
from support.files import fail, strict, untouched
from support.meshes import octahedron, tet_grid, tri_grid
from support.refused import bad_mesh, every_bad_mesh


def unreadable(folder):
    """Paths that are no mesh files, by what is wrong with them."""
    paths = {
        "missing": folder / "missing.vtk",
        "folder": folder / "folder.vtk",
        "extension": folder / "mesh.stl",
        "no extension": folder / "mesh",
        "empty": folder / "empty.vtu",
        "nonsense": folder / "nonsense.msh",
        "truncated": folder / "truncated.mesh",
        "below a file": folder / "file" / "mesh.vtk",
    }
    paths["folder"].mkdir()
    paths["extension"].write_text("solid")
    paths["no extension"].write_text("MeshVersionFormatted 2")
    paths["empty"].write_text("")
    paths["nonsense"].write_bytes(bytes(range(256)))
    paths["truncated"].write_text("MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0")
    (folder / "file").write_text("no folder")
    return paths


@pytest.mark.parametrize("what", ["missing", "folder", "extension", "no extension", "empty",
                                  "nonsense", "truncated", "below a file"])  # fmt: skip
@pytest.mark.parametrize("command", ["optimize", "check", "report"])
def test_a_file_that_cannot_be_read(meshopt, tmp_path, command, what):
    path = unreadable(tmp_path)[what]
    with untouched(tmp_path):
        ran = meshopt(command, path, *([tmp_path / "out.vtk"] if command == "optimize" else []))
    assert (ran.status, ran.out) == (3, "")
    assert str(path) in ran.complaint


@every_bad_mesh
def test_a_mesh_that_is_of_no_use(meshopt, tmp_path, name):
    path, status, said = bad_mesh(tmp_path, name)
    with untouched(tmp_path):
        ran = meshopt("optimize", path, tmp_path / "out.vtu")
    assert (ran.status, ran.out) == (status, "")
    assert str(path) in ran.complaint
    assert said in ran.complaint


@pytest.mark.parametrize("name", ["lines", "points"])
def test_a_mesh_without_faces_has_no_report(meshopt, tmp_path, name):
    path, _, _ = bad_mesh(tmp_path, name)
    ran = meshopt("report", path)
    assert (ran.status, ran.out) == (1, "")
    assert str(path) in ran.complaint
    assert f"{name} only: there is nothing to measure" in ran.complaint


# What can be measured of a mesh that cannot be optimized: cells, vertices, what is said.
MEASURED = {"both_orders": (2, 8, "corners"), "surface": (8, 6, "own plane")}


@pytest.mark.parametrize("name", MEASURED)
def test_a_report_says_what_it_can(meshopt, tmp_path, name):
    path, _, _ = bad_mesh(tmp_path, name)
    n_cells, n_points, said = MEASURED[name]
    ran = meshopt("report", path, "--format", "json")
    assert ran.status == 0
    assert said in ran.complaint
    before = strict(ran.out)["before"]
    assert (before["ne"], before["np"]) == (n_cells, n_points)
    if name == "surface":  # equilateral triangles
        assert before["worst"] == pytest.approx(1)
        assert before["angle_min"] == pytest.approx(60)


@pytest.mark.parametrize(
    "where", ["out.stl", "out", "file/out.vtk", "missing/out.vtk", "folder.vtk"]
)
def test_a_file_that_cannot_be_written(meshopt, tets, tmp_path, where):
    (tmp_path / "file").write_text("no folder")
    (tmp_path / "folder.vtk").mkdir()
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / where)
    assert (ran.status, ran.out) == (3, "")
    assert str(tmp_path / where) in ran.complaint


@pytest.mark.parametrize("function", ["replace", "fsync"])
@pytest.mark.parametrize("exists", [False, True])
def test_a_disk_that_fails_leaves_all_as_it_was(
    meshopt, tets, tmp_path, monkeypatch, function, exists
):
    output = tmp_path / "out.vtk"
    if exists:
        output.write_text("an older file")
    monkeypatch.setattr(os, function, fail(OSError(28, "No space left on device")))
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, output)
    assert (ran.status, ran.out) == (3, "")
    assert str(output) in ran.complaint
    assert "no space" in ran.complaint.lower()


def test_a_report_that_cannot_be_written(meshopt, tets, tmp_path):
    path = tmp_path / "missing" / "report.md"
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "--report", path)
    assert ran.status == 3
    assert str(path) in ran.complaint
    ran = meshopt("report", tets, "-o", path)
    assert (ran.status, ran.out) == (3, "")
    assert str(path) in ran.complaint


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Mesh(np.random.default_rng(0).random((10, 3)),
                      [Block("triangle10", np.arange(10)[None])]), "first order"),
        (octahedron, "meshopt check"),
        (lambda: replace(tet_grid(2), points=tet_grid(2).points * 1e60), "scale it"),
        (lambda: replace(tri_grid(2), points=tri_grid(2).points * 1e-60), "scale it"),
    ],
    ids=["third order", "surface", "huge", "tiny"],
)  # fmt: skip
def test_what_cannot_be_optimized_is_refused_with_a_remedy(meshopt, tmp_path, make, said):
    path = tmp_path / "in.msh"
    formats.write(path, make(), encoding_for(path))
    ran = meshopt("optimize", path, tmp_path / "out.msh")
    assert ran.status == 3
    assert said in ran.complaint
    assert not (tmp_path / "out.msh").exists()


def test_a_place_that_is_none_is_refused_before_the_work(meshopt, tmp_path):
    for place in (tmp_path / "none" / "out.msh", tmp_path):
        ran = meshopt("optimize", tmp_path / "not_read.msh", place)
        assert ran.status == 3
        assert f"{place}: cannot be written" in ran.complaint
