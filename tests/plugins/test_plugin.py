"""Packages add passes, measures, formats and outputs: that of `samples/plugin` is one."""

import os
import subprocess
import sys
import tomllib

import pytest

from meshopt_cli.registry import Table
from support.files import write
from support.meshes import tri_grid
from support.samples import ROOT, SAMPLES

PLUGIN = ROOT / "samples" / "plugin"
PROJECT = tomllib.loads((PLUGIN / "pyproject.toml").read_text("utf-8"))["project"]


def install(folder, points, name="meshopt-extras"):
    """What installing a package leaves of its entry points."""
    info = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = []
    for group, rows in points.items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in rows.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")


@pytest.fixture
def run(tmp_path):
    """The command line in a process that has the plugin."""
    install(tmp_path / "site", PROJECT["entry-points"])
    paths = [str(tmp_path / "site"), str(PLUGIN), str(ROOT)]

    def call(*words):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        return subprocess.run(
            [sys.executable, "-m", "meshopt_cli", *map(str, words)],
            check=False, capture_output=True, text=True, env=environment, cwd=tmp_path,
        )  # fmt: skip

    return call


@pytest.mark.parametrize(
    ("table", "name"),
    [("passes", "polish"), ("measures", "box-share"), ("formats", "off"), ("outputs", "brief")],
)
def test_what_it_adds_is_listed(run, table, name):
    (line,) = [one for one in run("list", table).stdout.splitlines() if one.startswith(f"{name} ")]
    assert "of meshopt-extras 1.0" in line


def test_its_pass_runs(run, tmp_path):
    ran = run("optimize", SAMPLES / "grid.vtk", "out.vtk", "--passes", "polish", "--set",
              "polish.turns=2")  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert "polish" in ran.stdout
    assert (tmp_path / "out.vtk").exists()
    assert run("check", "out.vtk").returncode == 0
    ran = run("optimize", SAMPLES / "grid.vtk", "out.vtk", "--set", "polish.turns=0",
              "--passes", "polish")  # fmt: skip
    assert ran.returncode == 2
    assert "out of range" in ran.stderr


def test_its_measure_is_told_and_is_a_gate(run):
    ran = run("report", SAMPLES / "grid.vtk", "--measure", "box-share")
    assert ran.returncode == 0, ran.stderr
    assert "box-share" in ran.stdout
    assert run("check", SAMPLES / "grid.vtk", "--gate", "box-share>=0.9").returncode == 1
    assert run("check", SAMPLES / "grid.vtk", "--gate", "box-share<=1").returncode == 0
    ran = run("optimize", SAMPLES / "grid.vtk", "out.vtk", "--measure", "box-share")
    assert ran.returncode == 2


def test_its_format_is_written_and_read(run, tmp_path):
    path = write(tmp_path / "in.vtk", tri_grid(4))
    assert run("optimize", path, "out.off").returncode == 0
    ran = run("check", "out.off")
    assert (ran.returncode, ran.stderr) == (0, "")
    (tmp_path / "bad.off").write_text("nothing of it")
    ran = run("check", "bad.off")
    assert ran.returncode == 3
    assert "bad.off: not a readable OFF file" in ran.stderr


def test_its_output_is_written(run, tmp_path):
    ran = run("report", SAMPLES / "grid.vtk", SAMPLES / "plate.vtu", "--format", "brief")
    assert [line.split(":")[0] for line in ran.stdout.splitlines()] == ["grid.vtk", "plate.vtu"]
    assert run("optimize", SAMPLES / "grid.vtk", "out.vtk", "--report", "out.brief").returncode == 0
    assert " -> " in (tmp_path / "out.brief").read_text()


def test_a_plugin_that_cannot_be_loaded_is_left_out(run, tmp_path):
    rows = {"none": "no_such_module:ROW", "smooth": "meshopt_extras.polish:Polish",
            "five": "meshopt_extras.polish:option"}  # fmt: skip
    install(tmp_path / "site", {"meshopt.passes": rows}, "broken")
    ran = run("list", "passes")
    assert ran.returncode == 0
    assert "the pass none of broken 1.0 is left out: ModuleNotFoundError" in ran.stderr
    assert "the pass five of broken 1.0 is left out: it is no pass" in ran.stderr
    assert "there is one of the name polish" in ran.stderr


def test_nothing_is_looked_for_where_all_is_known():
    code = (
        "import sys\n"
        "from meshopt_cli.passes import PASSES\n"
        "from meshopt_cli.formats import FORMATS\n"
        "assert 'smooth' in PASSES and PASSES['swap'] and FORMATS['vtu']\n"
        "print('importlib.metadata' in sys.modules)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"


class Thing:
    name = "thing"


def test_a_table():
    table = Table("meshopt.nothing", "thing", [Thing()], lambda row: isinstance(row, Thing))
    assert "thing" in table
    assert "other" not in table
    assert list(table.whole()) == ["thing"]
    with pytest.raises(KeyError):
        _ = table["other"]
