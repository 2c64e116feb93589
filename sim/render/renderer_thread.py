"""A renderer in a thread of its own, so that keyframes are rendered while samples are drawn.

Filament must be used by the thread that created it. The results do not depend on timing: one thread
does everything in the order in which it was asked to.
"""

from __future__ import annotations

import atexit
import os
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from queue import SimpleQueue
from typing import Any, ParamSpec, TypeVar

import mujoco

from sim.geometry.pinhole import Intrinsics
from sim.render.filament import FilamentRenderer

P = ParamSpec("P")
R = TypeVar("R")
MESA_THREADS = "LP_NUM_THREADS"
"""Environment variable with the number of threads that Mesa's software renderer starts for a
context. Without it, it starts one for each core. They would compete with the thread that draws the
samples: a crossing then takes 5 to 10 % more CPU time on two cores (measured)."""
Calls = SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None]
"""What the thread is asked to call, and where the result goes; None ends it."""


class RendererThread:
    """A thread that owns a renderer. Use as a context manager.

    The garbage collector may end the context, in any thread: of an iterator over samples, for
    example, that nobody uses any more. A `ThreadPoolExecutor` would then have lost its thread.

    Attributes:
        model: the model that is rendered.
        renderer: the renderer, to be used by functions that are passed to `submit` only.
    """

    def __init__(self, model: mujoco.MjModel, lens: Intrinsics) -> None:
        """Start the thread and set up the renderer.

        Args:
            model: model with photometric lights; see `sim.render.luminance_model`.
            lens: lens and sensor.

        Raises:
            RendererError: this machine has no Vulkan device.
        """
        self.model, self._closed = model, False
        self._calls: Calls = SimpleQueue()
        self._asked: list[Future[Any]] = []
        self._thread = threading.Thread(
            target=_work, args=(self._calls,), name="renderer", daemon=True
        )
        self._thread.start()
        try:
            with _one_mesa_thread():
                self.renderer = self.submit(FilamentRenderer, model, lens).result()
        except BaseException:
            self._end()
            raise
        _open.add(self)

    def __enter__(self) -> RendererThread:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Cancel what waits, close the renderer and end the thread. It may be called again."""
        inside = threading.current_thread() is self._thread
        if not self._closed:
            self._closed = True
            self.cancel()
            if inside:
                self.renderer.close()
            else:
                self.submit(self.renderer.close)
            self._calls.put(None)
        if not inside and not sys.is_finalizing():
            self._thread.join()  # also if an earlier call was interrupted here

    def cancel(self) -> None:
        """Cancel everything that was submitted and has not begun."""
        for asked in self._asked:
            asked.cancel()
        self._asked = []

    def _end(self) -> None:
        self._calls.put(None)
        self._thread.join()

    def submit(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Call a function in the thread, after everything that was submitted before.

        Returns:
            Its result, or what it raises, to be waited for. It is cancelled if the context ends
            before the function is called.
        """
        asked: Future[R] = Future()
        self._calls.put((asked, partial(function, *args, **kwargs)))
        self._asked = [*(other for other in self._asked if not other.done()), asked]
        return asked


_open: weakref.WeakSet[RendererThread] = weakref.WeakSet()
"""Threads to be closed at the end of Python. Those that the garbage collector is about to end are
no longer in it."""


@atexit.register
def _close_all() -> None:
    """Close what nobody has closed: Python would crash if it ended before a renderer."""
    for thread in list(_open):
        thread.close()


@contextmanager
def _one_mesa_thread() -> Iterator[None]:
    """Let contexts that are made in the with block use one thread, unless the user has chosen."""
    if MESA_THREADS in os.environ:
        yield
        return
    os.environ[MESA_THREADS] = "1"
    try:
        yield
    finally:
        os.environ.pop(MESA_THREADS, None)


def _work(calls: Calls) -> None:
    """Make the calls in turn. The thread refers to nothing else, so that it is never garbage."""
    while (call := calls.get()) is not None:
        asked, function = call
        if asked.set_running_or_notify_cancel():
            try:
                asked.set_result(function())
            except BaseException as error:
                asked.set_exception(error)
        del call, asked, function  # a waiting thread keeps no results alive
