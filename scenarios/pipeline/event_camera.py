"""An event camera for any MuJoCo model, stepped together with its simulation."""

from __future__ import annotations

import warnings
from typing import Any, Self

import numpy as np

from emulator import EventSensor, SensorConfig, SensorOutput
from flybench.events import empty_events
from scenarios.errors import ScenarioError
from sim import Illumination, Intrinsics, PhotometricCamera
from sim.render.filament import Luminance

STEP_PX = 0.5
"""Greatest motion between two samples. A crossing uses this value too; it was found sufficient."""
MAX_STEP_US = 5_000
"""Longest time between two samples (assumed)."""
MAX_TRAVEL_PX = 1.0
"""With more motion between two samples, events have wrong positions and times."""


class MotionWarning(UserWarning):
    """Something moves too far in the image between two luminance samples."""


class EventCamera:
    """An event sensor at the position of a camera of a MuJoCo model. Use as a context manager.

    The sensor interpolates luminance linearly between samples, so samples must be dense enough for
    the motion. `step` takes care of this: call it after every physics step. It renders the scene
    only when something has moved by half a pixel since the last rendering, or after 5 ms. The
    motion in the image is computed exactly, from the velocities in the simulation.

    Attributes:
        intrinsics: size and focal length of the camera.
        samples: number of times that the scene was rendered.
        luminance: (height, width) float32, last rendered luminance [cd/m²]; None before the first.
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
        light: str | Illumination | None = None,
        threads: int = 1,
    ) -> None:
        """Create the camera and the sensor.

        Args:
            model: a `mujoco.MjModel` with at least one light that has an intensity, unless `light`
                is given. docs/explanation/any-model.md describes what makes its luminance physical.
            camera: name of a camera of the model; its image gets the sensor's size.
            sensor: configuration of the sensor; None: a DAVIS346 with all its noise.
            seed: seed of everything random.
            period_us: fixed time between renderings [µs]; None: follow the motion.
            step_px: greatest motion between two samples [px].
            supersample: rendered pixels per sensor pixel along each axis.
            still: True to accept a model in which nothing can move.
            light: "daylight", "overcast", "dusk", "indoor" or "night", or an `Illumination`. It
                replaces the model's lights and sky. None: the model's lights.
            threads: number of threads for a sensor step.

        Raises:
            ScenarioError: the period or the step is not positive.
            SceneConfigError: there is no such camera, no light, or nothing that can move; or there
                is no such `light`.
            SensorConfigError: the sensor or the seed is invalid.
            RendererError: there is no Vulkan device.
        """
        if not step_px > 0 or (period_us is not None and not period_us > 0):
            raise ScenarioError(
                f"step_px is {step_px} and period_us is {period_us}. Allowed are numbers above 0. "
                "Choose, for example, step_px=0.5, and period_us=1000 or None."
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
            light=light,
        )
        self.intrinsics: Intrinsics = self._camera.intrinsics
        self.samples = 0
        self.luminance: Luminance | None = None
        self._period_us, self._step_px = period_us, step_px
        self._now_us, self._rendered_us, self._moved_px = -1, -1, 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the memory of the Vulkan device."""
        self._camera.close()

    def step(self, data: Any) -> SensorOutput:
        """Observe the scene in its present state. The sensor adapts to the first observation.

        Args:
            data: the `mujoco.MjData` of the simulation, later than at the last call; it is not
                changed. Mocap bodies have no velocity, so models with moving ones need `period_us`.

        Returns:
            Events and frames since the last rendering; none if the scene is not rendered now.

        Raises:
            ScenarioError: time has not advanced.
            SceneConfigError: the data belongs to another model.
        """
        t_us = round(data.time * 1e6)
        if self._now_us >= 0 and t_us <= self._now_us:
            raise ScenarioError(
                f"The simulation time is {t_us} µs, and was {self._now_us} µs at the last step. "
                "Allowed is a later time. Call step once after each mj_step, and create a new "
                "camera after mj_resetData."
            )
        before_us, self._now_us = self._now_us, t_us
        if before_us >= 0 and not self._is_due(data, t_us, t_us - before_us):
            return SensorOutput(empty_events(), np.empty(0, np.uint8), ())
        self.luminance = self._camera.luminance(data)
        self.samples += 1
        self._rendered_us, self._moved_px = t_us, 0.0
        return self._sensor.step(t_us, self.luminance)

    def _is_due(self, data: Any, t_us: int, step_us: int) -> bool:
        """Add the motion of this step; return True if the scene must be rendered now."""
        since_us = t_us - self._rendered_us
        if self._period_us is not None:
            if since_us < self._period_us:
                return False
            self._check_motion(self._speed_px_s(data) * since_us * 1e-6, since_us)
            return True
        travel_px = self._speed_px_s(data) * step_us * 1e-6
        self._check_motion(travel_px, step_us)
        self._moved_px += travel_px
        # Render now, since the next step would exceed a limit.
        return self._moved_px + travel_px > self._step_px or since_us + step_us > MAX_STEP_US

    def _speed_px_s(self, data: Any) -> float:
        """Return the highest known speed in the image [px/s]."""
        speed = np.hypot(*self._camera.flow_px_s(data).reshape(-1, 2).T)
        return float(np.fmax.reduce(speed, initial=0.0))

    def _check_motion(self, travel_px: float, step_us: int) -> None:
        if travel_px > MAX_TRAVEL_PX:
            warnings.warn(
                f"Something moves by {travel_px:.1f} px in {step_us} µs, from one luminance sample "
                f"to the next. At most {MAX_TRAVEL_PX:g} px gives reliable events. Choose a "
                "shorter "
                + ("period_us." if self._period_us is not None else "timestep of the model."),
                MotionWarning,
                stacklevel=4,
            )
