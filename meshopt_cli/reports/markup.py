"""Pieces of HTML: text that is escaped, tables, figures."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

from ..errors import shown
from .model import Picture
from .rows import figure, value

INFINITE, UNDEFINED = "\u221e", "\u2013"


def text(words: str) -> str:
    """Words, of a file or not, as they stand in a page or an attribute."""
    return escape(shown(words))


def quality(q: float) -> str:
    """Q in four digits: see `rows.figure`."""
    return _said(q, figure(q))


def amount(number: float) -> str:
    """A value of a measure in four digits: see `rows.value`."""
    return _said(number, value(number))


def _said(number: float, digits: str) -> str:
    if math.isnan(number):
        return UNDEFINED
    if math.isinf(number):
        return INFINITE if number > 0 else f"\u2212{INFINITE}"
    return digits


def table(
    caption: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    words: Iterable[int] = (),
    long: int | None = None,
) -> str:
    """A table whose first column names the rows, in a box that scrolls where it is narrow.

    Parameters
    ----------
    caption : str
    headings : sequence of str
    rows : iterable of sequences of str
        HTML: see `text`. Headings and the caption are plain.
    words : iterable of int
        Columns, besides the first, that are no figures.
    long : int, optional
        The column whose lines are broken.
    """
    kinds = dict.fromkeys([0, *words], ' class="words"')
    if long is not None:
        kinds[long] = ' class="long"'
    name = text(caption)
    lines = [
        f'<div class="scroll" role="region" aria-label="{name}" tabindex="0"><table>',
        f"<caption>{name}</caption>",
        "<thead><tr>"
        + "".join(
            f'<th scope="col"{kinds.get(i, "")}>{text(heading)}</th>' if heading else "<td></td>"
            for i, heading in enumerate(headings)
        )
        + "</tr></thead>",
        "<tbody>",
    ]
    for first, *others in rows:
        cells = "".join(f"<td{kinds.get(i, '')}>{cell}</td>" for i, cell in enumerate(others, 1))
        lines.append(f'<tr><th scope="row">{first}</th>{cells}</tr>')
    return "\n".join([*lines, "</tbody></table></div>"])


def drawing(svg: str, caption: str) -> str:
    """A figure with what it shows in words."""
    return f"<figure>\n{svg}\n<figcaption>{text(caption)}</figcaption>\n</figure>"


def picture(one: Picture, kind: str = "picture") -> str:
    """A picture with what it shows in words."""
    data = b64encode(one.png).decode("ascii")
    words = text(one.words)
    return (
        f'<figure class="{kind}">\n<img src="data:image/png;base64,{data}" width="{one.width}" '
        f'height="{one.height}" alt="{words}">\n<figcaption>{words}</figcaption>\n</figure>'
    )


def paragraph(words: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{text(words)}</p>"
