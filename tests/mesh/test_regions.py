"""Regions: which arrays make them, and that cells keep them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.tags import (
    MAX_LABELS,
    TAG_NAMES,
    Regions,
    doubtful_tags,
    regions_in,
    regions_of,
    with_regions,
)
from support.edits import layered
from support.runs import optimized
from support.settings import examples


def tagged_cells(**data):
    n = len(next(iter(data.values())))
    return [Block("tetra", np.zeros((n, 4), np.int64), {k: np.asarray(v) for k, v in data.items()})]


@examples(60)
@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(0, 2)), min_size=1, max_size=40))
def test_a_region_is_a_combination_of_tags(rows):
    one, other = zip(*rows, strict=True)
    blocks = tagged_cells(**{"medit:ref": one, "material": other, "stress": np.ones(len(rows))})
    region = regions_of(blocks)
    assert set(region) == set(range(len(set(rows))))
    assert len(set(zip(rows, region.tolist(), strict=True))) == len(set(rows))


@pytest.mark.parametrize("dtype", [np.uint8, np.int32, np.uint64])
def test_integers_of_any_width_are_tags(dtype):
    region = regions_of(tagged_cells(part=np.array([7, 7, 200], dtype)))
    assert region[0] == region[1] != region[2]


@pytest.mark.parametrize(
    "values",
    [
        np.arange(200) % (MAX_LABELS + 1),
        np.linspace(0, 1, 200) // 0.1 / 2,
        np.where(np.arange(200) < 100, np.nan, 1.0),
        np.arange(400).reshape(200, 2) % 2,
        np.arange(40),
        np.arange(40.0)[::-1],
    ],
    ids=["too many values", "halves", "not everywhere", "two columns", "numbers", "real numbers"],
)
def test_an_array_that_is_no_tag_makes_no_regions(values):
    blocks = tagged_cells(array=values)
    assert not np.any(regions_of(blocks))


def test_as_many_values_as_labels_are_allowed_make_regions():
    values = np.arange(2 * MAX_LABELS) % MAX_LABELS
    assert len(set(regions_of(tagged_cells(array=values)))) == MAX_LABELS


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_whole_reals_make_the_regions_that_integers_make(dtype):
    values = np.arange(200) // 70 - 1
    region = regions_of(tagged_cells(material=values))
    assert np.array_equal(regions_of(tagged_cells(material=values.astype(dtype))), region)


@pytest.mark.parametrize(
    "name",
    ["vtkGhostType", "vtkProcessId", "PartitionId", "Process Ids", "gmsh:partition", "medit:ridge"],
)
def test_parts_for_computing_are_no_regions(name):
    one = Mesh(np.zeros((1, 3)), tagged_cells(**{name: np.arange(40) // 10}))
    assert not np.any(regions_of(one.blocks))
    assert regions_in(one) == Regions((), 1)
    assert regions_in(with_regions(one, (name,))).count == 4


def test_few_cells_may_each_be_a_region_but_not_by_a_number_of_theirs():
    assert regions_of(tagged_cells(material=[3, 1, 2])).tolist() == [2, 0, 1]
    for name in ("GlobalElementId", "id", "cell_ids", "vtkOriginalCellIds", "index"):
        assert not np.any(regions_of(tagged_cells(**{name: [3, 1, 2]})))


NAMED = {
    "reals": (np.array([0.5, 0.25, 0.5, -1.0]), [2, 1, 2, 0]),
    "not everywhere": (np.array([np.nan, 1.5, np.nan, 1.5]), [1, 0, 1, 0]),
    "columns": (np.array([[1, 0], [1, 1], [0, 9], [1, 0]]), [1, 2, 0, 1]),
    "numbers": (np.arange(4), [0, 1, 2, 3]),
}


@pytest.mark.parametrize("name", NAMED)
def test_any_array_that_is_named_makes_regions(name):
    values, region = NAMED[name]
    one = Mesh(np.zeros((1, 3)), tagged_cells(this=values, other=[0, 1, 2, 2]))
    named = with_regions(one, ("this",))
    assert regions_of(named.blocks, named.regions).tolist() == region
    assert regions_in(named) == Regions(("this",), max(region) + 1)


def test_arrays_that_may_be_meant_are_asked_about():
    n = 40 * MAX_LABELS
    many = np.arange(n) // 10
    arrays = {"parts": many, "real": many.astype(float), "numbers": np.arange(n)}
    one = Mesh(np.zeros((1, 3)), tagged_cells(few=many % 4, stress=many / 7, **arrays))
    assert doubtful_tags(one) == {"parts": n // 10, "real": n // 10}
    assert doubtful_tags(with_regions(one, ("few",))) == {}


@pytest.mark.parametrize("name", TAG_NAMES)
def test_tags_by_name_may_have_any_number_of_values(name):
    values = np.arange(10 * MAX_LABELS)
    assert np.array_equal(regions_of(tagged_cells(**{name: values})), values)


def test_an_array_of_some_blocks_only_makes_no_regions():
    blocks = tagged_cells(part=[1, 2], own=[1, 1]) + tagged_cells(own=[1, 1])
    assert not np.any(regions_of(blocks))


def test_blocks_of_the_same_tags_are_one_region():
    blocks = tagged_cells(part=[1, 1]) + tagged_cells(part=[2]) + tagged_cells(part=[1])
    assert regions_of(blocks).tolist() == [0, 0, 1, 0]


@pytest.mark.parametrize("preset", ["standard", "best"])
def test_cells_keep_the_tag_of_their_place(preset):
    one = layered()
    result = optimized(one, preset=preset)
    (block,) = result.blocks
    assert block.data["layer"].dtype == np.int32
    assert not np.array_equal(result.points, one.points)
    height = result.points[block.cells].mean(axis=1)[:, 2]
    assert np.array_equal(block.data["layer"] == 9, height > 0.5)
