"""Any passes with any options on any small mesh: the domain stays, and no mesh gets worse.

Passes, options, their limits and the measures come from the tables of the package; what comes out
of the command line is judged by `support.domain`, which knows coordinates only.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, note
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.cli.main import status_of
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes import PASSES
from meshopt_cli.quality.measures import QUALITIES
from support.domain import TAG, Domain, assert_same_domain, assert_same_shape, assert_valid, worst_q
from support.files import write
from support.meshes import tet_grid, tri_grid
from support.planes import rotation
from support.settings import examples

DRIVING = [name for name, measure in QUALITIES.items() if measure.drives]
# Of an option without an upper limit, or with one that takes long, up to so many times more than
# its least and its default.
WIDE = 3
ROUNDING = {False: 1e-9, True: 1e-6}  # by whether coordinates are single


# Meshes --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Recipe:
    """A small mesh: a box, or one without a corner, of triangles or tets.

    Attributes
    ----------
    n : int
        Cells of its grid along each axis.
    amount : float
        How far vertices move, over the distance between them, those of the boundary and of plane
        interfaces within these.
    regions : {"one", "halves", "corner", "layers", "many"}
        Two or three with plane interfaces, or three at random cell by cell.
    declared : tuple of str
        What is declared of "sides", "parts of sides", "some sides", inner "facets", "edges" and
        "vertices".
    stretch : float
        Factor of the last coordinate.
    place : {"as it is", "other plane", "tilted"}
    single : bool
        Whether coordinates are of single precision.
    tangled : bool
        Whether a vertex is thrown across the cells around it.
    """

    dimension: int
    n: int
    seed: int = 0
    amount: float = 0.0
    notched: bool = False
    regions: str = "one"
    declared: tuple[str, ...] = ()
    stretch: float = 1.0
    place: str = "as it is"
    single: bool = False
    tangled: bool = False


DECLARED = ["sides", "parts of sides", "some sides", "facets", "edges", "vertices"]
recipes = {
    dimension: st.builds(
        Recipe,
        dimension=st.just(dimension),
        n=st.sampled_from([1, 2, 3, 4, 5, 6] if dimension == 2 else [1, 2, 3, 3, 3]),
        seed=st.integers(0, 2**16),
        amount=st.sampled_from([0.0, 0.5, 1.0, 1.5]),
        notched=st.booleans(),
        regions=st.sampled_from(["one", "halves", "corner", "layers", "many"]),
        declared=st.lists(
            st.sampled_from(DECLARED),
            unique=True, max_size=3,
        ).map(tuple),
        stretch=st.sampled_from([1.0, 0.3]),
        place=st.sampled_from(["as it is", "other plane", "tilted"]),
        single=st.booleans(),
        tangled=st.sampled_from([False, False, False, True]),
    )
    for dimension in (2, 3)
}  # fmt: skip


def content(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.linalg.det(edges)


def made(recipe):
    """The mesh of a recipe, and the directions to measure it in."""
    d, n = recipe.dimension, recipe.n
    random = np.random.default_rng(recipe.seed)
    grid = tri_grid(n) if d == 2 else tet_grid(n)
    points, (block,) = grid.points, grid.blocks
    cells = block.cells
    # Squares or cubes of the grid: what is cut by them has plane sides and hangs by no vertex.
    box = np.floor(points[cells].mean(axis=1) * n)
    if recipe.notched and n > 1:
        kept = ~(box[:, :2] >= n / 2).all(axis=1)
        cells, box = cells[kept], box[kept]
    tags = regions_of(recipe, box, random)
    skin = boundary(cells)
    moved = random.uniform(-recipe.amount / n, recipe.amount / n, points.shape)
    flat = [boundary(cells[tags == tag]) for tag in np.unique(tags)]
    moved *= ~held(points, skin if recipe.regions == "many" else np.concatenate(flat))
    while (bad := content(points + moved, cells) < 0.02 / n**d).any():
        moved[cells[bad]] *= 0.5
    points = points + moved
    inner = np.setdiff1d(cells, skin)
    if recipe.tangled and len(inner):
        points[random.choice(inner)] += random.uniform(-1, 1, d) * 1.5 / n
    points[:, -1] *= recipe.stretch
    blocks = [Block(block.type, cells, {TAG: tags})]
    blocks += declarations(recipe, cells, skin, random)
    points, axes = placed(recipe, points)
    return Mesh(points.astype(np.float32 if recipe.single else np.float64), blocks), axes


def boundary(cells):
    """Facets that have one cell only."""
    facets = np.concatenate([np.delete(cells, k, axis=1) for k in range(cells.shape[1])])
    rows, times = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    return rows[times == 1]


def held(points, skin):
    """Which coordinates a vertex keeps to stay on its sides, (np, d) of bool."""
    keeps = np.zeros(points.shape, dtype=bool)
    for facet in skin:
        for axis in np.flatnonzero(np.ptp(points[facet], axis=0) == 0):
            keeps[facet, axis] = True
    return keeps


def regions_of(recipe, box, random):
    """A tag for each cell, from the square or the cube of the grid that it is in."""
    n = recipe.n
    return {
        "one": lambda: np.ones(len(box), dtype=int),
        "halves": lambda: 1 + (box[:, 0] >= n / 2),
        "corner": lambda: 1 + (box >= n / 2).all(axis=1),
        "layers": lambda: 1 + box[:, -1].astype(int),
        "many": lambda: random.integers(1, 4, len(box)),
    }[recipe.regions]()


def declarations(recipe, cells, skin, random):
    """Blocks of cells of lower dimension, each with a tag of its own."""
    every = np.concatenate([np.delete(cells, k, axis=1) for k in range(cells.shape[1])])
    facets = np.unique(np.sort(every, axis=1), axis=0)
    inside = np.array([f for f in facets if not (skin == f).all(axis=1).any()])
    lines = [[a, b] for cell in cells for k, a in enumerate(cell) for b in cell[:k]]
    edges = np.unique(np.sort(lines, axis=1), axis=0)
    kind = "line" if recipe.dimension == 2 else "triangle"
    chosen = []
    if "sides" in recipe.declared:
        chosen.append((kind, skin, 11))
    elif "parts of sides" in recipe.declared:
        low = skin.mean(axis=1) < skin.mean()  # vertices are numbered along the first axis
        chosen += [(kind, skin[low], 16), (kind, skin[~low], 17)]
    elif "some sides" in recipe.declared:
        chosen.append((kind, skin[random.random(len(skin)) < 0.5], 12))
    if "facets" in recipe.declared and len(inside):
        chosen.append((kind, inside[random.random(len(inside)) < 0.1], 13))
    if "edges" in recipe.declared and recipe.dimension == 3:
        chosen.append(("line", edges[random.random(len(edges)) < 0.1], 14))
    if "vertices" in recipe.declared:
        chosen.append(("vertex", random.choice(np.unique(cells), 2, replace=False)[:, None], 15))
    return [Block(k, rows, {TAG: np.full(len(rows), t)}) for k, rows, t in chosen if len(rows)]


def placed(recipe, points):
    """Points in space, and the axes they had before."""
    d = recipe.dimension
    if recipe.place == "as it is":
        return points, np.eye(3)[:d]
    axes = rotation(recipe.seed)[:d] if recipe.place == "tilted" else np.eye(3)[[2, 0, 1][:d]]
    return points @ axes, axes


# Pipelines -----------------------------------------------------------------------------------


def values(option):
    """Any value that an option may have, the ends of its range more often."""
    least, most = option.metadata["least"], option.metadata["most"]
    if option.metadata["choices"]:
        return st.sampled_from(option.metadata["choices"])
    low = option.default if least is None else least
    high = WIDE * max(low, option.default, 1)
    if isinstance(option.default, int):
        return st.integers(low, high if most is None else min(most, high))
    high = high if most is None else min(most, high)
    return st.sampled_from([float(low), float(high)]) | st.floats(low, high).map(
        lambda x: round(x, 3)
    ).filter(lambda x: low <= x <= high)


def a_pass(kind):
    """A table of a pipeline file: a pass with some of its options."""
    options = {f.name: values(f) for f in fields(kind)}
    return st.fixed_dictionaries({"name": st.just(kind.name)}, optional=options)


passes = st.one_of([a_pass(kind) for kind in PASSES.values()])


@st.composite
def pipelines(draw, tangled):
    """The text of a pipeline file."""
    keys = {
        "measure": draw(st.sampled_from(DRIVING)),
        "rounds": draw(st.integers(1, 3)),
        "gain": draw(st.sampled_from([0.0, 0.02, 0.5])),
        "target-quality": draw(st.sampled_from([1.0, 2.0, 10.0])),
    }
    before = [{"name": "untangle"}] if tangled and draw(st.booleans()) else []
    before += draw(st.lists(passes, max_size=1))
    tables = [("before", t) for t in before]
    tables += [("pass", t) for t in draw(st.lists(passes, min_size=not before, max_size=3))]
    lines = [said(key, value) for key, value in keys.items()]
    for where, table in tables:
        lines += ["", f"[[{where}]]", *(said(key, value) for key, value in table.items())]
    return "\n".join(lines) + "\n", keys["measure"]


def said(key, value):
    return f"{key} = " + (f'"{value}"' if isinstance(value, str) else str(value))


# What comes out ------------------------------------------------------------------------------


def run(one, pipeline, boundary, folder):
    """Optimize in this process; gives the status, what was said, and the mesh if there is one."""
    path = write(folder / "in.vtu", one)
    (folder / "pipeline.toml").write_text(pipeline)
    output = folder / "out.vtu"
    told = io.StringIO()
    arguments = ["optimize", path, output, "--config", folder / "pipeline.toml", "-q"]
    with contextlib.redirect_stderr(told):
        status = status_of([*map(str, arguments), "--boundary", boundary])
    return status, told.getvalue(), formats.read(output)[0] if output.exists() else None


def check_run(recipe, pipeline, measure, boundary):
    """Run a pipeline on a mesh, and judge what comes out."""
    one, axes = made(recipe)
    with tempfile.TemporaryDirectory() as folder:
        status, told, result = run(one, pipeline, boundary, Path(folder))
    before = Domain(one, axes)
    if status == 1:
        assert worst_volume(before) <= 0, told
        assert result is None
        return
    assert status == 0, told
    after = Domain(result, axes)
    assert result.points.dtype == one.points.dtype
    assert_valid(after)
    if boundary == "fixed":
        assert_same_domain(before, after)
    else:
        assert_same_shape(before, after, ROUNDING[recipe.single])
    if worst_volume(before) > 0:
        least = worst_q(before.part, measure)
        assert worst_q(after.part, measure) >= least * (1 - ROUNDING[recipe.single])


def worst_volume(of):
    return content(of.part.points, of.part.cells).min()


@pytest.mark.parametrize("boundary", ["fixed", "slide"])
@pytest.mark.parametrize("dimension", [2, 3])
@examples(100)
@given(data=st.data())
def test_any_pipeline(dimension, boundary, data):
    """Boundary, interfaces and volumes stay, cells are positive, and the worst Q does not rise."""
    recipe = data.draw(recipes[dimension])
    pipeline, measure = data.draw(pipelines(recipe.tangled))
    note(
        f"check_run({recipe!r}, pipeline, {measure!r}, {boundary!r}) with the pipeline\n{pipeline}"
    )
    check_run(recipe, pipeline, measure, boundary)
