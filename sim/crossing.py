"""A crossing, sample by sample: what light reaches the camera, and what is true."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.camera import Intrinsics
from sim.config import CrossingConfig, Direction
from sim.mains import Mains
from sim.moving_light import LightReach
from sim.renderer import FilamentRenderer, Luminance, luminance_model
from sim.reprojection import Drawn, Reprojection, rest_lens
from sim.sampling import sample_times_us
from sim.scene import Scene, build_scene
from sim.truth import GroundTruth, ground_truth
from sim.windows import Window, hull, points_window

BEAM_SOFTNESS = 4
"""The beams alone have no edge sharper than some pixels, so they may move farther in a step."""
FLICKER_STEPS = 20
"""Samples in a period of lamps that flicker (assumed)."""


@dataclass(frozen=True)
class Sample:
    """What the camera sees at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 [cd/m²]; the mean over each pixel.
        truth: the target's.
        changed: x0, y0, x1, y1 of a window outside of which the light is exactly as at the sample
            before, half-open [px].
    """

    t_us: int
    luminance: Luminance
    truth: GroundTruth
    changed: Window


class Crossing:
    """One vehicle's crossing: its scene, its motion, and how it is sampled."""

    def __init__(self, config: CrossingConfig, intrinsics: Intrinsics | None = None) -> None:
        """Compose the scene and plan the motion; nothing is drawn yet.

        Args:
            config: what to show.
            intrinsics: the lens and sensor; None: a DAVIS346 behind 6 mm.

        Raises:
            SceneConfigError: the lead time asks for more than the profile can give.
        """
        self.config = config
        self.intrinsics = intrinsics or Intrinsics()
        self.scene: Scene = build_scene(config)
        self.trajectory = self.scene.trajectory
        reach_m = self.scene.reach_m(self.scene.target, self._half_view_rad())
        self._start_s = self.trajectory.time_at_s(-reach_m) - config.lead_s
        self._end_s = self.trajectory.time_at_s(reach_m) + config.lead_s
        self.trajectory.position_m(self._start_s)
        self._data = mujoco.MjData(self.scene.model)
        self.scene.place(self._data, 0.0)
        self._reach = LightReach(
            self.scene.model, self._data, self.scene.objects, self.scene.pose, self.intrinsics
        )

    @property
    def duration_us(self) -> int:
        """Length of the sequence [µs]."""
        return round((self._end_s - self._start_s) * 1e6)

    def seconds(self, t_us: int) -> float:
        """Time since closest approach [s] of a time since the start [µs]."""
        return self._start_s + t_us * 1e-6

    def position_m(self, t_us: int) -> float:
        """Where the vehicle is on its way [m]."""
        return self.trajectory.position_m(self.seconds(t_us))

    def times_us(self) -> list[int]:
        """When the samples are [µs]."""
        longest_us = round(self.config.max_step_ms * 1e3)
        if flicker := self.scene.flicker:
            longest_us = min(longest_us, int(1e6 / flicker.rate_hz / FLICKER_STEPS))
        return list(
            sample_times_us(
                0,
                self.duration_us,
                self._fastest_px_s,
                step_px=self.config.step_px,
                max_step_us=longest_us,
            )
        )

    def samples(self, times_us: Sequence[int] | None = None) -> Iterator[Sample]:
        """The sequence, from keyframes; see `sim.reprojection`.

        Args:
            times_us: increasing, instead of `times_us()` [µs].

        Yields:
            Samples in order of time; each owns its arrays.

        Raises:
            RendererError: this machine cannot render.
        """
        times = self.times_us() if times_us is None else list(times_us)
        model = luminance_model(self.scene.model)
        lens = rest_lens(self.scene, self.intrinsics, [self.seconds(t) for t in times])
        with FilamentRenderer(model, lens) as renderer:
            drawing = Reprojection(
                renderer,
                model,
                self.scene,
                self.intrinsics,
                times,
                self.seconds,
                supersample=self.config.supersample,
                spacing_px=self.config.keyframe_px,
                step_px=self.config.step_px,
            )
            before = [(0, 0, self.intrinsics.width, self.intrinsics.height)]
            for t_us in times:
                drawn = drawing.draw(t_us)
                yield self._sample(t_us, drawn, hull(before + drawn.windows))
                before = drawn.windows

    @contextmanager
    def full_frames(self, supersample: int | None = None) -> Iterator[Callable[[int], Luminance]]:
        """Give a function that draws the whole image at a time [µs], nothing taken over.

        What `samples` is held against. Unlike them it draws the street anew too, whose shadows'
        edges the renderer moves by a fraction of a pixel with the vehicle.

        Args:
            supersample: rendered pixels per sensor pixel and axis; the configuration's if None.

        Raises:
            RendererError: this machine cannot render.
        """
        scene, model = self.scene, luminance_model(self.scene.model)
        mains = Mains(scene.mains_lights, scene.mains_materials)
        whole = (0, 0, self.intrinsics.width, self.intrinsics.height)
        size = supersample or self.config.supersample
        with FilamentRenderer(model, self.intrinsics) as renderer:
            data = mujoco.MjData(model)

            def draw(t_us: int) -> Luminance:
                t_s = self.seconds(t_us)
                scene.place(data, t_s)
                with mains.scaled(model, scene.mains_factor(t_s)):
                    renderer.update(data)
                    return renderer.luminance(scene.pose_at(t_s), whole, supersample=size)

            yield draw

    def _sample(self, t_us: int, drawn: Drawn, changed: Window) -> Sample:
        truth = ground_truth(
            self.scene,
            self.trajectory,
            self.intrinsics,
            t_us=t_us,
            t_s=self.seconds(t_us),
            mask=np.isin(drawn.visible.body, self.scene.target.bodies),
        )
        return Sample(t_us, drawn.luminance, truth, changed)

    def _fastest_px_s(self, t_us: int) -> float:
        """Image speed of the fastest thing that moves in view; 0 where nothing does."""
        t_s = self.seconds(t_us)
        self.scene.place(self._data, t_s)
        reach = self._reach.at(self._data)
        fastest = self.scene.fastest_px_s(t_s, self.intrinsics.focal_px)
        bodies = (obj.corners_m(self._data) for obj in self.scene.objects)
        if self.scene.shake or reach.shadows or any(map(self._in_view, bodies)):
            return fastest
        return fastest / BEAM_SOFTNESS if reach.beams else 0.0

    def _in_view(self, corners_m: npt.NDArray[np.float64]) -> bool:
        return points_window(corners_m, self.scene.pose, self.intrinsics) is not None

    def _half_view_rad(self) -> float:
        level = self.config.direction in (Direction.RIGHT, Direction.LEFT)
        return self.intrinsics.half_width_rad if level else self.intrinsics.half_height_rad
