"""A renderer in a thread of its own, so that keyframes are rendered while samples are drawn.

Filament must be used by the thread that created it. The results do not depend on timing: one thread
does everything in the order in which it was asked to.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

import mujoco

from sim.geometry.pinhole import Intrinsics
from sim.render.filament import FilamentRenderer

P = ParamSpec("P")
R = TypeVar("R")


class RendererThread:
    """A thread that owns a renderer. Use as a context manager.

    Attributes:
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
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="renderer")
        self._asked: list[Future[Any]] = []
        try:
            self.renderer = self._thread.submit(FilamentRenderer, model, lens).result()
        except BaseException:
            self._thread.shutdown()
            raise

    def __enter__(self) -> RendererThread:
        return self

    def __exit__(self, *_: object) -> None:
        for asked in self._asked:
            asked.cancel()
        self._thread.submit(self.renderer.close).result()
        self._thread.shutdown()

    def submit(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Call a function in the thread, after everything that was submitted before.

        Returns:
            Its result, or what it raises, to be waited for. It is cancelled if the context ends
            before the function is called.
        """
        asked = self._thread.submit(function, *args, **kwargs)
        self._asked = [*(other for other in self._asked if not other.done()), asked]
        return asked
