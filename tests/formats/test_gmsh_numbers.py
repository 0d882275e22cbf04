"""Nodes and elements of Gmsh are called by the numbers that the file gives them."""

import pytest

from meshopt_cli.formats import numbering, read
from meshopt_cli.jobs.findings import verdict_on
from meshopt_cli.validity import check
from support.gmsh import Builder, two_tets


@pytest.mark.parametrize("version", ["1", "2.2", "4.1"])
def test_sparse_numbers(tmp_path, version):
    path = tmp_path / "mesh.msh"
    content = two_tets(Builder(version), (30, 7, 1000, 2, 8))
    path.write_bytes(content.replace(b"\n2 30", b"\n5000 30").replace(b"\n2 4 ", b"\n5000 4 "))
    mesh, source = read(path)
    names = numbering(source.encoding, mesh)
    assert [names.point(i) for i in range(5)] == [f"node {n}" for n in (2, 7, 8, 30, 1000)]
    cells = [names.cell(0, 0), names.cell(1, 0), names.cell(1, 1)]
    assert cells == ["element 1", "element 5000", "element 3"]


def test_numbers_that_count_on_need_no_list(tmp_path):
    path = tmp_path / "mesh.msh"
    path.write_bytes(two_tets(Builder("4.1")))
    mesh, _ = read(path)
    assert mesh.numbers is None
    assert all(block.numbers is None for block in mesh.blocks)


def test_findings_name_elements_by_their_numbers(tmp_path):
    path = tmp_path / "mesh.msh"
    content = two_tets(Builder("2.2"), (30, 7, 1000, 2, 8))
    path.write_bytes(content.replace(b"\n3 4 2 7 1 7 1000 2 8\n", b"\n99 4 2 7 1 7 1000 2 2\n"))
    mesh, source = read(path)
    verdict = verdict_on(path, source, mesh, check(mesh), 1)
    found = {finding.code: finding.entities for finding in verdict.findings}
    assert found["M003"] == ("element 99",)
    assert found["M203"] == ("node 8",)
