"""`--allow`, on the command line and in a pipeline file."""

import pytest

from support.files import write
from support.kinds import cut, plate_with_beam
from support.meshes import in_space, tri_grid


@pytest.fixture
def crack(tmp_path):
    return write(tmp_path / "crack.vtu", in_space(cut(tri_grid(6), 0.1, 0.9)))


@pytest.mark.parametrize(
    "options",
    [
        ["--allow", "M202,M205"],
        ["--allow", "M202", "--allow", "m205"],
        ["--allow", "M2"],
        ["--allow", "M202, M205,"],
    ],
)
def test_codes_are_taken_in_lists_and_repeated(meshopt, crack, tmp_path, options):
    ran = meshopt("optimize", crack, tmp_path / "out.vtu", *options, "-q")
    assert (ran.status, ran.out, ran.err) == (0, "", "")
    assert meshopt("check", tmp_path / "out.vtu", "--ignore", "M202,M205").status == 0
    assert meshopt("check", tmp_path / "out.vtu").status == 1


def test_without_it_the_mesh_is_refused_with_the_way_out(meshopt, crack, tmp_path):
    for options in ([], ["--allow", "M205"]):
        ran = meshopt("optimize", crack, tmp_path / "out.vtu", *options)
        assert ran.status == 1
        assert "if that is meant: --allow M202" in ran.err
        assert not (tmp_path / "out.vtu").exists()


@pytest.mark.parametrize("code", ["M001", "M101", "M207", "M10"])
def test_rules_that_no_mesh_breaks_on_purpose(meshopt, crack, tmp_path, code):
    ran = meshopt("optimize", crack, tmp_path / "out.vtu", "--allow", code)
    assert ran.status == 2
    assert f"--allow: {code} cannot be allowed, only M202, M205" in ran.err


def test_the_configuration_allows_too(meshopt, crack, tmp_path):
    config = tmp_path / "pipeline.toml"
    config.write_text('preset = "fast"\nallow = ["M202", "M205"]\n')
    out = tmp_path / "out.vtu"
    assert meshopt("optimize", crack, out, "--config", config).status == 0
    out.unlink()
    # The command line wins.
    ran = meshopt("optimize", crack, out, "--config", config, "--allow", "M205")
    assert ran.status == 1
    for wrong in ('allow = ["M101"]', 'allow = ["M999"]', "allow = [2]", 'allow = "M202"'):
        config.write_text(wrong)
        ran = meshopt("optimize", crack, out, "--config", config)
        assert ran.status == 2
        assert str(config) in ran.err
    assert not out.exists()


def test_explain_says_how_to_allow(meshopt):
    said = meshopt("check", "--explain", "M202").out
    assert "check --ignore M202, optimize --allow M202." in said
    assert "--allow" not in meshopt("check", "--explain", "M101").out


def test_beams_need_no_option(meshopt, tmp_path):
    path = write(tmp_path / "beam.vtu", plate_with_beam(3, 1))
    ran = meshopt("check", path)
    assert ran.status == 0
    assert "M216 the line stands by itself" in ran.out
    assert meshopt("optimize", path, tmp_path / "out.vtu", "-q").status == 0
