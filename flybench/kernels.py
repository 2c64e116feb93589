"""How kernels are compiled, and where the compiled code is cached."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config as numba_config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.sigutils import normalize_signature
from numba.core.types import unliteral

from flybench.sources import ROOT, sources_digest

__all__ = ["compiled", "compiled_fastmath", "inlined", "inlined_fastmath"]

Kernel = TypeVar("Kernel", bound=Callable[..., object])

USER_CACHE = Path("~/.cache/flybench/kernels")
"""Where compiled kernels are cached if the package's own folders cannot be written to."""


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel once and cache it on disk.

    Kernels are compiled without `fastmath`, because two machines could then round differently: the
    same seed would no longer give the same events, and the same scene not the same luminance.
    NumPy's error model makes x/0 an infinity, which kernels use for "never". Kernels release
    Python's lock, so that threads can share a step.
    """
    return _compiled(function)


def compiled_fastmath(function: Kernel) -> Kernel:
    """Compile a kernel whose sums may be reordered, for results that need no portable bits."""
    return _compiled(function, fastmath=True)


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel into its caller, for steps of a hot loop that pass many scalars."""
    return _compiled(function, forceinline=True)


def inlined_fastmath(function: Kernel) -> Kernel:
    """Compile a kernel into its caller; its sums may be reordered."""
    return _compiled(function, forceinline=True, fastmath=True)


def _compiled(function: Kernel, **options: bool) -> Kernel:
    kernel: Any = numba.njit(error_model="numpy", nogil=True, **options)(function)  # type: ignore[call-overload]
    kernel.compile = _for_any_value(kernel.compile)
    if _cache_folder(Path(function.__code__.co_filename).parent) is not None:
        kernel._cache = _KernelCache(function)  # type: ignore[no-untyped-call]
    return cast(Kernel, kernel)


def _for_any_value(compile_types: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a dispatcher's `compile` that ignores which constants a kernel is called with.

    Numba would compile a kernel anew for each constant argument, and for the constant that a
    counter of the caller begins with, to the same code.
    """

    def compile_any(types: Any) -> Any:
        arguments, _ = normalize_signature(types)  # type: ignore[no-untyped-call]
        return compile_types(tuple(unliteral(one) for one in arguments))  # type: ignore[no-untyped-call]

    return compile_any


class _Locator:
    """Gives Numba the cache folder of a kernel and the digest of the sources of the cached code.

    The locators of Numba check only the file of the kernel that Python calls, not those of the
    kernels that are compiled into it. After an edit of the latter, old code would be run.
    """

    def __init__(self, function: Callable[..., object], file: str) -> None:
        self._function, self._file = function, Path(file)

    @classmethod
    def from_function(cls, function: Callable[..., object], file: str) -> _Locator:
        """Return a locator, as numba asks for it."""
        return cls(function, file)

    def get_cache_path(self) -> str:
        """Return the folder of the compiled kernel."""
        return str(_cache_folder(self._file.parent))

    def ensure_cache_path(self) -> None:
        """Do nothing: `_cache_folder` has made the folder."""

    def get_source_stamp(self) -> str:
        """Return the digest of every source that may be compiled into the kernel."""
        return _stamp(self._file)

    def get_disambiguator(self) -> str:
        """Return a string that distinguishes functions with the same name in one folder."""
        return f"{self._function.__module__}-{self._function.__code__.co_firstlineno}"


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012


class _KernelCache(FunctionCache):
    _impl_class = _KernelCacheImpl

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a compiled kernel, unless the disk is full."""
        with suppress(OSError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load a compiled kernel, or return None if none is up to date."""
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except (AttributeError, ImportError):  # it refers to a class that is gone
            self.flush()  # type: ignore[no-untyped-call]
            return None


@cache
def _stamp(file: Path) -> str:
    """Return the digest of the kernel's package (or folder, outside flybench) and of `flybench`."""
    if file.is_relative_to(ROOT):
        return sources_digest("flybench", file.relative_to(ROOT).parts[0])
    return sources_digest("flybench", str(file.parent))


@cache
def _cache_folder(source: Path) -> Path | None:
    """Folder for the compiled kernels of a source folder; None if none can be written to."""
    chosen: str = numba_config.CACHE_DIR  # type: ignore[attr-defined]
    for candidate in (
        [Path(chosen) / "flybench"] if chosen else [source / "__pycache__", USER_CACHE]
    ):
        folder = _writable(candidate)
        if folder is not None:
            return folder
    _warn_once()
    return None


def _writable(folder: Path) -> Path | None:
    try:
        folder = folder.expanduser()
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        return None
    return folder


@cache
def _warn_once() -> None:
    logging.getLogger("flybench").warning(
        "flybench: no folder for compiled kernels is writable, so this process compiles them "
        "again. Set NUMBA_CACHE_DIR to a writable folder."
    )
