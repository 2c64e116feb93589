"""How every kernel of this package is compiled."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def discard_stale_kernels(package: Path) -> None:
    """Delete the cached kernels of a package that are older than any of its sources.

    Numba notices an edit only in the file of the kernel that Python calls, not in the files of the
    kernels that it was compiled with.

    Args:
        package: folder of the sources, with Numba's indices in its `__pycache__`.
    """
    newest = max(source.stat().st_mtime_ns for source in package.glob("*.py"))
    for index in (package / "__pycache__").glob("*.nbi"):
        with suppress(FileNotFoundError):  # another process may be at it too
            if index.stat().st_mtime_ns < newest:
                index.unlink()


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel once and cache it on disk.

    No `fastmath`: two machines would draw different light. NumPy's error model makes x/0 an
    infinity. Kernels release Python's lock.
    """
    return cast(Kernel, numba.njit(cache=True, nogil=True, error_model="numpy")(function))


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel into its caller: for steps of a hot loop that pass many scalars."""
    kernel = numba.njit(cache=True, nogil=True, error_model="numpy", inline="always")
    return cast(Kernel, kernel(function))


discard_stale_kernels(Path(__file__).parent)
