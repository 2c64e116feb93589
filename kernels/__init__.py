"""How the kernels of simulator and emulator are compiled, and when they are compiled anew."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TypeVar, cast

import numba

__all__ = ["compiled", "discard_stale", "inlined"]

Kernel = TypeVar("Kernel", bound=Callable[..., object])


@cache
def discard_stale(package: Path) -> None:
    """Delete the cached kernels of a package that are older than any of its sources, or than this.

    Numba notices an edit only in the file of the kernel that Python calls, not in the files of the
    kernels that it was compiled with; it would go on running yesterday's physics.

    Args:
        package: folder of the sources, with Numba's indices in its `__pycache__`.
    """
    newest = max(source.stat().st_mtime_ns for source in [*package.glob("*.py"), Path(__file__)])
    for index in (package / "__pycache__").glob("*.nbi"):
        with suppress(FileNotFoundError):  # another process may be at it too
            if index.stat().st_mtime_ns < newest:
                index.unlink()


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel once and cache it on disk, where stale kernels beside it go first.

    No `fastmath`: it would let two machines round differently and so break "same seed, same
    events" and "same scene, same light". NumPy's error model makes x/0 an infinity, which kernels
    use as "never". Kernels release Python's lock, so that two threads can share a step.
    """
    _discard_beside(function)
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", nogil=True)(function))


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel into its caller: for steps of a hot loop that pass many scalars."""
    _discard_beside(function)
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", forceinline=True)(function))


def _discard_beside(function: Callable[..., object]) -> None:
    discard_stale(Path(function.__code__.co_filename).parent)
