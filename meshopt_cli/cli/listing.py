"""`meshopt list`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..quality.measures import Measure

Row = tuple[str, ...]


def _passes() -> list[Row]:
    from ..passes import PASSES

    return [(p.name, p.summary) for p in PASSES.values()]


def _measures() -> list[Row]:
    from ..quality.measures import MEASURES

    return [(m.name, m.formula, m.unit, _sources(m), _use(m)) for m in MEASURES.values()]


def _sources(measure: Measure) -> str:
    """The families that have a measure, those with one source together."""
    families: dict[str, list[str]] = {}
    for family, way in measure.ways.items():
        families.setdefault(way.source, []).append(family)
    return "; ".join(
        ", ".join(names) + (f" ({source})" if source else "") for source, names in families.items()
    )


def _use(measure: Measure) -> str:
    if measure.drives:
        return ""
    return "for reports and gates only" if measure.is_quality else "for gates only"


def _formats() -> list[Row]:
    from ..formats import FORMATS

    return [(f.name, " ".join((*f.extensions, *f.others)), f.description) for f in FORMATS.values()]


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
    "rules": _rules,
    "presets": _presets,
}


def option_rows(name: str) -> list[tuple[str, str, str]]:
    """The options of a pass: name, default, help."""
    from ..passes import PASSES

    result = []
    for f in fields(PASSES[name]):
        choices = " | ".join(f.metadata["choices"])
        help = f.metadata["help"] + (f" [{choices}]" if choices else "")
        result.append((f.name.replace("_", "-"), f"{f.default}", help))
    return result


@click.command("list")
@click.argument("table", type=click.Choice(list(TABLES)))
def command(table: str) -> None:
    """List passes, measures, formats, rules or presets."""
    from rich.table import Table

    from .terminal import report_console

    grid = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    shown = TABLES[table]()
    for column in range(len(shown[0])):
        grid.add_column(no_wrap=column == 0)
    for row in shown:
        grid.add_row(*row)
    console = report_console()
    console.print(grid)
    if table == "passes":
        for row in shown:
            options = option_rows(row[0])
            if options:
                console.print(f"\noptions of {row[0]} (--set {row[0]}.OPTION=VALUE):")
                grid = Table(box=None, show_header=False, padding=(0, 2))
                for option in options:
                    grid.add_row(*option)
                console.print(grid)
