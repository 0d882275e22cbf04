"""Which module may import what, and what every public name carries."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from meshopt_cli.compiled.cache import sources
from meshopt_cli.passes import PASSES
from meshopt_cli.warmup import GROUPS, shares_of
from support.compiling import WITHOUT_PASS
from support.samples import ROOT

PACKAGE = ROOT / "meshopt_cli"
SOURCES = sorted(PACKAGE.rglob("*.py"))
# Where each library may be imported, as parts of the path below the package.
ROOMS = {
    "meshio": ("formats",),
    "numba": ("compiled/jit.py", "compiled/plain.py", "compiled/semantics.py"),
    "llvmlite": ("compiled/cache.py", "compiled/jit.py", "compiled/native.py"),
    "click": ("cli",),
    "tqdm": ("progress/lines.py",),
    "rich": ("cli", "reports", "progress/lines.py"),
    "matplotlib": ("pictures/plane.py", "pictures/sheet.py"),
    "distributed": ("pieces/dask.py",),
    "PIL": ("pictures/sheet.py",),
    "pyvista": ("api/accessor.py", "formats/memory/grids.py", "pictures/solid.py"),
    "vtkmodules": ("pictures/solid.py",),
}
KERNELS_MAY = {"__future__", "math", "enum", "typing", "numpy"}
# Which rooms each room may import from, besides the version of the package: the whole table.
MAY = {
    "errors": set(),
    "cores": set(),
    "memory": set(),
    "cells": set(),
    "elements": {"cells"},
    "handles": set(),
    "registry": set(),
    "plugins": {"errors", "formats", "mesh", "passes", "quality", "reports"},
    "compiled": {"errors", "files", "memory"},
    "kernels": {"cells", "compiled", "handles"},
    "mesh": {"cells", "elements", "errors", "handles"},
    "quality": {"cells", "cores", "errors", "kernels", "mesh", "registry"},
    "metric": {"cells", "errors", "mesh", "quality"},
    "validity": {"cells", "elements", "errors", "kernels", "mesh", "quality"},
    "repairs": {"cells", "elements", "errors", "mesh", "validity"},
    "boundary": {"cells", "errors", "kernels", "mesh"},
    "constraints": {"cells", "errors", "kernels", "mesh"},
    "transfer": {"cells", "kernels", "mesh", "metric"},
    "blocks": {"cores", "kernels", "work"},
    "work": {"boundary", "cells", "constraints", "errors", "handles", "kernels", "mesh"},
    "warmup": {"cells", "compiled", "cores", "errors", "files", "kernels", "mesh", "work"},
    "passes": {"blocks", "cells", "errors", "kernels", "mesh", "progress", "registry", "work"},
    "plans": {"boundary", "cells", "constraints", "errors", "kernels", "mesh", "passes", "progress",
              "quality", "work"},
    "progress": {"work"},
    "files": {"errors"},
    "formats": {"cells", "errors", "files", "mesh", "registry"},
    "reports": {"cells", "errors", "files", "mesh", "metric", "quality", "registry", "validity"},
    "pictures": {"cells", "errors", "mesh", "quality"},
    "jobs": {"boundary", "cells", "constraints", "cores", "errors", "files", "formats", "kernels",
             "mesh", "metric", "passes", "pictures", "plans", "progress", "quality", "repairs",
             "reports", "transfer", "validity", "work"},
    "api": {"compiled", "errors", "formats", "jobs", "mesh", "metric", "plans",
            "progress", "quality", "repairs", "reports", "warmup"},
    "pieces": {"boundary", "cells", "cores", "errors", "files", "formats", "jobs", "mesh",
               "quality", "reports", "validity"},
    "cli": {"compiled", "cores", "errors", "files", "formats", "jobs", "memory", "passes", "pieces",
            "plans", "progress", "quality", "registry", "repairs", "reports", "validity", "warmup"},
    "__main__": {"cli"},
    "version": set(),
    "__init__": {"api", "errors", "progress"},
}  # fmt: skip


def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def module_of(path):
    """Name of a module below the package: "mesh.model", "validity" for its `__init__`."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if len(parts) > 1 and parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in SOURCES}


