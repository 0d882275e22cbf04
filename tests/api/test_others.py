"""The other functions: check, report, repair, read and write."""

import inspect

import numpy as np
import pytest

import meshopt_cli as meshopt
from meshopt_cli.cli import check, report
from meshopt_cli.cli.entry import status_of
from support.edits import shaken
from support.meshes import tet_grid
from support.samples import SAMPLES

TERMINAL = {"engine", "scheduler", "meshes",
            "form", "statistics", "jobs", "exit_zero", "no_config", "explain", "output",
            "quiet", "verbose", "log_file"}  # fmt: skip
CALLED = {"extend": "extend_select", "gates": "gate", "regions": "region", "measures": "measure",
          "marked": "write_quality"}  # fmt: skip


def tets():
    mesh = shaken(tet_grid(3), 0.2, 1)
    return mesh.points, np.concatenate([b.cells for b in mesh.blocks if b.type == "tetra"])


@pytest.mark.parametrize(
    ("function", "command"), [(meshopt.check, check.command), (meshopt.report, report.command)]
)
def test_options_are_those_of_the_command_line(function, command):
    keywords = inspect.signature(function).parameters
    for flag in command.params:
        if flag.name not in TERMINAL:
            assert CALLED.get(flag.name, flag.name) in keywords
    for name in keywords:
        assert name in function.__doc__


def test_findings_name_cells_as_they_are_given():
    points, cells = tets()
    wrong = cells.copy()
    wrong[7] = wrong[7][[1, 0, 2, 3]]
    found = meshopt.check((points, wrong))
    assert not found
    assert "M101" in found.counts
    assert any("cell 7" in one.entities for one in found.findings)
    assert "cell 7" in found.to_text()
    assert '"M101"' in found.to_json()
    assert "M101" in repr(found)
    assert meshopt.check((points, cells)).is_valid


def test_gates():
    assert meshopt.check(tets(), fail_above=1000, gate="height-min>=1e-6")
    assert set(meshopt.check(tets(), fail_above=1.01).counts) == {"M401"}
    assert set(meshopt.check(tets(), gate="tau>=0.99", size="1").counts) == {"M406"}
    checked = meshopt.check(tets(), select="M1", ignore="M105").checked
    assert {"M101", "M102"} <= set(checked)
    assert "M105" not in checked
    assert all(code.startswith("M1") for code in checked)
    with pytest.raises(meshopt.ConfigError):
        meshopt.check(tets(), gate="tau>=0.99")
    with pytest.raises(meshopt.BadMeshError):
        meshopt.check((np.zeros((0, 3)), np.zeros((0, 4), int)))


def test_marks_are_written(tmp_path):
    points, cells = tets()
    cells = np.concatenate([cells, cells[:1]])
    meshopt.check((points, cells), mark=tmp_path / "marks.vtu")
    assert meshopt.read(tmp_path / "marks.vtu").blocks


def test_reports_compare():
    points, cells = tets()
    better = meshopt.optimize((points, cells)).mesh
    alone, both = (
        meshopt.report(better, measure="all"),
        meshopt.report(better, against=(points, cells)),
    )
    assert alone.worst < both.facts.before.worst
    assert len(alone.statistics) > 20
    assert "worst Q" in repr(alone)
    assert both.facts.is_comparison
    assert "<html" in both.to_html()


def test_repairs(tmp_path):
    points, cells = tets()
    twice = np.concatenate([points, points[:1]])
    cells = np.concatenate([cells, cells[-1:]])
    cells[0] = np.where(cells[0] == 0, len(points), cells[0])
    done = meshopt.repair((twice, cells))
    assert done.after
    assert len(done.mesh[1]) == len(cells) - 1
    assert done.before
    assert "valid" in repr(done)
    assert meshopt.check(done.write(tmp_path / "out.vtu"))
    with pytest.raises(meshopt.ConfigError, match="duplicates"):
        meshopt.repair((twice, cells), mends="duplicate")
    some = meshopt.repair((twice, cells), mends=["duplicates"])
    assert not some.after


@pytest.mark.parametrize("name", ["grid.vtk", "raw_ball.mesh", "plate.vtu"])
def test_files_go_through_like_those_of_the_command_line(tmp_path, capsys, name):
    """What is read and written knows its version, and whether it was text."""
    path = SAMPLES / name
    mesh = meshopt.read(path)
    out = meshopt.write(tmp_path / f"one{path.suffix}", mesh)
    made = tmp_path / f"two{path.suffix}"
    arguments = ["repair", str(path), str(made), "--duplicates"]
    assert status_of(arguments) == 0
    assert out.read_bytes() == made.read_bytes()
    assert meshopt.write(tmp_path / "x.msh", path, binary=True).exists()
    with pytest.raises(meshopt.WriteError):
        meshopt.write(tmp_path / "x.none", mesh)
