"""Compile kernels ahead, in several processes at once.

numba compiles in one thread of a process. A first run would wait twice as long without this;
later runs find the machine code in the cache. Only the groups of kernels that a run needs are
compiled before it; `python -m meshopt_cli.warmup` compiles all of them by hand.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import sys
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from . import kernels
from .cells import FAMILIES
from .compiled import cache, ways
from .compiled.decorators import Entry
from .cores import n_cores
from .errors import EXIT_DONE, MeshoptError
from .files.ending import ended_by
from .kernels.operators.lbfgs import Memory
from .kernels.shape.distortion import Body
from .kernels.shape.simplex import ASPECT_RATIO
from .kernels.steiner.net import Goal, Net
from .kernels.types import N_VERDICTS, CellMesh, Judge, Scratch, SimplexMesh
from .mesh.any_cells import AnyCells
from .mesh.cast import Simplices
from .mesh.facets import CellSet
from .work.cells import mesh_of
from .work.foldover import body_of, memory_for
from .work.session import Workspace
from .work.steiner import net_of

Array = np.ndarray

# The groups of kernels, and how long they take to compile, in any unit; the longest first.
GROUPS: dict[str, float] = {
    "mend": 15,
    "steiner": 4,
    "split": 3,
    "constrained": 3,
    "relax": 3,
    "basic": 2.5,
    "collapse": 2.5,
    "swap": 2.5,
    "relocation": 2,
    "odt": 2,
    "cells": 2,
    "global": 1.5,
    "nonobtuse": 2,
    "fit": 2,
    "check": 1,
    "blocks": 0.5,
}


class Specimen(NamedTuple):
    """A tetrahedron to be worked on, and what else the examples of kernels are made of.

    One is enough: all kernels have the same types on every mesh.
    """

    mesh: SimplexMesh
    cell_mesh: CellMesh
    scratch: Scratch
    order: Array  # (0,) int64: nothing to visit
    facets: Array  # (1, 3) int64
    vertex_values: Array  # (4,) float64
    counts: Array  # (N_VERDICTS,) int64
    body: Body
    memory: Memory
    net: Net
    goal: Goal


def specimen() -> Specimen:
    """The smallest working mesh."""
    work = Workspace(
        Simplices(
            points=np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
            cells=np.array([[0, 1, 2, 3]]),
            region=np.zeros(1, dtype=np.int64),
            fixed=np.zeros(4, dtype=bool),
            facets=np.empty((0, 3), np.int64),
            edges=np.empty((0, 2), np.int64),
            frame=None,
            single=False,
            turned=False,
        ),
        Judge(ASPECT_RATIO, 0.0),
    )
    body = body_of(work.mesh.points, work.mesh.cells, np.eye(3)[None], np.zeros(1, np.int64))
    return Specimen(
        work.mesh,
        _cell_mesh(),
        work.scratch,
        order=np.empty(0, dtype=np.int64),
        facets=np.array([[0, 1, 2]]),
        vertex_values=np.zeros(4),
        counts=np.zeros(N_VERDICTS, dtype=np.int64),
        body=body,
        memory=memory_for(body, 4),
        net=net_of(
            work.mesh.points,
            work.mesh.cells[:1, :3].copy(),
            np.zeros(1, np.int64),
            np.ones((1, 3), bool),
            np.ones(4, bool),
            np.empty(0, np.int64),
            0,
            0,
        ),
        goal=Goal(work.judge, 0.0, 0.0, 0.0, 0.0, 0.0, 0, False),
    )


def _cell_mesh() -> CellMesh:
    """The smallest working mesh of any cells."""
    cell = FAMILIES["hexahedron"].reference
    cells = CellSet("hexahedron", np.arange(len(cell))[None], np.zeros(1, np.int64))
    return mesh_of(
        AnyCells(
            cell,
            [cells],
            np.ones(len(cell), bool),
            np.zeros(1, np.int64),
            np.zeros(1, bool),
            np.empty((0, 2), np.int64),
            None,
            False,
        ),
        Judge(ASPECT_RATIO, 0.0),
    )


def entries() -> list[Entry]:
    """All kernels that Python calls, by module."""
    found = []
    for place in pkgutil.walk_packages(kernels.__path__, f"{kernels.__name__}."):
        module = importlib.import_module(place.name)
        found += [
            value
            for value in vars(module).values()
            if isinstance(value, Entry) and value.__module__ == place.name
        ]
    return found


def shares_of(groups: Iterable[str], n_shares: int) -> list[list[str]]:
    """The groups of each process: one goes to the process that has the least to do."""
    shares: list[list[str]] = [[] for _ in range(n_shares)]
    wanted = set(groups)
    for group in GROUPS:
        if group in wanted:
            min(shares, key=lambda share: sum(GROUPS[g] for g in share)).append(group)
    return [share for share in shares if share]


def compile_here(groups: Iterable[str]) -> None:
    """Compile some groups in this process."""
    work = specimen()
    all_ = entries()
    for group in groups:
        for entry in all_:
            if entry.group == group and entry.example is not None:
                entry.prepare(*entry.example(work))
        ways.note(group)


def compile_groups(groups: Iterable[str]) -> None:
    """Fill the cache with what is missing of some groups, on as many cores as there are.

    A process that fails is no harm: what it did not compile is compiled when it is needed.
    """
    shares = shares_of(ways.missing(groups), n_cores())
    if not shares:
        return
    environment = {**os.environ, "MESHOPT_CACHE_DIR": str(cache.folder().parent)}
    helpers = [
        subprocess.Popen(
            [sys.executable, "-m", "meshopt_cli.warmup", *share],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for share in shares[1:]
    ]

    def end() -> None:
        for helper in helpers:
            helper.kill()

    try:
        with ended_by(end):
            for share in shares[:1]:
                compile_here(share)
            for helper in helpers:
                helper.wait()
    finally:
        end()


def main(groups: list[str]) -> int:
    """Compile some groups in this process, or what is missing of all; the exit status."""
    try:
        if groups:
            compile_here(groups)
        else:
            compile_groups(GROUPS)
    except MeshoptError as error:
        print(f"meshopt: {error}", file=sys.stderr)
        return error.exit_status
    return EXIT_DONE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
