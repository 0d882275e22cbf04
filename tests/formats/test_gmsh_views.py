"""Views of Gmsh: several steps of one quantity, times, parts, and those without a name."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, write
from meshopt_cli.mesh.model import View
from support.encodings import assert_unreadable
from support.gmsh import Builder, two_tets

BUILDERS = [Builder("2.2"), Builder("4.1"), Builder("2.2", True), Builder("4.1", True)]
BUILDERS += [Builder("2.2", True, ">"), Builder("4.1", True, ">"), Builder("3"), Builder("4.0")]
every_builder = pytest.mark.parametrize(
    "builder", BUILDERS, ids=lambda b: f"{b.spelled}{b.order * b.binary}"
)
TARGETS = [Encoding(name, "", binary) for name in ("gmsh", "gmsh22") for binary in (False, True)]


def with_views(tmp_path, builder, *views):
    path = tmp_path / "mesh.msh"
    path.write_bytes(two_tets(builder) + b"".join(views))
    return path


def steps(builder):
    return [
        builder.view("NodeData", "T", {1: 1.0, 2: 2.0}, 0.0, 0),
        builder.view("NodeData", "T", {1: 3.0, 5: 4.0}, 0.25, 1),
        builder.view("NodeData", "T", {3: 5.0}, 1.5, 7),
        builder.view("ElementData", "T", {2: (1.0, 2.0, 3.0)}, 0.0, 0),
        builder.view("ElementData", "T", {3: (4.0, 5.0, 6.0)}, 9.0, 1),
        builder.view("NodeData", "u", {4: 8.0}, 2.0, 3),
    ]


@every_builder
def test_each_step_is_an_array(tmp_path, builder):
    mesh, source = read(with_views(tmp_path, builder, *steps(builder)))
    nan = np.nan
    expected = {
        "T@0": [1, 2, nan, nan, nan],
        "T@1": [3, nan, nan, nan, 4],
        "T@7": [nan, nan, 5, nan, nan],
        "u": [nan, nan, nan, 8, nan],
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(mesh.point_data[name], values)
    tets = mesh.blocks[1].data
    np.testing.assert_array_equal(tets["T@0"], [[1, 2, 3], [nan] * 3])
    np.testing.assert_array_equal(tets["T@1@2"], [[nan] * 3, [4, 5, 6]])  # of another time
    assert mesh.views["T@1"] == View("T", 0.25, 1)
    assert mesh.views["T@7"] == View("T", 1.5, 7)
    assert mesh.views["T@1@2"] == View("T", 9.0, 1)
    assert mesh.views["u"] == View("u", 2.0, 3)
    assert source.lost == ()


@every_builder
@pytest.mark.parametrize("target", TARGETS)
def test_all_steps_come_back(tmp_path, builder, target):
    mesh, _ = read(with_views(tmp_path, builder, *steps(builder)))
    lost = write(tmp_path / "again.msh", mesh, target).lost
    assert not any("time" in what or "T" in what for what in lost)
    again, _ = read(tmp_path / "again.msh")
    assert again.views == mesh.views
    for name in ("T@0", "T@1", "T@7", "u"):
        np.testing.assert_array_equal(again.point_data[name], mesh.point_data[name])
    for name in ("T@0", "T@1@2"):
        np.testing.assert_array_equal(again.blocks[1].data[name], mesh.blocks[1].data[name])


def test_other_formats_have_the_arrays_and_name_the_times(tmp_path):
    mesh, _ = read(with_views(tmp_path, BUILDERS[1], *steps(BUILDERS[1])))
    for end in ("vtu", "vtk"):
        path = tmp_path / f"out.{end}"
        lost = write(path, mesh, encoding_for(path)).lost
        assert any(what.startswith("the times of T@1, T@7") for what in lost)
        assert {"T@0", "T@1", "T@7", "u"} <= set(read(path)[0].point_data)
    lost = write(tmp_path / "out.mesh", mesh, FORMATS["medit"].default).lost
    assert {"T@0", "T@1", "T@7", "u"} <= set(lost)


@every_builder
def test_a_view_without_a_name_gets_one(tmp_path, builder):
    view = builder.view("NodeData", None, {1: 1.0})
    mesh, _ = read(with_views(tmp_path, builder, view, builder.view("NodeData", None, {2: 1.0})))
    assert list(mesh.point_data)[-2:] == ["view 1", "view 2"]


@every_builder
def test_parts_of_partitions_make_one_array(tmp_path, builder):
    parts = [
        builder.view("NodeData", "T", {1: 1.0, 2: 2.0}, partition=1),
        builder.view("NodeData", "T", {3: 3.0, 4: 4.0, 5: 5.0}, partition=2),
    ]
    mesh, source = read(with_views(tmp_path, builder, *parts))
    assert mesh.point_data["T"].tolist() == [1, 2, 3, 4, 5]
    assert mesh.views == {}
    assert source.lost == ()


def test_two_views_that_differ_in_nothing_are_both_kept(tmp_path):
    views = [BUILDERS[0].view("NodeData", "T", {1: value}) for value in (1.0, 2.0)]
    mesh, _ = read(with_views(tmp_path, BUILDERS[0], *views))
    assert [mesh.point_data[name][0] for name in ("T@0", "T@0@2")] == [1.0, 2.0]


def test_what_is_not_kept_is_named(tmp_path):
    builder = BUILDERS[1]
    views = [
        builder.section("InterpolationScheme", b'"p2"\n1\n2\n1\n1 1\n1\n1 1\n1\n'),
        builder.section("ElementNodeData", b'1\n"s"\n1\n0\n3\n0\n1\n1\n2 4 1 2 3 4\n'),
        builder.view("NodeData", "T", {1: 1.0, 77: 2.0}),
        builder.section("NodeData", b'2\n"u"\n"p2"\n1\n0\n3\n0\n1\n1\n1 1.0\n'),
    ]
    lost = read(with_views(tmp_path, builder, *views))[1].lost
    for what in ("$InterpolationScheme", "$ElementNodeData", "view T", "scheme of the view u"):
        assert any(what in one for one in lost), what


@pytest.mark.parametrize(
    "body",
    [
        b"1\n",
        b'1\n"T"\n1\n0\n3\n0\n1\n',
        b'1\n"T"\n1\n0\n3\n0\n1\n99999999\n1 2\n',
        b'1\n"T"\n1\n0\n3\n0\n0\n1\n1 2\n',
        b'1\n"T"\n1\n0\n2\n0\n1\n1 2\n',
        b'1\n"T"\n1\n0\n3\n0\nx\n1\n1 2\n',
        b'1\n"T"\n1\n0\n3\n0\n1\n1\nnone 2\n',
    ],
)
def test_a_malformed_view_is_refused_by_its_section(tmp_path, body):
    path = with_views(tmp_path, BUILDERS[0], BUILDERS[0].section("NodeData", body))
    assert_unreadable(path, "$NodeData")
