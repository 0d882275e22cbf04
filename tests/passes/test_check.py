"""The pass check: what it says of a mesh that is not mended yet."""

from __future__ import annotations

import pytest

from meshopt_cli.errors import BadMeshError, InvariantError
from meshopt_cli.passes.check import Check
from meshopt_cli.passes.untangle import Untangle
from support.invariants import workspace
from support.samples import sample


def test_a_tangle_is_refused_as_what_it_is():
    """Cells that came inverted are no fault of an operator: the message says what to do."""
    work = workspace(sample("tangled.vtk"))
    with pytest.raises(BadMeshError, match="untangle") as raised:
        Check().run(work)
    assert not isinstance(raised.value, InvariantError)
    Check(inverted="allowed").run(work)
    Untangle().run(work)
    Check().run(work)


def test_a_cell_that_became_inverted_is_a_fault():
    """Where all cells came positive, a cell that is not breaks a promise of the operators."""
    work = workspace(sample("grid.vtk"))
    work.mesh.quality[work.living()[3]] = -1.0
    with pytest.raises(InvariantError):
        Check().run(work)
