"""The forms of what `check` finds."""

import json
from xml.etree import ElementTree as ET

import numpy as np

from meshopt_cli import formats
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import RULES
from support.broken import BROKEN
from support.files import write


def test_text_names_the_total(check, torn):
    _, out, _ = check(torn, "--limit", "2", "--select", "M205")
    *listed, more, last = out.splitlines()
    assert len(listed) == 2
    total = json.loads(check(torn, "--format", "json")[1])["files"][0]["counts"]["M205"]
    assert more == f"{torn}: M205 {total - 2} more, {total} in all"
    assert last == f"{torn}: not valid ({total} errors)"
    _, out, _ = check(torn, "--limit", "0", "--select", "M205")
    assert len(out.splitlines()) == total + 1


def test_statistics(check, good, bad, torn):
    status, out, _ = check(good, bad, torn, "--statistics")
    assert status == 1
    lines = [line.strip() for line in out.splitlines()]
    assert "1 M209 cells overlap" in lines
    assert lines[-1] == "3 files: 1 valid, 2 not valid"
    value = json.loads(check(bad, "--statistics", "--format", "json")[1])
    assert value["statistics"] == {"M209": 1}
    assert check(bad, "--statistics", "--format", "sarif")[0] == 2


def test_exit_zero(check, bad, tmp_path):
    assert check(bad, "--exit-zero")[0] == 0
    assert check(bad, tmp_path / "missing.vtu", "--exit-zero")[0] == 3
    assert check(bad, "--exit-zero", "--select", "X")[0] == 2


def test_github_annotations(check, good, bad, tmp_path):
    strange = write(tmp_path / "a,b%c.vtu", BROKEN["unused points"][0])
    status, out, _ = check(good, bad, strange, tmp_path / "none.vtu", "--format", "github")
    assert status == 3
    first, *others = out.splitlines()
    assert first.startswith(f"::error file={bad},title=M209 cells overlap::cell 1: ")
    assert others[0].startswith(f"::warning file={tmp_path}/a%2Cb%25c.vtu,title=M203")
    assert others[-1].startswith(f"::error file={tmp_path}/none.vtu,title=meshopt check::")


def test_junit(check, good, bad, torn, tmp_path):
    status, out, _ = check(good, bad, torn, tmp_path / "none.vtu", "--format", "junit")
    assert status == 3
    root = ET.fromstring(out.encode())
    assert [suite.get("name") for suite in root] == [
        str(path) for path in (good, bad, torn, tmp_path / "none.vtu")
    ]
    assert [int(suite.get("failures")) for suite in root] == [0, 1, 2, 0]
    assert [int(suite.get("errors")) for suite in root] == [0, 0, 0, 1]
    for element in (root, *root):
        cases = list(element.iter("testcase"))
        assert int(element.get("tests")) == len(cases)
        assert int(element.get("failures")) == len(list(element.iter("failure")))
    (failure,) = root[1].iter("failure")
    assert failure.get("type") == "M209"
    assert failure.text.startswith(f"{bad}:cell 1: M209 ")


def test_sarif(check, good, bad, tmp_path):
    status, out, _ = check(good, bad, tmp_path / "none.vtu", "--format", "sarif")
    assert status == 3
    value = json.loads(out)
    assert value["version"] == "2.1.0"
    (run,) = value["runs"]
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == list(RULES)
    (result,) = run["results"]
    assert result["ruleId"] == "M209"
    assert list(RULES)[result["ruleIndex"]] == "M209"
    location = result["locations"][0]
    assert location["physicalLocation"]["artifactLocation"]["uri"] == bad.as_uri()
    assert location["logicalLocations"][0]["name"] == "cell 1"
    (invocation,) = run["invocations"]
    assert not invocation["executionSuccessful"]
    assert "none.vtu" in invocation["toolExecutionNotifications"][0]["message"]["text"]


def test_mark(check, tmp_path):
    of = BROKEN["crack between tets"][0]
    of = Mesh(of.points, [Block("tetra", np.concatenate([of.blocks[0].cells, [[0, 1, 2, 99]]]))])
    path, marked = write(tmp_path / "torn.vtk", of), tmp_path / "marked.vtu"
    status, out, _ = check(path, "--mark", marked, "--format", "json", "--limit", "0")
    assert status == 1
    counts = json.loads(out)["files"][0]["counts"]
    shown, _ = formats.read(marked)
    cells = [b for b in shown.blocks if b.type == "tetra"]
    points = [b for b in shown.blocks if b.type == "vertex"]
    assert (cells[0].data["meshopt:cell"] < len(of.blocks[0].cells) - 1).all()
    assert sum(b.data["M202"].sum() for b in points) >= counts["M202"]
    assert sum(b.data["M205"].sum() for b in cells) >= counts["M205"]
    assert {*cells[0].data["meshopt:code"]} == {205}
    rows = points[0].data["meshopt:point"]
    np.testing.assert_array_equal(shown.points[points[0].cells[:, 0]], of.points[rows])


def test_mark_of_a_valid_mesh_is_empty(check, good, tmp_path):
    assert check(good, "--mark", tmp_path / "marked.vtu")[0] == 0
    assert b'NumberOfCells="0"' in (tmp_path / "marked.vtu").read_bytes()


def test_mark_goes_with_one_mesh_and_a_file_of_its_own(check, good, bad, tmp_path):
    assert check(good, bad, "--mark", tmp_path / "marked.vtu")[0] == 2
    assert check(bad, "--mark", bad)[0] == 2
    assert check(bad, "--mark", tmp_path / "marked.xyz")[0] == 3
    assert not (tmp_path / "marked.vtu").exists()
