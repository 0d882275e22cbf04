"""Tables that installed packages add rows to, by entry points.

Looking for these takes longer than a small run, so that a table does so only where it lacks what
is asked for, or all there is is wanted.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

log = logging.getLogger("meshopt")

Row = TypeVar("Row")


class Table(dict[str, Row], Generic[Row]):
    """Rows by their names: those of this program, then those of others.

    Parameters
    ----------
    group : str
        Of the entry points.
    what : str
        What a row is: "pass".
    rows : iterable of rows
    is_row : function of anything
        Whether it can be a row.

    Attributes
    ----------
    sources : dict of str to str
        Where the rows of others come from: the name and the version of a package.
    """

    def __init__(
        self, group: str, what: str, rows: Iterable[Row], is_row: Callable[[object], bool]
    ) -> None:
        super().__init__({_name(row): row for row in rows})
        self.sources: dict[str, str] = {}
        self._group = group
        self._what = what
        self._is_row = is_row
        self._is_whole = False

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or dict.__contains__(self.whole(), name)

    def __missing__(self, name: str) -> Row:
        rows = self.whole()
        if not dict.__contains__(rows, name):
            raise KeyError(name)
        return rows[name]

    def whole(self) -> Table[Row]:
        """The table with all rows there are; what cannot be loaded is warned of, once."""
        if not self._is_whole:
            self._is_whole = True
            from importlib.metadata import entry_points

            for point in entry_points(group=self._group):
                found = point.dist
                source = f"{found.name} {found.version}" if found else point.value
                if problem := self._add(point.load, source):
                    log.warning("the %s %s of %s is left out: %s",
                                self._what, point.name, source, problem)  # fmt: skip
        return self

    def _add(self, load: Callable[[], Row], source: str) -> str:
        """Add a row; says what is wrong with it, if anything is."""
        try:
            row = load()
        except Exception as error:  # code of others may raise anything
            return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
        if not self._is_row(row):
            return f"it is no {self._what}"
        name = _name(row)
        if dict.__contains__(self, name):
            return f"there is one of the name {name}"
        self[name] = row
        self.sources[name] = source
        return ""


def _name(row: object) -> str:
    return str(getattr(row, "name", ""))
