"""The check of many files: what there is to do for each, and in which process."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..cells import family_of
from ..errors import EXIT_BAD_MESH, EXIT_DONE, EXIT_FILES, ConfigError, MeshoptError
from ..files.places import require_places
from ..mesh.model import Mesh, top_blocks
from ..quality.gates import FIGURES, IN_METRIC, Gates
from ..quality.measures import DEFAULT_MEASURE, measure_named
from ..reports.verdict import Verdict
from ..validity import Report, check, choose
from ..validity.jacobian import not_looked_at
from .admission import READABLE, require_range
from .findings import verdict_on
from .pool import each
from .regions import with_asked_regions

if TYPE_CHECKING:
    from ..formats import Source
    from .metric import Asked

# Limits that stand for one measure in the plane and another in space: one of them is idle.
PAIRED = ("M402",)
JACOBIAN = "M105"  # the rule that does not know all types of cells
LARGE = 5 << 20  # bytes of a file that may hold more cells than numpy alone deals with

log = logging.getLogger("meshopt")


@dataclass(frozen=True)
class Task:
    """What to look for in every file, and how much to tell."""

    select: tuple[str, ...]
    ignore: tuple[str, ...]
    extend: tuple[str, ...]
    gates: Gates
    tolerance: float | None
    limit: int | None
    mark: Path | None = None
    verbosity: int = 0
    regions: tuple[str, ...] = ()
    input_format: str | None = None
    max_size: int | None = None
    asked: Asked | None = None

    def require_metric(self) -> None:
        """Refuse gates in a metric without one, and a metric without such gates.

        Raises
        ------
        ConfigError
        """
        named = [limit.name for limit in self.gates.of_mesh]
        if named and self.asked is None:
            raise ConfigError(f"a gate on {named[0]} needs a metric: add --metric or --size")
        if self.asked is not None and not named:
            raise ConfigError(
                f"a metric is of no use here without a --gate on {', '.join(FIGURES)}"
            )

    @property
    def checked(self) -> tuple[str, ...]:
        """Codes of the rules that are looked for."""
        extend = (*self.extend, *self.gates.codes)
        return tuple(rule.code for rule in choose(self.select, self.ignore, extend))

    def require_mark(self, files: list[Path]) -> None:
        """Refuse to mark what is found in several files, over the mesh, or where it cannot be.

        Raises
        ------
        ConfigError, WriteError
        """
        if self.mark is None:
            return
        from .. import formats

        if len(files) > 1:
            raise ConfigError("--mark goes with one mesh")
        formats.encoding_for(self.mark)
        path = None if self.asked is None else self.asked.path
        require_places([self.mark], [*files, *([path] if path else [])])


def needs_kernels(files: Iterable[Path], gates: Gates) -> bool:
    """Whether compiled code will be called: for measures, and for large meshes."""
    measures = [limit.measure for limit in gates.limits]
    if gates.of_mesh:
        measures.append(measure_named(gates.measure or DEFAULT_MEASURE))
    if any(measure.is_compiled for measure in measures):
        return True
    return any(path.is_file() and path.stat().st_size > LARGE for path in files)


def examine(path: Path, task: Task) -> Verdict:
    """Read one file and look for all that makes it invalid."""
    from .. import formats

    try:
        mesh, source = formats.read(path, task.input_format, task.max_size)
    except MeshoptError as error:
        return Verdict(str(path), error.exit_status, error=str(error))
    try:
        return examine_mesh(mesh, source, task)
    except MeshoptError as error:
        text = str(error)
        named = (task.mark and str(task.mark) in text) or text.startswith(f"{path}: ")
        return Verdict(str(path), error.exit_status, error=text if named else f"{path}: {text}")


def examine_mesh(mesh: Mesh, source: Source, task: Task) -> Verdict:
    """Look for all that makes a mesh invalid.

    Raises
    ------
    ConfigError, ReadError, BadMeshError, UnsupportedMeshError, WriteError
        The mesh lacks what the task is about, or its marks cannot be written.
    """
    checked = task.checked
    mesh = with_asked_regions(source.path, mesh, task.regions)
    report: Report = check(
        mesh,
        task.select,
        task.ignore,
        task.gates,
        extend=task.extend,
        tolerance=task.tolerance,
        figures=_figures(mesh, source, task),
    )
    if task.mark is not None:
        from .marking import write_marks

        write_marks(task.mark, source, mesh, report)
    _warn_of_idle_gates(source.path, mesh, task.gates)
    if JACOBIAN in checked:
        _warn_of_unknown_cells(source.path, mesh)
    status, error = (EXIT_DONE if report.is_valid else EXIT_BAD_MESH), ""
    if mesh.dimension() < 0:
        status, error = EXIT_BAD_MESH, f"{source.path}: no cells to check"
    return verdict_on(source.path, source, mesh, report, status, checked, task.limit, error)


def _figures(mesh: Mesh, source: Source, task: Task) -> dict[str, float]:
    """What a mesh is in the metric, none where nobody asks or its cells have no shape.

    Raises
    ------
    ConfigError, ReadError, BadMeshError, UnsupportedMeshError
        See `jobs.metric.judge_by` and `quality.measurable`.
    """
    if task.asked is None or IN_METRIC not in task.checked or mesh.dimension() < 0:
        return {}
    if not check(mesh, READABLE).is_valid:
        return {}
    from ..metric.summary import figures_of
    from ..quality.measurable import measurable
    from .metric import judge_by

    require_range(mesh)
    measure = measure_named(task.gates.measure or DEFAULT_MEASURE)
    judged = judge_by(task.asked, mesh, source, measurable(mesh), measure, task.max_size)
    return figures_of(judged.summary)


def _warn_of_idle_gates(path: Path, mesh: Mesh, gates: Gates) -> None:
    """Say which limits are on a measure that no cell of the mesh has."""
    types = {block.type for block in top_blocks(mesh)}
    families = {family.name if (family := family_of(t)) else t for t in types}
    named = {limit.name: limit for limit in gates.limits if limit.code not in PAIRED}
    for name, limit in named.items():
        if families and not families & set(limit.measure.ways):
            kinds = ", ".join(sorted(families))
            log.warning("%s: no gate on %s holds for cells of type %s", path, name, kinds)


def _warn_of_unknown_cells(path: Path, mesh: Mesh) -> None:
    """Say in one line which cells are looked at in part, or not at all."""
    said: dict[bool, list[str]] = {True: [], False: []}
    for kind, n in not_looked_at(mesh).items():
        said[family_of(kind) is not None].append(f"{kind} ({n:,})")
    if said[True]:
        kinds = ", ".join(said[True])
        log.warning("%s: of cells of type %s only the corners are looked at", path, kinds)
    if said[False]:
        kinds = ", ".join(said[False])
        log.warning("%s: cells of type %s are not looked at: it is unknown", path, kinds)


def examine_all(
    paths: list[Path], task: Task, jobs: int | None, set_up: Callable[[int], None]
) -> Iterator[Verdict]:
    """Verdicts on all files in their order, from as many processes as it is worth.

    Parameters
    ----------
    set_up : callable
        Called first in every process, with the verbosity: it says where the log goes.
    """
    tasks = [(path, task) for path in paths]
    return each(tasks, examine, _killed, jobs, set_up, task.verbosity)


def _killed(path: Path, task: Task, error: str) -> Verdict:
    return Verdict(str(path), EXIT_FILES, error=error)
