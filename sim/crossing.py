"""A crossing, sample by sample: what light reaches the camera, and what is true."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from sim.camera import Intrinsics, Pose
from sim.config import CrossingConfig, Direction
from sim.influence import body_window, influence_window
from sim.renderer import FilamentRenderer, Luminance, luminance_model
from sim.sampling import sample_times_us
from sim.scene import Scene, build_scene
from sim.truth import GroundTruth, ground_truth

BEAM_SOFTNESS = 4
"""The beams alone have no edge sharper than some pixels, so they may move farther in a step."""


@dataclass(frozen=True)
class Sample:
    """What the camera sees at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 [cd/m²]; the mean over each pixel.
        truth: the target's.
    """

    t_us: int
    luminance: Luminance
    truth: GroundTruth


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
        return list(
            sample_times_us(
                0,
                self.duration_us,
                self._fastest_px_s,
                step_px=self.config.step_px,
                max_step_us=round(self.config.max_step_ms * 1e3),
            )
        )

    def samples(self) -> Iterator[Sample]:
        """Render the sequence.

        Yields:
            Samples in order of time; each owns its arrays.

        Raises:
            RendererError: this machine cannot render.
        """
        model = luminance_model(self.scene.model)
        with FilamentRenderer(model, self.intrinsics) as renderer:
            data = mujoco.MjData(model)
            empty = self._empty_street(renderer, data)
            for t_us in self.times_us():
                yield self._sample(renderer, data, t_us, empty)

    @contextmanager
    def full_frames(self) -> Iterator[Callable[[int], Luminance]]:
        """Give a function that draws the whole image at a time [µs], nothing taken over.

        What `samples` is held against, and what a frame costs. Unlike them it draws the street
        anew too, whose shadows' edges the renderer moves by a fraction of a pixel with the vehicle.

        Raises:
            RendererError: this machine cannot render.
        """
        model = luminance_model(self.scene.model)
        with FilamentRenderer(model, self.intrinsics) as renderer:
            data = mujoco.MjData(model)

            def draw(t_us: int) -> Luminance:
                t_s = self.seconds(t_us)
                self.scene.place(data, t_s)
                return self._whole(renderer, data, self.scene.pose_at(t_s))

            yield draw

    def _sample(
        self, renderer: FilamentRenderer, data: mujoco.MjData, t_us: int, empty: Luminance
    ) -> Sample:
        t_s = self.seconds(t_us)
        pose = self.scene.pose_at(t_s)
        luminance = empty.copy()
        mask = np.zeros(empty.shape, np.bool_)
        if window := influence_window(self.scene, t_s, self.intrinsics):
            x0, y0, x1, y1 = window
            self.scene.place(data, t_s)
            renderer.update(data)
            luminance[y0:y1, x0:x1] = renderer.luminance(
                pose, window, supersample=self.config.supersample
            )
        if window := body_window(self.scene, t_s, self.intrinsics):
            x0, y0, x1, y1 = window
            geoms = renderer.segmentation(pose, window)
            mask[y0:y1, x0:x1] = np.isin(geoms, self.scene.vehicle_geoms)
        truth = ground_truth(
            self.scene,
            self.trajectory,
            self.intrinsics,
            t_us=t_us,
            t_s=t_s,
            mask=mask,
        )
        return Sample(t_us, luminance, truth)

    def _empty_street(self, renderer: FilamentRenderer, data: mujoco.MjData) -> Luminance:
        self.scene.vacate(data, self._half_view_rad())
        return self._whole(renderer, data, self.scene.pose)

    def _whole(self, renderer: FilamentRenderer, data: mujoco.MjData, pose: Pose) -> Luminance:
        renderer.update(data)
        whole = (0, 0, self.intrinsics.width, self.intrinsics.height)
        return renderer.luminance(pose, whole, supersample=self.config.supersample)

    def _fastest_px_s(self, t_us: int) -> float:
        """Image speed of the fastest thing that moves in view; 0 where nothing does."""
        t_s = self.seconds(t_us)
        if body_window(self.scene, t_s, self.intrinsics):
            return self.scene.fastest_px_s(t_s, self.intrinsics.focal_px)
        if influence_window(self.scene, t_s, self.intrinsics):
            return self.scene.fastest_px_s(t_s, self.intrinsics.focal_px) / BEAM_SOFTNESS
        return 0.0

    def _half_view_rad(self) -> float:
        level = self.config.direction in (Direction.RIGHT, Direction.LEFT)
        return self.intrinsics.half_width_rad if level else self.intrinsics.half_height_rad
