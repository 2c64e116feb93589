"""Cache key of a sequence's luminance: equal keys mean equal luminance, bit for bit."""

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

from flybench.sources import LUMINANCE_SOURCES, sources_digest
from sim.config import CrossingConfig
from sim.geometry.pinhole import Intrinsics
from sim.render.vulkan import vulkan_devices


def luminance_key(
    config: CrossingConfig, model: mujoco.MjModel, lens: Intrinsics, times_us: Sequence[int]
) -> str:
    """Return the key of a sequence: a digest of everything that determines its luminance.

    The digest covers the configuration, the compiled scene (and so all its assets), the lens, the
    sample times, the sources of `sim` and `flybench` as they were when the digest was first
    computed, the versions of the libraries that compute luminance, the machine's architecture, and
    its Vulkan devices with their drivers.

    Args:
        config: configuration of the crossing.
        model: compiled scene.
        lens: intrinsics of the camera.
        times_us: times of the samples [µs].

    Returns:
        64 hexadecimal digits.
    """
    determinants = {
        "config": config.resolved(),
        "lens": asdict(lens),
        "sources": sources_digest(*LUMINANCE_SOURCES),
        "libraries": [library.__version__ for library in (mujoco, np, numba, cv2)],
        "machine": platform.machine(),
        "devices": [asdict(device) for device in vulkan_devices()],
    }
    digest = hashlib.sha256(json.dumps(determinants, sort_keys=True).encode())
    digest.update(np.array(times_us, np.int64).tobytes())
    digest.update(_bytes(model))
    return digest.hexdigest()


def _bytes(model: mujoco.MjModel) -> bytes:
    """Return the compiled model in MuJoCo's file format."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
