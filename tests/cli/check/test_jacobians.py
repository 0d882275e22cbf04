"""Cells whose Jacobian is not positive, and those that are not looked at."""

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.mesh.model import Block
from support.elements import HEXAHEDRA, one
from support.files import write
from support.meshes import tet_grid


@pytest.fixture
def bent(tmp_path):
    return write(tmp_path / "bent.vtu", one("hexahedron", HEXAHEDRA["edge"] / 10))


def test_a_finding_says_how_bad_it_is_and_where(check, bent, tmp_path):
    status, out, _ = check(bent, "--mark", tmp_path / "marked.vtu")
    assert status == 1
    assert "cell 0: M105 the Jacobian is as low as -0.2" in out
    assert "inside the cell at (" in out
    marked, _ = formats.read(tmp_path / "marked.vtu")
    assert marked.blocks[0].data["meshopt:code"].tolist() == [105]
    assert check(bent, "--ignore", "M105")[0] == 0


@pytest.fixture
def cubic(tmp_path):
    """A tetrahedron of third order beside a linear mesh."""
    of = tet_grid(1)
    corners = of.points[of.blocks[0].cells[0]]
    inner = np.random.default_rng(0).dirichlet(np.ones(4), 16) @ corners
    cell = np.concatenate([of.blocks[0].cells[0], np.arange(16) + len(of.points)])
    of.points = np.concatenate([of.points, inner])
    of.blocks = [Block("tetra", of.blocks[0].cells[1:]), Block("tetra20", cell[None])]
    return write(tmp_path / "cubic.msh", of)


def test_types_that_are_looked_at_in_part_are_named(check, cubic, good):
    status, _, err = check(cubic)
    assert status == 0
    assert "cubic.msh: of cells of type tetra20 (1) only the corners are looked at" in err
    assert "looked at" not in check(cubic, "--select", "M2")[2]
    assert "looked at" not in check(good)[2]
