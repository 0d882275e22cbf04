"""`meshopt list`."""

from __future__ import annotations

from dataclasses import fields

import click

TABLES = ("passes", "measures", "formats", "rules", "presets")


def names(table: str) -> list[str]:
    """The names in a table."""
    return [row[0] for row in rows(table)]


def rows(table: str) -> list[tuple[str, ...]]:
    """A table as lines: the name first, then what there is to say."""
    if table == "passes":
        from ..passes import PASSES

        return [(p.name, p.summary) for p in PASSES.values()]
    if table == "measures":
        from ..quality.summary import MEASURES

        return [
            (m.name, m.formula, f"({m.equations[0]}), ({m.equations[1]})",
             "" if m.drives else "for reports only")
            for m in MEASURES.values()
        ]  # fmt: skip
    if table == "formats":
        from ..formats import FORMATS

        return [(f.name, " ".join(f.extensions), f.description) for f in FORMATS.values()]
    if table == "rules":
        from ..validity import RULES

        return [
            (r.code, f"{r.severity}{', on request' if r.on_request else ''}", r.title,
             r.explanation, r.source)
            for r in RULES.values()
        ]  # fmt: skip
    from ..plans.presets import PRESETS

    return [(p.name, p.summary) for p in PRESETS.values()]


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
@click.argument("table", type=click.Choice(TABLES))
def command(table: str) -> None:
    """List passes, measures, formats, rules or presets."""
    from rich.table import Table

    from .terminal import report_console

    grid = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    shown = rows(table)
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
