"""meshopt: optimize, check and report on meshes, from the command line and from Python.

What is public is imported when it is first asked for, so that the package costs nothing before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .version import __version__

if TYPE_CHECKING:
    from .api.calls import check, optimize, repair, report
    from .api.meshes import Mesh, read, write
    from .api.results import Appraisal, Repaired, Report, Result
    from .errors import (
        BadMeshError,
        ConfigError,
        InvariantError,
        MeshoptError,
        ReadError,
        UnsupportedMeshError,
        WriteError,
    )
    from .progress.lines import rich_progress, tqdm_progress
    from .progress.watch import Progress

_PLACES = {
    "api.calls": ("check", "optimize", "repair", "report"),
    "api.meshes": ("Mesh", "read", "write"),
    "api.results": ("Appraisal", "Repaired", "Report", "Result"),
    "errors": ("BadMeshError", "ConfigError", "InvariantError", "MeshoptError", "ReadError",
               "UnsupportedMeshError", "WriteError"),
    "progress.lines": ("rich_progress", "tqdm_progress"),
    "progress.watch": ("Progress",),
}  # fmt: skip
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

__all__ = sorted(_PLACE_OF)  # noqa: PLE0605 (from the table)


def __getattr__(name: str) -> Any:
    if name not in _PLACE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f".{_PLACE_OF[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
