"""Many meshes, each optimized from file to file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import EXIT_BAD_MESH, EXIT_DONE, EXIT_FILES, EXIT_INVARIANT, MeshoptError
from ..files.ending import note_written
from ..reports.model import Report
from ..reports.verdict import Verdict
from .optimize_file import FileTask, optimize_file
from .optimize_mesh import InvalidFileError
from .pool import each


@dataclass(frozen=True)
class Outcome:
    """What came of one mesh.

    Attributes
    ----------
    status : int
        As if it had been the only one.
    report : Report, optional
        Where it was optimized.
    error : str
        One line: why nothing is written.
    verdict : Verdict, optional
        What makes it invalid.
    """

    input: Path
    output: Path
    status: int
    report: Report | None = None
    error: str = ""
    verdict: Verdict | None = None


def optimize_one(path: Path, task: FileTask) -> Outcome:
    """Optimize a mesh; what goes wrong is told in the outcome."""
    try:
        done = optimize_file(task)
    except InvalidFileError as error:
        return Outcome(path, task.output, error.exit_status, None, str(error), error.verdict)
    except MeshoptError as error:
        return Outcome(path, task.output, error.exit_status, None, str(error))
    except MemoryError:
        return Outcome(path, task.output, EXIT_FILES, None, f"{path}: out of memory")
    except Exception as error:  # the others are to go on
        name = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
        return Outcome(path, task.output, EXIT_INVARIANT, None, f"{path}: internal error ({name})")
    if done.written is None:
        worst = f"the worst Q stays at {done.result.after.worst:.4g}, above {task.fail_above:g}"
        return Outcome(
            path, task.output, EXIT_BAD_MESH, done.report, f"{path}: {worst}: nothing written"
        )
    return Outcome(path, task.output, EXIT_DONE, done.report)


def optimize_all(
    tasks: Sequence[FileTask], jobs: int | None, set_up: Callable[[int], None], verbosity: int
) -> Iterator[Outcome]:
    """What comes of each of many meshes, in their order; see `pool.each`."""
    pairs = [(task.input, task) for task in tasks]
    return each(pairs, optimize_one, _killed, jobs, set_up, verbosity, _note)


def _note(one: Outcome) -> None:
    """Note that the result is there, which another process wrote."""
    if one.status == EXIT_DONE:
        note_written(one.output)


def _killed(path: Path, task: FileTask, error: str) -> Outcome:
    return Outcome(path, task.output, EXIT_FILES, None, error)
