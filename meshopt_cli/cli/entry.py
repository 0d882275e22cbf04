"""The start and the end of a run: its exit status, and what becomes of an error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import signals

# All else is imported by functions: until signals have their meaning, Python gives them its own.
if TYPE_CHECKING:
    import click

# How libraries that cannot be loaded say that there is no memory for them.
NO_MEMORY = ("cannot allocate memory", "failed to map segment", "can't start new thread")


def run() -> None:
    """Run the command line and leave with its exit status."""
    signals.install()
    import contextlib
    import os
    import sys

    from . import standard

    # numpy starts a thread a core for products of large matrices, which are none here: that is a
    # quarter of the processor time of a small run.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    standard.prepare()
    status = status_of(sys.argv[1:])
    # What failed to be printed would be tried again.
    with contextlib.suppress(Exception):
        sys.stderr.flush()
    signals.ignore()
    sys.exit(status)


def status_of(arguments: list[str]) -> int:
    """Run the command line; returns the exit status. Errors become one line on stderr."""
    import io
    import sys

    from ..errors import EXIT_FILES, MeshoptError, NoReaderError
    from ..files.ending import begin
    from . import standard

    # A name of a file may hold what stdout cannot show.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    begin()
    status = _status_of(arguments)
    try:
        sys.stdout.flush()
    except NoReaderError:
        standard.forget_stdout()
    except (MeshoptError, OSError) as error:
        standard.forget_stdout()
        return max(status, _fail(_with_truth(str(error)), EXIT_FILES))
    return status


def _status_of(arguments: list[str]) -> int:
    import os

    from ..errors import (
        EXIT_DONE,
        EXIT_FILES,
        EXIT_INTERRUPTED,
        EXIT_INVARIANT,
        EXIT_USAGE,
        MeshoptError,
        NoReaderError,
    )
    from ..files.ending import what_is_written
    from . import standard

    try:
        import click

        from .main import main
    except (ImportError, MemoryError) as error:
        if _is_for_memory(error):
            return _fail("out of memory", EXIT_FILES)
        raise
    try:
        words = tuple(arguments)  # which are told in reports; click empties the list
        result = main.main(arguments, prog_name="meshopt", standalone_mode=False, obj=words)
        return result if isinstance(result, int) else EXIT_DONE
    except click.exceptions.Exit as done:
        return done.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        return _fail(error.format_message(), EXIT_USAGE, "")
    except click.ClickException as error:
        return _fail(f"{error.format_message().rstrip('.')}{_help_of(error)}", EXIT_USAGE)
    except NoReaderError:
        # Whoever reads has seen enough: no error, for nothing depends on what is printed.
        standard.forget_stdout()
        return EXIT_DONE
    except MeshoptError as error:
        return _fail(_with_truth(str(error)), error.exit_status)
    except (KeyboardInterrupt, click.Abort):
        return _fail(f"interrupted: {what_is_written()}", EXIT_INTERRUPTED)
    except Exception as error:
        if _is_for_memory(error):
            return _fail(_with_truth("out of memory"), EXIT_FILES)
        if os.environ.get("MESHOPT_TRACEBACK"):
            import traceback

            traceback.print_exc()
        name = type(error).__name__
        return _fail(
            f"internal error ({name}: {' '.join(str(error).split())[:200]}); {what_is_written()}; "
            "MESHOPT_TRACEBACK=1 shows where",
            EXIT_INVARIANT,
        )


def _help_of(error: click.ClickException) -> str:
    """Where to read how a command is used that was used wrongly."""
    context = getattr(error, "ctx", None)
    if context is None:
        return ""
    return f"; see {context.command_path} --help"


def _is_for_memory(error: BaseException | None) -> bool:
    """Whether it was raised for want of memory, by itself or while another was dealt with."""
    while error is not None:
        if isinstance(error, MemoryError):
            return True
        if any(text in str(error).lower() for text in NO_MEMORY):
            return True
        error = error.__cause__ or error.__context__
    return False


def _with_truth(message: str) -> str:
    """What went wrong, and what is written all the same."""
    from ..files.ending import is_anything_written, what_is_written

    return f"{message}; {what_is_written()}" if is_anything_written() else message


def _fail(message: str, status: int, start: str = "meshopt: ") -> int:
    import contextlib
    import sys

    from ..errors import shown

    with contextlib.suppress(OSError):
        text = shown(message) if start else message
        print(f"{start}{text}", file=sys.stderr, flush=True)
    return status
