"""`meshopt optimize --metric` and `--size`."""

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.formats.medit_sol import TENSOR, Solution, read_sol, write_sol
from meshopt_cli.mesh.cast import cast
from meshopt_cli.metric.field import components
from meshopt_cli.quality.measures import QUALITIES
from support.driven import layered
from support.edits import halves, shaken
from support.files import strict, write
from support.invariants import region_volumes, sorted_skin
from support.meshes import hex_grid, tet_grid, tri_grid

GRIDS = [pytest.param(tri_grid, 12, id="plane"), pytest.param(tet_grid, 6, id="space")]


def made(folder, make, n, suffix=".mesh"):
    """A mesh in two regions, and a file of tensors for it."""
    one = halves(shaken(make(n)))
    values = components(layered(one.points))
    path, sol = write(folder / f"in{suffix}", one), folder / "in.sol"
    write_sol(sol, Solution(one.points.shape[1], [(TENSOR, values)]))
    return path, sol


def both(meshopt, *arguments):
    """The figures in the metric, before and after."""
    ran = meshopt("optimize", *arguments, "--json")
    assert ran.status == 0, ran.err
    report = strict(ran.out)
    return report["metric"], report["metric_after"]


@pytest.mark.parametrize(("make", "n"), GRIDS)
@pytest.mark.parametrize("suffix", [".mesh", ".msh", ".vtu"])
def test_edges_come_near_to_length_1(meshopt, tmp_path, make, n, suffix):
    path, sol = made(tmp_path, make, n, suffix)
    out = tmp_path / f"out{suffix}"
    before, after = both(meshopt, path, out, "--metric", sol)
    assert after["edges"]["tau"] > before["edges"]["tau"] + 0.01
    assert after["inner_edges"]["share"] > before["inner_edges"]["share"] + 0.05
    assert meshopt("check", out).status == 0
    old, new = (cast(formats.read(one)[0]) for one in (path, out))
    np.testing.assert_allclose(region_volumes(new), region_volumes(old), rtol=1e-9)
    assert len(sorted_skin(new)) == len(sorted_skin(old))


@pytest.mark.parametrize(("make", "n"), GRIDS)
@pytest.mark.parametrize("boundary", ["fixed", "slide"])
def test_a_second_run_is_not_worse(meshopt, tmp_path, make, n, boundary):
    path, sol = made(tmp_path, make, n)
    out, again, to = (tmp_path / name for name in ("a.mesh", "b.mesh", "a.sol"))
    how = ("--boundary", boundary)
    _, first = both(meshopt, path, out, "--metric", sol, "--metric-out", to, *how)
    before, after = both(meshopt, out, again, "--metric", to, *how)
    assert before["edges"]["tau"] == pytest.approx(first["edges"]["tau"], rel=1e-12)
    assert after["edges"]["tau"] >= before["edges"]["tau"] - 1e-9


@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_a_boundary_that_slides_is_driven_too(meshopt, tmp_path, make, n):
    path, sol = made(tmp_path, make, n, ".msh")
    figures = {}
    for boundary in ("fixed", "slide"):
        out = tmp_path / f"{boundary}.msh"
        _, after = both(meshopt, path, out, "--metric", sol, "--boundary", boundary)
        figures[boundary] = after["edges"]
        assert meshopt("check", out).status == 0
        old, new = (cast(formats.read(one)[0]) for one in (path, out))
        np.testing.assert_allclose(region_volumes(new), region_volumes(old), rtol=1e-12)
    assert figures["slide"]["tau"] > figures["fixed"]["tau"] + 0.01
    assert figures["slide"]["share"] > figures["fixed"]["share"] + 0.05


@pytest.mark.parametrize("preset", ["fast", "standard"])
def test_other_presets_go_by_quality_in_the_metric(meshopt, tmp_path, preset):
    path, sol = made(tmp_path, tri_grid, 12)
    before, after = both(meshopt, path, tmp_path / "o.mesh", "--metric", sol, "--preset", preset)
    assert after["worst"] <= before["worst"]
    assert after["mean"] < before["mean"]


@pytest.mark.parametrize("preset", ["fast", "standard"])
@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_the_identity_changes_no_byte(meshopt, tmp_path, preset, make):
    path = write(tmp_path / "in.mesh", shaken(make(5)))
    plain, driven = tmp_path / "a.mesh", tmp_path / "b.mesh"
    assert meshopt("optimize", path, plain, "--preset", preset).status == 0
    d = 2 if make is tri_grid else 3
    sol = tmp_path / "one.sol"
    n = len(formats.read(path)[0].points)
    write_sol(sol, Solution(d, [(TENSOR, components(np.tile(np.eye(d), (n, 1, 1))))]))
    for how in (("--size", "1"), ("--metric", sol)):
        assert meshopt("optimize", path, driven, "--preset", preset, *how).status == 0
        assert driven.read_bytes() == plain.read_bytes()


