"""What is wrong with a command line is named: status 2."""

import os

import pytest

from support.files import contents, untouched, worst_of

WRONG_OPTIONS = [
    (["--preset", "fats"], "fast"),
    (["--passes", "swapp"], "swap"),
    (["--passes", "smooth,swapp"], "swap"),
    (["--passes", ""], "passes"),
    (["--passes", " , "], "passes"),
    (["--measure", "aspect"], "aspect-ratio"),
    (["--measure", "edge-ratio"], "edge-ratio"),
    (["--file-format", "stl"], "vtu"),
    (["--input-format", "stl"], "vtu"),
    (["--region", "none"], "none"),
    (["--set", "smooth"], "PASS.OPTION=VALUE"),
    (["--set", "smoth.worse-than=2"], "smooth"),
    (["--set", "smooth.worse-tha=2"], "worse-than"),
    (["--set", "smooth.worse-than=much"], "smooth.worse-than"),
    (["--set", "smooth.worse-than=0.5"], "smooth.worse-than"),
    (["--set", "smooth.method=no"], "laplace"),
    (["--passes", "swap", "--set", "smooth.worse-than=2"], "smooth"),
    (["--preset", "fast", "--passes", "swap"], "--passes"),
    (["--config", "missing.toml"], "missing.toml"),
    (["--report", "report.doc"], "report.doc"),
    (["--report", "report"], "report"),
    (["--rounds", "0"], "--rounds"),
    (["--rounds", "many"], "--rounds"),
    (["--target-quality", "0.5"], "--target-quality"),
    (["--target-quality", "nan"], "target-quality"),
    (["--time-limit", "-1"], "--time-limit"),
    (["--time-limit", "nan"], "time-limit"),
    (["--fail-above", "0.9"], "--fail-above"),
    (["--fail-above", "nan"], "fail-above"),
    (["--no-such-option"], "--no-such-option"),
    (["-q", "-v"], "-v"),
    (["third.vtk"], "third.vtk"),
]
every_wrong_option = pytest.mark.parametrize(
    ("arguments", "said"), WRONG_OPTIONS, ids=[" ".join(a) for a, _ in WRONG_OPTIONS]
)


@every_wrong_option
def test_a_wrong_option_is_named_and_nothing_is_written(
    meshopt, tets, tmp_path, monkeypatch, arguments, said
):
    monkeypatch.chdir(tmp_path)
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, tmp_path / "out.vtk", *arguments)
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--rounds", "0"],
        ["--no-such-option"],
        ["--set"],
        ["-q", "-v"],
        ["--preset", "fats"],
    ],
    ids=" ".join,
)
def test_wrong_usage_is_said_in_one_line(meshopt, tets, tmp_path, arguments):
    assert meshopt("optimize", tets, tmp_path / "out.vtk", *arguments).complaint


@pytest.mark.parametrize(
    "arguments",
    [
        ["optimise"],
        ["optimize"],
        ["check"],
        ["report"],
        ["list"],
        ["list", "meshes"],
        ["check", "MESH", "--format", "xml"],
        ["check", "MESH", "--select", "M999"],
        ["check", "MESH", "--ignore", "X"],
        ["check", "missing.vtk", "--select", "M999"],
        ["check", "MESH", "-q", "-v"],
        ["report", "MESH", "--format", "xml"],
        ["report", "MESH", "--measure", "aspect"],
        ["report", "missing.vtk", "--measure", "aspect"],
    ],
    ids=" ".join,
)
def test_wrong_usage_of_the_commands(meshopt, tets, arguments):
    ran = meshopt(*[tets if word == "MESH" else word for word in arguments])
    assert (ran.status, ran.out) == (2, "")
    assert ran.err


@pytest.mark.parametrize("link", ["same", "other spelling", "symbolic", "hard"])
def test_output_over_input_needs_to_be_asked_for(meshopt, tets, tmp_path, link):
    output = tmp_path / "link.vtk"
    if link == "same":
        output = tets
    elif link == "other spelling":
        (tmp_path / "sub").mkdir()
        output = tmp_path / "sub" / ".." / tets.name
    elif link == "symbolic":
        output.symlink_to(tets)
    else:
        os.link(tets, output)
    with untouched(tmp_path):
        ran = meshopt("optimize", tets, output)
    assert (ran.status, ran.out) == (2, "")
    assert str(output) in ran.complaint
    assert "--in-place" in ran.complaint


def test_output_may_not_be_missing(meshopt, tets, tmp_path):
    with untouched(tmp_path):
        ran = meshopt("optimize", tets)
    assert (ran.status, ran.out) == (2, "")
    assert "OUTPUT" in ran.complaint


@pytest.mark.parametrize("twice", [False, True])
def test_in_place(meshopt, tets, tmp_path, twice):
    before = worst_of(tets)
    ran = meshopt("optimize", tets, *[tets] * twice, "--in-place")
    assert (ran.status, ran.err) == (0, "")
    assert list(contents(tmp_path)) == [tets]
    assert worst_of(tets) < before
