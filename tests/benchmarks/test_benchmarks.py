"""The judge of the benchmark on shapes that are known, and the files it has the peers read."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest

import judge
import native
import peers
import scaling
import spread
from judge import Part

REGULAR = np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], dtype=float)
TRIANGLE = np.array([[0, 0], [1, 0], [0.5, math.sqrt(3) / 2]])
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
# Around the diagonal from 0 to 7.
AROUND = (1, 3, 2, 6, 4, 5)


def single(points):
    return Part(np.asarray(points, float), np.arange(len(points))[None], np.ones(1, int))


def cube(regions=(1, 1, 1, 1, 1, 1)):
    """Six tetrahedra of a cube."""
    cells = [(0, 7, b, a) for a, b in zip(AROUND, AROUND[1:] + AROUND[:1], strict=True)]
    return Part(CUBE.copy(), np.array(cells), np.array(regions))


@pytest.mark.parametrize("points", [REGULAR, TRIANGLE, 3 * REGULAR + 5])
def test_regular_cells_have_one(points):
    part = single(points)
    verdict = judge.judge(part)
    assert verdict.worst == pytest.approx(1)
    assert verdict.counts == [1, 0, 0, 0]
    angle = 60 if part.dimension == 2 else math.degrees(math.acos(1 / 3))
    assert verdict.angle_min == pytest.approx(angle)
    assert verdict.angle_max == pytest.approx(angle)
    assert not verdict.invalid


def test_corner_of_a_cube():
    part = single([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert judge.volumes(part)[0] == pytest.approx(1 / 6)
    faces = 1.5 + math.sqrt(3) / 2
    expected = math.sqrt(2) * faces * 6 * math.sqrt(6) / 36
    assert judge.aspect_ratios(part)[0] == pytest.approx(expected)
    assert judge.angles(part).max() == pytest.approx(90)


@pytest.mark.parametrize(
    "points",
    [REGULAR[[1, 0, 2, 3]], [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], TRIANGLE[[1, 0, 2]]],
    ids=["inverted", "flat", "clockwise"],
)
def test_flat_and_inverted_cells_are_invalid(points):
    verdict = judge.judge(single(points))
    assert verdict.invalid == 1
    assert verdict.worst == math.inf
    assert verdict.counts == [0, 0, 0, 1]


def test_walls_of_a_cube():
    facets, inside, outside = judge.walls(cube())
    assert len(facets) == 12
    assert set(inside) == {1}
    assert set(outside) == {0}
    corners = CUBE[facets]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.sum(outwards * (corners.mean(axis=1) - 0.5), axis=1) > 0)


def test_interfaces_are_walls():
    facets, inside, outside = judge.walls(cube((1, 1, 1, 2, 2, 2)))
    assert len(facets) == 14
    assert sorted(zip(inside[outside > 0], outside[outside > 0], strict=True)) == [(1, 2)] * 2


def test_order_and_rounding_change_nothing():
    before, after = cube(), cube()
    order = np.array([7, 2, 0, 1, 3, 4, 6, 5])
    after.points = before.points[order] + 1e-12
    after.cells = np.argsort(order)[before.cells[::-1]]
    assert judge.compare(before, after) == "kept"


def test_what_changes_the_boundary_is_seen():
    before, moved, flipped = cube(), cube(), cube()
    moved.points[7] += 1e-6
    assert judge.compare(before, moved) == "1 vertices moved or new"
    # Around another diagonal: two of the faces of the cube are cut the other way.
    flipped.points = before.points[[4, 5, 6, 7, 0, 1, 2, 3]]
    flipped.cells = flipped.cells[:, [0, 1, 3, 2]]
    assert judge.volumes(flipped).min() > 0
    assert "facets lost" in judge.compare(before, flipped)


def test_a_region_that_grows_is_seen():
    before, after = cube((1, 1, 1, 2, 2, 2)), cube((1, 1, 2, 2, 2, 2))
    assert judge.compare(before, after) != "kept"
    after = cube((2, 2, 2, 1, 1, 1))
    after.region[:] = [1, 1, 1, 2, 2, 2]
    assert judge.compare(before, after) == "kept"


def test_points_are_found_where_they_are():
    known = np.random.default_rng(1).random((200, 3))
    known = np.concatenate([known, known[:3]])
    found = judge.find(known + 1e-12, known, 1e-9)
    assert np.array_equal(found[:3], found[200:])
    assert np.array_equal(found[3:200], np.arange(3, 200))
    assert judge.find(known[:1] + 1e-3, known, 1e-9)[0] == -1


@pytest.mark.parametrize(
    ("suffix", "write", "read"),
    [
        (".mesh", native.write_medit, lambda path: native.read_medit(path, 3)),
        (".vol", native.write_netgen, native.read_netgen),
        (".node", native.write_tetgen, native.read_tetgen),
    ],
    ids=["medit", "netgen", "tetgen"],
)
def test_files_of_peers_come_back(tmp_path, suffix, write, read):
    before = cube((1, 1, 1, 2, 2, 2))
    before.points[7] += 1 / 3
    path = tmp_path / f"cube{suffix}"
    write(path, before)
    after = read(path)
    assert np.array_equal(after.points, before.points)
    assert np.array_equal(after.cells, before.cells)
    assert np.array_equal(after.region, before.region)


def test_a_plane_is_laid_flat():
    turned, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    points = np.array([[0, 0, 0], [4, 0, 0], [0, 3, 0]]) @ turned + 7
    flat = native.oriented(
        native.Plane(points).flatten(points), np.array([[0, 1, 2]]), np.ones(1, int)
    )
    assert judge.volumes(flat)[0] == pytest.approx(6)


def test_the_meter_ends_what_takes_too_long(tmp_path):
    log = tmp_path / "log"
    call = [sys.executable, "-I", "-S", native.__file__.replace("native", "child"), "meter"]

    def measured(limit, code):
        command = [*call, limit, "0", str(log), sys.executable, "-S", "-c", code]
        return json.loads(subprocess.run(command, capture_output=True, check=True).stdout)

    late = measured("0.2", "import time; time.sleep(20)")
    assert late["late"]
    assert late["seconds"] < 10
    failed = measured("20", "print('so'); raise SystemExit(3)")
    assert failed["status"] == 3
    assert not failed["late"]
    assert log.read_text() == "so\n"


def test_the_report_tells_the_seconds(samples, tmp_path):
    command = [sys.executable, "-m", "meshopt_cli", "optimize", str(samples / "grid.vtk"),
               str(tmp_path / "out.vtk"), "--preset", "fast"]  # fmt: skip
    told = subprocess.run(command, capture_output=True, text=True, check=True)
    seconds = peers.TOOLS["meshopt-fast"].optimize(told.stdout)
    assert seconds is not None
    assert 0 < seconds < 600


def test_a_line_of_growth(tmp_path):
    took, report = scaling.measured(cube(), "fast", tmp_path)
    line = dict(zip(scaling.COLUMNS, scaling.row(took, report, took["peak"]), strict=True))
    assert line["cells"] == "6"
    assert line["less start"] == "0"
    assert 0 < float(line["peak MiB"]) < float(line["bytes/cell"])
    assert float(line["passes s"]) <= float(line["whole s"])


@pytest.mark.parametrize("name", ["grid.vtk", "two_regions.msh", "quadtree.vtk"])
def test_another_numbering_is_the_same_mesh(samples, name):
    part, _ = native.read_any(samples / name)
    other = spread.renumbered(part, 3)
    assert not np.array_equal(part.points, other.points)
    one, two = judge.judge(part), judge.judge(other)
    assert two.worst == pytest.approx(one.worst)
    assert two.mean == pytest.approx(one.mean)
    assert (two.cells, two.vertices, two.invalid) == (one.cells, one.vertices, 0)
    assert np.bincount(other.region).tolist() == np.bincount(part.region).tolist()


def test_the_spread_is_told(samples, capsys):
    spread.main([str(samples / "quadtree.vtk"), "--times", "2", "--preset", "fast"])
    line = next(one for one in capsys.readouterr().out.splitlines() if "quadtree" in one)
    assert len(line.split("│")) == 2 + 1 + len(spread.FIGURES)


def test_pieces_are_told_of_beside_the_whole(samples, capsys):
    mesh = str(samples / "quadtree.vtk")
    spread.main([mesh, "--times", "0", "--preset", "fast", "--pieces", "3"])
    told = [line for line in capsys.readouterr().out.splitlines() if "│" in line]
    assert any("in 3 pieces" in line for line in told)
