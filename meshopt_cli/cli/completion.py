"""What a shell offers for what is not typed to its end yet: rows of the tables there are.

`eval "$(_MESHOPT_COMPLETE=bash_source meshopt)"` lets bash ask; zsh and fish likewise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

Rows = Callable[[], Iterable[tuple[str, str]]]  # names, each with what it is
Completer = Callable[[click.Context, click.Parameter, str], list["CompletionItem"]]


def presets() -> Iterable[tuple[str, str]]:
    from ..plans.presets import PRESETS

    return ((p.name, p.summary) for p in PRESETS.values())


def passes() -> Iterable[tuple[str, str]]:
    from ..passes import PASSES

    return ((p.name, p.summary) for p in PASSES.whole().values())


def settings() -> Iterable[tuple[str, str]]:
    from ..passes import option_rows

    return (
        (f"{name}.{option}=", help) for name, _ in passes() for option, _, help in option_rows(name)
    )


def measures() -> Iterable[tuple[str, str]]:
    from ..quality.measures import QUALITIES

    return ((m.name, m.formula) for m in QUALITIES.values())


def limits() -> Iterable[tuple[str, str]]:
    from ..quality.verdict.table import every_measure

    return ((m.name, m.formula) for m in every_measure().whole().values())


def gates() -> Iterable[tuple[str, str]]:
    from ..quality.gates import FIGURES

    return [*limits(), *((f.name, f.summary) for f in FIGURES.values())]


def families() -> Iterable[tuple[str, str]]:
    from ..quality.verdict.table import every_measure

    rows = every_measure().whole().values()
    return ((name, "") for name in dict.fromkeys(n for m in rows for n in m.ways))


def formats() -> Iterable[tuple[str, str]]:
    from ..formats import FORMATS

    return ((f.name, f.description) for f in FORMATS.whole().values())


def rules() -> Iterable[tuple[str, str]]:
    from ..validity import RULES

    return ((r.code, r.title) for r in RULES.values())


def metrics(
    ctx: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """The metric of the mesh itself, and files."""
    from click.shell_completion import CompletionItem

    from ..jobs.metric import IMPLIED

    own = [CompletionItem(IMPLIED, help="the metric of the mesh itself")]
    files = CompletionItem(incomplete, type="file")
    return [*(item for item in own if item.value.startswith(incomplete)), files]


def of(rows: Rows, many: bool = False) -> Completer:
    """What completes one of the names of a table, or the last of several with commas."""

    def complete(
        ctx: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from click.shell_completion import CompletionItem

        before, comma, start = incomplete.rpartition(",") if many else ("", "", incomplete)
        taken = set(before.split(","))
        return [
            CompletionItem(f"{before}{comma}{name}", help=" ".join(help.split()))
            for name, help in rows()
            if name.startswith(start) and name not in taken
        ]

    return complete
