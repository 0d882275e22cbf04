"""Cells that are listed the other way round: told from inverted ones, turned, and said."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import validity
from meshopt_cli.jobs.admission import InvalidMeshError, admit
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.orientation import turned, with_agreeing_cells, with_positive_cells
from support.edits import halves, shaken, shifted, together
from support.meshes import tet_grid, tri_grid
from support.planes import in_tilted_plane
from support.runs import optimized
from support.settings import examples

SQUARE = halves(shaken(tri_grid(5)))
MESHES = {
    "square": SQUARE,
    "tilted square": in_tilted_plane(SQUARE),
    "cube": halves(shaken(tet_grid(3))),
}


def some_turned(of: Mesh, chosen: np.ndarray) -> Mesh:
    (block,) = of.blocks
    cells = np.where(chosen[:, None], turned(block.cells), block.cells)
    return Mesh(of.points, [Block(block.type, cells, block.data)])


def flipped(of: Mesh, share: float, seed: int) -> Mesh:
    n = len(of.blocks[0].cells)
    return some_turned(of, np.random.default_rng(seed).random(n) < share)


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("turn", [with_positive_cells, with_agreeing_cells])
@given(share=st.floats(0.0, 0.25), seed=st.integers(0, 1000))
@examples(20)
def test_cells_of_either_direction_are_made_to_agree(name, turn, share, seed):
    mesh = MESHES[name]
    wrong = flipped(mesh, share, seed)
    mended, n = turn(wrong)
    assert np.array_equal(mended.blocks[0].cells, mesh.blocks[0].cells)
    assert n == np.count_nonzero((wrong.blocks[0].cells != mesh.blocks[0].cells).any(axis=1))


@pytest.mark.parametrize("name", MESHES)
def test_more_than_half_turned_is_optimized_too(name, caplog):
    mesh = MESHES[name]
    with caplog.at_level(logging.WARNING, "meshopt"):
        result = optimized(flipped(mesh, 0.7, 1), passes=["smooth", "swap"])
    assert validity.check(result).is_valid
    assert "cells are listed the other way round, and turned: " in caplog.text
    tags = np.concatenate([block.data["gmsh:physical"] for block in result.blocks])
    assert set(tags.tolist()) == {0, 1}


@pytest.mark.parametrize("name", MESHES)
def test_check_says_that_turning_mends_it(name):
    report = validity.check(flipped(MESHES[name], 0.3, 2))
    assert report.codes[:1] == ("M101",)
    messages = {finding.message for finding in report.groups[0].findings(MESHES[name])}
    assert messages == {
        "the cell is listed the other way round than its neighbours: turning it mends that"
    }


def test_a_whole_sheet_that_runs_the_other_way_is_turned():
    away = shifted(SQUARE, 5.0, 0.0)
    both = together(SQUARE, some_turned(away, np.ones(len(SQUARE.blocks[0].cells), bool)))
    mesh, tangle = admit(both, untangles=False)
    assert tangle is None
    assert validity.check(mesh).is_valid


def tangled(of: Mesh) -> Mesh:
    """One inner vertex moved past its ball."""
    centre = np.full(of.points.shape[1], 0.5)
    points = of.points.copy()
    points[np.argmin(np.abs(points - centre).sum(axis=1))] += 0.45
    return replace(of, points=points)


@pytest.mark.parametrize("grid", [tri_grid(5), tet_grid(4)], ids=["plane", "space"])
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_inverted_cells_are_told_from_turned_ones(grid, share):
    wrong = flipped(tangled(grid), share, 3)
    assert "M101" in validity.check(wrong).codes
    mesh, tangle = admit(wrong, untangles=True)
    assert tangle is not None
    assert "M207" not in validity.check(mesh).codes
    assert validity.check(optimized(mesh)).is_valid


def test_cells_on_one_side_of_a_facet_are_named_as_the_file_has_them():
    points = np.array([[0.0, 0], [1, 0], [0, 1], [0.2, 0.9]])
    mesh = Mesh(points, [Block("triangle", np.array([[0, 1, 2], [0, 1, 3]]))])
    with pytest.raises(InvalidMeshError) as refused:
        optimized(mesh)
    assert "M207" in refused.value.report.codes
