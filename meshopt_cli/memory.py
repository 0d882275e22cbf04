"""Whether there is memory enough to begin with."""

from __future__ import annotations

# What numpy maps when it is imported, and some: what it calls ends the process without a word
# of ours where there is less.
NEEDED = 160 << 20


def require_memory() -> None:
    """Find out whether libraries can be loaded, where the process has a limit of its memory.

    Raises
    ------
    MemoryError
    """
    try:
        import resource
    except ImportError:  # not on Windows, which has no such limits
        return
    if resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY:
        return
    import mmap

    try:
        mmap.mmap(-1, NEEDED).close()
    except OSError:
        raise MemoryError from None
