"""Meshes of second order from file to file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.mesh.model import Block
from support.curved import bulging, corners_only, of_second_order, rim
from support.edits import shaken
from support.meshes import tet_grid


@pytest.mark.parametrize(
    "name", ["in.msh", "in.vtk", "in.vtu", "old.msh"],
)  # fmt: skip
def test_from_file_to_file(meshopt, tmp_path, name):
    one = shaken(tet_grid(3))
    skin = np.concatenate([np.delete(one.blocks[0].cells, k, axis=1) for k in range(4)])
    rows, first, times = np.unique(
        np.sort(skin, axis=1), axis=0, return_index=True, return_counts=True
    )
    one.blocks.insert(0, Block("triangle", skin[first[times == 1]]))
    one.blocks.insert(0, Block("line", rows[times == 1][:3, :2]))
    one.points -= 0.5
    of = of_second_order(one, bulging(0.03))
    for block, tag in zip(of.blocks, (3, 2, 1), strict=True):
        block.data = {"gmsh:physical": np.full(len(block.cells), tag)}
    source, target = tmp_path / name, tmp_path / f"out_{name}"
    encoding = formats.encoding_for(source, None, "gmsh22" if name == "old.msh" else None)
    formats.write(source, of, encoding)
    ran = meshopt("optimize", source, target, "--json")
    assert ran.status == 0, ran.complaint
    result, read = formats.read(target)
    assert read.encoding.format == encoding.format
    assert [b.type for b in result.blocks] == ["line3", "triangle6", "tetra10"]
    assert [b.data["gmsh:physical"][0] for b in result.blocks] == [3, 2, 1]
    assert rim(replace(result, blocks=result.blocks[2:])) == rim(replace(of, blocks=of.blocks[2:]))
    assert meshopt("check", target).status == 0
    told = meshopt("report", target, "--format", "json").out
    assert f'"np": {len(corners_only(result)[0].points)}' in told.replace("  ", " ")


@pytest.mark.parametrize("suffix", [".mesh", ".meshb"])
def test_to_medit_and_back(meshopt, tmp_path, suffix):
    source, target = tmp_path / "in.vtu", tmp_path / f"out{suffix}"
    formats.write(source, of_second_order(tet_grid(2), bulging(0.02)), formats.encoding_for(source))
    for one, other in ((source, target), (target, source)):
        ran = meshopt("optimize", one, other, "--in-place")
        assert ran.status == 0, ran.complaint
        assert [b.type for b in formats.read(other)[0].blocks] == ["tetra10"]
        assert meshopt("check", other).status == 0
