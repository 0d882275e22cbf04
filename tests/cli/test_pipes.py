"""Pipes, compressed files, text and binary."""

import gzip
import hashlib
import json

import pytest

from meshopt_cli import formats
from support.processes import in_a_pipe


@pytest.mark.parametrize("options", [(), ("--input-format", "vtk", "--file-format", "vtk")])
def test_a_mesh_through_a_pipe(meshopt, tets, tmp_path, options):
    """The mesh is all that stdout gets; the report goes to stderr."""
    status, out, err = in_a_pipe(tets.read_bytes(), "optimize", "-", "-", *options)
    assert status == 0
    assert meshopt("optimize", tets, tmp_path / "out.vtk").status == 0
    assert out == (tmp_path / "out.vtk").read_bytes()
    assert "Q_T" in err


def test_the_json_report_beside_a_pipe(tets, tmp_path):
    report = tmp_path / "report.json"
    arguments = ("optimize", "-", "-", "--file-format", "vtu", "--json", "--report", report)
    status, out, err = in_a_pipe(tets.read_bytes(), *arguments)
    assert status == 0
    assert json.loads(err) == json.loads(report.read_text())
    said = json.loads(err)
    assert said["input"]["sha256"] == hashlib.sha256(tets.read_bytes()).hexdigest()
    assert said["output"] == {
        "path": "-", "format": "vtu", "sha256": hashlib.sha256(out).hexdigest()
    }  # fmt: skip


@pytest.mark.parametrize(
    ("data", "arguments", "status", "said"),
    [
        (b"", ("-", "-"), 3, "empty"),
        (b"solid", ("-", "-"), 3, "not a mesh"),
        (b"# vtk DataFile Version 3.0\n", ("-", "-", "--input-format", "gmsh"), 3, "not a Gmsh"),
        (b"", ("-",), 2, "OUTPUT"),
        (b"", ("-", "--in-place"), 2, "OUTPUT"),
    ],
)
def test_what_is_wrong_in_a_pipe(data, arguments, status, said):
    ran = in_a_pipe(data, "optimize", *arguments)
    assert ran[:2] == (status, b"")
    (line,) = ran[2].splitlines()
    assert said in line


def test_nothing_goes_down_the_pipe_when_the_mesh_stays_bad(tets):
    status, out, err = in_a_pipe(tets.read_bytes(), "optimize", "-", "-", "--fail-above", "1.01")
    assert status == 1
    assert b"DATASET" not in out
    assert "nothing written" in err


def test_check_and_report_read_pipes_and_compressed_files(meshopt, tets, tmp_path):
    status, out, _ = in_a_pipe(tets.read_bytes(), "check", "-")
    assert (status, out.decode().strip()) == (0, "-: valid")
    packed = tmp_path / "packed.vtk.gz"
    packed.write_bytes(gzip.compress(tets.read_bytes()))
    assert meshopt("report", packed).out.startswith("packed.vtk.gz: ")


def test_compressed_in_and_out(meshopt, tets, tmp_path):
    packed, output = tmp_path / "packed.vtk.gz", tmp_path / "out.mesh.gz"
    packed.write_bytes(gzip.compress(tets.read_bytes()))
    assert meshopt("optimize", packed, output).status == 0
    assert meshopt("optimize", tets, tmp_path / "out.mesh").status == 0
    assert gzip.decompress(output.read_bytes()) == (tmp_path / "out.mesh").read_bytes()


@pytest.mark.parametrize("suffix", [".msh", ".vtk", ".vtu"])
def test_text_or_binary_on_request(meshopt, tets, tmp_path, suffix):
    output = tmp_path / f"out{suffix}"
    for option, binary in (("--ascii", False), ("--binary", True)):
        assert meshopt("optimize", tets, output, option).status == 0
        assert formats.sniff(output).binary == binary


def test_medit_is_text_or_binary_by_its_name(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.mesh", "--binary")
    assert ran.status == 2
    assert ".meshb" in ran.complaint
    assert meshopt("optimize", tets, tmp_path / "out.mesh", "--ascii").status == 0


def test_the_report_says_what_is_lost(meshopt, samples, tmp_path):
    ran = meshopt("optimize", samples / "two_regions.msh", tmp_path / "out.mesh", "--json")
    names = formats.read(samples / "two_regions.msh")[0].names
    lost = " ".join(json.loads(ran.out)["lost"])
    assert names
    assert all(f"{name} = {tag}" in lost for (_, tag), name in names.items())
    assert lost.split(",")[0] in ran.complaint
