"""Memory that is given back: what is drawn once is large, and would leave gaps that add up.

The C library takes large blocks from the system one by one and gives them back when they are freed,
but by itself raises its idea of what is large to 32 MB as it goes, and so keeps what start-up used.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable

LARGE_BYTES = 4 * 1024**2
"""More than an array that is made for every sample, and less than most that are made for a
sequence; of `flybench run` by night, the peak falls from 1,056 to 932 MB (measured)."""
SPARE_BYTES = 16 * 1024**2
"""What is kept for the next sample (assumed)."""
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""glibc's numbers for what `mallopt` sets, from its `malloc.h`."""


def return_large_blocks() -> bool:
    """Have freed memory go back to the system, in this process from now on.

    Returns:
        Whether the C library knows how; elsewhere than with glibc, all stays as it is.
    """
    mallopt = _of_glibc("mallopt")
    if mallopt is None:
        return False
    set_ = mallopt(_MMAP_THRESHOLD, LARGE_BYTES), mallopt(_TRIM_THRESHOLD, SPARE_BYTES)
    return all(set_)


def return_free_memory() -> None:
    """Have small blocks that are free go back to the system too, now; elsewhere do nothing.

    A renderer that is closed leaves some 100 MB of them between others (measured).
    """
    if trim := _of_glibc("malloc_trim"):
        trim(0)


def _of_glibc(name: str) -> Callable[..., int] | None:
    try:
        function: Callable[..., int] = getattr(ctypes.CDLL(None), name)
    except (OSError, TypeError, AttributeError):
        return None
    return function
