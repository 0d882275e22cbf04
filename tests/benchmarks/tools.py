"""The tools that `peers.py` compares: how each is found, run, and read back."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata, util
from pathlib import Path

import native
from judge import Part
from meshopt_cli import __version__

CHILD = Path(__file__).with_name("child.py")
# How tools say what the optimization took.
SECONDS = r'(?:"optimize":|, optimize|LIB: ELAPSED TIME|Optimization seconds:)\s*([\d.e-]+)'


@dataclass
class Job:
    """A mesh to optimize: where it came from, what it is, and a folder to work in.

    Attributes
    ----------
    folder : Path
        Of all tools; what one wrote is gone before the next runs.
    ready : set of str
        Names of the files there that tools read.
    """

    source: Path
    part: Part
    plane: native.Plane | None
    folder: Path
    ready: set[str] = field(default_factory=set)

    def prepared(self, name: str, write: Callable[[Path, Part], None]) -> Path:
        """The mesh in another kind of file, which is written once."""
        path = self.folder / name
        if name not in self.ready:
            write(path, self.part)
            self.ready.add(name)
        return path

    def clear(self) -> None:
        """Remove the files that tools wrote: none may be taken for that of another."""
        stems = {Path(name).stem for name in self.ready}
        for path in self.folder.iterdir():
            if path.name.partition(".")[0] not in stems or ".1." in path.name:
                path.unlink()


class Tool(ABC):
    """A tool that optimizes meshes, run with certain arguments."""

    dimensions: tuple[int, ...] = (3,)

    def __init__(self, *arguments: str) -> None:
        self.arguments = arguments

    @abstractmethod
    def version(self) -> str | None:
        """Name and version, or None where it is not installed."""

    @abstractmethod
    def command(self, job: Job) -> list[str]:
        """The command line, for which the files it reads are written."""

    @abstractmethod
    def result(self, job: Job) -> Part:
        """Read what the command wrote."""

    def optimize(self, log: str) -> float | None:
        """Seconds of the optimization alone, from what the command printed."""
        found = re.findall(SECONDS, log)
        return float(found[-1]) if found else None


class Meshopt(Tool):
    """This project, on the file as it is, to the same format."""

    dimensions = (2, 3)

    def version(self) -> str:
        return f"meshopt {__version__}"

    def command(self, job: Job) -> list[str]:
        start = [sys.executable, "-m", "meshopt_cli", "optimize"]
        return [*start, str(job.source), str(self._target(job)), *self.arguments]

    def result(self, job: Job) -> Part:
        return native.read_any(self._target(job), job.plane)[0]

    def _target(self, job: Job) -> Path:
        return job.folder / f"meshopt-out{''.join(job.source.suffixes[-2:])}"


class Gmsh(Tool):
    """Gmsh's own optimizer through its Python module: how often, and the threshold."""

    def version(self) -> str | None:
        return _package("gmsh", "gmsh", "Gmsh")

    def command(self, job: Job) -> list[str]:
        source = job.prepared("gmsh.msh", native.write_gmsh)
        return _child("gmsh", source, job.folder / "gmsh-out.msh", *self.arguments)

    def result(self, job: Job) -> Part:
        return native.read_any(job.folder / "gmsh-out.msh")[0]


class Mmg(Tool):
    """Mmg's programs, which remesh: the counts change."""

    def __init__(self, program: str, dimension: int, *arguments: str) -> None:
        super().__init__(*arguments)
        self.program, self.dimensions = program, (dimension,)

    def version(self) -> str | None:
        program = self._path()
        return program and _printed(program, "-h", r"Release ([\d.]+)", "Mmg")

    def command(self, job: Job) -> list[str]:
        source = job.prepared("mmg.mesh", native.write_medit)
        target = job.folder / "mmg-out.mesh"
        return [str(self._path()), "-v", "1", *self.arguments, str(source), str(target)]

    def result(self, job: Job) -> Part:
        return native.read_medit(job.folder / "mmg-out.mesh", *self.dimensions)

    def _path(self) -> str | None:
        # What the package puts on the path is a script around the program it brings.
        spec = util.find_spec("mmgpy")
        for folder in spec.submodule_search_locations if spec else []:
            path = Path(folder) / "bin" / f"{self.program}_O3"
            if path.exists():
                _libraries(Path(folder) / "lib")
                return str(path)
        return shutil.which(f"{self.program}_O3") or shutil.which(self.program)


class Netgen(Tool):
    """Netgen's optimizer of volumes through its Python module: a strategy, in three steps."""

    def version(self) -> str | None:
        return _package("netgen", "netgen-mesher", "Netgen")

    def command(self, job: Job) -> list[str]:
        source = job.prepared("netgen.vol", native.write_netgen)
        return _child("netgen", source, job.folder / "netgen-out.vol", *self.arguments)

    def result(self, job: Job) -> Part:
        return native.read_netgen(job.folder / "netgen-out.vol")


class Tetgen(Tool):
    """TetGen, which mends a mesh it reads (-r) when it is told how far to go (-O)."""

    def version(self) -> str | None:
        program = shutil.which("tetgen")
        return program and _printed(program, "-h", r"Version ([\d.]+)", "TetGen")

    def command(self, job: Job) -> list[str]:
        source = job.prepared("tetgen.node", native.write_tetgen)
        return [str(shutil.which("tetgen")), *self.arguments, str(source)]

    def result(self, job: Job) -> Part:
        return native.read_tetgen(job.folder / "tetgen.1.node")


TOOLS: dict[str, Tool] = {
    "meshopt-fast": Meshopt("--preset", "fast"),
    "meshopt-standard": Meshopt("--preset", "standard"),
    "meshopt-best": Meshopt("--preset", "best"),
    "gmsh": Gmsh("1", "0.3"),
    "gmsh-x5": Gmsh("5", "1"),
    "mmg3d": Mmg("mmg3d", 3, "-optim", "-nosurf"),
    "mmg3d-noinsert": Mmg("mmg3d", 3, "-optim", "-nosurf", "-noinsert"),
    "netgen": Netgen("smsm"),
    "netgen-default": Netgen("cmdmustm"),
    "tetgen": Tetgen("-rYqS0O9/7o/140"),
    "mmg2d": Mmg("mmg2d", 2, "-optim", "-nosurf"),
}


def _child(*words: str | Path) -> list[str]:
    return [sys.executable, str(CHILD), *map(str, words)]


def _package(module: str, distribution: str, title: str) -> str | None:
    return f"{title} {metadata.version(distribution)}" if util.find_spec(module) else None


@cache
def _printed(program: str, option: str, pattern: str, title: str) -> str:
    # One of them ends by an exception, with what it printed still in its buffer.
    command = [*(["stdbuf", "-o0"] if shutil.which("stdbuf") else []), program, option]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(pattern, told.stdout + told.stderr)
    return f"{title} {found[1].rstrip('.')}" if found else title


def _libraries(folder: Path) -> None:
    """Let programs of a package find the libraries beside them."""
    known = os.environ.get("LD_LIBRARY_PATH", "")
    if str(folder) not in known.split(os.pathsep):
        os.environ["LD_LIBRARY_PATH"] = f"{folder}{os.pathsep}{known}".rstrip(os.pathsep)
