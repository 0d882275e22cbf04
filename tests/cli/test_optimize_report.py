"""What `optimize` says of the mesh before and after."""

import csv
import hashlib
import io
import re

import numpy as np
import pytest

from meshopt_cli import __version__, formats
from meshopt_cli.passes import PASSES
from meshopt_cli.quality.measures import DEFAULT_MEASURE, OF_SIMPLICES
from meshopt_cli.reports.rows import HEADINGS
from support.files import strict, worst_of
from support.processes import ESCAPE
from support.reports import FILE_KEYS, PASS_KEYS, TOP_KEYS, check_summary


@pytest.mark.parametrize("name", ["tets", "triangles"])
@pytest.mark.parametrize("measure", [DEFAULT_MEASURE, "mean-edge"])
def test_the_json_report(meshopt, request, tmp_path, name, measure):
    path = request.getfixturevalue(name)
    output = tmp_path / f"out{path.suffix}"
    ran = meshopt("optimize", path, output, "--json", "--measure", measure, "-v")
    assert ran.status == 0
    value = strict(ran.out)
    assert set(value) == TOP_KEYS
    assert value["meshopt"] == __version__
    assert value["measure"] == measure
    assert value["dimension"] == {"tets": 3, "triangles": 2}[name]
    for key, file in (("input", path), ("output", output)):
        assert set(value[key]) == FILE_KEYS
        assert value[key]["path"] == str(file)
        assert value[key]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
        assert value[key]["format"] == path.suffix[1:]
    check_summary(value["before"], formats.read(path)[0], measure)
    check_summary(value["after"], formats.read(output)[0], measure)
    assert value["after"]["worst"] <= value["before"]["worst"]
    assert value["after"]["target"] == value["before"]["target"]
    assert set(value["seconds"]) == {"read", "optimize", "write"}
    assert all(seconds >= 0 for seconds in value["seconds"].values())
    assert value["stopped"]
    assert value["passes"]
    for one in value["passes"]:
        assert set(one) == PASS_KEYS
        assert one["name"] in PASSES
        assert one["visited"] == one["applied"] + sum(one["refused"].values())
        assert one["round"] >= 0
        assert one["seconds"] >= 0


@pytest.mark.parametrize("name", ["tets", "triangles"])
def test_the_table(meshopt, request, tmp_path, name):
    path = request.getfixturevalue(name)
    ran = meshopt("optimize", path, tmp_path / f"out{path.suffix}")
    assert (ran.status, ran.err) == (0, "")
    title, head, *rows = ran.out.splitlines()
    assert title.startswith(f"{path.name}: ")
    assert re.split(r"\s{2,}", head.strip()) == list(HEADINGS)
    found = {row.split()[0]: row.split()[1:] for row in rows[:4] if row[0] != " "}
    assert list(found) == ["before", "after"]
    for cells in found.values():
        assert len(cells) == len(HEADINGS)
        assert sum(float(cell) for cell in cells[:4]) == pytest.approx(100, abs=0.21)
    bars = [line for line in rows[4:] if re.match("(before|after) ", line)]
    assert len(bars) == 2
    assert "stopped: " in ran.out
    assert len(re.findall("^smooth ", ran.out, re.M)) == 1


def read_report(path):
    """What a report file says of the worst Q after the run, in as many digits as it has."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".json":
        return strict(text)["after"]["worst"]
    if path.suffix == ".csv":
        return float(list(csv.DictReader(io.StringIO(text)))[-1]["Q_T"])
    words = next(re.findall(r"[\w.%+-]+", line) for line in text.splitlines() if "after" in line)
    return float(words[words.index("after") + 6])


def test_reports_in_files(meshopt, tets, tmp_path):
    paths = [tmp_path / f"report{suffix}" for suffix in (".json", ".md", ".csv", ".txt")]
    output = tmp_path / "out.vtk"
    ran = meshopt("optimize", tets, output, *[f"--report={path}" for path in paths], "-q")
    assert ran == (0, "", "")
    for path in paths:
        assert read_report(path) == pytest.approx(worst_of(output), abs=0.006)
        assert ESCAPE not in path.read_text(encoding="utf-8")
    assert set(strict(paths[0].read_text())) == TOP_KEYS
    assert set(strict(paths[0].read_text())["after"]["measures"]) == set(OF_SIMPLICES)


def test_a_time_limit_of_nothing_gives_the_mesh_back(meshopt, tets, tmp_path):
    ran = meshopt("optimize", tets, tmp_path / "out.vtk", "--time-limit", "0", "--json")
    assert ran.status == 0
    before, after = (strict(ran.out)[key] for key in ("before", "after"))
    for figures in (before, after):
        for cell in figures["worst_cells"]:
            del cell["cell"]  # cells may be listed in another order
    assert after == before
    assert np.array_equal(*(formats.read(p)[0].points for p in (tets, tmp_path / "out.vtk")))


def test_a_target_ends_the_rounds(meshopt, tets, tmp_path):
    """And a mesh that is there already is left alone."""
    arguments = ["optimize", tets, tmp_path / "out.vtk", "--json", "--passes", "smooth"]
    far = strict(meshopt(*arguments).out)
    near = strict(meshopt(*arguments, "--target-quality", "2.9").out)
    assert near["stopped"] == "target quality"
    assert near["after"]["worst"] <= 2.9
    assert len(near["passes"]) < len(far["passes"])
