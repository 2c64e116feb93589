"""Cache keys of luminance: equal keys mean equal luminance, bit for bit."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import cv2
import mujoco
import numba
import numpy as np

from flybench.sources import LUMINANCE_SOURCES, sources_digest
from sim.config import CrossingConfig
from sim.geometry.pinhole import Intrinsics, Pose
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
    rendered = config.resolved()
    del rendered["quality"]  # samples in between are not rendered
    rendered |= {"step_px": config.drawn_step_px, "keyframe_px": config.drawn_keyframe_px}
    digest = _digest({"config": rendered, "lens": asdict(lens)})
    digest.update(np.array(times_us, np.int64).tobytes())
    digest.update(_bytes(model))
    return digest.hexdigest()


def background_key(config: CrossingConfig, lens: Intrinsics, pose: Pose, **options: Any) -> str:
    """Return the key of a rendered background, which other sequences may share.

    The digest covers what `luminance_key` covers, without what changes only moving objects and the
    times of the samples: the background is rendered without moving objects.

    Args:
        config: configuration of the crossing.
        lens: intrinsics of the steady camera.
        pose: pose of the steady camera.
        options: how the background is rendered.

    Returns:
        64 hexadecimal digits.
    """
    street = {k: v for k, v in config.resolved().items() if k not in _OF_MOVERS}
    extra = {k: v for k, v in street.pop("distractors").items() if k not in _OF_MOVERS}
    camera = [vector.tolist() for vector in (pose.position_m, pose.right, pose.up)]
    own = {"wind": extra.pop("wind_grade") > 0, "flicker": extra.pop("flicker_hz") > 0}
    determinants = {"street": street | extra | own, "camera": camera, "lens": asdict(lens)}
    return _digest(determinants | {"background": options}).hexdigest()


_OF_MOVERS = frozenset(
    [
        "omega_rad_s",
        "profile",
        "vehicle",
        "paint_reflectance",
        "direction",
        "distance_m",
        "lead_s",
        "step_px",
        "max_step_ms",
        "supersample",
        "keyframe_px",
        "quality",
        "far_vehicle",
        "far_vehicle_kind",
        "far_vehicle_speed_m_s",
        "far_vehicle_lag_s",
        "far_vehicle_reflectance",
        "pedestrian",
        "pedestrian_pavement",
        "pedestrian_speed_m_s",
        "pedestrian_lag_s",
        "shake_rms_deg",
        "shake_corner_hz",
        "flicker_depth",
        "seed",
    ]
)
"""Parameters that do not change the background, or only through lens, pose and options."""


def _digest(determinants: dict[str, Any]) -> hashlib._Hash:
    """Return a digest of determinants, sources, libraries and the machine."""
    everywhere = {
        "sources": sources_digest(*LUMINANCE_SOURCES),
        "libraries": [library.__version__ for library in (mujoco, np, numba, cv2)],
        "machine": platform.machine(),
        "devices": [asdict(device) for device in vulkan_devices()],
    }
    return hashlib.sha256(json.dumps(determinants | everywhere, sort_keys=True).encode())


def _bytes(model: mujoco.MjModel) -> bytes:
    """Return the compiled model in MuJoCo's file format."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
