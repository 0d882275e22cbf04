"""Which module may import what, and what every public name carries."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from meshopt_cli.passes import PASSES
from meshopt_cli.warmup import TASKS, shares_of

PACKAGE = Path(__file__).parent.parent / "meshopt_cli"
SOURCES = sorted(PACKAGE.rglob("*.py"))
# Where each library may be imported, as parts of the path below the package.
ROOMS = {
    "meshio": ("formats",),
    "numba": ("kernels/_jit.py",),
    "llvmlite": ("kernels/_cache.py", "kernels/_jit.py", "kernels/_native.py"),
    "click": ("cli",),
    "tqdm": ("cli",),
    "rich": ("cli", "report"),
}
KERNELS_MAY = {"__future__", "math", "enum", "typing", "numpy"}
# What a folder or module may not know of.
BLIND = {
    "kernels": {"mesh", "passes", "pipeline", "formats", "cli", "report", "quality", "workspace"},
    "passes": {"formats", "cli", "report", "pipeline", "quality", "validity"},
    "formats": {"kernels", "passes", "cli", "report", "quality", "workspace"},
    "report": {"cli", "formats", "passes", "kernels"},
    "validity": {"cli", "report", "formats", "passes"},
}


def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path):
    """Names of all modules that a file imports, those of the package as `.name`."""
    depth = len(path.relative_to(PACKAGE).parts)
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
        elif isinstance(node, ast.ImportFrom) and node.level == depth:
            # Relative to the package itself.
            names = [node.module.split(".")[0]] if node.module else [a.name for a in node.names]
            yield from (f".{name}" for name in names)


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_libraries_stay_in_their_rooms(path):
    place = str(path.relative_to(PACKAGE))
    for name in imports(path):
        for room in ROOMS.get(name.split(".")[0], (place,)):
            if place.startswith(room):
                break
        else:
            pytest.fail(f"{place} imports {name}")


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_rooms_do_not_know_those_above(path):
    place = path.relative_to(PACKAGE).parts[0]
    known = {name[1:] for name in imports(path) if name.startswith(".")}
    assert not known & BLIND.get(place, set())


def test_kernels_import_nothing_but_numpy():
    for path in (PACKAGE / "kernels").glob("*.py"):
        if not path.name.startswith("_"):
            outside = {n.split(".")[0] for n in imports(path) if not n.startswith(".")}
            assert outside <= KERNELS_MAY, path.name


def test_every_kernel_is_compiled_by_our_decorators():
    for path in (PACKAGE / "kernels").glob("*.py"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.FunctionDef) and not path.name.startswith("_"):
                names = [d.id for d in node.decorator_list if isinstance(d, ast.Name)]
                assert names in (["kernel"], ["inlined"], ["entry"]), f"{path.name}: {node.name}"


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_modules_and_public_classes_are_documented(path):
    module = tree(path)
    assert ast.get_docstring(module)
    for node in module.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            assert ast.get_docstring(node), node.name


@pytest.mark.parametrize("module", ["cli.main", "formats", "validity"])
def test_start_up_is_small(module):
    code = (
        f"import sys, meshopt_cli.{module}\n"
        "print(*{'numba', 'meshio', 'rich', 'tqdm'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == ""


def test_every_pass_says_which_kernels_it_needs():
    """A first run compiles these before it starts, and no others."""
    groups = {group for kind in PASSES.values() for group in kind.kernels}
    assert groups | {"basic", "check"} == set(TASKS)
    shares = shares_of(TASKS, 3)
    assert sorted(group for share in shares for group in share) == sorted(TASKS)
