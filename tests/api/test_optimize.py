"""`optimize` as a function: what the command line makes, on whatever a mesh comes as."""

import inspect
import os
import subprocess
import sys

import meshio
import numpy as np
import pytest
import pyvista

import meshopt_cli as meshopt
from meshopt_cli.boundary.policy import Slide
from meshopt_cli.cli.entry import status_of
from meshopt_cli.cli.optimize import command
from meshopt_cli.plans.presets import PRESETS
from support.samples import SAMPLES

# What is about a terminal and the files of a command, and so no keyword of the function.
OF_COMMANDS = {"engine", "scheduler", "meshes",
               "output", "to", "output_dir", "jobs", "in_place", "reports", "as_json",
               "quiet", "verbose", "file_format", "binary", "metric_out", "log_file", "no_config",
               "show_config", "keep_best"}  # fmt: skip
FILES = ("grid.vtk", "raw_ball.mesh", "plate.vtu", "quadtree.vtk", "two_regions.msh")


def tets():
    mesh = meshio.read(SAMPLES / "grid.vtk")
    return mesh.points.astype(float), mesh.cells_dict["tetra"].astype(np.int64)


def alike(a, b):
    return np.array_equal(a.points, b.points) and all(
        np.array_equal(one.cells, other.cells)
        for one, other in zip(a.blocks, b.blocks, strict=True)
    )


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("preset", PRESETS)
def test_bytes_are_those_of_the_command_line(tmp_path, capsys, name, preset):
    one, two = tmp_path / "one.vtu", tmp_path / "two.vtu"
    options = {"preset": preset, **({"size": "0.5"} if preset == "adapt" else {})}
    flags = [word for key, value in options.items() for word in (f"--{key}", value)]
    assert status_of(["optimize", str(SAMPLES / name), str(one), *flags]) == 0
    meshopt.optimize(SAMPLES / name, **options).write(two)
    assert one.read_bytes() == two.read_bytes()


def test_options_are_those_of_the_command_line():
    """By their names and defaults, and none is missing."""
    flags = {p.name: p for p in command.params} | {"metric": None, "size": None}
    keywords = inspect.signature(meshopt.optimize).parameters
    for name, flag in flags.items():
        if name in OF_COMMANDS:
            continue
        keyword = {"settings": "set", "regions": "region"}.get(name, name)
        assert keyword in keywords, name
        default = None if flag is None else flag.default
        if isinstance(default, float | str | bool):
            assert keywords[keyword].default == default
    assert keywords["slide_tolerance"].default == Slide().tolerance
    assert "optimize" in meshopt.__all__
    for name in keywords:
        assert name in meshopt.optimize.__doc__


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        ({"rounds": 0}, "rounds: 0 is out of range"),
        ({"time_limit": "soon"}, "time_limit"),
        ({"fail_above": 0.5}, "fail_above"),
        ({"slide_tolerance": 2}, "slide_tolerance"),
        ({"preset": "bset"}, "best"),
        ({"boundary": "slid"}, "slide"),
        ({"set": {"smooth.methd": "laplace"}}, "method"),
        ({"gradation": 1.3}, "goes with"),
        ({"metric": np.ones(3), "size": "1"}, "exclude"),
        ({"metric": np.ones(3)}, "3"),
        ({"config": "none.toml"}, "none.toml"),
        ({"passes": "smoth"}, "smooth"),
        ({"allow": "M999"}, "M999"),
        ({"region": "none"}, "none"),
    ],
)
def test_what_is_wrong_is_said(wrong, what):
    with pytest.raises(meshopt.MeshoptError, match=what) as caught:
        meshopt.optimize(tets(), **wrong)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("given", [7, None, "none.vtu", (np.ones(3), 2), (np.ones((2, 2)),)])
def test_what_is_no_mesh_is_refused(given):
    with pytest.raises(meshopt.MeshoptError):
        meshopt.optimize(given)


