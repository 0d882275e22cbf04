"""The commands as functions: optimize, check, report and repair.

A mesh is a path, a `Mesh`, a `meshio.Mesh`, a `pyvista.UnstructuredGrid` or `PolyData`, or
`(points, cells)`: see `formats.memory.held`. What is given stays as it is. Options have the names,
the defaults and the ranges that they have on the command line; what belongs to a command's terminal
and files alone is left out. Errors are `MeshoptError` with one line for people.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import BadMeshError, ConfigError
from .meshes import AnyMesh, taken
from .options import Names, metric_of, names_of, numbers_in, settings_of, words_of
from .results import Appraisal, Repaired, Report, Result

if TYPE_CHECKING:
    import numpy as np

    from ..progress.observer import Observer
    from ..progress.watch import Progress

log = logging.getLogger("meshopt")


def optimize(
    mesh: AnyMesh,
    *,
    preset: str | None = None,
    passes: Names | None = None,
    config: str | os.PathLike[str] | None = None,
    set: Mapping[str, object] | Names = (),
    only: Names = (),
    freeze: Names = (),
    below: float | None = None,
    measure: str | None = None,
    metric: str | np.ndarray | None = None,
    size: Names | None = None,
    gradation: float | None = None,
    size_min: float | None = None,
    size_max: float | None = None,
    rounds: int | None = None,
    target_quality: float | None = None,
    time_limit: float | None = None,
    threads: int | None = None,
    fail_above: float | None = None,
    region: Names = (),
    allow: Names | None = None,
    boundary: str = "fixed",
    slide_tolerance: float = 1e-6,
    keep_off: Names = (),
    no_data: bool = False,
    write_quality: bool = False,
    input_format: str | None = None,
    max_size: int | None = None,
    all_measures: bool = False,
    progress: Callable[[Progress], object] | None = None,
) -> Result:
    """Optimize a mesh.

    The boundary, the interfaces between regions and the declared facets stay exactly as they are,
    the result is never worse than the input, and arrays go along.

    Parameters
    ----------
    mesh : mesh of any kind
        A path, a `Mesh`, a `meshio.Mesh`, a `pyvista.UnstructuredGrid` or `PolyData`, or
        `(points, cells)`.
    preset : str, optional
        "fast", "standard", "best" or another of `meshopt list presets`.
    passes : names, optional
        Passes to run in rounds instead, such as "smooth,swap".
    config : path, optional
        A pipeline in a TOML file instead.
    set : mapping, or names, optional
        Options of passes, such as ``{"smooth.method": "laplace"}``.
    only, freeze : words, optional
        Cells to work on alone, or to leave as they are: groups by name or number, or boxes such as
        "0:1,0:1,0:0.5".
    below : float, optional
        Work only around cells that are worse than this Q, 1 at least.
    measure : str, optional
        What quality is, 1 for the ideal cell: see `meshopt list measures`.
    metric : str or (np,) or (np, k) array, optional
        Drive the mesh by a metric: a file (.sol, .solb), an array of the points by its name,
        "implied", or sizes (np,) or tensors (k = 3 or 4 in the plane, 6 or 9) in the order of VTK.
    size : formula, or several, optional
        Drive it by sizes, such as "0.01+0.19*x", or "steel=0.1" for a region or a group.
    gradation, size_min, size_max : float, optional
        What is made of the metric before: the greatest growth along an edge of length 1, from 1.01
        to 100, and the least and greatest size, in lengths of the mesh.
    rounds : int, optional
        At most so many.
    target_quality : float, optional
        Stop when no cell is worse than this Q, 1 at least.
    time_limit : float, optional
        Stop after so many seconds, with the best mesh so far.
    threads : int, optional
        How many work at once on a mesh of 100,000 tetrahedra and more; as many as there are cores
        without. The result is the same for any number.
    fail_above : float, optional
        Refuse the result where a cell stays worse than this Q, 1 at least.
    region : names, optional
        Arrays of the cells that make regions, instead of all tags.
    allow : names, optional
        Codes of rules that the mesh breaks on purpose, such as "M202".
    boundary : str
        "fixed", "slide" (its shape stays) or "split" (vertices are added).
    slide_tolerance : float
        Sine of the angle within which facets lie in one plane, from 0 to 1.
    keep_off : words, optional
        Places that vertices keep a distance from, such as "x=0.5:0.1".
    no_data : bool
        Drop all arrays but tags.
    write_quality : bool
        Arrays of an older run that tell of quality are no loss: `Result.write` makes them anew.
    input_format : str, optional
        See `read`.
    max_size : int, optional
        The most bytes that files may have.
    all_measures : bool
        Tell the worst Q by every measure in the result, and the angles that the boundary forces.
    progress : function of a `Progress`, optional
        Called at every stage and pass, and each half second between them; what it is given has
        `cancel()`. See `tqdm_progress` and `rich_progress`.

    Returns
    -------
    Result

    Raises
    ------
    ConfigError
        Something of the options is wrong.
    ReadError, UnsupportedMeshError
        The mesh cannot be read, or its cells cannot be optimized.
    BadMeshError
        It is not valid; or the result is worse than `fail_above`, and is the `result` of the error.

    Examples
    --------
    >>> import meshopt_cli as meshopt
    >>> result = meshopt.optimize("part.msh", preset="best")  # doctest: +SKIP
    >>> result.write("part.vtu")  # doctest: +SKIP
    """
    numbers_in({
        "rounds": rounds, "target_quality": target_quality, "time_limit": time_limit,
        "threads": threads,
        "fail_above": fail_above, "below": below, "slide_tolerance": slide_tolerance,
    })  # fmt: skip
    from ..jobs.optimize_file import named_in
    from ..jobs.optimize_mesh import accepted, optimize_mesh, task_of
    from ..progress.observer import SILENT, Stage
    from ..progress.watch import Watch

    given_task = accepted(
        task_of(
            boundary,
            slide_tolerance,
            preset=preset,
            passes=names_of(passes),
            config=None if config is None else Path(config),
            settings=settings_of(set),
            only=words_of(only),
            freeze=words_of(freeze),
            below=below,
            measure=measure,
            rounds=rounds,
            target_quality=target_quality,
            time_limit=time_limit,
            threads=threads,
            allow=names_of(allow),
            regions=words_of(region),
            keep_off=words_of(keep_off),
            no_data=no_data,
            write_quality=write_quality,
            all_measures=all_measures,
            max_size=max_size,
            metric=metric_of(
                metric, size, gradation=gradation, size_min=size_min, size_max=size_max
            ),
        )
    )
    observer: Observer = SILENT if progress is None else Watch(progress)
    observer.entered(Stage.READ)
    given = taken(mesh, input_format, max_size)
    done = optimize_mesh(given_task, given.mesh, given.source, observer, _compile)
    result = Result(named_in(done, given.source), given)
    if fail_above is not None and result.after.worst > fail_above:
        what = f"the worst Q stays at {result.after.worst:.4g}, above {fail_above:g}"
        error = BadMeshError(f"{given.source.path}: {what}")
        error.result = result  # type: ignore[attr-defined]
        raise error
    return result


def check(
    mesh: AnyMesh,
    *,
    select: Names = (),
    extend_select: Names = (),
    ignore: Names = (),
    fail_above: float | None = None,
    measure: str | None = None,
    min_angle: float | None = None,
    max_angle: float | None = None,
    min_size: float | None = None,
    max_aspect: float | None = None,
    gate: Names = (),
    metric: str | np.ndarray | None = None,
    size: Names | None = None,
    gradation: float | None = None,
    size_min: float | None = None,
    size_max: float | None = None,
    region: Names = (),
    tolerance: float | None = None,
    limit: int = 10,
    mark: str | os.PathLike[str] | None = None,
    input_format: str | None = None,
    max_size: int | None = None,
) -> Report:
    """Look for everything that makes a mesh invalid.

    Parameters
    ----------
    mesh : mesh of any kind
        See `optimize`.
    select, extend_select, ignore : names, optional
        Rules by their codes or prefixes of them: only these, these too, all but these.
    fail_above : float, optional
        A cell with a greater Q makes the mesh bad (M401), by `measure`.
    measure : str, optional
        See `optimize`.
    min_angle, max_angle : float, optional
        Limits of dihedral angles, or of those of faces in a plane, in degrees (M402).
    min_size : float, optional
        Least length of an edge (M403).
    max_aspect : float, optional
        Greatest aspect ratio (M404).
    gate : words, optional
        Other limits, such as "height-min>=0.1" or "dihedral-min>=10 @ steel" (M404).
    metric, size, gradation, size_min, size_max
        See `optimize`: what gates on "tau", "unit-edges" and others are in (M406).
    region : names, optional
        See `optimize`.
    tolerance : float, optional
        Points nearer than this part of the extent coincide, above 0 and at most 0.1.
    limit : int
        Findings of each rule that are listed; 0 lists all.
    mark : path, optional
        Where the cells and points that are found are written, with their codes.
    input_format, max_size
        See `read`.

    Returns
    -------
    Report
        True where the mesh is valid.

    Raises
    ------
    ConfigError
        Something of the options is wrong.
    ReadError, WriteError
        A file cannot be read, or written.
    BadMeshError
        There is nothing to look at.
    """
    limits = {
        "fail_above": fail_above, "min_angle": min_angle, "max_angle": max_angle,
        "min_size": min_size, "max_aspect": max_aspect,
    }  # fmt: skip
    numbers_in(limits | {"tolerance": tolerance, "limit": limit})
    from ..jobs.check import Task, examine_mesh
    from ..quality.gates import gates_of

    task = Task(
        names_of(select) or (),
        names_of(ignore) or (),
        names_of(extend_select) or (),
        gates_of(measure=measure, gates=words_of(gate), **limits),
        tolerance,
        limit or None,
        None if mark is None else Path(mark),
        regions=words_of(region),
        max_size=max_size,
        asked=metric_of(metric, size, gradation=gradation, size_min=size_min, size_max=size_max),
    )
    task.require_metric()
    _ = task.checked  # an unknown code is an error before a file is read
    given = taken(mesh, input_format, max_size)
    task.require_mark([given.source.path])
    verdict = examine_mesh(given.mesh, given.source, task)
    if verdict.error:
        raise BadMeshError(verdict.error)
    return Report(verdict)


def report(
    mesh: AnyMesh,
    *,
    measure: Names = (),
    metric: str | np.ndarray | None = None,
    size: Names | None = None,
    gradation: float | None = None,
    size_min: float | None = None,
    size_max: float | None = None,
    against: AnyMesh | None = None,
    region: Names = (),
    write_quality: str | os.PathLike[str] | None = None,
    input_format: str | None = None,
    max_size: int | None = None,
) -> Appraisal:
    """Measure the quality of a mesh.

    Parameters
    ----------
    mesh : mesh of any kind
        See `optimize`.
    measure : names, optional
        What to measure, "all" for everything: the first Q ranks the cells.
    metric, size, gradation, size_min, size_max
        See `optimize`: judge the mesh by it, besides.
    against : mesh of any kind, optional
        Another mesh, of which this one may have been made.
    region : names, optional
        See `optimize`.
    write_quality : path, optional
        Where the mesh is written, with its quality on the cells.
    input_format, max_size
        See `read`.

    Returns
    -------
    Appraisal

    Raises
    ------
    ConfigError
        Something of the options is wrong.
    ReadError, WriteError
        A file cannot be read, or written.
    BadMeshError, UnsupportedMeshError
        There are no cells to measure.
    """
    from ..jobs.report import Wanted, compared, report_on_mesh

    wanted = Wanted(
        names_of(measure) or (),
        all_measures=True,
        regions=words_of(region),
        marked=None if write_quality is None else Path(write_quality),
        with_histograms=True,
        metric=metric_of(metric, size, gradation=gradation, size_min=size_min, size_max=size_max),
        max_size=max_size,
    )
    given = taken(mesh, input_format, max_size)
    told = report_on_mesh(given.mesh, given.source, wanted)
    if against is None:
        return Appraisal(told, [given.mesh])
    other = taken(against, None, max_size)
    before = report_on_mesh(other.mesh, other.source, wanted)
    return Appraisal(compared(before, told), [other.mesh, given.mesh])


def repair(
    mesh: AnyMesh,
    *,
    mends: Names = "all",
    tolerance: float | None = None,
    input_format: str | None = None,
    max_size: int | None = None,
) -> Repaired:
    """Mend what is wrong with a mesh.

    Parameters
    ----------
    mesh : mesh of any kind
        See `optimize`.
    mends : names
        What to mend, as the flags of `meshopt repair` without their dashes.
    tolerance : float, optional
        Points nearer than this part of the extent are in one place, above 0 and at most 0.1.
    input_format, max_size
        See `read`.

    Returns
    -------
    Repaired
        Its `after` tells what is left.

    Raises
    ------
    ConfigError
        There is no such mend.
    ReadError
        The mesh cannot be read.
    BadMeshError
        No cell would be left.
    """
    numbers_in({"tolerance": tolerance})
    from ..errors import chosen
    from ..jobs.repair_file import repair_mesh
    from ..repairs import MENDS

    wanted = names_of(mends) or ()
    names = tuple(MENDS) if wanted == ("all",) else wanted
    if not names:
        raise ConfigError(f"say what to mend: all, or some of {', '.join(MENDS)}")
    for name in names:
        chosen(MENDS, name, "mend")
    given = taken(mesh, input_format, max_size)
    return Repaired(repair_mesh(given.mesh, given.source, names, tolerance), given)


def _compile(groups: Iterable[str]) -> None:
    """Compile what is missing of some groups of kernels, on all cores."""
    from ..compiled.ways import missing

    if missing(groups):
        from ..warmup import compile_groups

        log.info("compiling kernels, once on this machine")
        compile_groups(groups)
