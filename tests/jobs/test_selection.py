"""Work on some cells alone: all others stay as they are, to the last bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import BadMeshError, ConfigError, UnsupportedMeshError
from meshopt_cli.jobs.admission import InvalidMeshError
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.jobs.optimize_mesh import Task, kind_of
from meshopt_cli.jobs.quality_arrays import Q, with_quality
from meshopt_cli.jobs.selection import RINGS, frozen_by
from meshopt_cli.mesh.model import Mesh, top_blocks
from meshopt_cli.plans.config import Request, Selection, plan_for
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import check
from support.curved import of_second_order
from support.edits import shaken
from support.meshes import hex_grid, quad_grid, tet_grid
from support.samples import SAMPLES

KINDS = ["triangles", "tetrahedra", "regions", "mixed", "hexahedra"]
every_kind = pytest.mark.parametrize("kind", KINDS)


@pytest.fixture
def meshes(tmp_path):
    """A mesh of a kind in a file, with room for improvement everywhere."""

    def make(kind):
        if kind in ("triangles", "regions"):
            name = {"triangles": "grid.vtk", "regions": "two_regions.msh"}[kind]
            return SAMPLES / name
        mesh = {
            "tetrahedra": lambda: shaken(tet_grid(4), 0.25, 1),
            "mixed": lambda: shaken(quad_grid(8), 0.3, 1),
            "hexahedra": lambda: shaken(hex_grid(5), 0.25, 1),
        }[kind]()
        path = tmp_path / "in.vtk"
        formats.write(path, mesh, formats.FORMATS["vtk"].default)
        return path

    return make


def middle(mesh: Mesh) -> float:
    """A place that cells lie on both sides of."""
    return float(np.median(mesh.points[:, 0]))


def cells_of(mesh: Mesh, masks) -> set:
    """Cells by the bits of their corners, in their order."""
    return {
        (block.type, mesh.points[cell].tobytes())
        for block, mask in zip(top_blocks(mesh), masks, strict=True)
        for cell in block.cells[mask]
    }


def every_cell(mesh: Mesh) -> set:
    return cells_of(mesh, [np.ones(len(b.cells), bool) for b in top_blocks(mesh)])


def optimized(path, tmp_path, **request):
    output = tmp_path / f"out{path.suffix}"
    done = optimize_file(FileTask(path, output, Task(Request(**request))))
    return done, formats.read(output)[0]


@every_kind
@pytest.mark.parametrize("preset", ["fast", "standard", "best"])
def test_what_is_frozen_stays_to_the_last_bit(kind, preset, meshes, tmp_path):
    path = meshes(kind)
    before = formats.read(path)[0]
    box = f":{middle(before)!r},:"
    done, after = optimized(path, tmp_path, preset=preset, freeze=(box,))
    plan = plan_for(Request(), before.dimension(), kind_of(before))
    frozen = frozen_by(Selection(freeze=(box,)), before, plan.measure)
    staying = cells_of(before, frozen.masks)
    assert 0 < len(staying) < len(every_cell(before))
    assert staying <= every_cell(after)
    assert every_cell(after) != every_cell(before)
    assert check(after).is_valid
    assert done.result.after.mean < done.result.before.mean
    n = sum(len(block.cells) for block in top_blocks(after))
    assert done.result.after.n_cells == n


@every_kind
def test_only_and_freeze_of_the_rest_are_the_same(kind, meshes, tmp_path):
    path = meshes(kind)
    x = middle(formats.read(path)[0])
    _, one = optimized(path, tmp_path, preset="fast", only=(f":{x!r},:",))
    _, other = optimized(
        path, tmp_path, preset="fast", freeze=(f"{float(np.nextafter(x, np.inf))!r}:,:",)
    )
    np.testing.assert_array_equal(one.points, other.points)


@every_kind
def test_below_works_around_what_is_worse(kind, meshes, tmp_path):
    path = meshes(kind)
    before = formats.read(path)[0]
    plan = plan_for(Request(), before.dimension(), kind_of(before))
    blocks = top_blocks(with_quality(before, plan.measure))
    q = np.sort(np.concatenate([block.data[Q] for block in blocks]))
    below = float(q[-2])
    selection = Selection(below=below)
    frozen = frozen_by(selection, before, plan.measure)
    near = np.zeros(len(before.points), bool)
    for block in blocks:
        near[block.cells[block.data[Q] > below]] = True
    for _ in range(RINGS):
        worked = [near[block.cells].any(axis=1) for block in blocks]
        for block, mask in zip(blocks, worked, strict=True):
            near[block.cells[mask]] = True
    for mask, wanted in zip(frozen.masks, worked, strict=True):
        np.testing.assert_array_equal(mask, ~wanted)
    _, after = optimized(path, tmp_path, preset="fast", below=below)
    assert cells_of(before, frozen.masks) <= every_cell(after)


def test_nothing_worse_leaves_the_mesh_as_it_is(meshes, tmp_path, caplog):
    path = meshes("tetrahedra")
    done, after = optimized(path, tmp_path, below=1e6)
    assert every_cell(after) == every_cell(formats.read(path)[0])
    assert "no cell is selected" in caplog.text
    assert done.result.lines == ()


def test_all_selected_is_as_none(meshes, tmp_path):
    path = meshes("tetrahedra")
    _, one = optimized(path, tmp_path, preset="fast", only=(":,:,:",))
    _, other = optimized(path, tmp_path, preset="fast")
    np.testing.assert_array_equal(one.points, other.points)


def test_regions_and_groups_by_name_and_number():
    mesh = formats.read(SAMPLES / "two_regions.msh")[0]
    measure = MEASURES["aspect-ratio"]
    names = {name: (d, tag) for (d, tag), name in mesh.names.items()}
    top = {name: tag for name, (d, tag) in names.items() if d == mesh.dimension()}
    assert top
    for name, tag in top.items():
        one = frozen_by(Selection(only=(name,)), mesh, measure)
        for again in (str(tag), f"{mesh.dimension()}:{name}"):
            other = frozen_by(Selection(only=(again,)), mesh, measure)
            for a, b in zip(one.masks, other.masks, strict=True):
                np.testing.assert_array_equal(a, b)
        assert frozen_by(Selection(only=tuple(top)), mesh, measure) is None


def test_a_group_of_faces_stands_for_the_cells_at_it():
    mesh = formats.read(SAMPLES / "two_regions.msh")[0]
    lower = [name for (d, _), name in mesh.names.items() if d < mesh.dimension()]
    measure = MEASURES["aspect-ratio"]
    for name in lower:
        frozen = frozen_by(Selection(freeze=(name,)), mesh, measure)
        assert any(mask.any() for mask in frozen.masks)
        assert not frozen.is_all


def test_arrays_go_along(tmp_path):
    mesh = shaken(tet_grid(4), 0.25, 1)
    points = {"height": mesh.points[:, 2].copy()}
    blocks = [
        replace(b, data={"level": mesh.points[b.cells].mean(axis=1)[:, 2]}) for b in mesh.blocks
    ]
    path = tmp_path / "in.vtk"
    formats.write(
        path, replace(mesh, blocks=blocks, point_data=points), formats.FORMATS["vtk"].default
    )
    before = formats.read(path)[0]
    x = middle(before)
    _, after = optimized(path, tmp_path, only=(f":{x!r},:",))
    np.testing.assert_allclose(after.point_data["height"], after.points[:, 2], atol=0.5)
    kept = {}
    for block in top_blocks(before):
        kept |= {
            before.points[c].tobytes(): v
            for c, v in zip(block.cells, block.data["level"], strict=True)
        }
    n = 0
    for block in top_blocks(after):
        for cell, value in zip(block.cells, block.data["level"], strict=True):
            wanted = kept.get(after.points[cell].tobytes())
            if wanted is not None:
                assert value == wanted
                n += 1
    assert n > 0


@pytest.mark.parametrize("policy", ["slide"])
def test_the_boundary_may_slide_where_cells_are_worked_on(policy, meshes, tmp_path, capsys):
    path = meshes("tetrahedra")
    before = formats.read(path)[0]
    box = f":{middle(before)!r},:"
    output = tmp_path / "out.vtk"
    arguments = ["optimize", "-q", str(path), str(output), "--freeze", box, "--boundary", policy]
    assert status_of(arguments) == 0
    after = formats.read(output)[0]
    frozen = frozen_by(Selection(freeze=(box,)), before, MEASURES["aspect-ratio"])
    assert cells_of(before, frozen.masks) <= every_cell(after)
    assert check(after).is_valid


def test_a_metric_drives_what_is_selected(meshes, tmp_path):
    path = meshes("tetrahedra")
    before = formats.read(path)[0]
    box = f":{middle(before)!r},:"
    output = tmp_path / "out.vtk"
    assert (
        status_of(["optimize", "-q", str(path), str(output), "--freeze", box, "--size", "0.6"]) == 0
    )
    after = formats.read(output)[0]
    frozen = frozen_by(Selection(freeze=(box,)), before, MEASURES["aspect-ratio"])
    assert cells_of(before, frozen.masks) <= every_cell(after)
    assert len(every_cell(after)) != len(every_cell(before))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--only", "nobody"], "no cell is in a group 'nobody'"),
        (["--freeze", "7:8,7:8,7:8"], "the centre of no cell"),
        (["--below", "0.5"], "--below"),
        (["--only", ":0.5,:", "--keep-off", "boundary:0.1"], "--keep-off is for the whole mesh"),
        (["--only", ":0.5,:", "--passes", "repair,smooth"], "repair is for the whole mesh"),
    ],
)
def test_what_cannot_be_done_is_refused(options, said, meshes, tmp_path, capsys):
    path = meshes("tetrahedra")
    assert status_of(["optimize", str(path), str(tmp_path / "out.vtk"), *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "out.vtk").exists()


def test_meshes_of_second_order_are_refused(tmp_path):
    path = tmp_path / "in.vtk"
    formats.write(path, of_second_order(tet_grid(2)), formats.FORMATS["vtk"].default)
    with pytest.raises(UnsupportedMeshError, match="first order"):
        optimized(path, tmp_path, only=(":0.5,:",))


def test_a_mesh_that_is_none_is_refused(tmp_path):
    mesh = tet_grid(2)
    mesh.blocks[0].cells[0, 0] = 10_000
    path = tmp_path / "in.mesh"
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices 4", *("0 0 0 0",) * 4]
    path.write_text("\n".join([*lines, "Tetrahedra 1", "1 2 3 4 0", "End", ""]))
    for request in ({"below": 1.0}, {"only": (":0.5,:",)}):
        with pytest.raises(BadMeshError):
            optimized(path, tmp_path, **request)
    for selection in (Selection(below=1.0), Selection(only=(":0.5,:",))):
        with pytest.raises(InvalidMeshError, match="M00"):
            frozen_by(selection, mesh, MEASURES["aspect-ratio"])


def test_cells_that_stay_are_not_turned(tmp_path):
    mesh = tet_grid(3)
    cells = mesh.blocks[0].cells.copy()
    left = mesh.points[cells].mean(axis=1)[:, 0] < middle(mesh)
    cells[left] = cells[left][:, [1, 0, 2, 3]]
    path = tmp_path / "in.vtk"
    turned = replace(mesh, blocks=[replace(mesh.blocks[0], cells=cells)])
    formats.write(path, turned, formats.FORMATS["vtk"].default)
    with pytest.raises(BadMeshError, match="repair --orientation"):
        optimized(path, tmp_path, freeze=(f":{middle(mesh)!r},:",))


def test_a_file_may_select(tmp_path, meshes):
    path = meshes("tetrahedra")
    config = tmp_path / "a.toml"
    config.write_text('only = [":0.5,:"]\nbelow = 1.5\npreset = "fast"\n')
    assert plan_for(Request(config=config)).selection == Selection((":0.5,:",), (), 1.5)
    assert plan_for(Request(config=config, only=("a",))).selection.only == ("a",)
    config.write_text('only = "a"')
    with pytest.raises(ConfigError, match="only"):
        plan_for(Request(config=config))
    optimized(path, tmp_path, preset="fast", only=(":0.5,:",), below=1.5)


@pytest.mark.parametrize("kind", ["triangles", "tetrahedra"])
def test_numbers_of_cells_stay_their_own(kind, meshes, tmp_path):
    before = formats.read(meshes(kind))[0]
    first = 1
    for block in top_blocks(before):
        block.data["cell_id"] = np.arange(first, first + len(block.cells))
        first += len(block.cells)
    path = tmp_path / "numbered.vtk"
    formats.write(path, before, formats.FORMATS["vtk"].default)
    _, after = optimized(path, tmp_path, preset="standard", freeze=(f"{middle(before)!r}:,:",))
    numbers = np.concatenate([block.data["cell_id"] for block in top_blocks(after)])
    assert len(set(numbers.tolist())) == len(numbers)
    assert set(numbers.tolist()) != set(range(1, first))