@pytest.mark.parametrize("suffix", [".mesh", ".vtu"])
def test_the_metric_goes_along(meshopt, tmp_path, suffix):
    path, sol = made(tmp_path, tri_grid, 10, suffix)
    out, to = tmp_path / f"out{suffix}", tmp_path / "out.sol"
    both(meshopt, path, out, "--metric", sol, "--metric-out", to)
    assert len(read_sol(to).fields[0][1]) == len(formats.read(out)[0].points)
    named = tmp_path / "named.vtu"
    both(meshopt, path, named, "--metric", sol, "--metric-out", "M")
    ran = meshopt("report", named, "--metric", "M", "--format", "json")
    again = strict(ran.out)["metric"]
    ran = meshopt("report", out, "--metric", to, "--format", "json")
    assert again["edges"]["tau"] == pytest.approx(strict(ran.out)["metric"]["edges"]["tau"])


def test_sizes_by_a_formula(meshopt, tmp_path):
    path = write(tmp_path / "in.vtu", shaken(tri_grid(12)))
    before, after = both(meshopt, path, tmp_path / "o.vtu", "--size", "0.05 + 0.1*x")
    assert after["edges"]["tau"] > before["edges"]["tau"]
    assert after["kind"] == "sizes"


def test_sizes_of_a_region(meshopt, tmp_path):
    """A group of its own size has more cells than the same area elsewhere."""
    one = halves(shaken(tri_grid(12)))
    path = write(tmp_path / "in.mesh", one)
    out = tmp_path / "o.mesh"
    both(meshopt, path, out, "--size", "0.15", "--size", "1=0.05")
    region = cast(formats.read(out)[0]).region
    counts = sorted(np.bincount(region))
    assert counts[1] > 2 * counts[0]


def test_a_metric_is_shaped_before_it_drives(meshopt, tmp_path):
    path = write(tmp_path / "in.mesh", shaken(tri_grid(16)))
    jump = ("--size", "max(0.02, min(0.3, 100*(x-0.5)))")
    _, plain = both(meshopt, path, tmp_path / "a.mesh", *jump)
    _, graded = both(meshopt, path, tmp_path / "b.mesh", *jump, "--gradation", "1.3")
    _, least = both(meshopt, path, tmp_path / "c.mesh", *jump, "--size-min", "0.06")
    assert least["ne"] < plain["ne"] < graded["ne"]
    assert "gradation 1.3" in graded["source"]
    assert graded["edges"]["tau"] > plain["edges"]["tau"]


def test_the_implied_metric_asks_for_nothing(meshopt, tmp_path):
    path = write(tmp_path / "in.vtu", tri_grid(8))
    before, after = both(meshopt, path, tmp_path / "o.vtu", "--metric", "implied")
    assert after["edges"]["tau"] >= before["edges"]["tau"] - 1e-9


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--preset", "adapt"), "needs a metric"),
        (("--passes", "fit"), "needs a metric"),
        (("--metric-out", "m.sol"), "--metric-out"),
        (("--passes", "nonobtuse", "--size", "1"), "knows no metric"),
        (("--size", "1", "--metric", "implied"), "exclude"),
        (("--metric", "nosuch"), "nosuch"),
        (("--size", "x"), "not positive"),
        (("--gradation", "1.3"), "goes with"),
        (("--size", "nosuch=1"), "nosuch"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(meshopt, tmp_path, arguments, said):
    path = write(tmp_path / "in.mesh", tri_grid(3))
    ran = meshopt("optimize", path, tmp_path / "o.mesh", *arguments)
    assert ran.status == 2
    assert said in ran.err
    assert len(ran.err.splitlines()) == 1
    assert not (tmp_path / "o.mesh").exists()


def test_hexahedra_are_not_driven(meshopt, tmp_path):
    path = write(tmp_path / "in.vtu", hex_grid(3))
    ran = meshopt("optimize", path, tmp_path / "o.vtu", "--size", "0.1")
    assert ran.status == 3
    assert "report" in ran.err


def test_every_measure_that_steers_does_so_in_a_metric(meshopt, tmp_path):
    path, sol = made(tmp_path, tri_grid, 8)
    for name, measure in QUALITIES.items():
        if measure.drives:
            before, after = both(
                meshopt, path, tmp_path / "o.mesh", "--metric", sol, "--measure", name
            )
            assert after["measure"] == name
            assert after["edges"]["tau"] > before["edges"]["tau"]
