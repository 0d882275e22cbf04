"""What a mend is, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..mesh.model import Mesh
from ..validity.examination import Examination

Vertices = frozenset[int]


@dataclass(frozen=True)
class Mended:
    """A mesh after one mend.

    Attributes
    ----------
    mesh : Mesh
        The very same where nothing was to be done.
    counts : dict of str to int
        How many of what changed, as messages say it: "points merged". Zeros may be among them.
    notes : tuple of str
        What is to be known of it; a line each.
    left : tuple of str
        What could not be mended; a line each.
    """

    mesh: Mesh
    counts: dict[str, int]
    notes: tuple[str, ...] = ()
    left: tuple[str, ...] = ()

    def followed_by(self, later: Mended) -> Mended:
        """This and the same mend made once more, as one."""
        counts = {what: n + later.counts.get(what, 0) for what, n in self.counts.items()}
        notes = tuple(dict.fromkeys(self.notes + later.notes))
        return Mended(later.mesh, counts, notes, later.left)


@dataclass(frozen=True)
class Mend:
    """A row of `MENDS`.

    Attributes
    ----------
    name : str
        What the command line calls it.
    summary : str
        What it does, for help texts.
    apply : function of an Examination
        Mends the mesh that is examined. It leaves that as it is.
    """

    name: str
    summary: str
    apply: Callable[[Examination], Mended]