def imports(path):
    """Names of the outside modules that a file imports, wherever in it."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


def imported(module):
    """Modules of the package that a module imports, in functions and for types too."""
    path = MODULES[module]
    package = path.parent.relative_to(PACKAGE).parts
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            base += tuple(node.module.split(".")) if node.module else ()
            for alias in node.names:
                below = ".".join((*base, alias.name))
                yield below if below in MODULES else ".".join(base) or "__init__"


def circles(graph):
    """Sets of modules that lead back to each other, each sorted."""
    reach = graph
    for _ in graph:
        reach = {a: known.union(*(reach[b] for b in known)) for a, known in reach.items()}
    groups = {tuple(sorted(b for b in reach[a] if a in reach[b])) for a in reach}
    return sorted(list(group) for group in groups if group)


def test_no_module_imports_itself_in_a_circle():
    graph = {module: set(imported(module)) for module in MODULES}
    assert circles(graph) == []


def test_circles_are_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [["b", "c"]]


def test_the_table_of_rooms_is_whole():
    assert {module.split(".")[0] for module in MODULES} == set(MAY)


@pytest.mark.parametrize("module", MODULES)
def test_rooms_know_those_of_the_table_only(module):
    room = module.split(".")[0]
    known = {other.split(".")[0] for other in imported(module)}
    assert known <= MAY[room] | {room, "version"}


def test_the_table_of_rooms_allows_nothing_unused():
    for room, may in MAY.items():
        known = {
            other.split(".")[0]
            for module in MODULES
            if module.split(".")[0] == room
            for other in imported(module)
        }
        assert may <= known, room


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_libraries_stay_in_their_rooms(path):
    place = str(path.relative_to(PACKAGE))
    for name in imports(path):
        for room in ROOMS.get(name.split(".")[0], (place,)):
            if place.startswith(room):
                break
        else:
            pytest.fail(f"{place} imports {name}")


def test_kernels_import_nothing_but_numpy():
    for path in (PACKAGE / "kernels").rglob("*.py"):
        assert {name.split(".")[0] for name in imports(path)} <= KERNELS_MAY, path.name


def test_machine_code_is_made_anew_for_every_source_it_depends_on():
    """Its folder is named by the digest of these."""
    graph = {module: set(imported(module)) for module in MODULES}
    needed = {module for module in MODULES if module.split(".")[0] == "kernels"}
    for _ in MODULES:
        needed |= {b for a in needed if not a.startswith("compiled") for b in graph[a]}
    assert "compiled.decorators" in needed
    assert {MODULES[module] for module in needed} <= set(sources())


def test_every_kernel_is_compiled_by_our_decorators():
    for path in (PACKAGE / "kernels").rglob("*.py"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.FunctionDef):
                (decorator,) = [ast.unparse(d).split("(")[0] for d in node.decorator_list]
                assert decorator in ("kernel", "inlined", "entry"), f"{path.name}: {node.name}"


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_modules_and_public_classes_are_documented(path):
    module = tree(path)
    assert ast.get_docstring(module)
    for node in module.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            assert ast.get_docstring(node), node.name


@pytest.mark.parametrize("module", ["cli.entry", "cli.view", "formats", "validity"])
def test_start_up_is_small(module):
    code = (
        f"import sys, meshopt_cli.{module}\n"
        "print(*{'numba', 'meshio', 'rich', 'tqdm', 'matplotlib', 'pyvista'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == ""


def test_every_pass_says_which_kernels_it_needs():
    """A first run compiles these before it starts, and no others but those of blocks."""
    groups = {group for kind in PASSES.values() for group in kind.kernels}
    # Those of blocks are few, and for large meshes alone: they are compiled when one comes.
    assert groups | {"basic", "blocks", "check"} | WITHOUT_PASS == set(GROUPS)
    shares = shares_of(GROUPS, 3)
    assert sorted(group for share in shares for group in share) == sorted(GROUPS)
