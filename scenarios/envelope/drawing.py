"""Events of a synthetic stimulus, and its ground truth at every time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from detector.metrics import Box
from emulator import SensorConfig
from flybench.events import Events, concatenate_events
from scenarios.envelope.noise import merge_streams, poisson_noise
from scenarios.envelope.pixels import DEFAULT_SENSOR, PixelArray, threshold_scale
from scenarios.envelope.scene import Scene, make_scene
from scenarios.envelope.stimulus import Stimulus

F64 = npt.NDArray[np.float64]

STEP_PX = 0.5
"""Greatest motion between two images; log luminance is interpolated linearly between them."""
MAX_STEP_US = 10_000.0
"""Longest time between two images."""
_EDGE_PX = 2
"""How far around a layer its motion may change pixels."""


@dataclass(frozen=True, eq=False)
class DrawnStimulus:
    """Events of a synthetic stimulus, and its ground truth.

    Attributes:
        stimulus: description of the stimulus.
        scene: layers and motion that the description leads to.
        events: (n,) of `EVENT_DTYPE`, of scene and noise, sorted by t.
        in_view_us: first and last time at which the target is in view [µs].
    """

    stimulus: Stimulus
    scene: Scene
    events: Events
    in_view_us: tuple[int, int]

    @property
    def duration_us(self) -> int:
        """Length of the stream [µs]."""
        return self.scene.duration_us

    def box_px(self, t_us: int) -> Box | None:
        """Return the bounding box of the visible target [px], half-open; None if out of view."""
        x0, y0, x1, y1 = self.scene.target_px(np.array([float(t_us)]))[0]
        if x0 >= x1 or y0 >= y1:
            return None
        return math.floor(x0), math.floor(y0), math.ceil(x1), math.ceil(y1)

    def centroid_px(self, t_us: int) -> tuple[float, float] | None:
        """Return the centre of the visible target [px]; None if out of view."""
        x0, y0, x1, y1 = self.scene.target_px(np.array([float(t_us)]))[0]
        return None if x0 >= x1 or y0 >= y1 else (float(x0 + x1) / 2, float(y0 + y1) / 2)


def draw_stimulus(stimulus: Stimulus, sensor: SensorConfig = DEFAULT_SENSOR) -> DrawnStimulus:
    """Generate the events of a stimulus; equal stimuli give the same events, bit for bit.

    Args:
        stimulus: the stimulus.
        sensor: sensor whose thresholds the pixels have.
    """
    scene = make_scene(stimulus)
    noise = poisson_noise(
        stimulus.noise_hz,
        width=stimulus.width,
        height=stimulus.height,
        duration_us=scene.duration_us,
        rng=np.random.default_rng((stimulus.seed, 2)),
    )
    signal = concatenate_events(list(_signal_events(scene, sensor)))
    events = merge_streams(signal, noise)
    return DrawnStimulus(stimulus, scene, events, _in_view_us(scene))


def _signal_events(scene: Scene, sensor: SensorConfig) -> Iterator[Events]:
    """Yield the events that the scene causes, step by step, sorted by time."""
    steps = math.ceil(scene.duration_us / _step_us(scene))
    times_us = np.linspace(0, scene.duration_us, steps + 1)
    shifts, corners = scene.image_shift_px(times_us), scene.corners_px(times_us)
    pixels = PixelArray(
        scene.background,
        [layer.texture for layer in scene.layers],
        [layer.opacity for layer in scene.layers],
        margin_px=scene.margin_px,
        sensor=sensor,
        scale=threshold_scale(scene.stimulus.events_per_edge),
        rng=np.random.default_rng((scene.stimulus.seed, 1)),
    )
    pixels.adapt(shifts[0], corners[0])
    for n in range(steps):
        parts = [
            pixels.step(
                shifts[n + 1],
                corners[n + 1],
                region,
                start_us=times_us[n],
                step_us=times_us[n + 1] - times_us[n],
            )
            for region in _changed_regions(scene, corners[n], corners[n + 1])
        ]
        events = concatenate_events(parts)
        yield events[np.argsort(events["t"], kind="stable")]


def _step_us(scene: Scene) -> float:
    return min(STEP_PX / scene.max_speed_px_s * 1e6, MAX_STEP_US)


def _changed_regions(scene: Scene, before: F64, after: F64) -> Iterator[Box]:
    """Yield the regions that a step may change: around the layers, or the whole image."""
    s = scene.stimulus
    if scene.shake is not None:
        yield 0, 0, s.width, s.height
        return
    for n, layer in enumerate(scene.layers):
        low, high = np.minimum(before[n], after[n]), np.maximum(before[n], after[n])
        (x0, y0), (x1, y1) = low - _EDGE_PX, high + layer.size_px + _EDGE_PX
        box = max(int(x0), 0), max(int(y0), 0), min(int(x1), s.width), min(int(y1), s.height)
        if box[0] < box[2] and box[1] < box[3]:
            yield box


def _in_view_us(scene: Scene) -> tuple[int, int]:
    """Return the first and last whole millisecond at which the target is in view [µs]."""
    times_us = np.arange(0, scene.duration_us + 1, 1000)
    x0, y0, x1, y1 = scene.target_px(times_us.astype(np.float64)).T
    visible = times_us[(x1 > x0) & (y1 > y0)]
    return (int(visible[0]), int(visible[-1])) if visible.size else (0, 0)
