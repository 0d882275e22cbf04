"""Gmsh's periodic nodes: kept as pairs of points, through work and into files."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, Encoding, read, write
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.mesh.periodic import Link, renumbered
from support.gmsh import Builder, shaken_square

SHIFT = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
BUILDERS = [Builder(v) for v in ("2.2", "3", "4.0", "4.1")]
BUILDERS += [Builder(v, True, o) for v in ("2.2", "4.1") for o in "<>"]
TARGETS = [Encoding(name, "", binary) for name in ("gmsh", "gmsh22") for binary in (False, True)]


def square(builder, affine=SHIFT):
    """Two triangles, whose right side is the image of the left one; nodes by tens."""
    points = {10: (0.0, 0.0, 0.0), 20: (1.0, 0.0, 0.0), 30: (1.0, 1.0, 0.0), 40: (0.0, 1.0, 0.0)}
    sides = {1: (10, 40)}, {2: (20, 30)}
    entities = b""
    if builder.version >= 3:
        entities = builder.entities((1, 1, [], []), (1, 2, [], []), (2, 1, [5], []))
    return b"".join(
        (
            builder.header(),
            entities,
            builder.nodes(points, [(2, 1, tuple(points))]),
            builder.elements(
                (1, 1, 1, 0, sides[0]),
                (1, 2, 1, 0, sides[1]),
                (2, 1, 2, 5, {3: (10, 20, 30), 4: (10, 30, 40)}),
            ),
            builder.periodic((0, 2, 1, (), [(20, 10)]), (1, 2, 1, affine, [(20, 10), (30, 40)])),
        )
    )


def same(links, others):
    assert [link.pairs.tolist() for link in links] == [link.pairs.tolist() for link in others]
    heads = [[(k.dimension, k.tag, k.master, k.affine) for k in of] for of in (links, others)]
    return heads[0] == heads[1]


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda b: f"{b.spelled}{b.order * b.binary}")
@pytest.mark.parametrize("target", TARGETS)
def test_pairs_come_back(tmp_path, builder, target):
    path = tmp_path / "mesh.msh"
    path.write_bytes(square(builder))
    mesh, source = read(path)
    point, side = mesh.periodic
    assert (point.dimension, point.tag, point.master, point.affine) == (0, 2, 1, ())
    assert (side.dimension, side.tag, side.master, side.affine) == (1, 2, 1, SHIFT)
    assert point.pairs.tolist() == [[1, 0]]
    assert side.pairs.tolist() == [[1, 0], [2, 3]]
    assert source.lost == ()
    written = write(tmp_path / "again.msh", mesh, target)
    assert not any("stand for" in what for what in written.lost)
    again, source = read(tmp_path / "again.msh")
    assert same(again.periodic, mesh.periodic)
    assert source.lost == ()


def test_entities_of_pairs_are_written(tmp_path):
    """Gmsh cannot read on after a link between entities that it does not know."""
    path = tmp_path / "mesh.msh"
    path.write_bytes(square(Builder("2.2")))
    write(path, read(path)[0], Encoding("gmsh", "4.1", binary=False))
    assert b"$Entities\n2 2 1 0\n1 0.0 0.0 0.0 0\n2 1.0 0.0 0.0 0\n" in path.read_bytes()


@pytest.mark.parametrize("name", ["vtk", "vtu", "medit", "meditb"])
def test_formats_without_pairs_say_so(tmp_path, name):
    path = tmp_path / "mesh.msh"
    path.write_bytes(square(Builder("2.2")))
    lost = write(tmp_path / "out", read(path)[0], FORMATS[name].default).lost
    assert any("stand for each other" in what for what in lost)


def test_pairs_with_nodes_that_are_not_there_are_named(tmp_path):
    builder = Builder("4.1")
    content = square(builder).replace(b"\n30 40\n", b"\n30 41\n")
    path = tmp_path / "mesh.msh"
    path.write_bytes(content)
    mesh, source = read(path)
    assert [link.pairs.tolist() for link in mesh.periodic] == [[[1, 0]], [[1, 0]]]
    assert any("$Periodic" in what for what in source.lost)


def test_pairs_follow_their_points():
    link = Link(1, 2, 1, SHIFT, np.array([[0, 3], [1, 4], [2, 5]]))
    (new,) = renumbered([link], np.array([7, -1, 2, 6, 0, 5]))
    assert new.pairs.tolist() == [[7, 6], [2, 5]]
    assert new.affine == SHIFT


def test_optimizing_keeps_the_pairs(tmp_path):
    """Sides of a square that correspond, before and after, by their coordinates."""
    n = 6
    points, cells, place = shaken_square(n)
    builder = Builder("4.1")
    pairs = [(place[n, j], place[0, j]) for j in range(n + 1)]
    path = tmp_path / "mesh.msh"
    path.write_bytes(
        builder.header()
        + builder.entities((1, 1, [], []), (1, 2, [], []), (2, 1, [5], []))
        + builder.nodes(points, [(2, 1, tuple(points))])
        + builder.elements((2, 1, 2, 5, cells))
        + builder.periodic((1, 2, 1, SHIFT, pairs))
    )
    assert optimize_file(FileTask(path, tmp_path / "out.msh")).written
    mesh, _ = read(tmp_path / "out.msh")
    (link,) = mesh.periodic
    assert len(link.pairs) == n + 1
    one, other = mesh.points[link.pairs.T]
    assert (one - other).tolist() == [[1.0, 0.0, 0.0]] * (n + 1)
