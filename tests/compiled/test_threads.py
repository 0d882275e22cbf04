"""First calls of kernels from many threads at once: what they need is made once."""

from __future__ import annotations

import functools
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from meshopt_cli.compiled import cache, decorators, native, ways
from meshopt_cli.compiled.once import once
from support.compiling import at

pytestmark = pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted")

N_THREADS = 8


def tripled(values):
    for i in range(len(values)):
        values[i] *= 3


def at_once(work):
    """What `work(i)` returns in each of several threads that start together."""
    barrier = threading.Barrier(N_THREADS)

    def started(i):
        barrier.wait()
        return work(i)

    with ThreadPoolExecutor(N_THREADS) as pool:
        return list(pool.map(started, range(N_THREADS)))


def slowly(function, calls):
    """The function, taking long enough for all threads to meet in it, and noting its calls."""

    @functools.wraps(function)
    def slow(*arguments, **options):
        calls.append(function.__name__)
        time.sleep(0.05)
        return function(*arguments, **options)

    return slow


def results_of(entries):
    def call(i):
        values = np.full(3, float(i))
        entries[i](values)
        return values.tolist()

    return at_once(call)


RESULTS = [[3.0 * i] * 3 for i in range(N_THREADS)]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder for machine code."""
    monkeypatch.setattr(cache, "folders", at(tmp_path))
    return tmp_path


def test_one_thread_makes_what_all_need():
    calls = []
    kept = once(slowly(object, calls))
    assert len({id(made) for made in at_once(lambda _: kept())}) == 1
    assert calls == ["object"]


def test_the_linker_is_made_once(folder, monkeypatch):
    decorators.Entry(tripled)(np.ones(1))
    calls = []
    make = native.llvm.create_lljit_compiler
    monkeypatch.setattr(native.llvm, "create_lljit_compiler", slowly(make, calls))
    monkeypatch.setattr(native, "_linker", once(native._linker.__wrapped__))
    # Entries that do not know of each other, so that only the linker's own lock is in the way.
    assert results_of([decorators.Entry(tripled) for _ in range(N_THREADS)]) == RESULTS
    assert calls == ["create_lljit_compiler"]


def test_an_entry_is_compiled_and_linked_once(folder, monkeypatch):
    from meshopt_cli.compiled import jit

    calls = []
    monkeypatch.setattr(jit, "compile_entry", slowly(jit.compile_entry, calls))
    monkeypatch.setattr(native, "load", slowly(native.load, calls))
    assert results_of([decorators.Entry(tripled)] * N_THREADS) == RESULTS
    assert calls == ["compile_entry", "load"]


def test_the_folder_is_found_once(tmp_path, monkeypatch):
    """Where none can be written, each thread would else make a temporary one of its own."""
    file = tmp_path / "file"
    file.touch()
    for name in ("MESHOPT_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(file))
    calls = []
    monkeypatch.setattr(tempfile, "mkdtemp", slowly(tempfile.mkdtemp, calls))
    monkeypatch.setattr(cache, "folders", once(cache.folders.__wrapped__))
    assert len(set(at_once(lambda _: cache.folder()))) == 1
    assert calls == ["mkdtemp"]
