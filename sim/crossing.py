"""A crossing, sample by sample: what light reaches the camera, and what is true."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np
import numpy.typing as npt

from flybench.direction import Direction
from sim.cache.key import luminance_key
from sim.cache.luminance_cache import LuminanceCache, LuminanceStream
from sim.cache.luminance_file import LuminanceSample
from sim.config import CrossingConfig
from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rectangles import Rectangle, hull, points_rectangle, whole
from sim.keyframes.reprojection import RenderedSample, Reprojection
from sim.keyframes.steady_lens import steady_lens
from sim.motion.sample_times import sample_times_us
from sim.render.filament import FilamentRenderer, Luminance
from sim.render.free_memory import return_large_blocks
from sim.render.luminance_model import luminance_model
from sim.scene.lamp_flicker import FlickeringLamps
from sim.scene.scene import Scene, build_scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder
from sim.truth.dense_truth import RATE_STEP_S
from sim.truth.ground_truth import GroundTruth
from sim.truth.probe import TruthProbe

BEAM_STEP = 4
"""The beams alone have no edge sharper than some pixels, so they may move farther in a step
(assumed)."""
FLICKER_STEPS = 20
"""Samples in a period of lamps that flicker (assumed)."""


@dataclass(frozen=True)
class Sample:
    """What the camera sees at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 [cd/m²]; the mean over each pixel.
        truth: of everything that moves, the target first.
        changed: x0, y0, x1, y1 of a rectangle outside of which the light is exactly as at the
            sample before, half-open [px].
    """

    t_us: int
    luminance: Luminance
    truth: GroundTruth
    changed: Rectangle


class Crossing:
    """One vehicle's crossing: its scene, its motion, and how it is sampled."""

    def __init__(
        self,
        config: CrossingConfig,
        intrinsics: Intrinsics | None = None,
        *,
        cache: LuminanceCache | None = None,
    ) -> None:
        """Compose the scene and plan the motion; nothing is drawn yet.

        Args:
            config: what to show.
            intrinsics: the lens and sensor; None: a DAVIS346 behind 6 mm.
            cache: where the light of `samples` is kept; None: nowhere, it is drawn each time.

        Raises:
            SceneConfigError: the lead time asks for more than the profile can give.
        """
        return_large_blocks()
        self.config, self.cache = config, cache
        self.intrinsics = intrinsics or Intrinsics()
        self.scene: Scene = build_scene(config)
        self.trajectory = self.scene.trajectory
        reach_m = self.scene.reach_m(self.scene.target, self._half_view_rad())
        self._start_s = self.trajectory.time_at_s(-reach_m) - config.lead_s
        self._end_s = self.trajectory.time_at_s(reach_m) + config.lead_s
        spare_s = config.max_step_ms * 1e-3 + RATE_STEP_S  # asked about, beyond the ends
        for t_s in (self._start_s - spare_s, self._end_s + spare_s):
            self.trajectory.position_m(t_s)
        self._data = mujoco.MjData(self.scene.model)
        self.scene.place(self._data, 0.0)
        self._reach = AffectedAreaFinder(
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
        """The sequence, from keyframes; see `sim.keyframes.reprojection`.

        Args:
            times_us: increasing, instead of `times_us()` [µs].

        Yields:
            Samples in order of time; each owns its arrays.

        Raises:
            RendererError: this machine cannot render.
            SceneConfigError: the times do not rise, or there are none.
        """
        times = self.times_us() if times_us is None else list(times_us)
        if not times or any(late <= early for early, late in itertools.pairwise([-1, *times])):
            raise SceneConfigError(
                f"the times of the samples are {len(times)} numbers that do not rise from 0 or "
                "more; allowed is at least one, each later than the one before; sort them"
            )
        probe = TruthProbe(self.scene, self.intrinsics)
        for light in self._kept_light(times):
            truth = probe.at(light.t_us, self.seconds(light.t_us), light.body)
            yield Sample(light.t_us, light.luminance, truth, light.changed)

    def draw_ahead(self) -> Iterator[int]:
        """Draw into the cache what `samples` will read, before anything else takes memory.

        Where all is kept already, or nothing can be, it ends at once; where the cache has no room
        for so much, as soon as that is known.

        Yields:
            Times of what is drawn, in order [µs].

        Raises:
            RendererError: this machine cannot render.
        """
        if self.cache is None:
            return
        known = self.cache.rendered
        with closing(self._kept_light(self.times_us())) as lights:
            for light in lights:
                if self.cache.rendered == known or not self.cache.stores:
                    return
                yield light.t_us

    def _kept_light(self, times_us: Sequence[int]) -> LuminanceStream:
        """From the cache where there is one."""
        if self.cache is None:
            return self._light(times_us)
        return self.cache.samples(
            luminance_key(self.config, self.scene.model, self.intrinsics, times_us),
            (self.intrinsics.height, self.intrinsics.width),
            len(times_us),
            lambda: self._light(times_us),
        )

    def _light(self, times_us: Sequence[int]) -> LuminanceStream:
        with self.from_keyframes(times_us) as draw:
            before = [whole(self.intrinsics)]
            for t_us in times_us:
                drawn = draw(t_us)
                changed = hull(before + drawn.rectangles)
                yield LuminanceSample(t_us, drawn.luminance, drawn.visible.body, changed)
                before = drawn.rectangles

    @contextmanager
    def from_keyframes(self, times_us: Sequence[int]) -> Iterator[Callable[[int], RenderedSample]]:
        """Give a function that draws samples from keyframes, at times that may not go back [µs].

        Args:
            times_us: increasing; the keyframes are planned on them, and the function takes any time
                from the first to the last [µs].

        Raises:
            RendererError: this machine cannot render.
        """
        model = luminance_model(self.scene.model)
        lens = steady_lens(self.scene, self.intrinsics, [self.seconds(t) for t in times_us])
        with FilamentRenderer(model, lens) as renderer:
            drawing = Reprojection(
                renderer,
                model,
                self.scene,
                self.intrinsics,
                times_us,
                self.seconds,
                supersample=self.config.supersample,
                spacing_px=self.config.keyframe_px,
                step_px=self.config.step_px,
            )
            yield drawing.render

    @contextmanager
    def full_frames(
        self, supersample: int | None = None, rectangle: Rectangle | None = None
    ) -> Iterator[Callable[[int], Luminance]]:
        """Give a function that draws the image at a time [µs], nothing taken over.

        What `samples` is held against. Unlike them it draws the street anew too, whose shadows'
        edges the renderer moves by a fraction of a pixel with the vehicle.

        Args:
            supersample: rendered pixels per sensor pixel and axis; the configuration's if None.
            rectangle: which pixels; all if None.

        Raises:
            RendererError: this machine cannot render.
        """
        scene, model = self.scene, luminance_model(self.scene.model)
        mains = FlickeringLamps(scene.flickering_lights, scene.flickering_materials)
        pixels = rectangle or whole(self.intrinsics)
        size = supersample or self.config.supersample
        with FilamentRenderer(model, self.intrinsics) as renderer:
            data = mujoco.MjData(model)

            def draw(t_us: int) -> Luminance:
                t_s = self.seconds(t_us)
                scene.place(data, t_s)
                with mains.scaled(model, scene.flicker_factor(t_s)):
                    renderer.update(data)
                    return renderer.luminance(scene.pose_at(t_s), pixels, supersample=size)

            yield draw

    def _fastest_px_s(self, t_us: int) -> float:
        """A bound on the image speed of anything that moves in view; 0 where nothing does."""
        longest_us = round(self.config.max_step_ms * 1e3)
        before = t_us // longest_us * longest_us
        return max(self._speed_at_px_s(before), self._speed_at_px_s(before + longest_us))

    @lru_cache(maxsize=4)  # noqa: B019, which the crossing outlives
    def _speed_at_px_s(self, t_us: int) -> float:
        t_s = self.seconds(t_us)
        self.scene.place(self._data, t_s)
        reach = self._reach.find(self._data)
        seen = {obj.name for _, obj, _ in reach.shadows}
        seen |= {o.name for o in self.scene.objects if self._in_view(o.corners_m(self._data))}
        focal_px = self.intrinsics.focal_px
        sharp = self.scene.fastest_px_s(t_s, focal_px, seen)
        lit = {o.name for o in self.scene.objects if o.lamps.size} if reach.beams else set()
        return max(sharp, self.scene.fastest_px_s(t_s, focal_px, lit) / BEAM_STEP)

    def _in_view(self, corners_m: npt.NDArray[np.float64]) -> bool:
        return points_rectangle(corners_m, self.scene.pose, self.intrinsics) is not None

    def _half_view_rad(self) -> float:
        level = self.config.direction in (Direction.RIGHT, Direction.LEFT)
        return self.intrinsics.half_width_rad if level else self.intrinsics.half_height_rad
