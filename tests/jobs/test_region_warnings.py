"""What is asked back about regions."""

import numpy as np
import pytest

from support.edits import halves, shaken
from support.files import write
from support.meshes import tet_grid
from support.runs import optimized


def coloured(grid):
    """Cells of a few colours, such that hardly two neighbours have the same."""
    (block,) = grid.blocks
    block.data["colour"] = np.random.default_rng(0).integers(0, 7, len(block.cells)).astype(float)
    return grid


def test_colours_that_leave_nothing_to_work_on_are_doubted(caplog):
    optimized(coloured(shaken(tet_grid(3))), passes=["smooth"])
    assert "regions that colour makes" in caplog.text
    caplog.clear()
    optimized(halves(shaken(tet_grid(3))), passes=["smooth"])
    assert "--region" not in caplog.text


@pytest.mark.parametrize("command", ["check", "report", "optimize"])
def test_an_array_of_many_values_is_asked_about(capsys, tmp_path, caplog, command):
    from meshopt_cli.cli.entry import status_of

    grid = shaken(tet_grid(4))
    (block,) = grid.blocks
    block.data["part"] = np.arange(len(block.cells)) // 5
    path = write(tmp_path / "in.vtu", grid)
    output = [str(tmp_path / "out.vtu")] * (command == "optimize")
    assert status_of([command, str(path), *output]) == 0
    said = capsys.readouterr().err
    assert "the array part has 77 values" in said
    assert "--region part" in said
