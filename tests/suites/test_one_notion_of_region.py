"""One notion of region: `check`, `report` and `optimize` mean the same by it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.cells import FAMILIES
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.tags import FLAGS, MAX_LABELS, TAG_NAMES, tags_of, with_regions
from meshopt_cli.validity import check
from support.meshes import hex_grid, mesh, tet_grid, tri_grid

GRIDS = {"triangle": tri_grid(4), "tetra": tet_grid(2)}


def parts_of(of, region):
    """How many parts each region has, by walking from cell to cell through common facets."""
    cells = np.concatenate([block.cells for block in of.blocks])
    (table,) = FAMILIES[of.blocks[0].type].facets
    beside: dict[frozenset, list[int]] = {}
    for number, cell in enumerate(cells.tolist()):
        for facet in table.tolist():
            beside.setdefault(frozenset(cell[k] for k in facet), []).append(number)
    near = {k: set() for k in range(len(cells))}
    for both in beside.values():
        if len(both) == 2 and region[both[0]] == region[both[1]]:
            near[both[0]].add(both[1])
            near[both[1]].add(both[0])
    parts = np.zeros(int(region.max()) + 1, dtype=int)
    left = set(near)
    while left:
        waiting = [left.pop()]
        parts[region[waiting[0]]] += 1
        while waiting:
            here = near[waiting.pop()] & left
            left -= here
            waiting += here
    return parts


def scattered(of):
    """How many regions M213 says have several parts."""
    return sum(len(group) for group in check(of, ["M213"]).groups)


@st.composite
def tagged(draw):
    """A grid in one block or two, with arrays of which some make regions."""
    grid = GRIDS[draw(st.sampled_from(sorted(GRIDS)))]
    (block,) = grid.blocks
    n = len(block.cells)
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cut = draw(st.sampled_from([0, n // 3]))
    rows = [slice(0, cut), slice(cut, n)] if cut else [slice(0, n)]
    blocks = [Block(block.type, block.cells[part]) for part in rows]
    names = st.sampled_from([*TAG_NAMES, *FLAGS, "material", "number", "zone"])
    for name in draw(st.lists(names, max_size=3, unique=True)):
        most = draw(st.sampled_from([1, 2, 3, 2 * MAX_LABELS]))
        kind = draw(st.sampled_from([np.int64, np.int32, np.uint8, np.float64]))
        shape = draw(st.sampled_from([(n,), (n, 1)] if name not in FLAGS else [(n,)]))
        values = random.integers(0, most, shape).astype(kind)
        if most > MAX_LABELS and values.ndim == 1:
            values[: MAX_LABELS + 1] = np.arange(MAX_LABELS + 1)[:n]
        for own, part in zip(blocks, rows, strict=True):
            if draw(st.integers(0, 4)) < 4:
                own.data[name] = values[part]
    return Mesh(grid.points, blocks)


@given(tagged())
def test_regions_of_check_and_of_optimize(of):
    region = cast(of).region
    if tags_of(of.blocks):
        assert scattered(of) == np.count_nonzero(parts_of(of, region) > 1)
    else:
        assert region.max() == 0
        assert scattered(of) == 0


@given(tagged(), st.data())
def test_named_regions_of_check_and_of_optimize(of, data):
    fit = [n for n in ("material", "zone", *TAG_NAMES) if all(n in b.data for b in of.blocks)]
    if not fit:
        with pytest.raises(ConfigError, match="'material'"):
            with_regions(of, ("material",))
        return
    name = data.draw(st.sampled_from(fit))
    named = with_regions(of, (name,))
    alone = replace(of, blocks=[replace(b, data={name: b.data[name]}) for b in of.blocks])
    region = cast(named).region
    assert len(np.unique(region)) == len(
        np.unique(np.concatenate([b.data[name] for b in of.blocks]))
    )
    assert scattered(named) == np.count_nonzero(parts_of(alone, region) > 1)


def test_any_array_with_few_whole_numbers_makes_regions():
    """Two of three layers have one number: `optimize` keeps what is between them."""
    grid = hex_grid(3)
    (block,) = grid.blocks
    block.data["material"] = (np.arange(27) // 9) % 2
    assert scattered(grid) == 1
    block.data["material"] = np.arange(27) // 9
    assert scattered(grid) == 0


# The command line -----------------------------------------------------------------------


@pytest.fixture
def layers(tmp_path):
    """A cube with two arrays: the layers of `one` hang together, those of `two` do not."""
    grid = tet_grid(3)
    (block,) = grid.blocks
    layer = (grid.points[block.cells].mean(axis=1)[:, 0] * 3).astype(np.int64)
    block.data = {"one": layer, "two": layer % 2}
    path = tmp_path / "layers.vtu"
    formats.write(path, grid, formats.encoding_for(path))
    return path


def run(capsys, *args):
    status = status_of([*map(str, args)])
    return status, capsys.readouterr()


def counts(capsys, *args):
    status, said = run(capsys, "check", "--format", "json", "--no-config", *args)
    assert status == 0
    return json.loads(said.out)["files"][0]["counts"]


def test_region_of_check(capsys, layers):
    assert "M213" not in counts(capsys, layers)  # by both arrays each layer is one region
    assert counts(capsys, layers, "--region", "two") == {"M213": 1}
    assert "M213" not in counts(capsys, layers, "--region", "one")
    assert "M213" not in counts(capsys, layers, "--region", "one", "--region", "two")


def test_region_of_check_in_the_configuration(capsys, layers, monkeypatch):
    (layers.parent / "meshopt.toml").write_text('[check]\nregion = ["two"]\n')
    monkeypatch.chdir(layers.parent)
    status, said = run(capsys, "check", layers.name)
    assert status == 0
    assert "M213" in said.out


def test_region_of_report(capsys, layers):
    """Interfaces are boundary: what they allow is the target."""
    grid, source = formats.read(layers)
    inner = np.flatnonzero(np.abs(grid.points - 1 / 3).max(axis=1) < 0.1)
    grid.points[inner, 1] = 0.65  # thin faces on one interface, none on the boundary
    (block,) = grid.blocks
    block.data["none"] = np.zeros_like(block.data["one"])
    formats.write(layers, grid, source.encoding)
    targets = {}
    for name in ("one", "none"):
        status, said = run(capsys, "report", "--format", "json", "--region", name, layers)
        assert status == 0
        targets[name] = json.loads(said.out)["before"]["target"]
    assert targets["one"] > 1.01 * targets["none"]


@pytest.mark.parametrize("command", ["check", "report", "optimize"])
def test_an_unknown_array_is_named_with_what_there_is(capsys, layers, command):
    output = [layers.with_name("out.vtu")] * (command == "optimize")
    status, said = run(capsys, command, "--region", "thre", layers, *output)
    assert status == 2
    assert "no array 'thre' of numbers on all cells: choose from one, two" in said.err


def test_arrays_of_all_families(tmp_path, capsys):
    """`check` takes meshes that cannot be optimized."""
    both = mesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], quad=[[0, 1, 2, 3]], triangle=[[1, 4, 2]])
    for block in both.blocks:
        block.data["part"] = np.array([len(block.type)])
    path = tmp_path / "both.vtu"
    formats.write(path, both, formats.encoding_for(path))
    assert counts(capsys, path, "--region", "part") == {}
    status, said = run(capsys, "check", "--region", "other", path)
    assert status == 2
    assert "choose from part" in said.err
