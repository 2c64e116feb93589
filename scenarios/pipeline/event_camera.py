"""An event camera on any MuJoCo model, stepped beside its simulation."""

from __future__ import annotations

import warnings
from typing import Any, Self

import numpy as np

from emulator import EventSensor, SensorConfig, SensorOutput
from flybench.events import empty_events
from scenarios.errors import ScenarioError
from sim import Intrinsics, PhotometricCamera, SceneConfigError
from sim.render.filament import Luminance

STEP_PX = 0.5
"""The farthest that anything moves between two samples; as in a crossing, where that was enough."""
MAX_STEP_US = 5_000
"""The longest time between two samples (assumed)."""
BELIEVABLE_PX = 1.0
"""Farther than a pixel between samples, and events are in wrong places at wrong times."""


class MotionWarning(UserWarning):
    """Things move too far in the image between two samples of light."""


class EventCamera:
    """A DAVIS346 in the place of a camera of a MuJoCo model. Use as a context manager.

    The sensor takes light as ramping from sample to sample, so that samples must follow the motion.
    They do by themselves: `step` may be called after every step of the physics, and draws the scene
    only when something has moved by half a pixel since it was last drawn, or 5 ms have passed. How
    far things move is known from the exact optical flow that follows from the velocities.

    Attributes:
        intrinsics: size and focal length.
        samples: how many times the scene was drawn.
        luminance: (height, width) float32, the last light that was drawn [cd/m²]; None before.
    """

    def __init__(
        self,
        model: Any,
        camera: str,
        *,
        sensor: SensorConfig | None = None,
        seed: int = 0,
        period_us: int | None = None,
        step_px: float = STEP_PX,
        supersample: int = 2,
        still: bool = False,
        threads: int = 1,
    ) -> None:
        """Set up camera and sensor.

        Args:
            model: a `mujoco.MjModel` with at least one light of an intensity; sim/README.md says
                what makes it physical.
            camera: name of one of its cameras; its image has the sensor's size.
            sensor: the sensor; a DAVIS346 with all its noise where None.
            seed: of everything random.
            period_us: draw every so often instead of following the motion [µs].
            step_px: the farthest that anything moves between two samples [px].
            supersample: rendered pixels per pixel and axis.
            still: accept a model in which nothing can move.
            threads: how many share a step of the sensor.

        Raises:
            ScenarioError: a period or a step that is not positive.
            SceneConfigError: no such camera, no light, nothing that can move.
            SensorConfigError: no such sensor, or a seed that is none.
            RendererError: no Vulkan device.
        """
        if not step_px > 0 or (period_us is not None and not period_us > 0):
            raise ScenarioError(
                f"step_px is {step_px} and period_us is {period_us}; allowed is more than 0; "
                "give pixels such as 0.5, and microseconds such as 1000 or None"
            )
        sensor = sensor or SensorConfig()
        self._sensor = EventSensor(sensor, seed=seed, threads=threads)
        self._camera = PhotometricCamera(
            model,
            camera,
            width=sensor.width,
            height=sensor.height,
            supersample=supersample,
            still=still,
        )
        self.intrinsics: Intrinsics = self._camera.intrinsics
        self.samples = 0
        self.luminance: Luminance | None = None
        self._period_us, self._step_px = period_us, step_px
        self._now_us, self._drawn_us, self._moved_px = -1, -1, 0.0
        self._has_flow = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the device's memory."""
        self._camera.close()

    def step(self, data: Any) -> SensorOutput:
        """Look at the scene as it now is; the first look is what the sensor settles on.

        Args:
            data: the `mujoco.MjData` of the simulation, later than at the last call; it is not
                changed. What moves a mocap body has no velocity, and needs a period.

        Returns:
            Events and frames since the scene was last drawn; none where it was not drawn now.

        Raises:
            ScenarioError: time stands still or goes back; or a shape has no triangles, so that its
                motion is not known, and there is no period.
            SceneConfigError: the data is of another model.
        """
        t_us = round(data.time * 1e6)
        if self._now_us >= 0 and t_us <= self._now_us:
            raise ScenarioError(
                f"the simulation's time is {t_us} µs, and was {self._now_us} µs at the last step; "
                "allowed is a later one; call step once after each mj_step, and make another "
                "camera after mj_resetData"
            )
        before_us, self._now_us = self._now_us, t_us
        if before_us >= 0 and not self._is_due(data, t_us, t_us - before_us):
            return SensorOutput(empty_events(), np.empty(0, np.uint8), ())
        self.luminance = self._camera.luminance(data)
        self.samples += 1
        self._drawn_us, self._moved_px = t_us, 0.0
        return self._sensor.step(t_us, self.luminance)

    def _is_due(self, data: Any, t_us: int, step_us: int) -> bool:
        """Whether to draw; counts how far things have moved."""
        since_us = t_us - self._drawn_us
        if self._period_us is not None:
            if since_us < self._period_us:
                return False
            self._check_motion(self._speed_px_s(data) * since_us * 1e-6, since_us)
            return True
        travel_px = self._speed_px_s(data) * step_us * 1e-6
        self._check_motion(travel_px, step_us)
        self._moved_px += travel_px
        # The next step would take it too far.
        return self._moved_px + travel_px > self._step_px or since_us + step_us > MAX_STEP_US

    def _speed_px_s(self, data: Any) -> float:
        """The fastest motion in the image [px/s]; 0 where it cannot be told."""
        if not self._has_flow:
            return 0.0
        try:
            return float(np.hypot(*self._camera.flow_px_s(data).reshape(-1, 2).T).max())
        except SceneConfigError as error:
            if self._period_us is None:
                raise ScenarioError(
                    f"how far things move is not known: {error}; or give a period_us, such as 1000"
                ) from error
            self._has_flow = False
            return 0.0

    def _check_motion(self, travel_px: float, step_us: int) -> None:
        if travel_px > BELIEVABLE_PX:
            warnings.warn(
                f"things move by {travel_px:.1f} px in {step_us} µs, from one sample of light to "
                f"the next; allowed is {BELIEVABLE_PX:g} px for events to be believed; take a "
                "shorter "
                + ("period_us" if self._period_us is not None else "timestep of the model"),
                MotionWarning,
                stacklevel=4,
            )
