"""The pipeline files of a project, and what holds for a run, for `meshopt optimize`."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..plans.config import Request
    from ..plans.sources import Settled


def project_of() -> Settled:
    """What the files say that are nearest to the working folder."""
    from ..plans.project import found_in
    from ..plans.sources import Settled

    with contextlib.suppress(FileNotFoundError):  # the working folder is gone
        return found_in(Path.cwd())
    return Settled()


def show(request: Request, in_metric: bool) -> None:
    """Print what holds, as a pipeline file."""
    from ..plans.config import plan_of, settle
    from ..plans.writing import text_of

    holds = settle(request, in_metric)
    plan_of(holds)  # what is wrong is said here as well
    click.echo(text_of(holds), nl=False)
