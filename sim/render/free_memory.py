"""Return of freed memory to the operating system.

Rendering a sequence allocates large arrays once. If the C library keeps them after they are freed,
the peak memory of the process grows. By default, glibc returns a block at once only if it is larger
than a threshold, and raises that threshold to 32 MB while the program runs. It then keeps the
memory that start-up has used.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable

LARGE_BYTES = 4 * 1024**2
"""Blocks above this size are returned to the system when they are freed. The value is above the
size of arrays that are made for every sample, and below that of most arrays that are made once per
sequence. Returning them lowers the peak of `flybench run` at night from 1,056 to 932 MB
(measured)."""
SPARE_BYTES = 16 * 1024**2
"""Free memory that is kept for the next sample (assumed)."""
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
"""Parameter numbers of `mallopt`, from glibc's `malloc.h`."""


def return_large_blocks() -> bool:
    """Make the C library return large freed blocks at once, in this process from now on.

    Threads that start from now on share a heap, instead of having one each with free blocks of its
    own: the peak of `flybench run` at night fell from 902 to 865 MB (measured once; four later
    runs took 880 to 940 MB).

    Returns:
        True if the C library supports this; without glibc, nothing changes.
    """
    mallopt = _glibc_function("mallopt")
    if mallopt is None:
        return False
    wanted = {_MMAP_THRESHOLD: LARGE_BYTES, _TRIM_THRESHOLD: SPARE_BYTES, _ARENA_MAX: 1}
    succeeded = [mallopt(number, value) for number, value in wanted.items()]
    return all(succeeded)


def return_free_memory() -> None:
    """Return small free blocks to the system now; without glibc, do nothing.

    A closed renderer leaves some 100 MB of them between blocks in use (measured).
    """
    if trim := _glibc_function("malloc_trim"):
        trim(0)


def _glibc_function(name: str) -> Callable[..., int] | None:
    try:
        function: Callable[..., int] = getattr(ctypes.CDLL(None), name)
    except (OSError, TypeError, AttributeError):
        return None
    return function
