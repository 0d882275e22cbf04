"""What functions give back: values with short words, and pages for notebooks."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..reports.outputs import CHECK_OUTPUTS, NORMAL, OUTPUTS, write_reports

if TYPE_CHECKING:
    import numpy as np

    from ..formats import Written
    from ..formats.memory import Held
    from ..jobs.optimize_mesh import Optimized
    from ..jobs.repair_file import Mended
    from ..mesh.model import Mesh
    from ..quality.statistics import Statistic
    from ..quality.summary import Summary
    from ..reports import model
    from ..reports.verdict import Finding, Verdict


class Told:
    """What is told of meshes, in the forms that the command line has for it."""

    def _told(self, pictures: bool) -> model.Report:
        raise NotImplementedError

    @property
    def facts(self) -> model.Report:
        """All that is told, as values."""
        return self._told(pictures=False)

    def to_text(self) -> str:
        """The table that is printed on a terminal."""
        return self._as("table")

    def to_json(self) -> str:
        """For programs: the keys are told in the README."""
        return self._as("json")

    def to_csv(self) -> str:
        """A line for each mesh, before and after."""
        return self._as("csv")

    def to_markdown(self) -> str:
        """For a pull request."""
        return self._as("markdown")

    def to_html(self, path: str | os.PathLike[str] | None = None) -> str:
        """A page of its own, with pictures where the extra `plot` is installed.

        Parameters
        ----------
        path : str or path, optional
            Where it is written, too.

        Raises
        ------
        WriteError
        """
        told = self._told(pictures=True)
        if path is not None:
            write_reports(Path(path), [told], OUTPUTS["html"])
        return OUTPUTS["html"].text([told])

    def _as(self, form: str) -> str:
        return OUTPUTS[form].text([self.facts], NORMAL)

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(self.to_text())}</pre>"


class Result(Told):
    """A mesh that was optimized.

    Attributes
    ----------
    mesh : mesh of the kind that was given
        Of a path, a `Mesh`.
    before, after : Summary
        `worst` and `mean` Q, `percent` of the cells in each rank, `n_cells`, `n_points`, `types`,
        `worst_cells` and more.
    passes : tuple of PassFacts
        What every pass did.
    stopped : str
        Why the run ended: "done", "nothing to gain", "no change", "gain below", "target quality",
        "rounds", "time limit", or "cancelled".
    lost : tuple of str
        What of the input did not go along.
    seconds : float
        That the work took.
    metric : (np, k) array, optional
        What drove the work at the points of the mesh: sizes (k = 1), or tensors, in the order of
        VTK.
    """

    def __init__(self, done: Optimized, given: Held) -> None:
        self._done = done
        self._source = given.source
        self._written: Written | None = None
        self.mesh: Any = given.back(done.result.mesh)
        self.stopped: str = done.result.stopped
        self.seconds: float = done.result.seconds
        self.lost: tuple[str, ...] = (*given.source.lost, *done.result.lost)

    @property
    def before(self) -> Summary:
        return self._done.result.before

    @property
    def after(self) -> Summary:
        return self._done.result.after

    @property
    def passes(self) -> tuple[model.PassFacts, ...]:
        return self.facts.passes

    @property
    def metric(self) -> np.ndarray | None:
        if self._done.metric is None:
            return None
        from ..metric.field import VTK, in_order

        return in_order(self._done.metric, VTK)

    def write(
        self,
        path: str | os.PathLike[str],
        *,
        file_format: str | None = None,
        binary: bool | None = None,
        write_quality: bool = False,
        metric_out: str | None = None,
    ) -> Path:
        """Write the mesh to a file, as `meshopt optimize` does.

        Parameters
        ----------
        path, file_format, binary
            See `write`.
        write_quality : bool
            Put Q, type and region of the cells into the file, as arrays.
        metric_out : str, optional
            Write the metric at the points: to a file, `.sol` or `.solb`, or as an array of this
            name.

        Raises
        ------
        WriteError
        ConfigError
            There is no such format.
        """
        from .. import formats
        from ..jobs.optimize_file import write_optimized

        place = Path(path)
        encoding = formats.encoding_for(place, self._source.encoding, file_format, binary)
        self._done, self._written = write_optimized(
            self._done, place, encoding, write_quality, metric_out
        )
        return place

    def _told(self, pictures: bool) -> model.Report:
        from ..jobs.optimize_file import report_on_run

        done, source = self._done, self._source
        return report_on_run(done, source, self._written, {"optimize": self.seconds}, pictures)

    def __repr__(self) -> str:
        before, after = self.before, self.after
        return (
            f"<meshopt.Result: {after.n_cells:,} cells, worst Q {before.worst:.4g} -> "
            f"{after.worst:.4g}, mean {before.mean:.4g} -> {after.mean:.4g}, "
            f"stopped: {self.stopped}>"
        )


class Appraisal(Told):
    """What a mesh is worth.

    Attributes
    ----------
    summary : Summary
        As `Result.before`.
    statistics : tuple of Statistic
        Of the measures that were asked for: `name`, `least`, `mean`, `greatest` and more.
    """

    def __init__(self, told: model.Report, meshes: Sequence[Mesh]) -> None:
        self._report = told
        self._meshes = meshes

    @property
    def summary(self) -> Summary:
        return self._report.before

    @property
    def worst(self) -> float:
        """Q of the worst cell."""
        return self.summary.worst

    @property
    def mean(self) -> float:
        """The mean Q."""
        return self.summary.mean

    @property
    def statistics(self) -> tuple[Statistic, ...]:
        return self._report.statistics

    def _told(self, pictures: bool) -> model.Report:
        if not pictures:
            return self._report
        from ..jobs.illustrate import illustrated

        return illustrated(self._report, self._meshes)

    def quality(self, measure: str | None = None) -> np.ndarray:
        """A measure of each cell of the mesh, (n,) float64; NaN for cells that do not have it.

        Parameters
        ----------
        measure : str, optional
            Instead of the first one that was asked for, or the one that ranks the cells.

        Raises
        ------
        ConfigError
            There is no such measure.
        """
        from ..jobs.quality_arrays import on_cells
        from ..quality.statistics import measures_named

        asked = measure or next((one.measure for one in self.statistics), self.summary.measure)
        (row,) = measures_named([asked])
        return on_cells(self._meshes[-1], row)

    def __repr__(self) -> str:
        one = self.summary
        q = f"worst Q {one.worst:.4g}, mean {one.mean:.4g}"
        return f"<meshopt.Appraisal: {one.n_cells:,} cells, {q}>"


class Report:
    """What `check` found in a mesh. It is true where the mesh is valid.

    Attributes
    ----------
    findings : tuple of Finding
        The first places that break each rule: `code`, `severity`, `message`, `entities`, `where`.
    counts : dict of str to int
        How many places break each rule, by its code.
    checked : tuple of str
        Codes of the rules that were looked for.
    """

    def __init__(self, verdict: Verdict) -> None:
        self.verdict = verdict

    @property
    def is_valid(self) -> bool:
        """Whether no rule of severity error is broken."""
        return self.verdict.is_valid

    @property
    def findings(self) -> tuple[Finding, ...]:
        return self.verdict.findings

    @property
    def counts(self) -> dict[str, int]:
        return dict(self.verdict.counts or {})

    @property
    def checked(self) -> tuple[str, ...]:
        return self.verdict.checked

    def to_text(self) -> str:
        """A line for each finding, and one for the mesh."""
        return CHECK_OUTPUTS["text"].text([self.verdict])

    def to_json(self) -> str:
        """For programs: the keys are told in the README."""
        return CHECK_OUTPUTS["json"].text([self.verdict])

    def __bool__(self) -> bool:
        return self.is_valid

    def __repr__(self) -> str:
        broken = ", ".join(f"{code} x {n}" for code, n in self.counts.items()) or "nothing found"
        return f"<meshopt.Report: {'valid' if self.is_valid else 'not valid'}, {broken}>"


class Repaired:
    """A mesh that was mended.

    Attributes
    ----------
    mesh : mesh of the kind that was given
    before : dict of str to int
        How many places of it broke each rule.
    after : Report
        On what was made of it.
    mends : dict of str to dict of str to int
        How many of what each mend changed.
    notes, lost : tuple of str
        What could not be mended, and what did not go along.
    """

    def __init__(self, done: Mended, given: Held) -> None:
        from ..jobs.repair_file import report_on_repair

        self._mended, self._source = done.mesh, given.source
        told = report_on_repair(done, given.source, given.source)
        self.mesh: Any = given.back(done.mesh)
        self.before = dict(told.before)
        self.after = Report(told.after)
        self.mends = done.mends
        self.notes = told.notes
        self.lost = told.lost

    def write(
        self,
        path: str | os.PathLike[str],
        *,
        file_format: str | None = None,
        binary: bool | None = None,
    ) -> Path:
        """Write the mesh to a file, as `meshopt repair` does; see `write`."""
        from .meshes import of_file, write

        mesh = of_file(self._mended, self._source)
        return write(path, mesh, file_format=file_format, binary=binary)

    def __repr__(self) -> str:
        counts = {what: n for mend in self.mends.values() for what, n in mend.items() if n}
        done = ", ".join(f"{n} {what}" for what, n in counts.items()) or "nothing to mend"
        return f"<meshopt.Repaired: {done}; {'valid' if self.after else 'not valid'}>"
