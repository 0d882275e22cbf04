"""Defaults of `check` from the files of a project."""

import json

import pytest


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
        ("[check]\nwhatever = 1\n", "choose one of"),
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
