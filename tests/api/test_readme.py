"""What the README shows of Python runs, one block after the other, as in a notebook."""

import re
import shutil

import meshio
import numpy as np
import pytest
import pyvista

from support.samples import ROOT, SAMPLES

README = (ROOT / "README.md").read_text("utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", README[README.index("## Python") :], re.S | re.M)


@pytest.fixture
def names(tmp_path, monkeypatch):
    """What a reader has before the first block."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(SAMPLES / "two_regions.msh", tmp_path / "part.msh")
    mesh = meshio.read(SAMPLES / "plate.vtu")
    return {"pyvista": pyvista, "mesh": mesh, "sizes": np.full(len(mesh.points), 0.1)}


def test_the_blocks_run(names, tmp_path, capsys):
    assert len(BLOCKS) >= 3
    for block in BLOCKS:
        exec(block, names)
    said = capsys.readouterr().out
    assert re.search(r"<meshopt.Result: [\d,]+ cells, worst Q .* -> .*>", said)
    assert (tmp_path / "quality.html").exists()
    assert "Q" in names["grid"].cell_data
    progress = type("Told", (), {"worst": 2.0, "cancel": lambda self: setattr(self, "ended", 1)})()
    names["patient"](progress)
    assert progress.ended


def test_a_session_as_in_a_notebook(names, tmp_path):
    """Look, optimize, look again, adapt, write."""
    exec(
        """
import meshopt_cli as meshopt

before = meshopt.report(mesh, measure=["aspect-ratio", "angle-min"])
result = meshopt.optimize(mesh, preset="fast")
after = meshopt.report(result.mesh, measure=["aspect-ratio", "angle-min"])
assert after.worst < before.worst
shown = [value._repr_html_() for value in (before, result, after)]
assert all("<pre>" in text for text in shown)
adapted = meshopt.optimize(result.mesh, size="0.05+0.1*x")
tau = [facts.edges.tau for facts in (adapted.facts.metric, adapted.facts.metric_after)]
assert tau[1] > tau[0]
path = adapted.write("adapted.mesh", metric_out="adapted.sol")
assert meshopt.check(path)
assert meshopt.read(path).points.shape == meshopt.read("adapted.mesh").points.shape
again = meshopt.optimize(path, metric="adapted.sol")
assert abs(again.before.worst - adapted.after.worst) < 1e-6
""",
        names,
    )
    assert (tmp_path / "adapted.sol").exists()
