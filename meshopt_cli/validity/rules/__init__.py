"""The rules: a file for each group of codes, and the table of all of them."""

from __future__ import annotations

from collections.abc import Iterable

from ...errors import ConfigError
from ..model import WARNING, Rule
from . import conformity, constraint, content, domain, gates, kinds, middles, shape

# In the order of the codes.
RULES: dict[str, Rule] = {
    row.code: row
    for module in (content, shape, middles, conformity, domain, kinds, constraint, gates)
    for row in vars(module).values()
    if isinstance(row, Rule)
}


def choose(
    select: Iterable[str] = (), ignore: Iterable[str] = (), extend: Iterable[str] = ()
) -> list[Rule]:
    """The rules that codes and prefixes stand for, in the order of their codes.

    Parameters
    ----------
    select : iterable of str
        Nothing means all that are not on request.
    ignore : iterable of str
        What is left out of those.
    extend : iterable of str
        What is looked for besides.

    Raises
    ------
    ConfigError
        A code or prefix that no rule has.
    """
    kept, dropped, more = _matching(select), _matching(ignore), _matching(extend)
    if not kept:
        kept = {code for code, row in RULES.items() if not row.on_request}
    return [RULES[code] for code in sorted((kept | more) - dropped)]


def meant(prefixes: Iterable[str]) -> tuple[str, ...]:
    """The rules, of those that codes and prefixes stand for, that a mesh may break on purpose.

    Raises
    ------
    ConfigError
        A code or prefix of no rule, or only of rules that no mesh breaks on purpose.
    """
    able = [code for code, row in RULES.items() if row.can_be_meant]
    codes: set[str] = set()
    for prefix in prefixes:
        # Nothing need be allowed of a warning.
        found = {c for c in _matching([prefix]) if c in able or RULES[c].severity == WARNING}
        if not found:
            raise ConfigError(f"{prefix} cannot be allowed, only {', '.join(able)} can")
        codes |= found.intersection(able)
    return tuple(sorted(codes))


def _matching(prefixes: Iterable[str]) -> set[str]:
    matching: set[str] = set()
    for prefix in prefixes:
        codes = {code for code in RULES if prefix and code.startswith(prefix.upper())}
        if not codes:
            raise ConfigError(f"no rule has the code {prefix!r}; there are {', '.join(RULES)}")
        matching |= codes
    return matching
