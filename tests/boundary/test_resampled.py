"""A metric on a boundary that slides: its edges are split and collapsed, and its shape stays."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import validity
from meshopt_cli.boundary.patches import patches_of, sides_of_edges
from meshopt_cli.boundary.policy import TOLERANCE, Fixed, Slide
from meshopt_cli.boundary.proof import prove_patches
from meshopt_cli.boundary.resampling import resampled
from meshopt_cli.errors import InvariantError
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes import PASSES
from meshopt_cli.progress.observer import Silent
from support.boxes import box, on_sides
from support.curved import bulging, middles_by_place, of_second_order
from support.driven import adapted, in_range, layered, same_everywhere, workspace_in
from support.edits import halves
from support.invariants import assert_whole, region_volumes, sorted_skin
from support.meshes import tet_grid, tri_grid
from support.planes import in_tilted_plane
from support.samples import sample
from support.settings import examples

TAG = "gmsh:physical"
both = pytest.mark.parametrize("dimension", [2, 3])


def small(dimension, seed=0, amount=0.3):
    """A box that a test is quick with."""
    return box(dimension, 6 if dimension == 2 else 4, seed, amount)


def sizes(of, kind):
    """Lengths or areas of declared cells, by their tags."""
    sums = Counter()
    points = np.zeros((len(of.points), 3))
    points[:, : of.points.shape[1]] = of.points
    for block in of.blocks:
        if block.type == kind and len(block.cells):
            a, b = points[block.cells[:, 0]], points[block.cells[:, 1]]
            size = np.linalg.norm(b - a, axis=1)
            if kind == "triangle":
                c = points[block.cells[:, 2]]
                size = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
            for tag, one in zip(block.data[TAG].tolist(), size.tolist(), strict=True):
                sums[tag] += one
    return dict(sums)


def with_lines(of):
    """A box with its twelve edges declared, each by a tag of its own."""
    edges = boundary_edges(of)
    ends = of.points[edges]
    on = on_sides(ends).all(axis=1) & (ends[:, 0] == ends[:, 1])
    rows = on.sum(axis=1) == 2
    at = np.where(on[rows], 1 + (ends[rows].mean(axis=1) > 0.5), 0)
    tags = at @ [1, 3, 9]
    return replace(of, blocks=[*of.blocks, Block("line", edges[rows], {TAG: tags})])


def boundary_edges(of):
    """Edges of the boundary, (n, 2)."""
    outer = cast(of).outer
    return outer if outer.shape[1] == 2 else sides_of_edges(outer, len(of.points))[0]


def lines_are_edges(of):
    """Whether all declared lines are edges of the boundary."""
    (lines,) = (block for block in of.blocks if block.type == "line")
    return (adjacency.places_in(boundary_edges(of), lines.cells, len(of.points)) >= 0).all()


@both
@examples(4)
@given(seed=st.integers(0, 2**32 - 1), least=st.sampled_from([0.02, 0.1, 0.3]))
def test_a_box_stays_a_box(dimension, seed, least):
    """Its corners stay, and its sides and edges are covered by what carries their tags."""
    before = small(dimension, seed)
    if dimension == 3:
        before = with_lines(before)
    after = adapted(before, lambda p: layered(p, least), Slide()).mesh
    assert validity.check(after).is_valid
    corners = before.points[on_sides(before.points).all(axis=1)]
    assert all((after.points == corner).all(axis=1).any() for corner in corners)
    parts = cast(before), cast(after)
    np.testing.assert_allclose(*(region_volumes(part) for part in parts), rtol=1e-12)
    for kind in ("line", "triangle")[: dimension - 1]:
        assert sizes(after, kind) == pytest.approx(sizes(before, kind), rel=1e-12)
    # Every facet of the skin is declared once, and by the tag of the side it lies on.
    kind = "line" if dimension == 2 else "triangle"
    (declared,) = (block for block in after.blocks if block.type == kind)
    assert np.array_equal(np.unique(np.sort(declared.cells), axis=0), sorted_skin(parts[1]))
    assert len(declared.cells) == len(parts[1].outer)
    for row, tag in zip(after.points[declared.cells], declared.data[TAG], strict=True):
        axis, k = divmod(int(tag) - 1, 2)
        assert np.abs(row[:, axis] - k).max() < 1e-12
    if dimension == 3:
        (lines,) = (block for block in after.blocks if block.type == "line")
        assert (
            adjacency.places_in(boundary_edges(after), lines.cells, len(after.points)) >= 0
        ).all()


@both
@pytest.mark.parametrize("size", [0.5, 2.0])
def test_the_boundary_meets_the_metric(dimension, size):
    """Sizes that are not those of the boundary are there afterwards, finer or coarser."""
    before = small(dimension, amount=0.2)
    metric = same_everywhere(size / (6 if dimension == 2 else 4))
    fixed, after = (adapted(before, metric, policy).mesh for policy in (Fixed(), Slide()))
    shares = [in_range(one.points, boundary_edges(one), metric) for one in (fixed, after)]
    assert shares[0] < 0.5
    assert shares[1] > 0.7
    counts = [len(boundary_edges(one)) for one in (fixed, after)]
    assert (counts[1] > counts[0]) == (size < 1)
    assert sorted(sizes(after, "line")) == sorted(sizes(before, "line"))


@both
def test_an_interface_stays(dimension):
    """Where two regions meet, all stays, and so do the edges of the boundary there."""
    before = small(dimension, 1, amount=0.2)
    before.points[np.abs(before.points[:, 0] - 0.5) < 0.1, 0] = 0.5
    before.blocks[0].data = halves(Mesh(before.points, before.blocks[:1])).blocks[0].data
    metric = same_everywhere(0.1)
    after = adapted(before, metric, Slide()).mesh
    assert validity.check(after).is_valid
    parts = cast(before), cast(after)
    np.testing.assert_allclose(*(region_volumes(part) for part in parts), rtol=1e-12)

    def interface(part):
        rows = np.unique(np.sort(part.inner, axis=1), axis=0)
        return np.unique(np.sort(part.points[rows].reshape(len(rows), -1), axis=1), axis=0)

    assert len(interface(parts[0]))
    np.testing.assert_array_equal(*(interface(part) for part in parts))
    assert len(parts[1].outer) > len(parts[0].outer)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "polygon"])
def test_a_curved_boundary_stays(name):
    """Facets that only come near to a curve are not split: that would not come nearer."""
    if name == "polygon":
        before = tri_grid(8)
        x, y = (2.0 * before.points - 1.0).T
        before.points = np.stack([x * np.sqrt(1 - y * y / 2), y * np.sqrt(1 - x * x / 2)], axis=1)
    else:
        source = sample(name)
        before = Mesh(source.points, [Block("tetra", source.cells)])
    after = adapted(before, same_everywhere(0.15), Slide()).mesh
    assert len(after.points) > len(before.points)
    places = [
        {frozenset(map(tuple, one.points[facet].tolist())) for facet in cast(one).outer}
        for one in (before, after)
    ]
    assert places[0] == places[1]


@both
@pytest.mark.parametrize("how", ["required", "twice"])
def test_facets_that_must_stay_do(dimension, how):
    before = small(dimension)
    kind = "line" if dimension == 2 else "triangle"
    (block,) = (one for one in before.blocks if one.type == kind)
    flags = np.arange(len(block.cells)) % 3 == 0
    some = block.cells[flags]
    if how == "required":
        block.data["medit:required"] = flags.astype(np.int64)
    else:
        before.blocks.append(Block(kind, some, {TAG: np.full(len(some), 7)}))
    after = adapted(before, same_everywhere(0.08), Slide()).mesh
    assert validity.check(after, ignore=("M",)).is_valid
    assert len(cast(after).outer) > len(block.cells)
    places = {frozenset(map(tuple, after.points[row].tolist())) for row in cast(after).outer}
    for row in some:
        assert frozenset(map(tuple, before.points[row].tolist())) in places
    assert sizes(after, kind) == pytest.approx(sizes(before, kind))


@pytest.mark.parametrize("how", ["required", "twice"])
def test_lines_that_must_stay_do(how):
    before = with_lines(small(3))
    lines = before.blocks[-1]
    flags = lines.data[TAG] == lines.data[TAG][0]
    if how == "required":
        lines.data["medit:required"] = flags.astype(np.int64)
    else:
        before.blocks.append(Block("line", lines.cells[flags], {TAG: np.full(flags.sum(), 99)}))
    after = adapted(before, same_everywhere(0.12), Slide()).mesh
    edges = {frozenset(map(tuple, ends.tolist())) for ends in after.points[boundary_edges(after)]}
    for ends in before.points[lines.cells[flags]]:
        assert frozenset(map(tuple, ends.tolist())) in edges
    assert sizes(after, "line") == pytest.approx(sizes(before, "line"))
    assert len(sizes(after, "line")) == 12 + (how == "twice")


def test_a_line_within_a_plane_stays():
    """On both sides of it is the same plane: nothing else would tell where it went."""
    before = small(3, amount=0.0)
    edges = boundary_edges(before)
    ends = before.points[edges]
    within = ((ends[..., 2] == 0) & (ends[..., 1] == 0.5) & (ends[..., 0] <= 0.5)).all(axis=1)
    assert within.sum() == 2
    before.blocks.append(Block("line", edges[within], {TAG: np.array([5, 5])}))
    after = adapted(before, same_everywhere(0.12), Slide()).mesh
    (lines,) = (block for block in after.blocks if block.type == "line")
    places = [
        {frozenset(map(tuple, pair.tolist())) for pair in one.points[rows]}
        for one, rows in ((before, edges[within]), (after, lines.cells))
    ]
    assert places[0] == places[1]
    assert lines_are_edges(after)


def test_an_inclined_plane():
    """Coordinates in the plane of the mesh are those of its frame."""
    flat = small(2, 3)
    before = Mesh(in_tilted_plane(Mesh(flat.points, flat.blocks[:1])).points, flat.blocks)
    plan_of = same_everywhere(0.05)
    after = adapted(before, plan_of, Slide()).mesh
    assert validity.check(after).is_valid
    assert sizes(after, "line") == pytest.approx(sizes(before, "line"), rel=1e-9)
    assert len(cast(after).outer) > 2 * len(cast(before).outer)


@both
def test_single_precision(dimension):
    before = small(dimension)
    before.points = before.points.astype(np.float32)
    after = adapted(before, same_everywhere(0.12), Slide()).mesh
    assert after.points.dtype == np.float32
    assert validity.check(after).is_valid
    np.testing.assert_allclose(region_volumes(cast(after)), [1.0], rtol=1e-6)


@both
def test_second_order(dimension):
    """New edges of the boundary have their node half way, and curved ones stay."""
    flat = tri_grid(4) if dimension == 2 else tet_grid(3)
    before = of_second_order(flat, bulging(0.03))
    after = adapted(before, same_everywhere(0.12), Slide()).mesh
    assert validity.check(after).is_valid
    assert len(after.points) > len(before.points)
    curved = {
        ends: at for ends, at in middles_by_place(before).items()
        if not np.allclose(np.mean([list(end) for end in ends], axis=0), at, atol=1e-6)
    }  # fmt: skip
    assert curved
    assert curved.items() <= middles_by_place(after).items()


def test_data_of_points_goes_along():
    before = small(2)
    before.point_data["u"] = 2.0 * before.points[:, 0] - before.points[:, 1]
    after = adapted(before, same_everywhere(0.07), Slide()).mesh
    np.testing.assert_allclose(
        after.point_data["u"], 2.0 * after.points[:, 0] - after.points[:, 1], atol=1e-12
    )


@both
def test_other_presets_keep_the_number_of_facets_within_bounds(dimension):
    """A metric that only says what quality is adds no vertex to the boundary."""
    before = small(dimension)
    after = adapted(before, same_everywhere(0.05), Slide(), preset="fast").mesh
    assert len(after.points) <= len(before.points)
    assert sizes(after, "line") == pytest.approx(sizes(before, "line"))


@both
@pytest.mark.parametrize(
    "name", [name for name, step in PASSES.items() if step.takes_metric and name != "repair"]
)
def test_every_pass_keeps_the_patches(dimension, name):
    """Facets that came of others are where these were, whatever else is done to them."""
    before = small(dimension, 5)
    part = cast(before)
    patches = resampled(patches_of(before, part, TOLERANCE), before, part)
    work = workspace_in(before, layered(before.points, 0.05), patches=patches)
    for step in (PASSES["fit"](accept="valid"), PASSES[name](), PASSES["fit"](), PASSES[name]()):
        step.run(work, Silent())
        assert_whole(work)
    after, origin = work.result()
    assert (origin[np.unique(after.outer)] < 0).any()
    prove_patches(part, after, patches, origin)
    for facet, patch in zip(after.points[after.outer], after.patch, strict=True):
        side = before.points[patches.facets[patch]]
        axis = np.flatnonzero(np.ptp(side, axis=0) == 0)[0]
        assert np.abs(facet[:, axis] - side[0, axis]).max() < 1e-12


@pytest.mark.parametrize("what", ["off", "wider"])
def test_a_boundary_that_left_its_planes_is_told(what):
    """The proof sees new vertices, too, which have no place to compare theirs with."""
    before = small(3, 5)
    part = cast(before)
    patches = resampled(patches_of(before, part, TOLERANCE), before, part)
    work = workspace_in(before, same_everywhere(0.15)(before.points), patches=patches)
    PASSES["fit"](accept="valid").run(work, Silent())
    after, origin = work.result()
    new = np.intersect1d(np.unique(after.outer), np.flatnonzero(origin < 0))
    inside = new[(on_sides(after.points[new])).sum(axis=1) == 1]
    after.points[inside[0]] += 1e-3 if what == "off" else 0.0
    if what == "wider":
        after.patch[0] = after.patch[after.patch != after.patch[0]][0]
    with pytest.raises(InvariantError):
        prove_patches(part, after, patches, origin)
