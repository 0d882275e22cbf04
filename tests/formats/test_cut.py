"""Files that are cut off: refused, or read with a warning, or nothing of them is missing."""

import logging
import re

import numpy as np
import pytest

from fuzz.seeds import seeds
from meshopt_cli.errors import ReadError
from meshopt_cli.formats import read
from support.encodings import warnings_of

CUTS = 25  # places of each file
# Where a section of Gmsh or VTK may start: up to there a file is whole, as far as that can be told.
SECTION = re.compile(rb"\s*(\$[A-Z]\w+|[A-Z][A-Z_]{4,}\b)")


def held(mesh):
    """All that a mesh holds, to be compared."""
    blocks = [
        (b.type, b.cells.tolist(), {k: np.asarray(v).tolist() for k, v in b.data.items()})
        for b in mesh.blocks
    ]
    arrays = {k: v.tolist() for k, v in mesh.point_data.items()}
    return repr((mesh.points.tolist(), blocks, arrays, sorted(mesh.fields), mesh.names))


@pytest.mark.parametrize("name", [name for name in seeds() if not name.endswith("-gz")])
def test_nothing_is_lost_in_silence(tmp_path, caplog, name):
    ending, data = seeds()[name]
    path = tmp_path / f"mesh{ending}"
    path.write_bytes(data)
    whole = held(read(path)[0])
    dice = np.random.default_rng(len(data))
    for size in sorted({len(data) - 1, *dice.integers(0, len(data), CUTS).tolist()}):
        if SECTION.match(data, size):
            continue
        path.write_bytes(data[:size])
        caplog.clear()
        with caplog.at_level(logging.WARNING):
            try:
                mesh = read(path)[0]
            except ReadError:
                continue
        said = [one for one in warnings_of(caplog) if "cut" in one or "truncated" in one]
        assert said or held(mesh) == whole, f"{size} of {len(data)} bytes"
