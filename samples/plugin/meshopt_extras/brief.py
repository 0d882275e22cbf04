"""An output: a line for each mesh."""

from collections.abc import Iterable, Iterator

from meshopt_cli.plugins import Manner, Report, ReportOutput


def _lines(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    for report in reports:
        summaries = [one for one in (report.before, report.after) if one is not None]
        yield f"{report.name}: {' -> '.join(f'{one.worst:.3g}' for one in summaries)}\n"


BRIEF = ReportOutput("brief", _lines, (".brief",), "the worst Q, a line for each mesh")
