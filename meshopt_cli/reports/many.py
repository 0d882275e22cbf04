"""Lines that tell of many optimizations."""

from __future__ import annotations

from ..errors import shown
from .model import Report
from .rows import figure


def line_of(report: Report) -> str:
    """One optimization: the files, the worst and the mean Q before and after, why it ended."""
    before, after = report.before, report.after
    assert after is not None
    assert report.output is not None
    return (
        f"{shown(report.input.path)} -> {shown(report.output.path)}: {after.n_cells:,} cells, "
        f"Q_T {figure(before.worst)} -> {figure(after.worst)}, "
        f"mean {figure(before.mean)} -> {figure(after.mean)} ({report.stopped})"
    )


def last_line(n: int, n_written: int) -> str:
    """All of them."""
    left = f", {n - n_written} not" if n_written < n else ""
    return f"{n} {'mesh' if n == 1 else 'meshes'}: {n_written} written{left}"
