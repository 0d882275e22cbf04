"""The judge of domains sees every change that no run may make."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.quality.measures import QUALITIES
from support.domain import TAG, Domain, assert_same_domain, assert_same_shape, assert_valid, worst_q
from support.recipes import Recipe, made

SPACE = Recipe(3, 3, seed=2, amount=0.5, regions="halves", declared=("sides", "edges", "vertices"))
PLANE = Recipe(2, 4, seed=2, amount=0.5, regions="halves", declared=("sides", "facets", "vertices"))
every_recipe = pytest.mark.parametrize("recipe", [SPACE, PLANE], ids=["space", "plane"])
SHARP = 1e-9


def with_point(of, vertex, by):
    points = of.points.copy()
    points[vertex] += by
    return replace(of, points=points)


def with_block(of, kind, change):
    return replace(of, blocks=[change(b) if b.type == kind else b for b in of.blocks])


def main(of):
    return of.blocks[0]


def on_sides(of):
    """On how many sides of the unit square or cube each vertex is."""
    return ((of.points < 1e-9) | (of.points > 1 - 1e-9)).sum(axis=1)


def corner_moved(of):
    return with_point(of, int(np.argmax(on_sides(of))), 1e-6)


def side_dented(of):
    vertex = int(np.flatnonzero(on_sides(of) == 1)[0])
    inwards = np.where(of.points[vertex] < 1e-9, 1e-6, 0) - np.where(
        of.points[vertex] > 1 - 1e-9, 1e-6, 0
    )
    return with_point(of, vertex, inwards)


def with_rows(of, kind, rows):
    """Only these cells of each block of a type, in this order."""
    return with_block(
        of, kind, lambda b: replace(b, cells=b.cells[rows], data={TAG: b.data[TAG][rows]})
    )


def cell_gone(of):
    return with_rows(of, main(of).type, slice(1, None))


def cell_twice(of):
    return with_rows(of, main(of).type, np.r_[0, np.arange(len(main(of).cells))])


def cell_of_another_region(of):
    tags = main(of).data[TAG].copy()
    tags[0] = 3 - tags[0]
    return with_block(of, main(of).type, lambda b: replace(b, data={TAG: tags}))


def cell_inverted(of):
    cells = main(of).cells.copy()
    cells[0, :2] = cells[0, 1::-1]
    return with_block(of, main(of).type, lambda b: replace(b, cells=cells))


def declared_gone(kind):
    return lambda of: with_rows(of, kind, slice(1, None))


def other_tag(of):
    """Of one declared facet."""

    def change(block):
        tags = block.data[TAG].copy()
        tags[0] += 1
        return replace(block, data={TAG: tags})

    return with_block(of, {2: "line", 3: "triangle"}[of.points.shape[1]], change)


CHANGES = {
    "corner moved": corner_moved,
    "side dented": side_dented,
    "cell gone": cell_gone,
    "cell twice": cell_twice,
    "cell of another region": cell_of_another_region,
    "cell inverted": cell_inverted,
    "declared vertex gone": declared_gone("vertex"),
    "declared line gone": declared_gone("line"),
    "other tag of a facet": other_tag,
}


def judge_all(of, other, axes):
    before, after = Domain(of, axes), Domain(other, axes)
    assert_valid(after)
    yield lambda: assert_same_domain(before, after)
    yield lambda: assert_same_shape(before, after, SHARP)


@every_recipe
def test_a_mesh_is_as_it_is(recipe):
    of, axes = made(recipe)
    for judged in judge_all(of, of, axes):
        judged()


@every_recipe
@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("policy", [0, 1], ids=["fixed", "slide"])
def test_every_change_is_seen(recipe, name, policy):
    of, axes = made(recipe)
    with pytest.raises(AssertionError):
        list(judge_all(of, CHANGES[name](of), axes))[policy]()


@every_recipe
@pytest.mark.parametrize("measure", [name for name, row in QUALITIES.items() if row.drives])
def test_a_worse_cell_is_seen(recipe, measure):
    of, axes = made(recipe)
    flat = replace(of, points=of.points * np.r_[np.ones(recipe.dimension - 1), 0.2])
    one, other = (worst_q(Domain(m, axes).part, measure) for m in (of, flat))
    assert other < one
