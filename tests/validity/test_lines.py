"""Meshes without faces: lines, and points alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Mesh
from meshopt_cli.validity import check
from support.files import write
from support.meshes import mesh
from support.settings import examples


def chain(n):
    t = np.linspace(0, 3, n + 1)
    i = np.arange(n)
    return mesh(np.stack([np.cos(t), np.sin(t), t], axis=1), line=np.stack([i, i + 1], axis=1))


def test_no_rule_stumbles_over_lines():
    assert check(chain(5), extend=["M"]).codes == ()


@examples(40)
@given(st.integers(0, 9), st.integers(0, 9), st.booleans())
def test_lines_listed_twice_or_with_one_end(row, other, back):
    of = chain(10)
    cells = of.blocks[0].cells
    again = cells[row][::-1] if back else cells[row]
    twice = Mesh(of.points, [type(of.blocks[0])("line", np.vstack([cells, again]))])
    (group,) = check(twice).groups
    assert group.code == "M201"
    assert [(f.cell, f.other_cells) for f in group.findings(twice)] == [(10, ((0, row),))]
    ends = Mesh(of.points, [type(of.blocks[0])("line", np.vstack([cells, [other, other]]))])
    assert check(ends).codes == ("M003",)


@pytest.mark.parametrize("columns", [2, 3])
def test_ends_in_one_place(columns):
    of = chain(4)
    of.points[2] = of.points[1]
    of.points = np.ascontiguousarray(of.points[:, :columns])
    assert check(of).codes == ("M102", "M202")


@pytest.mark.parametrize(
    ("make", "status", "said"),
    [
        (lambda: chain(3), 0, "valid"),
        (lambda: mesh(np.eye(3), vertex=[[0], [1], [2]]), 0, "valid"),
        (lambda: mesh(np.eye(3), line=[[0, 1], [1, 0]]), 1, "M201"),
    ],
)
def test_the_command(tmp_path, make, status, said, capsys):
    from meshopt_cli.cli.entry import status_of

    path = write(tmp_path / "lines.vtu", make())
    assert status_of(["check", str(path)]) == status
    out, err = capsys.readouterr()
    assert said in out + err


def test_lines_cannot_be_optimized(tmp_path, capsys):
    from meshopt_cli.cli.entry import status_of

    path = write(tmp_path / "lines.vtu", chain(3))
    assert status_of(["optimize", str(path), str(tmp_path / "out.vtu")]) == 1
    assert "lines only" in capsys.readouterr().err
    assert not (tmp_path / "out.vtu").exists()
