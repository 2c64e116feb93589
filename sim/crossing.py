"""One crossing of a vehicle: the luminance image and the ground truth of every sample."""

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
from flybench.memory import count_memory
from sim.cache.key import luminance_key
from sim.cache.luminance_cache import LuminanceCache, LuminanceStream
from sim.cache.luminance_file import LuminanceSample
from sim.config import CrossingConfig
from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rectangles import (
    Rectangle,
    enclosing_rectangle,
    image_rectangle,
    rectangle_of_points,
)
from sim.keyframes.midpoints import with_midpoints
from sim.keyframes.reprojection import RenderedSample, Reprojection
from sim.keyframes.rotation_warp import steady_lens
from sim.motion.sample_times import sample_times_us
from sim.render.filament import FilamentRenderer, Luminance, rendering_bytes
from sim.render.free_memory import return_large_blocks
from sim.render.kept_renderer import renderer_thread
from sim.render.luminance_model import luminance_model
from sim.scene.lamp_flicker import FlickeringLamps
from sim.scene.scene import Scene, build_scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder
from sim.truth.dense_truth import RATE_STEP_S
from sim.truth.ground_truth import GroundTruth
from sim.truth.probe import TruthProbe

BEAM_STEP_FACTOR = 4
"""Headlight beams may move this many times `step_px` between two samples, because their edges are
several pixels wide (assumed)."""
SAMPLES_PER_FLICKER_PERIOD = 20
"""Samples in one period of the lamps' flicker (assumed)."""


@dataclass(frozen=True)
class Sample:
    """Luminance and ground truth at one instant.

    Attributes:
        t_us: time since the start of the sequence [µs].
        luminance: (height, width) float32 mean luminance of each pixel [cd/m²].
        truth: ground truth for every moving object, the target first.
        changed: rectangle x0, y0, x1, y1, half-open [px]. Outside it, every luminance value is
            exactly that of the previous sample.
    """

    t_us: int
    luminance: Luminance
    truth: GroundTruth
    changed: Rectangle


