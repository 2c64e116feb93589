"""What determines the light of a sequence, as one name: same name, same light, bit for bit."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Sequence
from dataclasses import asdict

import cv2
import mujoco
import numba
import numpy as np

from flybench.sources import LUMINANCE, sources_digest
from sim.config import CrossingConfig
from sim.geometry.pinhole import Intrinsics
from sim.render.vulkan import vulkan_devices


def luminance_key(
    config: CrossingConfig, model: mujoco.MjModel, lens: Intrinsics, times_us: Sequence[int]
) -> str:
    """64 hexadecimal digits that tell a sequence's light from any other.

    They stand for the configuration, the compiled scene (and so all assets in it), the lens, the
    times, the sources of `sim` and `flybench` as they were when first asked for, the libraries
    that draw, the machine's architecture, and its Vulkan devices with their drivers.

    Args:
        config: what is shown.
        model: the compiled scene.
        lens: the camera's.
        times_us: of the samples [µs].
    """
    said = {
        "config": config.resolved(),
        "lens": asdict(lens),
        "sources": sources_digest(*LUMINANCE),
        "libraries": [library.__version__ for library in (mujoco, np, numba, cv2)],
        "machine": platform.machine(),
        "devices": [asdict(device) for device in vulkan_devices()],
    }
    digest = hashlib.sha256(json.dumps(said, sort_keys=True).encode())
    digest.update(np.array(times_us, np.int64).tobytes())
    digest.update(_bytes(model))
    return digest.hexdigest()


def _bytes(model: mujoco.MjModel) -> bytes:
    """The compiled model as MuJoCo would save it."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
