"""Sizes by formulas, for named parts of a mesh and the rest."""

import pickle

import numpy as np
import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.model import Block
from meshopt_cli.mesh.tags import PHYSICAL
from meshopt_cli.metric.sizes import sizes_of
from support.edits import tagged
from support.meshes import tri_grid


def two_halves(n=4):
    """A square whose left half is steel, with the lower side in a group."""
    one = tri_grid(n)
    left = one.points[one.blocks[0].cells].mean(axis=1)[:, 0] < 0.5
    one = tagged(one, np.where(left, 1, 2), PHYSICAL)
    low = np.flatnonzero(one.points[:, 1] == 0.0)
    low = low[np.argsort(one.points[low, 0])]
    lines = np.column_stack([low[:-1], low[1:]])
    one.blocks.append(Block("line", lines, {PHYSICAL: np.full(len(lines), 1)}))
    one.names = {(2, 1): "steel", (1, 1): "floor = low"}
    return one


def at(*texts):
    one = two_halves()
    return one.points, sizes_of(texts).at(one)


def test_a_formula_alone_holds_everywhere():
    points, found = at("0.1+x")
    assert found == pytest.approx(0.1 + points[:, 0])


@pytest.mark.parametrize("name", ["steel", "2:1", "2:steel", "1", " steel "])
@pytest.mark.parametrize(("of_part", "of_rest"), [(0.1, 0.3), (0.3, 0.1)])
def test_where_parts_meet_the_less_counts(name, of_part, of_rest):
    points, found = at(f"{of_rest}", f"{name}={of_part}")
    x = points[:, 0]
    expected = np.where(x < 0.5, of_part, of_rest)
    expected[x == 0.5] = min(of_part, of_rest)
    assert found == pytest.approx(expected)


def test_a_group_of_lower_dimension_lies_in_others():
    points, found = at("0.3", "steel=0.2", "floor = low=0.1+0.3*x")
    x, y = points.T[:2]
    expected = np.where(x <= 0.5, 0.2, 0.3)
    expected[y == 0.0] = np.minimum(expected, 0.1 + 0.3 * x)[y == 0.0]
    assert found == pytest.approx(expected)


def test_the_order_does_not_matter():
    texts = ["0.3", "steel=0.2+y", "1:1=0.1+x"]
    assert np.array_equal(at(*texts)[1], at(*texts[::-1])[1])


def test_vertices_without_any_are_infinite():
    points, found = at("steel=0.2")
    assert np.isinf(found).tolist() == (points[:, 0] > 0.5).tolist()


def test_what_is_not_defined_in_a_part_is_not_hidden_by_another():
    points, found = at("0.3", "steel=log(0-x)")
    assert np.isnan(found[(points[:, 0] < 0.5) & (points[:, 0] > 0.0)]).all()


@pytest.mark.parametrize(
    ("texts", "what"),
    [
        (["steal=1"], "'steal': did you mean 'steel'"),
        (["7=1"], "'7'"),
        (["1", "2"], "twice: 1 and 2"),
        (["steel=1", "steel=2"], "twice for steel"),
        (["=1"], "no name"),
        (["steel="], "no formula"),
        (["steel=x.real"], "letter 1"),
        (["steel>=0.2"], "'steel>'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(texts, what):
    with pytest.raises(ConfigError) as caught:
        at(*texts)
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_out_of_files_are_shown_plainly():
    one = two_halves()
    one.names = {(2, 1): "a\x1b[31m"}
    sizes = sizes_of(["0.3", "a\x1b[31m=0.1"])
    assert sizes.at(one).min() == 0.1
    assert str(sizes).isprintable()


def test_without_groups_none_is_offered():
    with pytest.raises(ConfigError, match=r"the mesh has none$"):
        sizes_of(["steel=1"]).at(tri_grid(1))


def test_they_go_to_other_processes():
    sizes = sizes_of(["0.3+x", "steel=0.2"])
    again = pickle.loads(pickle.dumps(sizes))
    assert str(again) == str(sizes) == "0.3+x, steel=0.2"
    assert np.array_equal(again.at(two_halves()), sizes.at(two_halves()))