class Crossing:
    """A vehicle that crosses a street: its scene, its motion and its samples."""

    def __init__(
        self,
        config: CrossingConfig,
        intrinsics: Intrinsics | None = None,
        *,
        cache: LuminanceCache | None = None,
    ) -> None:
        """Build the scene and plan the motion. Nothing is rendered yet.

        Args:
            config: parameters of the scene and of its sampling.
            intrinsics: lens and sensor; None: a DAVIS346 behind a 6 mm lens.
            cache: where `samples` stores its luminance and looks it up; None: `samples` renders
                every time.

        Raises:
            SceneConfigError: the lead time reaches beyond the end of the motion profile, or the
                lens is not symmetric.
            MemoryBudgetError: the image is too large for the memory budget.
        """
        return_large_blocks()
        self.config, self.cache = config, cache
        self.intrinsics = lens = intrinsics or Intrinsics()
        lens.require_symmetry()
        needed = rendering_bytes(lens, config.supersample)
        count_memory(self, f"Rendering of {lens.width}×{lens.height} px", needed)
        self.scene: Scene = build_scene(config)
        self.trajectory = self.scene.trajectory
        reach_m = self.scene.reach_m(self.scene.target, self._half_view_rad())
        self._start_s = self.trajectory.time_at_s(-reach_m) - config.lead_s
        self._end_s = self.trajectory.time_at_s(reach_m) + config.lead_s
        # Sampling and ground truth use times slightly beyond both ends: find invalid times here.
        margin_s = config.max_step_ms * 1e-3 + RATE_STEP_S
        for t_s in (self._start_s - margin_s, self._end_s + margin_s):
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
        """Convert time since the start of the sequence [µs] to time since closest approach [s]."""
        return self._start_s + t_us * 1e-6

    def position_m(self, t_us: int) -> float:
        """Position of the vehicle along its path, 0 at closest approach [m]."""
        return self.trajectory.position_m(self.seconds(t_us))

    def times_us(self) -> list[int]:
        """Times of the samples [µs]."""
        longest_us = round(self.config.max_step_ms * 1e3)
        if flicker := self.scene.flicker:
            longest_us = min(longest_us, int(1e6 / flicker.rate_hz / SAMPLES_PER_FLICKER_PERIOD))
        return list(
            sample_times_us(
                0,
                self.duration_us,
                self._fastest_px_s,
                step_px=self.config.drawn_step_px,
                max_step_us=longest_us,
            )
        )

    def samples(self, times_us: Sequence[int] | None = None) -> Iterator[Sample]:
        """Render the sequence from keyframes; see `sim.keyframes.reprojection`.

        Args:
            times_us: strictly increasing sample times [µs]; None: `times_us()`, in draft and fine
                quality with samples half way between them, see `sim.keyframes.midpoints`.

        Yields:
            Samples in order of time. Each owns its arrays.

        Raises:
            RendererError: this machine cannot render.
            SceneConfigError: the times are not strictly increasing, or there are none.
        """
        times = self.times_us() if times_us is None else list(times_us)
        if not times or not all(early < late for early, late in itertools.pairwise([-1, *times])):
            raise SceneConfigError(
                f"times_us holds {len(times)} times that are not strictly increasing from 0. "
                "Allowed is at least one time of 0 or more, each later than the previous one. "
                "Sort the times and remove duplicates."
            )
        probe = TruthProbe(self.scene, self.intrinsics, [self.seconds(t) for t in times])
        frames = self._cached_luminance(times)
        if times_us is None and self.config.has_midpoints:
            frames = with_midpoints(frames)
        for frame in frames:
            truth = probe.measure(frame.t_us, self.seconds(frame.t_us), frame.body)
            yield Sample(frame.t_us, frame.luminance, truth, frame.changed)

    def render_ahead(self, times_us: Sequence[int] | None = None) -> Iterator[int]:
        """Render into the cache what `samples` will read, before other stages take memory.

        This ends at once if there is no cache or if the cache holds the sequence already. It ends
        early if the cache turns out to have no room for the sequence.

        Args:
            times_us: times of the samples, as for `samples` [µs].

        Yields:
            Times of the rendered samples, in order [µs].

        Raises:
            RendererError: this machine cannot render.
        """
        if self.cache is None:
            return
        times = self.times_us() if times_us is None else list(times_us)
        with closing(self._cached_luminance(times)) as frames:
            for frame in frames:
                if not self.cache.stores:
                    return
                yield frame.t_us

    def _cached_luminance(self, times_us: Sequence[int]) -> LuminanceStream:
        """Luminance from the cache if there is one, else from the renderer."""
        if self.cache is None:
            return self._rendered_luminance(times_us)
        return self.cache.samples(
            luminance_key(self.config, self.scene.model, self.intrinsics, times_us),
            (self.intrinsics.height, self.intrinsics.width),
            len(times_us),
            lambda start: self._rendered_luminance(times_us, start),
        )

    def _rendered_luminance(self, times_us: Sequence[int], start: int = 0) -> LuminanceStream:
        """Render the samples from number `start` on; they do not depend on the start."""
        with self.keyframe_renderer(times_us) as render:
            previous = [image_rectangle(self.intrinsics)]
            if start:
                previous = render(times_us[start - 1]).rectangles
            for t_us in times_us[start:]:
                rendered = render(t_us)
                changed = enclosing_rectangle(previous + rendered.rectangles)
                yield LuminanceSample(t_us, rendered.luminance, rendered.body, changed)
                previous = rendered.rectangles

    @contextmanager
    def keyframe_renderer(
        self, times_us: Sequence[int]
    ) -> Iterator[Callable[[int], RenderedSample]]:
        """Open a renderer that makes samples from keyframes.

        Args:
            times_us: strictly increasing times for which the keyframes are planned [µs].

        Yields:
            Function that renders the sample at a time from the first to the last of `times_us`
            [µs]. Each call's time must be no earlier than that of the call before.

        Raises:
            RendererError: this machine cannot render.
        """
        lens = steady_lens(self.scene, self.intrinsics, [self.seconds(t) for t in times_us])
        with renderer_thread(self.scene.model, lens) as thread:
            reprojection = Reprojection(
                thread,
                self.scene,
                self.intrinsics,
                times_us,
                self.seconds,
                supersample=self.config.supersample,
                spacing_px=self.config.drawn_keyframe_px,
                step_px=self.config.drawn_step_px,
                cache=self.cache,
            )
            yield reprojection.render

    @contextmanager
    def full_frame_renderer(
        self, supersample: int | None = None, rectangle: Rectangle | None = None
    ) -> Iterator[Callable[[int], Luminance]]:
        """Open a renderer that renders every frame completely, without keyframes.

        This is the reference that `samples` is compared with. It also renders the background again
        for every frame. The renderer then moves the edges of the background's shadows by a fraction
        of a pixel as the vehicle moves, which does not happen in `samples`.

        Args:
            supersample: rendered pixels per sensor pixel and axis; None: as configured.
            rectangle: pixels to render; None: the whole image.

        Yields:
            Function that renders the luminance at a time [µs].

        Raises:
            RendererError: this machine cannot render.
        """
        scene, model = self.scene, luminance_model(self.scene.model)
        lamps = FlickeringLamps(scene.flickering_lights, scene.flickering_materials)
        pixels = rectangle or image_rectangle(self.intrinsics)
        size = supersample or self.config.supersample
        with FilamentRenderer(model, self.intrinsics) as renderer:
            data = mujoco.MjData(model)

            def render(t_us: int) -> Luminance:
                t_s = self.seconds(t_us)
                scene.place(data, t_s)
                with lamps.scaled(model, scene.flicker_factor(t_s)):
                    renderer.update(data)
                    return renderer.luminance(scene.pose_at(t_s), pixels, supersample=size)

            yield render

    def _fastest_px_s(self, t_us: int) -> float:
        """Upper bound of the image speed of everything in view; 0 if nothing moves."""
        longest_us = round(self.config.max_step_ms * 1e3)
        before_us = t_us // longest_us * longest_us
        return max(self._speed_at_px_s(before_us), self._speed_at_px_s(before_us + longest_us))

    @lru_cache(maxsize=4)  # noqa: B019, it keeps four crossings alive at most
    def _speed_at_px_s(self, t_us: int) -> float:
        t_s = self.seconds(t_us)
        self.scene.place(self._data, t_s)
        reach = self._reach.find(self._data)
        objects = zip(self.scene.objects, reach.shadows, strict=True)
        in_view = {obj.name for obj, areas in objects if areas.any()}
        in_view |= {o.name for o in self.scene.objects if self._in_view(o.corners_m(self._data))}
        with_beams = {o.name for o in self.scene.objects if o.lamps.size and len(reach.beams)}
        focal_px = self.intrinsics.focal_px
        edges_px_s = self.scene.fastest_px_s(t_s, focal_px, in_view)
        beams_px_s = self.scene.fastest_px_s(t_s, focal_px, with_beams)
        return max(edges_px_s, beams_px_s / BEAM_STEP_FACTOR)

    def _in_view(self, corners_m: npt.NDArray[np.float64]) -> bool:
        return rectangle_of_points(corners_m, self.scene.pose, self.intrinsics) is not None

    def _half_view_rad(self) -> float:
        horizontal = self.config.direction in (Direction.RIGHT, Direction.LEFT)
        return self.intrinsics.half_width_rad if horizontal else self.intrinsics.half_height_rad
