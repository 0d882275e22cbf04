"""Drawings for pages: the ranks of Table 18.3, the course of Q, histograms of measures.

Their colours are those of the page, by classes; no colour alone tells what is what.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from ..cells import FAMILIES
from ..quality.statistics import Statistic
from ..quality.summary import Summary
from .markup import amount, quality, text
from .model import PassFacts, Pictures

WIDTH = 360  # of each drawing, as wide as a phone
MOST_POINTS = 120  # of a course that are marked one by one
NEAR = 15.0  # labels that are nearer would touch each other


def _svg(label: str, height: float, parts: Sequence[str]) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH} {height:g}" role="img" aria-label="{text(label)}">\n'
        + "\n".join(parts)
        + "\n</svg>"
    )


def _at(number: float) -> str:
    return f"{number:.1f}".removesuffix(".0")


def _words(x: float, y: float, words: str, end: str = "", kind: str = "") -> str:
    anchor = f' text-anchor="{end}"' if end else ""
    style = f' class="{kind}"' if kind else ""
    return f'<text x="{_at(x)}" y="{_at(y)}"{anchor}{style}>{text(words)}</text>'


def _bar(x: float, y: float, width: float, height: float, kind: str, title: str) -> str:
    return (
        f'<rect class="{kind}" x="{_at(x)}" y="{_at(y)}" width="{_at(width)}" '
        f'height="{_at(height)}"><title>{text(title)}</title></rect>'
    )


# Ranks ---------------------------------------------------------------------------------------


def ranks(
    headings: Sequence[str], rows: Sequence[tuple[str, Sequence[int]]], of: str = "cells of Q"
) -> str:
    """Bars of the percentage of some things in each rank, of one mesh or before and after.

    Parameters
    ----------
    headings : sequence of str
        Of the ranks.
    rows : sequence of (str, counts)
        One or two, each with how many there are in each rank.
    of : str
        What is counted, and by what: "cells of Q".
    """
    left = 8.0 + 7.0 * max(map(len, headings))
    most, thick = WIDTH - left - 56.0, 15.0
    parts, y = [], 4.0
    kinds = ["was", "now"][-len(rows) :]
    noun, _, by = of.partition(" of ")
    percents = [[100.0 * n / max(sum(counts), 1) for n in counts] for _, counts in rows]
    for i, rank in enumerate(headings):
        parts.append(_words(left - 6, y + thick * len(rows) / 2 + 4, rank, "end"))
        for (name, counts), percent, kind in zip(rows, percents, kinds, strict=True):
            wide = max(most * percent[i] / 100.0, 1.5 if counts[i] else 0.0)
            title = f"{name}, {by} {rank}: {counts[i]:,} {noun}, {percent[i]:.1f} %"
            parts.append(_bar(left, y + 1, wide, thick - 3, kind, title))
            parts.append(_words(left + wide + 5, y + thick - 4, f"{percent[i]:.1f} %"))
            y += thick
        y += 8.0
    parts.append(f'<path class="axis" d="M{_at(left)} 0V{_at(y - 4)}"/>')
    if len(rows) > 1:
        y += 6.0
        for x, (name, _), kind in zip((left, left + 130.0), rows, kinds, strict=False):
            parts.append(_bar(x, y, 12.0, 12.0, kind, name))
            parts.append(_words(x + 18, y + 10.5, name))
        y += 16.0
    said = "; ".join(
        f"{name} {', '.join(f'{p:.1f} %' for p in percent)}"
        for (name, _), percent in zip(rows, percents, strict=True)
    )
    return _svg(f"Percent of {noun} in the ranks {', '.join(headings)} of {by}: {said}", y, parts)


# The course of a run -------------------------------------------------------------------------


def course(before: Summary, passes: Sequence[PassFacts]) -> str:
    """The worst Q, by its logarithm, and the mean Q after each run of a pass."""
    names = ["before", *(f"round {p.round}, {p.name}" for p in passes)]
    worst = [before.worst, *(p.worst for p in passes)]
    mean = [before.mean, *(p.mean for p in passes)]
    left, right = 52.0, WIDTH - 8.0
    step = (right - left) / len(passes)
    xs = [left + i * step for i in range(len(names))]
    parts = list(_rounds(xs, passes, 20.0, 228.0))
    parts += _panel("worst Q (log scale)", xs, worst, names, 24.0, 130.0, True)
    parts += _panel("mean Q", xs, mean, names, 160.0, 224.0, False)
    label = (
        f"Course of Q over {len(passes)} runs of passes: worst {quality(worst[0])} to "
        f"{quality(worst[-1])}, mean {quality(mean[0])} to {quality(mean[-1])}"
    )
    return _svg(label, 262.0, parts)


def _rounds(xs: Sequence[float], passes: Sequence[PassFacts], top: float, low: float) -> list[str]:
    """A line where each round starts, and under it how many runs there were by then."""
    words = "runs of passes; a line where a round starts"
    parts = [_words((xs[0] + xs[-1]) / 2, low + 30, words, "middle", "name")]
    last = -math.inf
    for x, (before, now) in zip(xs, pairwise([-1, *(p.round for p in passes)]), strict=False):
        if now != before and x - last >= 4.0:
            parts.append(f'<path class="grid" d="M{_at(x)} {_at(top)}V{_at(low)}"/>')
            last = x
    runs = range(0, len(xs), _step(len(passes)))
    return [*parts, *(_words(xs[i], low + 14, f"{i:,}", "middle") for i in runs)]


def _step(n: int) -> int:
    """A round number by which to count to some number, in ten steps at most."""
    power = 10 ** (len(str(n)) - 1)
    return next(s for s in (power // 10, power // 5, power // 2, power) if s and n <= 10 * s)


def _panel(
    title: str,
    xs: Sequence[float],
    values: Sequence[float],
    names: Sequence[str],
    top: float,
    low: float,
    is_logarithmic: bool,
) -> Iterator[str]:
    """A line through values, with the least and the greatest at the side."""
    kind = "worst" if is_logarithmic else "mean"
    yield _words(xs[0], top - 10, title)
    yield f'<path class="axis" d="M{_at(xs[0])} {_at(top - 4)}V{_at(low)}H{WIDTH - 8}"/>'
    finite = [v for v in values if math.isfinite(v) and v > 0.0]
    if not finite:
        yield _words(WIDTH / 2, (top + low) / 2, "infinite throughout", "middle")
        return
    least, greatest = min(finite), max(finite)
    place = _scale(least, greatest, is_logarithmic)
    high = top + 14.0 if len(finite) < len(values) else top  # room for those that are infinite

    def y(value: float) -> float:
        return low - 8.0 - place(value) * (low - 8.0 - high)

    marks = [least, greatest] if greatest > least else [least]
    labels = [y(mark) for mark in marks]
    for mark in _between(least, greatest) if is_logarithmic else ():
        if all(abs(y(mark) - other) >= NEAR for other in labels):
            marks.append(mark)
            labels.append(y(mark))
    for mark, at in zip(marks, labels, strict=True):
        yield f'<path class="grid" d="M{_at(xs[0])} {_at(at)}H{WIDTH - 8}"/>'
        yield _words(xs[0] - 5, at + 4, quality(mark), "end")
    start = "M"
    dots: list[str] = []
    path = ""
    for x, value, name in zip(xs, values, names, strict=True):
        if not (math.isfinite(value) and value > 0.0):
            if start == "L" or not dots:  # once for several that follow each other
                dots.append(_words(x, top + 6, quality(value), "middle"))
            start = "M"
            continue
        path += f"{start}{_at(x)} {_at(y(value))}"
        start = "L"
        dots.append(
            f'<circle class="{kind}" cx="{_at(x)}" cy="{_at(y(value))}" r="2.2">'
            f"<title>{text(f'{name}: {kind} Q {quality(value)}')}</title></circle>"
        )
    yield f'<path class="line {kind}" d="{path}"/>'
    if len(values) <= MOST_POINTS:
        yield from dots


def _scale(least: float, greatest: float, is_logarithmic: bool) -> Callable[[float], float]:
    """A function that takes the least to 0 and the greatest to 1; a half where they are one."""
    if is_logarithmic:
        a, span = math.log(least), math.log(greatest) - math.log(least)
        return lambda value: (math.log(value) - a) / span if span > 0.0 else 0.5
    span = greatest - least
    return lambda value: (value - least) / span if span > 0.0 else 0.5


def _between(least: float, greatest: float) -> list[float]:
    """Powers of ten between two values, and then twice and five times these."""
    decades = range(math.floor(math.log10(least)), math.floor(math.log10(greatest)) + 1)
    marks = [float(f"{k}e{n}") for k in (1, 2, 5) for n in decades]
    return [mark for mark in marks if least < mark < greatest]


# Histograms ----------------------------------------------------------------------------------


def histogram(statistic: Statistic) -> str:
    """Bars of how many cells have a measure in each bin, with the ideal where it is among them."""
    found = statistic.histogram
    assert found is not None
    top, low, left, right = 16.0, 104.0, 8.0, WIDTH - 8.0
    ends, most = (found.edges[0], found.edges[-1]), max(found.counts)
    place = _scale(*ends, found.is_logarithmic)

    def x(value: float) -> float:
        return left + place(value) * (right - left)

    parts = [_words(left, 11, f"{most:,} cells in the fullest bin")]
    for (a, b), count in zip(pairwise(found.edges), found.counts, strict=True):
        if not count:
            continue
        high = max((low - top) * count / most, 1.5)
        at, wide = (x(a), max(x(b) - x(a) - 1.0, 0.8)) if b > a else (WIDTH / 2 - 6, 12.0)
        title = f"{amount(a)} to {amount(b)}: {count:,} cells"
        parts.append(_bar(at, low - high, wide, high, "now", title))
    parts.append(f'<path class="axis" d="M{_at(left)} {_at(low)}H{_at(right)}"/>')
    if ends[0] < ends[1]:
        parts.append(_words(left, low + 15, amount(ends[0])))
        parts.append(_words(right, low + 15, amount(ends[1]), "end"))
        scale = "log scale" if found.is_logarithmic else statistic.unit.replace("1", "")
        parts.append(_words(WIDTH / 2, low + 15, scale, "middle"))
    else:
        parts.append(_words(WIDTH / 2, low + 15, amount(ends[0]), "middle"))
    ideal = statistic.ideal
    if ideal is not None and ends[0] <= ideal <= ends[1] and ends[0] < ends[1]:
        parts.append(f'<path class="ideal" d="M{_at(x(ideal))} {_at(top)}V{_at(low + 3)}"/>')
    label = f"Histogram of {statistic.measure} of {FAMILIES[statistic.family].plural}"
    return _svg(f"{label}: {histogram_words(statistic)}", low + 20.0, parts)


def histogram_words(statistic: Statistic) -> str:
    """What is to be seen in a histogram."""
    found = statistic.histogram
    if found is None:
        return ""
    most = max(range(len(found.counts)), key=found.counts.__getitem__)
    a, b = found.edges[most : most + 2]
    some = f"{amount(a)} to {amount(b)}" if b > a else amount(a)
    return (
        f"{amount(statistic.least)} to {amount(statistic.greatest)}, mean "
        f"{amount(statistic.mean)}; the most, {found.counts[most]:,} of {statistic.n_cells:,}, "
        f"at {some}"
    )


# Colours of pictures -------------------------------------------------------------------------


def legend(pictures: Pictures) -> str:
    """A bar of colours with the values that they stand for."""
    left, right, top, high = 12.0, WIDTH - 16.0, 18.0, 12.0
    step = (right - left) / len(pictures.colours)
    parts = [_words(left, 12, pictures.title)]
    for i, colour in enumerate(pictures.colours):
        # each a little wider, so that nothing is seen between them
        parts.append(
            f'<rect fill="{colour}" x="{left + i * step:.2f}" y="{_at(top)}" '
            f'width="{step + 0.3:.2f}" height="{_at(high)}"/>'
        )
    for place, label in pictures.ticks:
        x = left + place * (right - left)
        parts.append(f'<path class="axis" d="M{_at(x)} {_at(top)}v{_at(high + 4)}"/>')
        parts.append(_words(x, top + high + 17, label, "middle"))
    labels = ", ".join(label for _, label in sorted(pictures.ticks))
    return _svg(f"Colours of {pictures.title}, from the worst: {labels}", 50.0, parts)
