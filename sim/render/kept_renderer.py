"""The renderer of the last crossing, kept for the next one with the same model and lens.

Starting a renderer costs 0.5 s of CPU time, most of it in the first image. A sweep over speeds has
the same model at each of its points, since only poses differ.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from sim.geometry.pinhole import Intrinsics
from sim.render.luminance_model import luminance_model
from sim.render.renderer_thread import RendererThread

_Key = tuple[bytes, Intrinsics]

_lock = threading.RLock()
_kept: dict[_Key, RendererThread] = {}
"""The renderer that is kept, if there is one; nobody uses it at present."""
_keeps = False


def keep_renderer() -> None:
    """Keep one renderer from now on, in this process, until `release_renderer` is called.

    It takes some 200 MB while it is not used.
    """
    global _keeps
    _keeps = True


def release_renderer() -> None:
    """Close the renderer that is kept, and keep none from now on."""
    global _keeps
    _keeps = False
    _close_kept()


@contextmanager
def kept_renderer() -> Iterator[None]:
    """Keep one renderer in the with block, and after it only if one was kept before."""
    kept_before = _keeps
    keep_renderer()
    try:
        yield
    finally:
        if not kept_before:
            release_renderer()


@contextmanager
def renderer_thread(model: mujoco.MjModel, lens: Intrinsics) -> Iterator[RendererThread]:
    """Open a renderer of a model's luminance, or take the one that is kept.

    Args:
        model: compiled scene, with colours as authored.
        lens: lens and sensor.

    Yields:
        The thread; its `model` is the luminance model, which the caller must leave as it was.

    Raises:
        RendererError: this machine has no Vulkan device.
    """
    if not _keeps:
        with RendererThread(luminance_model(model), lens) as thread:
            yield thread
        return
    key = _digest(model), lens
    with _lock:
        kept = _kept.pop(key, None)
    if kept is None:
        _close_kept()  # one renderer at a time
        kept = RendererThread(luminance_model(model), lens)
    try:
        yield kept
    except BaseException:  # also if the caller wants no more samples
        kept.close()
        raise
    kept.cancel()
    kept.submit(int).result()  # what had begun may have changed the model for a moment
    with _lock:
        keeps = _keeps and not _kept
        if keeps:
            _kept[key] = kept
    if not keeps:
        kept.close()


def _close_kept() -> None:
    with _lock:
        threads = list(_kept.values())
        _kept.clear()
    for thread in threads:
        thread.close()


def _digest(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.blake2b(buffer.tobytes()).digest()
