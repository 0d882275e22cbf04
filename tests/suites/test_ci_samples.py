"""The samples for CI: what they run is run, in a folder with meshes."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.samples import ROOT, SAMPLES

CI = ROOT / "samples" / "ci"


def runs_of(text):
    """The commands of an Action, without its installation."""
    return [r for r in re.findall(r"^ +run: (.*)$", text, re.M) if "pip install" not in r]


def scripts_of(text):
    """The commands of the jobs of a template for GitLab."""
    return re.findall(r"^  script:\n    - (.*)$", text, re.M)


@pytest.fixture
def run(tmp_path):
    shutil.copy(SAMPLES / "grid.vtk", tmp_path)
    (tmp_path / "bin").mkdir()
    launcher = tmp_path / "bin" / "meshopt"
    launcher.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m meshopt_cli "$@"\n')
    launcher.chmod(0o755)

    def call(command, **variables):
        environment = os.environ | {
            "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(ROOT), "GITHUB_STEP_SUMMARY": str(tmp_path / "summary"),
            "MESHES": "grid.vtk", "CHECK": "", "OPTIONS": "", "FOLDER": "better", **variables,
        }  # fmt: skip
        shell = ["bash", "-euo", "pipefail", "-c", command]
        return subprocess.run(
            shell, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    return call


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash")
def test_the_action(run, tmp_path):
    text = (CI / "action.yml").read_text("utf-8")
    check, optimize, tell = runs_of(text)
    assert run(check).returncode == 0
    bad = run(check, CHECK="--fail-above 2")
    assert bad.returncode == 1
    assert "::error" in bad.stdout
    assert run(optimize, OPTIONS="--preset fast").returncode == 0
    assert run(tell).returncode == 0
    assert "grid.vtk" in (tmp_path / "summary").read_text()
    assert (tmp_path / "better" / "grid.vtk").exists()
    used = set(re.findall(r"inputs\.(\w+)", text))
    assert used == set(re.findall(r"^  (\w+):\n    description", text, re.M))


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash")
def test_the_template_of_gitlab(run, tmp_path):
    check, optimize = scripts_of((CI / "gitlab.yml").read_text("utf-8"))
    assert run(check).returncode == 0
    assert "<testsuite" in Path(tmp_path, "meshopt-junit.xml").read_text()
    assert run(check, CHECK="--fail-above 2").returncode == 1
    assert run(optimize).returncode == 0
    assert (tmp_path / "meshopt.html").exists()
