"""`meshopt check`: what is said, and the status."""

import hashlib
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from meshopt_cli.validity import RULES
from support.files import strict, write
from support.meshes import tet_grid
from support.refused import bad_mesh


@pytest.fixture
def several(tmp_path, tets, broken):
    """Files for check with the status that each has alone."""
    lines, _, _ = bad_mesh(tmp_path, "lines")
    quads, _, _ = bad_mesh(tmp_path, "quads")
    return {tets: 0, quads: 0, broken: 1, lines: 0, tmp_path / "missing.vtk": 3}


def test_check_of_one_mesh(meshopt, several):
    for path, status in several.items():
        ran = meshopt("check", path)
        assert ran.status == status
        assert str(path) in ran.out + ran.err
        if status == 0:
            assert ran.out == f"{path}: valid\n"
            assert ran.err == ""


def test_check_of_several_meshes_has_the_worst_status(meshopt, several):
    paths = list(several)
    for n in range(1, len(paths) + 1):
        for chosen in (paths[:n], paths[:n][::-1]):
            ran = meshopt("check", *chosen)
            assert ran.status == max(several[path] for path in chosen)
            assert all(str(path) in ran.out + ran.err for path in chosen)


def test_check_says_what_is_wrong_and_where(meshopt, broken):
    ran = meshopt("check", broken)
    assert ran.err == ""
    *findings, last = ran.out.splitlines()
    assert last.startswith(f"{broken}: not valid (")
    for line in findings:
        where = line.removeprefix(f"{broken}:")
        assert re.match(r"cell \d+: M\d{3} .* at \(\S+, \S+, \S+\)$", where)
    n_errors = int(re.search(r"([\d,]+) error", last)[1].replace(",", ""))
    assert n_errors == len(findings)


def test_check_as_json(meshopt, several):
    ran = meshopt("check", *several, "--format", "json")
    value = strict(ran.out)
    assert ran.status == 3
    assert list(value) == ["files"]
    assert [Path(one["path"]) for one in value["files"]] == list(several)
    for one, (path, status) in zip(value["files"], several.items(), strict=True):
        assert one["status"] == status
        assert one["valid"] == (status == 0)
        if status == 3:
            assert str(path) in one["error"]
            continue
        assert one["format"] == path.suffix[1:]
        assert one["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert set(one["counts"]) <= set(RULES)
        codes = Counter(finding["code"] for finding in one["findings"])
        assert set(codes) == set(one["counts"])
        assert all(codes[code] <= n for code, n in one["counts"].items())
        for finding in one["findings"]:
            assert set(finding) == {"code", "severity", "message", "entities", "others", "where"}
            assert finding["severity"] == RULES[finding["code"]].severity
            assert len(finding["where"]) == 3
    bad = value["files"][list(several.values()).index(1)]
    assert {"M101", "M201"} <= set(bad["counts"])


def test_check_as_json_of_a_point_that_is_nowhere(meshopt, tmp_path):
    one = tet_grid(2)
    one.points[3, 0] = np.nan
    one.points[4, 1] = np.inf
    path = write(tmp_path / "nan.vtu", one)
    ran = meshopt("check", path, "--format", "json")
    assert ran.status == 1
    (value,) = strict(ran.out)["files"]
    assert value["counts"]["M001"] == 2


def test_check_shows_the_first_of_many(meshopt, tmp_path):
    one = tet_grid(4)
    cells = one.blocks[0].cells
    one.blocks[0].cells = np.concatenate([cells, cells[:50]])
    path = write(tmp_path / "doubled.vtu", one)
    ran = meshopt("check", path, "--select", "M201")
    shown = [line for line in ran.out.splitlines() if re.search(r": M201 (?!\d)", line)]
    (more,) = re.findall(r": M201 (\d+) more", ran.out)
    assert len(shown) + int(more) == 50
    assert len(shown) < 50


def test_check_selects_and_ignores(meshopt, broken):
    def codes(*options):
        ran = meshopt("check", broken, "--format", "json", *options)
        (value,) = strict(ran.out)["files"]
        assert ran.status == value["status"] == (1 if value["counts"] else 0)
        return set(value["counts"])

    everything = codes()
    assert {"M101", "M201"} <= everything
    assert codes("--select", "M201") == {"M201"}
    assert codes("--select", "M1,M201") == {c for c in everything if c[:2] == "M1"} | {"M201"}
    assert codes("--ignore", "M201") == everything - {"M201"}
    assert codes("--select", "M2", "--ignore", "M201") == {
        c for c in everything - {"M201"} if c[:2] == "M2"
    }
    assert codes("--ignore", ",".join(everything)) == set()


def test_check_warnings_are_no_errors(meshopt, tmp_path):
    one = tet_grid(2)
    one.points = np.concatenate([one.points, [[9.0, 9.0, 9.0]]])
    path = write(tmp_path / "unused.vtu", one)
    ran = meshopt("check", path)
    assert ran.status == 0
    assert "M203" in ran.out
    assert ran.out.splitlines()[-1] == f"{path}: valid (1 warning)"


def test_check_quietly(meshopt, tets, broken):
    assert meshopt("check", tets, "-q") == (0, "", "")
    ran = meshopt("check", broken, "-q")
    assert ran.status == 1
    assert all(": M" in line for line in ran.out.splitlines())
    assert ran.out
