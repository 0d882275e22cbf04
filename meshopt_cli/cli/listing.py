"""`meshopt list`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import click

from ..errors import chosen
from . import completion

if TYPE_CHECKING:
    from ..quality.measures import Measure
    from ..registry import Table

Row = tuple[str, ...]


def _by(table: Table, name: str) -> str:
    """Which package a row is of, where it is of another one."""
    return f" (of {table.sources[name]})" if name in table.sources else ""


def _passes() -> list[Row]:
    from ..passes import PASSES

    return [(p.name, p.summary + _by(PASSES, p.name)) for p in PASSES.whole().values()]


def _measures(family: str | None = None) -> list[Row]:
    from ..quality.verdict.table import every_measure

    table = every_measure().whole()
    rows = list(table.values())
    if family is not None:
        known = {name: name for row in rows for name in row.ways}
        wanted = chosen(known, family, "measured family of cells")
        rows = [row for row in rows if wanted in row.ways]
    return [(m.name, m.formula + _by(table, m.name), m.unit, _sources(m), _use(m)) for m in rows]


def _sources(measure: Measure) -> str:
    """The families that have a measure, those with one source together."""
    families: dict[str, list[str]] = {}
    for family, way in measure.ways.items():
        families.setdefault(way.source, []).append(family)
    return "; ".join(
        ", ".join(names) + (f" ({source})" if source else "") for source, names in families.items()
    )


def _use(measure: Measure) -> str:
    from ..quality.measures import QUALITIES

    if measure.drives:
        return ""
    return (
        "a Q, for reports and gates only"
        if measure.name in QUALITIES
        else "for reports and gates only"
    )


def _formats() -> list[Row]:
    from ..formats import FORMATS

    return [
        (f.name, " ".join((*f.extensions, *f.others)), f.description + _by(FORMATS, f.name))
        for f in FORMATS.whole().values()
    ]


def _outputs() -> list[Row]:
    from ..reports.outputs import OUTPUTS

    return [
        (row.name, " ".join(row.suffixes), row.summary + _by(OUTPUTS, row.name))
        for row in OUTPUTS.whole().values()
    ]


def _rules() -> list[Row]:
    from ..validity import RULES

    return [
        (r.code, f"{r.severity}{', on request' if r.on_request else ''}", r.title,
         r.explanation, r.source)
        for r in RULES.values()
    ]  # fmt: skip


def _presets() -> list[Row]:
    from ..plans.presets import PRESETS

    return [(p.name, p.summary) for p in PRESETS.values()]


# Each table as lines: the name first, then what there is to say.
TABLES: dict[str, Callable[[], list[Row]]] = {
    "passes": _passes,
    "measures": _measures,
    "formats": _formats,
    "outputs": _outputs,
    "rules": _rules,
    "presets": _presets,
}


@click.command("list")
@click.argument("table", type=click.Choice(list(TABLES)))
@click.option(
    "--family", metavar="NAME", help="Only measures of these cells: quad, hexahedron.",
    shell_complete=completion.of(completion.families),
)  # fmt: skip
def command(table: str, family: str | None) -> None:
    """List passes, measures, formats, outputs, rules or presets."""
    if family is not None and table != "measures":
        raise click.UsageError("--family goes with measures")
    shown = TABLES[table]() if family is None else _measures(family)
    _print(shown)
    if table == "passes":
        from ..passes import option_rows

        for row in shown:
            if options := option_rows(row[0]):
                click.echo(f"\noptions of {row[0]} (--set {row[0]}.OPTION=VALUE):")
                _print(options, margin=2)


def _print(rows: Sequence[Row], margin: int = 0) -> None:
    """Print rows in columns: as wide as a terminal, else a line each."""
    if not sys.stdout.isatty():
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
            click.echo(" " * margin + "  ".join(cells).rstrip())
        return
    from rich.table import Table

    from .terminal import report_console

    grid = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, margin))
    for column in range(len(rows[0])):
        grid.add_column(no_wrap=column == 0)
    for row in rows:
        grid.add_row(*row)
    report_console().print(grid)
