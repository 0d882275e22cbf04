"""The start and the end of a run: its exit status, and what becomes of an error."""

from __future__ import annotations

import io
import os
import sys

import click

from ..errors import (
    EXIT_DONE,
    EXIT_FILES,
    EXIT_INTERRUPTED,
    EXIT_INVARIANT,
    EXIT_USAGE,
    MeshoptError,
)
from .main import main


def run() -> None:
    """Run the command line and leave with its exit status."""
    # numpy starts a thread a core for products of large matrices, which are none here: that is a
    # quarter of the processor time of a small run.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(status_of(sys.argv[1:]))


def status_of(arguments: list[str]) -> int:
    """Run the command line; returns the exit status. Errors become one line on stderr."""
    # A name of a file may hold what stdout cannot show.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        result = main.main(arguments, prog_name="meshopt", standalone_mode=False)
        return result if isinstance(result, int) else EXIT_DONE
    except click.exceptions.Exit as done:
        return done.exit_code
    except click.ClickException as error:
        hint = "" if not isinstance(error, click.UsageError) else "; see meshopt --help"
        return _fail(f"{error.format_message().rstrip('.')}{hint}", EXIT_USAGE)
    except MeshoptError as error:
        return _fail(str(error), error.exit_status)
    except (KeyboardInterrupt, click.Abort):
        return _fail("interrupted: nothing is written", EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader went away: what is left to print goes nowhere, and python's own farewell
        # must not complain about it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_DONE
    except MemoryError:
        return _fail("out of memory", EXIT_FILES)
    except Exception as error:
        if os.environ.get("MESHOPT_TRACEBACK"):
            import traceback

            traceback.print_exc()
        name = type(error).__name__
        return _fail(
            f"internal error ({name}: {' '.join(str(error).split())[:200]}); nothing is written; "
            "MESHOPT_TRACEBACK=1 shows where",
            EXIT_INVARIANT,
        )


def _fail(message: str, status: int) -> int:
    click.echo(f"meshopt: {message}", err=True)
    return status
