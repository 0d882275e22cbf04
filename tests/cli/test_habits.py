"""The command line as people type it, whatever other programs taught them."""

import gzip
import os

import click
import pytest
from click.shell_completion import ShellComplete

from meshopt_cli.cli.main import COMMANDS, LazyGroup, main
from support.files import untouched, write
from support.meshes import tet_grid
from support.processes import in_a_pipe, outside

NAMED = ("NAME", "LIST", "CODE", "CODES", "PASS.OPTION=VALUE", "GATE")


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["optim"], "optimize"),
        (["chek", "a.msh"], "check"),
        (["xyz"], "repair"),
        (["help"], "meshopt --help"),
        (["help", "check"], "meshopt check --help"),
        (["none.msh"], "meshopt check none.msh"),
        (["none.vtu.gz", "out.vtu"], "optimize none.vtu.gz OUTPUT"),
    ],
)
def test_no_command_suggests_one(meshopt, words, meant):
    ran = meshopt(*words)
    assert ran.status == 2
    assert meant in ran.complaint


def test_a_file_is_no_command_whatever_its_name(meshopt, tmp_path):
    path = tmp_path / "mesh"
    path.touch()
    assert f"meshopt check {path}" in meshopt(path).complaint


@pytest.mark.parametrize("command", COMMANDS)
def test_a_wrong_option_points_to_the_help_of_its_command(meshopt, command):
    assert f"meshopt {command} --help" in meshopt(command, "--no-such-option").complaint


@pytest.mark.parametrize("command", [["optimize"], ["repair", "--all"]])
def test_the_output_as_an_option(meshopt, tets, tmp_path, command):
    out = tmp_path / "out.vtu"
    assert meshopt(*command, tets, "-o", out).status == 0
    assert out.exists()
    with untouched(tmp_path):
        ran = meshopt(*command, tets, tmp_path / "one.vtu", "-o", tmp_path / "two.vtu")
    assert ran.status == 2
    assert "given twice" in ran.complaint


@pytest.mark.parametrize("command", ["check", "report"])
def test_folders_and_what_is_compressed_in_them(meshopt, tmp_path, command):
    folder = tmp_path / "meshes"
    (folder / "deep").mkdir(parents=True)
    for name in ("a.msh", "deep/b.vtk", "c.mesh.gz"):
        write(folder / name, tet_grid(1))
    (folder / "notes.txt").write_text("none")
    (folder / "packed.txt.gz").write_bytes(gzip.compress(b"none"))
    ran = meshopt(command, folder)
    assert (ran.status, ran.err) == (0, "")
    assert all(name in ran.out for name in ("a.msh", "b.vtk", "c.mesh.gz"))
    assert "txt" not in ran.out


@pytest.mark.parametrize("command", ["check", "report"])
def test_a_format_whatever_the_name(meshopt, tmp_path, command):
    path = write(tmp_path / "mesh.vtk", tet_grid(1)).rename(tmp_path / "mesh.dat")
    assert meshopt(command, path).status == 3
    assert meshopt(command, path, "--input-format", "vtk").status == 0


@pytest.mark.skipif(os.name != "posix", reason="names that POSIX has")
@pytest.mark.parametrize("command", ["check", "report"])
def test_other_names_of_stdin(tets, command):
    assert in_a_pipe(tets.read_bytes(), command, "/dev/stdin")[0] == 0


def test_a_report_on_stdout_is_there_once(tets, tmp_path):
    ran = outside("optimize", tets, tmp_path / "out.vtk", "--report", "-")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.count("stopped: ") == 1
    ran = outside("optimize", tets, "-", "--report", "-")
    assert ran.status == 2
    assert "stdout" in ran.complaint


@pytest.mark.parametrize("table", ["passes", "measures", "formats", "rules", "presets"])
def test_a_row_of_a_list_is_a_line_in_a_pipe(meshopt, table):
    lines = [line for line in meshopt("list", table).out.splitlines() if line]
    assert all(len(line.split()) > 1 for line in lines)
    assert lines == [line.rstrip() for line in lines]
    if table == "rules":
        assert all(line[0] == "M" for line in lines)


def completions(words, incomplete):
    shell = ShellComplete(main, {}, "meshopt", "_MESHOPT_COMPLETE")
    return [item.value for item in shell.get_completions(words, incomplete)]


def options():
    group = main
    assert isinstance(group, LazyGroup)
    for name in COMMANDS:
        command = group.get_command(click.Context(group), name)
        for option in command.params:
            if isinstance(option, click.Option) and option.metavar in NAMED:
                yield name, option


@pytest.mark.parametrize(
    ("command", "option"), list(options()), ids=lambda x: x if isinstance(x, str) else x.opts[-1]
)
def test_every_option_that_takes_a_name_completes_it(command, option):
    found = completions([command, option.opts[-1]], "")
    assert found
    first = found[0]
    assert first in completions([command, option.opts[-1]], first[:-1])


def test_the_names_of_a_list_are_completed_one_by_one():
    assert completions(["optimize", "--passes"], "smooth,sw") == ["smooth,swap"]
    assert "smooth,smooth" not in completions(["optimize", "--passes"], "smooth,")
    assert completions([], "opt") == ["optimize"]
    assert "--preset" in completions(["optimize"], "--pre")
