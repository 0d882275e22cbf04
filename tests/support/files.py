"""Mesh files: written, measured, and watched."""

import contextlib
import json

import numpy as np

from meshopt_cli import formats
from meshopt_cli.formats import encoding_for
from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality.measures import DEFAULT_MEASURE, QUALITIES, cell_quality


def write(path, one, encoding=None):
    formats.write(path, one, encoding or encoding_for(path))
    return path


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@contextlib.contextmanager
def untouched(folder):
    """Prove that no file comes, goes or changes, temporary ones included."""
    before = contents(folder)
    yield
    after = contents(folder)
    changed = sorted(n for n in {*before, *after} if before.get(n) != after.get(n))
    assert not changed, f"{', '.join(map(str, changed))} in {folder}"


def worst_of(path, measure=DEFAULT_MEASURE):
    simplices = cast(formats.read(path)[0])
    q = cell_quality(simplices.points, simplices.cells, QUALITIES[measure])
    return 1.0 / q.min() if q.min() > 0 else np.inf


def strict(text):
    """Read JSON as the standard has it, without NaN and Infinity."""

    def refuse(constant):
        raise ValueError(constant)

    return json.loads(text, parse_constant=refuse)


def fail(error):
    """A function that raises this, whatever it is called with."""

    def failing(*_, **__):
        raise error

    return failing
