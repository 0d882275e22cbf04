"""Any passes with any options on any small mesh: the domain stays, and no mesh gets worse.

Passes, options, their limits and the measures come from the tables of the package; what comes out
of the command line is judged by `support.domain`, which knows coordinates only.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given, note
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from meshopt_cli.passes import PASSES
from meshopt_cli.quality.measures import QUALITIES
from support.domain import Domain, assert_same_domain, assert_same_shape, assert_valid, worst_q
from support.files import write
from support.recipes import Recipe, content, made
from support.settings import examples

DRIVING = [name for name, measure in QUALITIES.items() if measure.drives]
# Of an option without an upper limit, or with one that takes long, up to so many times more than
# its least and its default.
WIDE = 3
ROUNDING = {False: 1e-9, True: 1e-6}  # by whether coordinates are single


# Meshes --------------------------------------------------------------------------------------


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


passes = st.one_of([a_pass(kind) for kind in PASSES.values() if not kind.needs_metric])


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


# What was found here once, or is as small as what was.
ONCE = {
    "plane interfaces": (
        Recipe(3, 3, 1, 0.5, notched=True, regions="layers", stretch=0.3, single=True),
        ["swap"],
    ),
    "facets between two parts of a side": (
        Recipe(3, 2, 959, 1.5, notched=True, regions="corner", declared=("some sides",)),
        ["swap"],
    ),
    "edges across a side": (
        Recipe(3, 3, 1, 1.5, notched=True, regions="halves",
               declared=("edges", "vertices", "facets"), place="other plane"),
        ["swap"],
    ),
    "ends of lines": (
        Recipe(3, 2, 1, 0.5, declared=("sides", "parts of sides", "edges")),
        ["smooth"],
    ),
    "check of a tangle": (Recipe(2, 2, 3, tangled=True), ["check", "untangle"]),
}  # fmt: skip


@pytest.mark.parametrize("boundary", ["fixed", "slide"])
@pytest.mark.parametrize("name", ONCE)
def test_what_was_found_once(name, boundary):
    recipe, steps = ONCE[name]
    pipeline = "gain = 0\n" + "".join(f'[[pass]]\nname = "{step}"\n' for step in steps)
    check_run(recipe, pipeline, "aspect-ratio", boundary)
