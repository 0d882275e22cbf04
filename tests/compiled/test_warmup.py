"""What is compiled ahead: every kernel that Python calls, for the arguments that it calls with."""

from __future__ import annotations

import inspect
from collections import defaultdict

import numpy as np
import pytest

from meshopt_cli import formats, warmup
from meshopt_cli.blocks import partition
from meshopt_cli.cli.entry import status_of
from meshopt_cli.compiled import decorators, ways, words
from meshopt_cli.validity import boundary, overlap
from meshopt_cli.work.foldover import relocate_all
from support.corners import corners, thrown
from support.edits import shaken
from support.files import write
from support.meshes import fan, hex_grid, tet_grid, tri_grid

pytestmark = pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted")

ENTRIES = [] if ways.INTERPRETED else warmup.entries()


@pytest.fixture(scope="module")
def work():
    return warmup.specimen()


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.__name__)
def test_every_entry_has_an_example(entry, work):
    assert entry.group in warmup.GROUPS
    arguments = entry.example(work)
    inspect.signature(entry.py_func).bind(*arguments)
    words.flatten(arguments)


def test_every_group_has_entries():
    assert {entry.group for entry in ENTRIES} == set(warmup.GROUPS)


@pytest.fixture
def called(monkeypatch):
    """For each kernel the layouts of the arguments that Python calls it with from now on."""
    layouts = defaultdict(set)
    call = decorators.Entry.__call__

    def noting(self, *arguments):
        layouts[self.py_func].add(words.flatten(arguments)[0])
        return call(self, *arguments)

    monkeypatch.setattr(decorators.Entry, "__call__", noting)
    return layouts


def test_examples_are_what_kernels_are_called_with(samples, tmp_path, called, work, monkeypatch):
    """An example of other types would have a run compile what the warm-up did not."""
    # Checks of small meshes do without compiled code.
    monkeypatch.setattr(overlap, "MANY", 0)
    monkeypatch.setattr(boundary, "MANY", 0)
    # And so does work on them without blocks.
    monkeypatch.setitem(partition.LEAST_CELLS, 3, 3000)
    monkeypatch.setattr(partition, "BLOCK_CELLS", 400)
    raw = tmp_path / "raw.vtu"
    mesh = tet_grid(3)
    mesh.point_data["height"] = mesh.points[:, 2].copy()
    mesh.points[np.all((mesh.points > 0.1) & (mesh.points < 0.9), axis=1)] *= 0.8
    formats.write(raw, mesh, formats.FORMATS["vtu"].default)
    boxes = write(tmp_path / "boxes.vtu", shaken(hex_grid(3)))
    flat = write(tmp_path / "flat.vtu", shaken(tri_grid(8), 0.45))
    coarse = write(tmp_path / "coarse.vtu", fan(5, (0.6, 0.3)))
    constrained = ["--passes", "split", "--set", "split.constrained=0.5"]
    for arguments in (
        ["optimize", samples / "raw_ball.mesh", tmp_path / "out.mesh", "--preset", "best"],
        ["optimize", samples / "raw_ball.mesh", tmp_path / "out.mesh", "--passes", "relax"],
        ["optimize", samples / "quadtree.vtk", tmp_path / "out.vtk", "--preset", "best"],
        ["optimize", samples / "grid.vtk", tmp_path / "out.vtk", "--boundary", "slide"],
        ["optimize", samples / "plate.vtu", tmp_path / "out.vtu", "--passes", "mend,collapse"],
        ["optimize", raw, tmp_path / "out.vtu", "--passes", "smooth"],
        ["optimize", raw, tmp_path / "out.vtu", *constrained],
        ["optimize", flat, tmp_path / "out.vtu", "--passes", "nonobtuse"],
        ["optimize", raw, tmp_path / "out.vtu", "--passes", "nonobtuse"],
        ["optimize", coarse, tmp_path / "out.vtu", "--passes", "nonobtuse", "--boundary", "split"],
        ["optimize", boxes, tmp_path / "out.vtu"],
        ["optimize", flat, tmp_path / "out.vtu", "--size", "0.2"],
        ["report", raw],
        ["check", raw],
    ):
        assert status_of([*map(str, arguments), "-q"]) == 0
    assert relocate_all(*corners(thrown(tet_grid(3))))[1].n_bad_after == 0
    expected = {entry.py_func: {words.flatten(entry.example(work))[0]} for entry in ENTRIES}
    assert {kernel: called.get(kernel, set()) for kernel in expected} == expected
