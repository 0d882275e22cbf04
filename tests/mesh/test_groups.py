"""Cells of groups that somebody names."""

import numpy as np
import pytest

from meshopt_cli.mesh.groups import cells_in, cells_named, names_of_groups
from meshopt_cli.mesh.model import Block
from meshopt_cli.mesh.tags import GEOMETRICAL, PHYSICAL, REF
from support.edits import tagged
from support.meshes import tet_grid


def named():
    """Two regions, 7 and 8, and two facets in the groups 7 and 9 of their dimension."""
    one = tagged(tet_grid(1), [7, 7, 7, 8, 8, 8], PHYSICAL)
    one.blocks[0].data[GEOMETRICAL] = np.array([1, 2, 2, 3, 3, 3])
    facets = one.blocks[0].cells[:2, :3]
    one.blocks.append(Block("triangle", facets, {PHYSICAL: np.array([7, 9])}))
    one.names = {(3, 7): "steel", (2, 7): "wall", (2, 9): "steel", (3, 5): "empty", (3, 6): "7"}
    return one


def rows(found):
    return None if found is None else [np.flatnonzero(mask).tolist() for mask in found]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("steel", [[0, 1, 2], [1]]),
        ("wall", [[], [0]]),
        ("8", [[3, 4, 5], []]),
        ("9", [[], [1]]),
        ("2:7", [[], [0]]),
        ("2:steel", [[], [1]]),
        ("3:steel", [[0, 1, 2], []]),
        ("empty", None),
        ("7", None),  # a group is called so, and has no cell
        ("10", None),
        ("1:steel", None),
        ("stee", None),
        ("2:", None),
        ("", None),
        ("9" * 30, None),
    ],
)
def test_names_and_numbers(name, expected):
    assert rows(cells_named(named(), name)) == expected


def test_of_one_dimension():
    one = named()
    assert rows(cells_in(one, "steel", 3)) == [[0, 1, 2], []]
    assert rows(cells_in(one, "empty", 3)) == [[], []]
    assert cells_in(one, "wall", 3) is None


def test_entities_in_several_groups():
    one = named()
    one.more_groups = {(3, 3): (5, 7), (2, 3): (7,)}
    assert rows(cells_named(one, "empty")) == [[3, 4, 5], []]
    assert rows(cells_named(one, "3:steel")) == [[0, 1, 2, 3, 4, 5], []]


@pytest.mark.parametrize("array", [REF, PHYSICAL, GEOMETRICAL, "material"])
def test_numbers_of_any_array_of_tags(array):
    one = tagged(tet_grid(1), [-1, -1, 2, 2, 2, 2], array)
    assert rows(cells_named(one, "-1")) == [[0, 1]]
    assert names_of_groups(one) == ["-1", "2"]


def test_arrays_that_are_asked_to_make_regions_count_alone():
    one = tagged(tet_grid(1), [1] * 6, PHYSICAL)
    one.blocks[0].data["layer"] = np.array([4.0, 4.0, 5.0, 5.0, 5.0, 5.0])
    one.regions = ("layer",)
    assert rows(cells_named(one, "4")) == [[0, 1]]
    assert cells_named(one, "1") is None
    assert names_of_groups(one) == ["4", "5"]


def test_meshes_without_tags():
    assert cells_named(tet_grid(1), "1") is None
    assert names_of_groups(tet_grid(1)) == []
