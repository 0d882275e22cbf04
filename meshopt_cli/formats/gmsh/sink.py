"""Numbers on their way into a section of a Gmsh file, as text or in binary."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from ...mesh.model import Array
from ..text import lines

_CHUNK = 1 << 16  # rows at a time, which bounds the memory it takes


class Sink:
    """Writes numbers of the kinds "i4", "u8" and "f8" to a file.

    Raises
    ------
    ValueError
        An integer does not fit into 32 bits where Gmsh has no more.
    """

    def __init__(self, f: BinaryIO, binary: bool) -> None:
        self._f, self.binary = f, binary

    def put(self, *parts: tuple[str, ArrayLike]) -> None:
        """Write a few numbers, on one line of text."""
        flat = [np.ravel(_fitting(kind, np.asarray(values))) for kind, values in parts]
        if self.binary:
            made = zip(parts, flat, strict=True)
            self._f.write(b"".join(v.astype("<" + kind).tobytes() for (kind, _), v in made))
        else:
            texts = [str(value) for values in flat for value in values.tolist()]
            self._f.write((" ".join(texts) + "\n").encode())

    def rows(self, *columns: tuple[str, Array]) -> None:
        """Write rows that stand side by side, (n,) or (n, k) arrays, one a line of text."""
        arrays = [_fitting(kind, values) for kind, values in columns]
        if not self.binary:
            self._f.writelines(lines(*arrays))
            return
        tables = [values if values.ndim == 2 else values[:, None] for values in arrays]
        fields = enumerate(zip(columns, tables, strict=True))
        row = np.dtype([(f"f{i}", "<" + kind, (t.shape[1],)) for i, ((kind, _), t) in fields])
        for start in range(0, len(tables[0]), _CHUNK):
            some = [table[start : start + _CHUNK] for table in tables]
            records = np.empty(len(some[0]), row)
            for i, table in enumerate(some):
                records[f"f{i}"] = table
            self._f.write(records.tobytes())

    def end(self, section: str) -> None:
        """Write the last line of a section."""
        self._f.write(b"\n" * self.binary + f"$End{section}\n".encode())


def _fitting(kind: str, values: Array) -> Array:
    if kind == "i4" and values.size:
        greatest = max(int(values.max()), -int(values.min()) - 1)
        if greatest >= 1 << 31:
            raise ValueError(f"Gmsh has no room for a tag or number of {greatest}: 32 bits")
    return values
