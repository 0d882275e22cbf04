"""The folder that a run in pieces works in: what is done is there, and need not be done again."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import formats
from ..errors import WriteError, reason
from ..formats import FORMATS
from ..mesh.model import Array, Mesh

# Pieces on the way are written fast, and read once or twice.
_ON_THE_WAY = replace(FORMATS["vtu"].default, compressed=False)
_JOB = "job.json"


@dataclass(frozen=True)
class Store:
    """Pieces and facts by turn and name.

    Attributes
    ----------
    folder : Path
        That all who work on the mesh can write to.
    """

    folder: Path

    def place(self, turn: int, name: str) -> Path:
        return self.folder / f"turn{turn}" / name

    def begin(self, job: dict[str, Any]) -> bool:
        """Make the folder ready; returns whether some of the same job is done already.

        Raises
        ------
        WriteError
            It cannot be made, or has what no run in pieces wrote.
        """
        try:
            before = self.job()
            if before == job:
                return True
            if before is None and self.folder.exists() and any(self.folder.iterdir()):
                raise WriteError(
                    f"{self.folder}: it has other files in it, and a run needs this folder: name "
                    "another OUTPUT"
                )
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir()
            self._write(self.folder / _JOB, job)
        except OSError as error:
            raise WriteError(f"{self.folder}: cannot be written: {reason(error)}") from error
        return False

    def job(self) -> dict[str, Any] | None:
        """What the folder is for; None where it is for nothing."""
        return self._read(self.folder / _JOB)

    def facts(self, turn: int, name: str) -> dict[str, Any] | None:
        """What a step that is done said; None where it is not."""
        return self._read(self.place(turn, f"{name}.json"))

    def say(self, turn: int, name: str, facts: dict[str, Any]) -> None:
        """Note that a step is done: all that it wrote is there."""
        self._write(self.place(turn, f"{name}.json"), facts)

    def put(self, turn: int, name: str, mesh: Mesh) -> None:
        """Write a mesh."""
        path = self.place(turn, f"{name}.vtu")
        path.parent.mkdir(exist_ok=True)
        formats.write(path, mesh, _ON_THE_WAY)

    def get(self, turn: int, name: str) -> Mesh:
        """Read a mesh that `put` wrote."""
        return formats.read(self.place(turn, f"{name}.vtu"))[0]

    def put_array(self, turn: int, name: str, values: Array) -> None:
        path = self.place(turn, f"{name}.npy")
        path.parent.mkdir(exist_ok=True)
        np.save(path, values)

    def array(self, turn: int, name: str) -> Array:
        values: Array = np.load(self.place(turn, f"{name}.npy"))
        return values

    def keep(self, turn: int, name: str, later: int, new_name: str) -> None:
        """Have a file in a later turn as well, under another name, unless it is dropped already."""
        if not self.place(turn, name).exists():
            return
        new = self.place(later, new_name)
        new.parent.mkdir(exist_ok=True)
        new.unlink(missing_ok=True)
        try:
            os.link(self.place(turn, name), new)
        except OSError:  # not on all systems of files
            shutil.copyfile(self.place(turn, name), new)

    def remove(self) -> None:
        """Nothing of it is needed any more."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def drop(self, turn: int) -> None:
        """Meshes of a turn are not needed any more; what was said of them is."""
        for path in self.folder.glob(f"turn{turn}/*.vtu"):
            path.unlink()

    @staticmethod
    def _read(path: Path) -> dict[str, Any] | None:
        try:
            value: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return value

    @staticmethod
    def _write(path: Path, value: dict[str, Any]) -> None:
        path.parent.mkdir(exist_ok=True)
        new = path.with_suffix(f".{os.getpid()}")
        new.write_text(json.dumps(value), encoding="utf-8")
        new.replace(path)
