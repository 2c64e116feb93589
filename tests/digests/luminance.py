"""Digests of luminance, ground truth and preview images."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mujoco
import numpy as np

from emulator import EventSensor, SensorConfig
from flybench.direction import Direction
from flybench.events import Cause
from sim import (
    Crossing,
    CrossingConfig,
    DenseTruth,
    Distractors,
    Intrinsics,
    Lighting,
    LuminanceCache,
    Pavement,
    PhotometricCamera,
    RelativeDirection,
    Sample,
    VehicleKind,
    event_truth,
    preview_jpegs,
)
from sim.photometric_camera import EXAMPLE_LIGHT
from tests.digests.exact import Case

SAMPLES = 12
EVERY_US = 5_000
LENS = Intrinsics(width=230, height=150)
"""The middle of the sensor, which is rendered faster."""
BUSY = Distractors(
    wind_grade=5,
    far_vehicle=RelativeDirection.OPPOSITE,
    pedestrian=RelativeDirection.SAME,
    pedestrian_pavement=Pavement.NEAR,
    shake_rms_deg=0.2,
    flicker_hz=100,
)
CROSSINGS = {
    "day_busy": CrossingConfig(omega_rad_s=1.9, supersample=2, street_seed=1, distractors=BUSY),
    "night_shake": CrossingConfig(
        lighting=Lighting.NIGHT,
        omega_rad_s=1.7,
        supersample=2,
        distractors=Distractors(shake_rms_deg=0.2, flicker_hz=100),
    ),
    "day_plain": CrossingConfig(
        omega_rad_s=2.2, direction=Direction.UP, vehicle=VehicleKind.MOTORCYCLE
    ),
    "dusk_van": CrossingConfig(
        lighting=Lighting.DUSK,
        omega_rad_s=1.8,
        direction=Direction.LEFT,
        vehicle=VehicleKind.VAN,
        distractors=Distractors(wind_grade=3),
    ),
}
MODEL = f"""<mujoco><worldbody>{EXAMPLE_LIGHT}
<camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 .4 1" fovy="45" resolution="96 64"/>
<geom type="plane" size="5 5 .1" rgba=".4 .4 .4 1"/>
<body pos="0 0 .6"><joint type="hinge" axis="0 1 0"/>
<geom type="box" size=".3 .05 .1" rgba=".8 .7 .6 1"/></body>
</worldbody></mujoco>"""


@lru_cache
def crossing(name: str) -> Crossing:
    """Return one of the crossings, without a cache."""
    return Crossing(CROSSINGS[name], LENS)


def middle_us(name: str) -> list[int]:
    """Times of samples before and after the closest approach [µs]."""
    first_us = crossing(name).duration_us // 2 - SAMPLES * EVERY_US // 2
    return [first_us + k * EVERY_US for k in range(SAMPLES)]


@lru_cache
def samples(name: str) -> list[Sample]:
    """The samples of the crossing's middle."""
    return list(crossing(name).samples(middle_us(name)))


def frames(name: str) -> Iterator[Any]:
    """Yield time, luminance and changed rectangle of every sample."""
    for sample in samples(name):
        yield sample.t_us, sample.luminance, sample.changed


def truth(name: str) -> Iterator[Any]:
    """Ground truth of every sample."""
    for sample in samples(name):
        yield sample.truth


def cached(name: str) -> Iterator[Any]:
    """Yield samples that are first rendered into a cache and then read from it."""
    with TemporaryDirectory() as folder:
        for _ in range(2):
            cache = LuminanceCache(Path(folder))
            stored = Crossing(CROSSINGS[name], LENS, cache=cache).samples(middle_us(name))
            yield list(stored), cache.read, cache.rendered


def times(name: str) -> list[int]:
    """Return the times of all samples of a crossing [µs]."""
    return crossing(name).times_us()


def geometry(name: str) -> Iterator[Any]:
    """Depth, flow and displacement at three times."""
    it = crossing(name)
    seen = DenseTruth(it.scene, it.intrinsics)
    for share in (0.3, 0.5, 0.6):
        t_s = it.seconds(round(share * it.duration_us))
        yield seen.depth_m(t_s), seen.flow_px_s(t_s), seen.displacement_px(t_s, t_s + 0.02)


def sources(name: str) -> Any:
    """Return the events of a sensor that sees a crossing, and their sources."""
    sensor = EventSensor(SensorConfig(width=LENS.width, height=LENS.height), seed=3)
    outputs = [sensor.step(s.t_us, s.luminance, changed=s.changed) for s in samples(name)]
    events = np.concatenate([output.events for output in outputs])
    causes = np.concatenate([output.causes for output in outputs])
    return events, causes, event_truth(events, causes, crossing(name), signal=Cause.SIGNAL)


def full_frames(name: str) -> Iterator[Any]:
    """Yield images that are rendered in full."""
    with crossing(name).full_frame_renderer() as draw:
        for t_us in middle_us(name)[::4]:
            yield draw(t_us)


def previews(name: str) -> list[bytes]:
    """Colour pictures."""
    return preview_jpegs(crossing(name), middle_us(name)[::4])


def photometric_camera() -> Iterator[Any]:
    """Yield the luminance, visibility, depth and flow of a camera in a small moving model."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    data.qvel[:] = 4.0
    with PhotometricCamera(model, "eye") as camera:
        for _ in range(4):
            mujoco.mj_step(model, data, 10)
            yield camera.luminance(data), camera.visible(data), camera.depth_m(data)
            yield camera.flow_px_s(data)


CASES: dict[str, Case] = {
    f"luminance.{what.__name__}.{name}": Case(partial(what, name))
    for what in (frames, truth, times, geometry)
    for name in CROSSINGS
} | {
    "luminance.sources.day_busy": Case(partial(sources, "day_busy")),
    "luminance.sources.night_shake": Case(partial(sources, "night_shake")),
    "luminance.full_frames.night_shake": Case(partial(full_frames, "night_shake")),
    "luminance.cached.day_plain": Case(partial(cached, "day_plain")),
    "luminance.previews.day_busy": Case(partial(previews, "day_busy")),
    "luminance.previews.night_shake": Case(partial(previews, "night_shake")),
    "luminance.photometric_camera": Case(photometric_camera),
}
