"""Whether there is memory enough to begin something that ends the process where there is not."""

from __future__ import annotations

FOR_NUMPY = 160 << 20  # bytes that are mapped when it is imported, and some
FOR_LLVM = 32 << 20  # more than linking of some code takes


def is_limited() -> bool:
    """Whether the process has a limit of its memory."""
    try:
        import resource
    except ImportError:  # not on Windows, which has no such limits
        return False
    return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY


def require_memory(n_bytes: int) -> None:
    """Find out whether there is so much memory, where the process has a limit of it.

    Raises
    ------
    MemoryError
    """
    if not is_limited():
        return
    import mmap

    try:
        mmap.mmap(-1, n_bytes).close()
    except OSError:
        raise MemoryError from None