def test_the_kind_that_was_given_comes_back():
    points, cells = tets()
    plain = meshopt.optimize((points, cells)).mesh
    assert isinstance(plain, tuple)
    typed = meshopt.optimize((points, {"tetra": cells})).mesh
    paired = meshopt.optimize([points, [("tetra", cells)]]).mesh
    ours = meshopt.optimize(meshio.Mesh(points, {"tetra": cells})).mesh
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: cells}, points)
    theirs = meshopt.optimize(grid).mesh
    assert type(theirs) is pyvista.UnstructuredGrid
    found = [plain[1], typed[1]["tetra"], paired[1][0][1], ours.cells_dict["tetra"]]
    found.append(theirs.cells_dict[pyvista.CellType.TETRA])
    for rows in found:
        assert np.array_equal(rows, found[0])
    for places in (typed[0], paired[0], ours.points, theirs.points):
        assert np.array_equal(places, plain[0])
    read = meshopt.optimize(SAMPLES / "grid.vtk").mesh
    assert isinstance(read, meshopt.Mesh)
    assert alike(meshopt.optimize(meshopt.read(SAMPLES / "grid.vtk")).mesh, read)


def test_what_was_given_stays():
    points, cells = tets()
    kept = points.copy(), cells.copy()
    assert meshopt.optimize((points, cells)).after.worst < 10
    assert np.array_equal(points, kept[0])
    assert np.array_equal(cells, kept[1])


def test_arrays_that_need_no_change_are_not_copied():
    points, cells = tets()
    cells = np.ascontiguousarray(cells, np.int64)
    result = meshopt.optimize((points, cells), passes="check")
    assert np.shares_memory(result.mesh[0], points)
    assert np.shares_memory(result.mesh[1], cells)


def test_too_bad_a_result_is_an_error_that_has_it():
    with pytest.raises(meshopt.BadMeshError, match=r"above 1\.01") as caught:
        meshopt.optimize(tets(), fail_above=1.01)
    assert caught.value.result.after.worst > 1.01


def test_an_invalid_mesh_is_refused():
    points, cells = tets()
    cells = cells.copy()
    cells[3] = cells[3][::-1][[1, 0, 2, 3]]
    moved = points.copy()
    moved[cells[5, 0]] += 100.0
    with pytest.raises(meshopt.BadMeshError, match=r"M10|untangled"):
        meshopt.optimize((moved, cells))


def test_a_metric_of_arrays_drives():
    points, cells = tets()
    sizes = np.full(len(points), 0.7)
    result = meshopt.optimize((points, cells), metric=sizes)
    before, after = result.facts.metric, result.facts.metric_after
    assert after.edges.tau > before.edges.tau
    assert result.metric.shape == (len(result.mesh[0]),)
    assert np.allclose(result.metric, 0.7)
    tensors = np.tile([1 / 0.49, 1 / 0.49, 1 / 0.49, 0, 0, 0], (len(points), 1))
    again = meshopt.optimize((points, cells), metric=tensors)
    assert again.facts.metric_after.edges.tau > before.edges.tau


def test_forms():
    result = meshopt.optimize(tets(), preset="fast")
    assert "worst Q" in repr(result)
    assert "\n" not in repr(result)
    assert "<pre>" in result._repr_html_()
    for text in (result.to_text(), result.to_json(), result.to_csv(), result.to_markdown()):
        assert f"{result.after.worst:.3g}"[:3] in text
    assert "<html" in result.to_html()


def test_a_page_is_written(tmp_path):
    result = meshopt.optimize(tets(), preset="fast")
    page = result.to_html(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text("utf-8") == page


def test_it_is_imported_at_once(tmp_path):
    """Nothing heavy comes with the functions, only with a call; numpy does not count."""
    code = (
        "import sys, time, numpy\n"
        "start = time.process_time()\n"
        "import meshopt_cli as meshopt\n"
        "meshopt.optimize, meshopt.read, meshopt.check, meshopt.Result, meshopt.tqdm_progress\n"
        "print(time.process_time() - start)\n"
        "print({'numba', 'meshio', 'rich', 'tqdm', 'click', 'pyvista'} & set(sys.modules))\n"
    )
    times = []
    env = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    env["PYTHONPYCACHEPREFIX"] = str(tmp_path)  # the first run fills it
    for _ in range(6):
        ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                             check=True, env=env)  # fmt: skip
        time, modules = ran.stdout.splitlines()
        assert modules == "set()"
        times.append(float(time))
    assert min(times) < 0.1  # 0.03 on a machine that does nothing else


def test_every_public_name_is_there():
    for name in meshopt.__all__:
        assert getattr(meshopt, name).__doc__
    assert set(meshopt.__all__) < set(dir(meshopt))
    with pytest.raises(AttributeError):
        _ = meshopt.no_such_name
