"""Many meshes at once: each goes to its place, and the worst status is that of the run."""

import gzip
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from meshopt_cli.jobs.destinations import PARTS
from support.edits import shaken
from support.files import write
from support.meshes import tet_grid
from support.processes import heed_signals
from support.samples import SAMPLES


@pytest.fixture
def folder(tmp_path):
    inside = tmp_path / "in"
    inside.mkdir()
    for name in ("grid.vtk", "plate.vtu"):
        shutil.copy(SAMPLES / name, inside)
    (inside / "ball.mesh.gz").write_bytes(gzip.compress((SAMPLES / "raw_ball.mesh").read_bytes()))
    return inside


def lines(ran):
    return ran.out.splitlines()


def test_a_folder_goes_to_a_folder(meshopt, folder, tmp_path):
    out = tmp_path / "new" / "out"
    ran = meshopt("optimize", folder, "--output-dir", out)
    assert ran.status == 0
    assert sorted(p.name for p in out.iterdir()) == ["ball.mesh.gz", "grid.vtk", "plate.vtu"]
    assert lines(ran)[-1] == "3 meshes: 3 written"
    assert all(" -> " in line and "mean" in line for line in lines(ran)[:-1])
    alone = tmp_path / "alone.vtk"
    assert meshopt("optimize", folder / "grid.vtk", alone, "-q").status == 0
    assert alone.read_bytes() == (out / "grid.vtk").read_bytes()


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_pattern_names_results_beside_their_inputs(meshopt, folder, jobs):
    arguments = ("optimize", folder, "-o", "{stem}.opt{suffix}", "--jobs", jobs)
    first = meshopt(*arguments)
    assert first.status == 0
    names = ["ball.mesh.gz", "ball.opt.mesh.gz", "grid.opt.vtk", "grid.vtk", "plate.opt.vtu",
             "plate.vtu"]  # fmt: skip
    assert sorted(p.name for p in folder.iterdir()) == names
    made = {p.name: p.read_bytes() for p in folder.iterdir()}
    again = meshopt(*arguments)
    assert lines(again)[-1] == "3 meshes: 3 written"  # not those of the first run besides
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == made


def test_every_part_of_a_pattern(meshopt, folder, tmp_path):
    pattern = tmp_path / "{stem}-{name}-{suffix}"
    (tmp_path / "x").mkdir()
    ran = meshopt("optimize", folder / "grid.vtk", "-o", f"{pattern}.vtk", "-q")
    assert (ran.status, ran.out) == (0, "")
    assert (tmp_path / "grid-grid.vtk-.vtk.vtk").exists()
    ran = meshopt("optimize", folder / "grid.vtk", "-o", "{parent}/../x/{stem}.msh", "-q")
    assert (tmp_path / "x" / "grid.msh").exists()
    assert set(PARTS) == {"stem", "suffix", "name", "parent"}


def test_results_in_the_folder_of_inputs_are_no_inputs(meshopt, folder):
    for _ in range(2):
        ran = meshopt("optimize", folder, "--output-dir", folder / "out")
        assert lines(ran)[-1] == "3 meshes: 3 written"


def test_the_others_go_on_and_the_status_is_the_worst(meshopt, folder, tmp_path):
    shutil.copy(SAMPLES / "broken.vtk", folder)
    (folder / "empty.vtu").write_text("")
    ran = meshopt("optimize", folder, "--output-dir", tmp_path / "out")
    assert ran.status == 3
    assert lines(ran)[-1] == "5 meshes: 3 written, 2 not"
    assert "broken.vtk: the mesh is not valid" in ran.err
    assert "empty.vtu: the file is empty" in ran.err
    (folder / "empty.vtu").unlink()
    ran = meshopt("optimize", folder, "--output-dir", tmp_path / "out", "--json")
    assert ran.status == 1
    assert len(json.loads(ran.out)) == 3
    assert not (tmp_path / "out" / "broken.vtk").exists()


def test_a_gate_holds_for_each(meshopt, folder, tmp_path):
    ran = meshopt("optimize", folder, "--output-dir", tmp_path / "out", "--fail-above", "1.5")
    assert ran.status == 1
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["plate.vtu"]
    assert "grid.vtk: the worst Q stays at" in ran.err


def test_one_report_tells_of_all(meshopt, folder, tmp_path):
    page = tmp_path / "all.md"
    ran = meshopt("optimize", folder, "--output-dir", tmp_path / "out", "--report", page, "-q")
    assert (ran.status, ran.out) == (0, "")
    for name in ("grid.vtk", "plate.vtu", "ball.mesh.gz"):
        assert name in page.read_text()


def test_wrong_uses(meshopt, folder, tmp_path):
    grid, plate = folder / "grid.vtk", folder / "plate.vtu"
    wrong = {
        (grid, plate, folder / "ball.mesh.gz"): "several inputs need --output-dir",
        (): "Missing argument 'INPUT'",
        (grid, plate, "-o", "{stm}.vtk"): "did you mean 'stem'",
        (grid, plate, "-o", "{stem"): "--output",
        (grid, plate, "-o", "{parent}/one.vtk"): "would both be written to",
        (grid, plate, "--output-dir", folder): "is an input itself",
        ("-", "--output-dir", tmp_path): "pipes",
        (
            grid,
            "--output-dir",
            tmp_path,
            "--metric-out",
            "m.sol",
            "--size",
            "1",
        ): "name of an array",
        (grid, "--output-dir", tmp_path, "--preset", "bset"): "best",
    }
    for arguments, what in wrong.items():
        ran = meshopt("optimize", *arguments)
        assert ran.status == 2, arguments
        assert what in ran.err
    assert meshopt("optimize", grid, "--output-dir", grid).status == 3
    assert meshopt("optimize", tmp_path / "none*", "--output-dir", tmp_path).status == 3
    assert meshopt("optimize", grid, "--output-dir", folder, "--in-place", "-q").status == 0


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_ends_all_and_leaves_nothing_half_written(tmp_path):
    inputs = [write(tmp_path / f"{i}.vtu", shaken(tet_grid(14), 0.2, i)) for i in range(8)]
    out = tmp_path / "out"
    command = [sys.executable, "-m", "meshopt_cli", "optimize", *map(str, inputs), "--jobs", "2",
               "--output-dir", str(out), "--preset", "best"]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, preexec_fn=heed_signals) as run:  # noqa: PLW1509 # fmt: skip
        while not (out.exists() and any(out.glob("*.vtu"))):
            assert run.poll() is None
            time.sleep(0.02)
        start = time.monotonic()
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=60)
        assert time.monotonic() - start < 10
    assert run.returncode == 130
    assert "interrupted" in said
    for path in out.iterdir():
        assert path.name in said or path.name.startswith(".meshopt-")
