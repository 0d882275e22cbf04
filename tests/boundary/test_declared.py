"""What a file declares on a boundary that slides: where tags change nothing moves."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Slide
from meshopt_cli.jobs.optimize import optimize
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.quality.measures import QUALITIES
from support.edits import shaken
from support.meshes import tet_grid

MEASURE = QUALITIES["aspect-ratio"]


def slid(mesh):
    """The mesh, optimized with a boundary that slides."""
    preset = PRESETS["standard"]
    pipeline = Pipeline(preset.name, preset.build(preset.stops[3], 3))
    return optimize(mesh, pipeline, MEASURE, policy=Slide()).mesh


def bent(n=4, seed=0):
    """A cube of tetrahedra whose vertices are shaken, those of its edges along them."""
    base = shaken(tet_grid(n), 0.3 / n, seed)
    points = base.points.copy()
    along = ((points > 0) & (points < 1)).sum(axis=1) == 1
    step = np.random.default_rng(seed).uniform(-0.3 / n, 0.3 / n, points.shape)
    step[(points == 0) | (points == 1)] = 0.0
    points[along] += step[along]
    return Mesh(points, base.blocks)


def edge_of_cube(mesh):
    """The edges along the x axis, in order, (n, 2)."""
    on_axis = np.flatnonzero((mesh.points[:, 1:] == 0).all(axis=1))
    on_axis = on_axis[np.argsort(mesh.points[on_axis, 0])]
    return np.stack([on_axis[:-1], on_axis[1:]], axis=1)


def lengths(mesh):
    """Length of the declared lines, by tag."""
    sums = Counter()
    for block in mesh.blocks:
        if block.type == "line":
            ends = mesh.points[block.cells]
            size = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
            for tag, one in zip(block.data["gmsh:physical"].tolist(), size, strict=True):
                sums[tag] += one
    return sums


@pytest.mark.parametrize("tags", [[1, 1, 2, 2], [1, 1, 1, 0], [1, 2, 1, 2]])
def test_lines_end_where_they_ended(tags):
    """Along a straight edge of the domain a vertex between two tags, or none, stays."""
    mesh = bent()
    rows = edge_of_cube(mesh)
    kept = np.array(tags) > 0
    data = {"gmsh:physical": np.array(tags)[kept]}
    mesh.blocks.append(Block("line", rows[kept], data))
    before, after = lengths(mesh), lengths(slid(mesh))
    assert after == pytest.approx(before)


def test_a_line_of_one_tag_slides():
    """Where the tag is one, its vertices are as free as without."""
    mesh = bent()
    rows = edge_of_cube(mesh)
    mesh.blocks.append(Block("line", rows, {"gmsh:physical": np.ones(len(rows), np.int64)}))
    result = slid(mesh)
    assert lengths(result) == pytest.approx(lengths(mesh))
    inner = mesh.points[rows[:-1, 1]]
    there = (result.points[:, None] == inner).all(axis=2).any(axis=0)
    assert not there.all()


@pytest.mark.parametrize("how", ["required", "twice"])
def test_facets_that_must_stay_do(how):
    """A facet that is required, or that the file lists twice, is there afterwards as it was."""
    mesh = bent()
    skin = cast(mesh).skin
    corners = mesh.points[skin]
    flat = skin[(corners[:, :, 2] == 0).all(axis=1)]
    some = flat[::3]
    if how == "required":
        flags = np.isin(np.arange(len(flat)), np.arange(0, len(flat), 3)).astype(np.int64)
        mesh.blocks.append(Block("triangle", flat, {"medit:required": flags}))
    else:
        tags = [np.full(len(flat), 1), np.full(len(some), 2)]
        for rows, tag in zip((flat, some), tags, strict=True):
            mesh.blocks.append(Block("triangle", rows, {"gmsh:physical": tag}))
    result = slid(mesh)
    new = np.sort(cast(result).skin, axis=1)
    places = {tuple(sorted(map(tuple, result.points[row].tolist()))) for row in new}
    for row in some:
        assert tuple(sorted(map(tuple, mesh.points[row].tolist()))) in places
