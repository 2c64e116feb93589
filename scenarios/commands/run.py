"""`flybench run`: one sequence, by day or night, at a given speed and direction."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Literal

import tyro

from emulator import SensorConfig, preset
from emulator.presets import PresetName
from flybench.direction import Direction
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.distractors import DistractorOptions
from scenarios.output.folder import check_output
from scenarios.output.terminal import progress_bar, script
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_detector
from scenarios.runs.run_table import print_runs
from scenarios.runs.sequence import EventsFormat, make_rivals, run_sequence
from sim import CrossingConfig, Lighting, Profile, VehicleKind, omega_from_speed
from sim.config import DISTANCE_M, PAPER_OMEGA_RAD_S

LOGS = Path("logs")
SECOND_SPEED = 1
"""Of the paper's four: 40 km/h."""


@dataclass(frozen=True)
class Run:
    """Run one sequence: render it, turn it into events, read its direction, record everything."""

    lighting: Literal["day", "dusk", "night"] = "day"
    """Sun and sky, or a fading sky with lamps, or street lamps and headlights."""
    omega: Annotated[float | None, tyro.conf.arg(metavar="RAD_S")] = None
    """Angular velocity at closest approach [rad/s]; the paper's 40 km/h where not given."""
    speed_km_h: Annotated[float | None, tyro.conf.arg(metavar="KM_H")] = None
    """Speed of the vehicle [km/h], instead of --omega."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Where the vehicle goes in the image."""
    profile: Literal["constant_speed", "constant_omega"] = "constant_speed"
    """What is held constant: the speed on the road, or the angular velocity."""
    vehicle: Literal["sedan", "van", "motorcycle"] = "sedan"
    """What drives."""
    paint_reflectance: float = CrossingConfig.paint_reflectance
    """Of its paint, 0.04 (black) to 0.8 (white); 0.13 all but vanishes before the road by day."""
    distance_m: float | None = None
    """From the camera to its flank [m]; the paper's 6.89 by day and dusk, 7.79 by night."""
    illuminance_lux: float | None = None
    """On the road, 0.1 to 100 000 [lux]; 30 000 by day, 50 at dusk, 10 by night."""
    sun_azimuth_deg: float = CrossingConfig.sun_azimuth_deg
    """By day: 0 is straight ahead of the camera, positive to its right [deg]."""
    sun_elevation_deg: float = CrossingConfig.sun_elevation_deg
    """By day: over the horizon, 5 to 90 [deg]."""
    street_seed: int = 0
    """Seed of the houses, trees, parked cars and lit windows."""
    distractors: tyro.conf.EnumChoicesFromValues[DistractorOptions] = field(
        default_factory=DistractorOptions
    )
    """What else moves or flickers."""
    seed: int = 0
    """Seed of everything random; the same gives the same events."""
    method: Annotated[str, tyro.conf.arg(metavar="NAME")] = FLY
    """Detector: fly, wide, or a class of your own as package.module:Class."""
    also: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME ...")] = ()
    """Detectors that look at the same events, to compare in the recording and the table."""
    sensor: PresetName = "davis346"
    """Preset of the sensor: its pixels, readout and lens, and with them the field of view."""
    noise: bool = True
    """Whether a davis346 has leak, shot noise, hot pixels and noisy frames."""
    lead_s: float = 0.15
    """How long the sequence lasts before the vehicle comes, and after it has gone [s]."""
    step_px: float = CrossingConfig.step_px
    """The farthest that anything may move in the image between two samples [px]."""
    supersample: int = CrossingConfig.supersample
    """Drawn points per pixel along each axis."""
    keyframe_px: float = CrossingConfig.keyframe_px
    """How far anything moves in the image from one keyframe to the next [px]."""
    events_format: tuple[EventsFormat, ...] = ()
    """Further files of the events, beside events.h5; aedat4 holds the APS frames too."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder to write, in place of flybench's own; a telling name under logs/ where not given."""
    light: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def config(self) -> RunConfig:
        """The run that the arguments ask for.

        Raises:
            SceneConfigError: a value is outside its range.
            ScenarioError: both a speed and an angular velocity are given, or the seed is out of
                range.
        """
        lighting = Lighting(self.lighting)
        crossing = CrossingConfig(
            lighting=lighting,
            direction=Direction(self.direction),
            profile=Profile(self.profile),
            distance_m=self.distance_m,
            illuminance_lux=self.illuminance_lux,
            lead_s=self.lead_s,
            step_px=self.step_px,
            supersample=self.supersample,
            keyframe_px=self.keyframe_px,
            vehicle=VehicleKind(self.vehicle),
            paint_reflectance=self.paint_reflectance,
            sun_azimuth_deg=self.sun_azimuth_deg,
            sun_elevation_deg=self.sun_elevation_deg,
            street_seed=self.street_seed,
            distractors=self.distractors.checked(),
        )
        crossing = replace(crossing, omega_rad_s=self._omega(lighting))
        return RunConfig(crossing, self._sensor(), method=self.method, seed=self.seed)

    def execute(self) -> int:
        """Run, and print the closing table."""
        config, cache = self.config(), self.light.open()
        beside = "".join(f"_{method.replace(':', '.')}" for method in self.also)
        folder = self.out or LOGS / f"{config.name}{beside and '_also'}{beside}"
        check_output(folder)
        make_detector(config)
        make_rivals(config, self.also)
        with progress_bar() as progress:
            tell = progress.track(config.name)
            summary = run_sequence(
                config,
                folder,
                tell,
                cache=cache,
                also=self.also,
                events_formats=self.events_format,
            )
        print_runs([(folder, summary)])
        return 0

    def _sensor(self) -> SensorConfig:
        if self.noise:
            return preset(self.sensor)
        if self.sensor != "davis346":
            raise ScenarioError(
                f"--sensor is {self.sensor} and --no-noise is given; allowed is --no-noise with "
                "davis346; choose --sensor ideal or v2e_clean for less noise"
            )
        return SensorConfig.noise_free()

    def _omega(self, lighting: Lighting) -> float:
        if self.speed_km_h is None:
            paper = PAPER_OMEGA_RAD_S.get(lighting, PAPER_OMEGA_RAD_S[Lighting.DAY])
            return paper[SECOND_SPEED] if self.omega is None else self.omega
        if self.omega is not None:
            raise ScenarioError(
                f"--omega is {self.omega} and --speed-km-h is {self.speed_km_h}; allowed is one of "
                "them; leave the other out"
            )
        return omega_from_speed(self.speed_km_h, self.distance_m or DISTANCE_M[lighting])


if __name__ == "__main__":
    script(Run)
