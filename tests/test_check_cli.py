"""`meshopt check` as it is used: gates, configuration, outputs, many files."""

import json
import os
import subprocess
import sys
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from broken_meshes import BROKEN
from builders import in_space, quad_grid, tet_grid, tri_grid
from edits import tagged

from meshopt_cli import formats
from meshopt_cli.cli.main import status_of
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import RULES, limit_of
from meshopt_cli.validity.limits import QUANTITIES, families_of, measured, quantities

LINE = r"^(.+):(.+): (M\d{3}) (.+)$"


@pytest.fixture(autouse=True)
def _nothing_configured(tmp_path, monkeypatch):
    """No file of this project is found from the working directory."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def check(capsys):
    """Run `meshopt check`; gives status, stdout and stderr."""

    def run(*arguments):
        capsys.readouterr()
        status = status_of(["check", *map(str, arguments)])
        out, err = capsys.readouterr()
        return (
            status,
            out,
            "".join(line for line in err.splitlines(keepends=True) if "compiling" not in line),
        )

    return run


def write(path, of):
    if of.points.shape[1] == 2:
        of = in_space(Mesh(of.points, of.blocks))
    formats.write(path, of, formats.encoding_for(path))
    return path


@pytest.fixture
def good(tmp_path):
    return write(tmp_path / "good.vtu", tet_grid(2))


@pytest.fixture
def bad(tmp_path):
    return write(tmp_path / "bad.vtu", BROKEN["tets across each other"][0])


@pytest.fixture
def torn(tmp_path):
    return write(tmp_path / "torn.vtu", BROKEN["crack between tets"][0])


# Rules ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", RULES)
def test_every_rule_is_explained(check, code):
    status, out, err = check("--explain", code.lower())
    rule = RULES[code]
    assert (status, err) == (0, "")
    for part in (code, rule.title, rule.severity, rule.explanation, rule.source, rule.fix):
        assert part in out


def test_an_unknown_rule_is_not_explained(check):
    status, out, err = check("--explain", "M999")
    assert (status, out) == (2, "")
    assert "M999" in err
    assert len(err.splitlines()) == 1


def test_rules_on_request(check, good):
    asked = {code for code, rule in RULES.items() if rule.on_request}
    assert asked == {"M301", "M302", "M303", "M405"}
    assert check(good)[1] == f"{good}: valid\n"
    status, out, _ = check(good, "--extend-select", "M3", "--format", "json")
    assert status == 0
    assert set(json.loads(out)["files"][0]["counts"]) == {"M302", "M303"}


def test_overconstrained_cells_edges_and_faces(check, tmp_path):
    def counts(of):
        path = write(tmp_path / "one.vtu", of)
        out = check(path, "--select", "M3", "--format", "json")[1]
        return json.loads(out)["files"][0]["counts"]

    # Of the triangles of a square those at two of its corners have two sides in the boundary;
    # the diagonal of a single square joins two corners.
    assert counts(tri_grid(3)) == {"M301": 2, "M302": 2}
    assert counts(tri_grid(1)) == {"M301": 2, "M302": 1}
    # Six tets around a diagonal: all faces inside have it, and two edges in the boundary.
    assert counts(tet_grid(1)) == {"M302": 1, "M303": 6}


def test_obtuse_angles(check, tmp_path):
    path = write(tmp_path / "right.vtu", tri_grid(2))
    assert check(path, "--select", "M405")[1] == f"{path}: valid\n"
    of = tri_grid(2)
    of.points[4] += [0.1, 0.02]
    status, out, _ = check(write(tmp_path / "obtuse.vtu", of), "--select", "M405")
    assert status == 0
    assert "M405" in out


# Gates ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gates", "code"),
    [
        (["--min-angle", "44"], None),
        (["--min-angle", "46"], "M402"),
        (["--max-angle", "91"], None),
        (["--max-angle", "89"], "M402"),
        (["--min-size", "0.49"], None),
        (["--min-size", "0.51"], "M403"),
        (["--max-aspect", "1.5"], "M404"),
        (["--max-aspect", "3"], None),
        (["--fail-above", "1.5"], "M401"),
        (["--fail-above", "3"], None),
        (["--gate", "dihedral-min>=44"], None),
        (["--gate", "dihedral-min >= 46"], "M404"),
        (["--gate", "edge-max<=0.9"], None),
        (["--gate", "edge-max<=0.8"], "M404"),
        (["--gate", "content>=0.02"], None),
        (["--gate", "content>=0.021"], "M404"),
        (["--gate", "radius-ratio<=9", "--gate", "edge-ratio<=1.1"], "M404"),
    ],
)
def test_gates(check, good, gates, code):
    status, out, _ = check(good, *gates, "--format", "json")
    (file,) = json.loads(out)["files"]
    assert set(file["counts"]) == ({code} if code else set())
    assert status == (1 if code else 0)


def test_a_gate_needs_not_be_selected_but_can_be_ignored(check, good):
    assert check(good, "--select", "M1", "--min-angle", "80")[0] == 1
    assert check(good, "--ignore", "M402", "--min-angle", "80")[0] == 0


def test_a_gate_on_a_region(check, tmp_path):
    of = tagged(tet_grid(2), [1] * 24 + [2] * 24)
    path = write(tmp_path / "two.mesh", of)

    def n_found(gate):
        counts = json.loads(check(path, "--gate", gate, "--format", "json")[1])["files"][0][
            "counts"
        ]
        return counts.get("M404", 0)

    assert n_found("edge-min>=9") == 48
    assert n_found("edge-min>=9 @ 2") == 24
    for region in ("3", "steel"):
        status, out, err = check(path, "--gate", f"edge-min>=9 @ {region}")
        assert (status, out) == (2, "")
        assert str(path) in err
        assert region in err


def test_a_gate_on_a_region_by_name(check, tmp_path):
    of = tagged(tet_grid(2), [1] * 24 + [7] * 24, "gmsh:physical")
    of.names = {"steel": (7, 3)}
    of.blocks[0].data["gmsh:geometrical"] = of.blocks[0].data["gmsh:physical"]
    path = write(tmp_path / "named.msh", of)
    out = check(path, "--gate", "edge-min>=9 @ steel", "--format", "json")[1]
    assert json.loads(out)["files"][0]["counts"]["M404"] == 24


@pytest.mark.parametrize(
    "text", ["", "edge-min", "edge-min=1", "edge-min>=", "edge-min>=x", "edge-min>=nan", "foo>=1",
             "edge-min>=1 @"]
)  # fmt: skip
def test_a_gate_that_cannot_be_understood(check, good, text):
    status, out, err = check(good, "--gate", text)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert repr(text) in err


def test_a_gate_that_no_cell_is_measured_by_is_said(check, tmp_path):
    path = write(tmp_path / "quads.vtu", quad_grid(2))
    for gate in (["--fail-above", "2"], ["--gate", "dihedral-min>=1"], ["--max-aspect", "2"]):
        status, out, err = check(path, *gate)
        assert (status, out) == (0, f"{path}: valid\n")
        assert "quad" in err
    assert check(path, "--min-angle", "80", "--min-size", "0.1")[2] == ""


def test_a_gate_is_written_as_it_is_read():
    for text in ("dihedral-min >= 10", "aspect-ratio <= 5 @ steel plate"):
        assert str(limit_of(text)) == text


@pytest.mark.parametrize("name", quantities())
def test_quantities_of_the_regular_cells(name):
    height = np.sqrt(2 / 3)
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0],
                       [0.5, np.sqrt(0.75) / 3, height]])  # fmt: skip
    regular = {
        "dihedral-min": (None, np.degrees(np.arccos(1 / 3))),
        "dihedral-max": (None, np.degrees(np.arccos(1 / 3))),
        "corner-min": (60, None),
        "corner-max": (60, None),
        "height-min": (np.sqrt(0.75), height),
        "content": (np.sqrt(3) / 4, np.sqrt(2) / 12),
    }
    for family, cells, expected in zip(
        ("triangle", "tetra"), ([[0, 1, 2]], [[0, 1, 2, 3]]), regular.get(name, (1, 1)), strict=True
    ):
        assert (family in families_of(name)) == (expected is not None)
        if expected is not None:
            assert measured(name, points, np.array(cells), family) == pytest.approx(expected)
    assert (name in QUANTITIES) == (name in regular or name.startswith("edge-m"))


# Configuration -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "table"), [("meshopt.toml", "check"), ("pyproject.toml", "tool.meshopt.check")]
)
def test_defaults_stand_in_the_nearest_file(check, good, tmp_path, monkeypatch, name, table):
    lines = 'min-angle = 80\ngate = ["edge-min>=9"]\nignore = ["M404"]\n'
    (tmp_path / name).write_text(f"[{table}]\n{lines}")
    below = tmp_path / "below" / "it"
    below.mkdir(parents=True)
    monkeypatch.chdir(below)
    status, out, _ = check(good, "--format", "json")
    assert status == 1
    assert set(json.loads(out)["files"][0]["counts"]) == {"M402"}
    assert check(good, "--min-angle", "1")[0] == 0  # the command line wins
    assert check(good, "--no-config")[0] == 0
    (below / "meshopt.toml").write_text("[check]\nexit-zero = true\nfail-above = 1.1\n")
    status, out, _ = check(good)
    assert status == 0
    assert "M401" in out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[check]\nmin-angel = 1\n", "did you mean 'min-angle'"),
        ("[check]\nwhatever = 1\n", "known are"),
        ('[check]\nmin-angle = "steep"\n', "min-angle"),
        ("[check]\nmin-angle = true\n", "min-angle"),
        ("[check]\nfail-above = 0.5\n", "fail-above"),
        ("[check]\nexit-zero = 1\n", "exit-zero"),
        ("[check]\ngate = [1]\n", "gate"),
        ("[check]\nselect = { a = 1 }\n", "select"),
        ("check = 1\n", "table"),
        ("[check\n", "TOML"),
    ],
)
def test_a_wrong_file_is_named(check, good, tmp_path, text, said):
    path = tmp_path / "meshopt.toml"
    path.write_text(text)
    status, out, err = check(good)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert str(path) in err
    assert said in err


def test_a_file_for_something_else_is_passed_by(check, good, tmp_path):
    (tmp_path / "pyproject.toml").write_text("[tool.other]\nx = 1\n")
    (tmp_path / "meshopt.toml").write_text("[optimize]\nx = 1\n")
    assert check(good)[0] == 0


# Outputs -------------------------------------------------------------------------------------


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


# Many files ----------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "meshes"
    (folder / "inner").mkdir(parents=True)
    write(folder / "a.vtu", tet_grid(1))
    write(folder / "b.mesh", BROKEN["hanging node"][0])
    write(folder / "inner" / "c.vtk", quad_grid(2))
    (folder / "notes.txt").write_text("no mesh")
    return folder


def test_folders_and_patterns(check, folder, tmp_path):
    status, out, err = check(folder)
    assert (status, err) == (1, "")
    assert out.splitlines()[-1] == "3 files: 2 valid, 1 not valid"
    assert "c.vtk: valid" in out
    _, out, _ = check(folder / "*.vtu", folder / "**" / "*.vtk", folder / "a.vtu")
    assert out.splitlines()[-1] == "2 files: 2 valid"
    for nothing in (folder / "*.msh", tmp_path / "empty"):
        (tmp_path / "empty").mkdir(exist_ok=True)
        status, out, err = check(nothing)
        assert (status, out) == (3, "")
        assert str(nothing) in err


@pytest.mark.parametrize("form", ["text", "json", "github", "junit", "sarif"])
def test_processes_change_nothing(check, folder, form):
    missing = folder / "missing.vtu"
    alone = check(folder, missing, "--format", form, "--jobs", "1")
    assert check(folder, missing, "--format", form, "--jobs", "3") == alone
    assert alone[0] == 3


def test_small_files_need_no_compiler(good):
    code = (
        "import sys; from meshopt_cli.cli.main import status_of\n"
        f"assert status_of(['check', {str(good)!r}, '--min-angle', '1']) == 0\n"
        "print({'numba', 'tqdm'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True,
                         env=os.environ)  # fmt: skip
    assert ran.stdout.splitlines()[-1] == "set()"
