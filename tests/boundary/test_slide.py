"""A boundary that slides: vertices move in its planes and along its ridges; its shape stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import validity
from meshopt_cli.boundary.patches import patches_of
from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.jobs import optimize as job
from meshopt_cli.kernels.guide import LINE, PLANE, STAYS
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.progress.observer import Silent
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.session import Workspace
from support.boxes import box, on_sides
from support.edits import halves
from support.invariants import assert_whole, region_volumes, sorted_skin, volumes
from support.samples import sample
from support.settings import examples

MEASURE = QUALITIES["aspect-ratio"]
TOLERANCE = 1e-6


def pipeline(preset, dimension):
    chosen = PRESETS[preset]
    return Pipeline(preset, chosen.build(chosen.stops[dimension], dimension))


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_an_interface_stays(dimension, preset, seed):
    """Where two regions meet, every facet and every vertex is as it was: it has two sides."""
    mesh = box(dimension, 4, seed, amount=0.2)
    # A plane: its triangles are as flat as those of a side of the box.
    mesh.points[np.abs(mesh.points[:, 0] - 0.5) < 0.1, 0] = 0.5
    centres = mesh.points[mesh.blocks[0].cells].mean(axis=1)
    mesh.blocks[0].data = {"gmsh:physical": 8 + (centres[:, 0] > 0.5).astype(np.int64)}
    result = job.optimize(mesh, pipeline(preset, dimension), MEASURE, policy=Slide())
    before, after = cast(mesh), cast(result.mesh)

    def interface(simplices):
        rows = np.sort(simplices.skin, axis=1)
        rows, count = np.unique(rows, axis=0, return_counts=True)
        return np.sort(simplices.points[rows[count == 2]].reshape(-1, 3 * dimension), axis=0)

    assert len(interface(before))
    np.testing.assert_array_equal(interface(before), interface(after))
    np.testing.assert_allclose(region_volumes(after), region_volumes(before))


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("dimension", [2, 3])
@examples(4)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_box_stays_a_box(dimension, preset, seed):
    """Its corners stay, its sides are covered by facets that carry the tag of the side."""
    mesh = box(dimension, 4 if dimension == 2 else 3, seed)
    result = job.optimize(mesh, pipeline(preset, dimension), MEASURE, policy=Slide())
    assert validity.check(result.mesh).is_valid
    points = result.mesh.points
    corners = (on_sides(mesh.points)).all(axis=1)
    for corner in mesh.points[corners]:
        assert (points == corner).all(axis=1).any()
    simplices = cast(result.mesh)
    np.testing.assert_allclose(volumes(simplices.points, simplices.cells).sum(), 1.0, rtol=1e-12)
    declared = [b for b in result.mesh.blocks if len(b.cells[0]) == dimension]
    rows = np.concatenate([b.cells for b in declared])
    tags = np.concatenate([b.data["gmsh:physical"] for b in declared])
    # Every facet of the skin is declared once, and by the tag of the side it lies on.
    assert np.array_equal(np.unique(np.sort(rows, axis=1), axis=0), sorted_skin(simplices))
    assert len(rows) == len(simplices.skin)
    for row, tag in zip(points[rows], tags, strict=True):
        axis, k = divmod(int(tag) - 1, 2)
        assert np.abs(row[:, axis] - k).max() < 1e-9
    assert result.after.worst <= result.before.worst * (1 + 1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_sliding_pays(dimension):
    """Where the boundary is badly placed, a boundary that slides allows a better mesh."""
    mesh = box(dimension, 4, 1, amount=0.8)
    fixed, slid = (
        job.optimize(mesh, pipeline("standard", dimension), MEASURE, policy=policy)
        for policy in (Fixed(), Slide())
    )
    assert slid.after.worst < fixed.after.worst
    assert not np.array_equal(slid.mesh.points[: len(mesh.points)], fixed.mesh.points)


def test_guides_of_a_box():
    """Corners are fixed, edges are lines, sides are planes, with their directions."""
    mesh = box(3, 3, 2)
    source = cast(mesh)
    found = patches_of(mesh, source, TOLERANCE)
    n_sides = on_sides(mesh.points).sum(axis=1)
    expected = {0: STAYS, 1: PLANE, 2: LINE, 3: STAYS}
    assert [expected[int(n)] for n in n_sides] == found.guide[:, 0].tolist()
    moving = found.guide[:, 0] > 0
    np.testing.assert_allclose(np.linalg.norm(found.guide[moving, 1:], axis=1), 1.0)
    for point, (kind, *along) in zip(mesh.points, found.guide, strict=True):
        if kind == PLANE:
            np.testing.assert_allclose(np.abs(along), on_sides(point), atol=1e-9)
        if kind == LINE:
            np.testing.assert_allclose(np.abs(along), ~on_sides(point), atol=1e-9)


def test_a_round_boundary_does_not_move():
    source = sample("raw_ball.mesh")
    mesh = Mesh(source.points, [Block("tetra", source.cells)])
    guide = patches_of(mesh, source, TOLERANCE).guide
    assert not guide.any()


def test_interfaces_and_declared_vertices_stay():
    """The vertices of an interface stay, also where it meets the boundary in a plane."""
    mesh = halves(box(3, 3, 3))
    source = cast(mesh)
    _, twice = np.unique(np.sort(source.skin, axis=1), axis=0, return_counts=True)
    assert (twice == 2).any()
    found = patches_of(mesh, source, TOLERANCE)
    rows = np.unique(np.sort(source.skin, axis=1), axis=0)[twice == 2]
    assert not found.guide[np.unique(rows)].any()
    result = job.optimize(mesh, pipeline("standard", 3), MEASURE, policy=Slide())
    before = mesh.points[np.unique(rows)]
    after = {tuple(p) for p in result.mesh.points.tolist()}
    assert all(tuple(p) in after for p in before.tolist())


@pytest.mark.parametrize("name", [n for n in PASSES if n != "check"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_pass_keeps_the_shape(dimension, name):
    mesh = box(dimension, 3, 5)
    source = cast(mesh)
    slide = patches_of(mesh, source, TOLERANCE)
    work = Workspace(source, MEASURE.judge, patches=slide)
    for _ in range(2):
        PASSES[name]().run(work, Silent())
        assert_whole(work)
    after, _ = work.result()
    np.testing.assert_allclose(volumes(after.points, after.cells).sum(), 1.0, rtol=1e-12)


def test_vertices_of_a_plane_collapse():
    """A side that is finer than it need be loses vertices, within its plane."""
    mesh = box(3, 4, 7, amount=0.9)
    source = cast(mesh)
    work = Workspace(source, MEASURE.judge, patches=patches_of(mesh, source, TOLERANCE))
    before = work.n_vertices
    PASSES["collapse"](worse_than=1.0, accept="valid", min_vertices=0.5).run(work, Silent())
    assert_whole(work)
    after, origin = work.result()
    gone = np.setdiff1d(np.arange(len(mesh.points)), origin)
    assert work.n_vertices < before
    assert (on_sides(mesh.points[gone]).sum(axis=1) == 1).any()
    assert (on_sides(mesh.points[gone]).sum(axis=1) < 2).all()
    np.testing.assert_allclose(volumes(after.points, after.cells).sum(), 1.0, rtol=1e-12)
