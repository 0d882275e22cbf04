"""Small files to start from: every format and encoding, with all that they may hold."""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from meshopt_cli.formats import FORMATS, write
from support import vtkfiles
from support.encodings import ENCODINGS, name_of, plane, tagged, tets, zoo
from support.gmsh import Builder, two_tets
from support.meshes import tet_grid

Seed = tuple[str, bytes]  # the ending of a file, and what is in it


@cache
def seeds() -> dict[str, Seed]:
    """By name; some of each kind are compressed, too."""
    with tempfile.TemporaryDirectory() as folder:
        found = {**dict(_ours(Path(folder))), **dict(_gmsh()), **dict(_by_vtk(Path(folder)))}
    for name in list(found)[::5]:
        ending, data = found[name]
        found[f"{name}-gz"] = (f"{ending}.gz", gzip.compress(data, mtime=0))
    return found


def _ours(folder: Path) -> Iterator[tuple[str, Seed]]:
    """What we write: mixed cells, one of each type, the plane, and a mesh to work on."""
    for encoding in ENCODINGS:
        ending = FORMATS[encoding.format].extensions[0]
        path = folder / f"mesh{ending}"
        for name, mesh in (("tets", tets()), ("zoo", zoo()), ("plane", plane()),
                           ("cube", tet_grid(1))):  # fmt: skip
            write(path, tagged(mesh, encoding), encoding)
            yield f"{name_of(encoding)}-{name}", (ending, path.read_bytes())


def _gmsh() -> Iterator[tuple[str, Seed]]:
    """Every version, with groups, periodic sides, partitions and views."""
    for version in ("1", "2.0", "2.2", "3", "4.0", "4.1"):
        for binary in (False, True):
            for order in "<>" if binary else "<":
                if binary and version in ("1", "3", "4.0"):
                    continue
                builder = Builder(version, binary, order)
                whole = two_tets(builder)
                if builder.version >= 2:
                    affine = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
                    link = (0, 1, 1, affine if builder.version >= 2.2 else [], [(1, 2)])
                    whole += builder.periodic(link)
                    whole += builder.view("NodeData", "T", {1: 1.0, 2: 0.5, 5: 2.0}, 0.5, 3)
                    whole += builder.view("ElementData", "s", {2: [1.0] * 9, 3: [0.5] * 9})
                if builder.version > 4:
                    row = (3, 1, 3, 1, [1, 2], [7])
                    whole += builder.partitioned(2, [(1, 1)], row)
                kind = f"gmsh-{version}-{'binary' + order if binary else 'text'}"
                yield kind, (".msh", whole)


def _by_vtk(folder: Path) -> Iterator[tuple[str, Seed]]:
    """Every data set and every way to put it down."""
    random = np.random.default_rng(1)
    for kind, (make, writer, ending) in vtkfiles.KINDS.items():
        data = make(random)
        path = folder / "mesh.vtk"
        for version in (42, 51):
            for binary in (False, True):
                vtkfiles.write_legacy(path, data, version, binary)
                yield f"vtk-{kind}-{version}-{binary}", (".vtk", path.read_bytes())
        path = folder / f"mesh.{ending}"
        for mode in (0, 1, 2):
            for compressor in (0, 1, 3) if mode else (0,):
                big, wide, encoded = (bool(bit) for bit in random.integers(0, 2, 3))
                vtkfiles.write_xml(path, data, writer, mode, compressor, wide, big, encoded)
                yield f"{ending}-{mode}-{compressor}", (f".{ending}", path.read_bytes())
