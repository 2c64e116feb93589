"""`flybench run`: simulate one crossing and detect its direction."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import tyro

from emulator import SensorConfig
from flybench.direction import Direction
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.distractors import DistractorOptions
from scenarios.options.method import FilterName, MethodName, behind_filter
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import check_output_folder
from scenarios.output.progress import progress_bar
from scenarios.output.terminal import report_failures, run_cli
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_detector
from scenarios.runs.extra_detectors import make_extra_detectors
from scenarios.runs.run_table import print_runs
from scenarios.runs.sequence import EventsFormat, RunParts, estimated_bytes, failures, record_run
from sim import CrossingConfig, Lighting, Profile, VehicleKind, omega_from_speed
from sim.config import (
    DEFAULT_DISTANCE_M,
    DEFAULT_ILLUMINANCE_LUX,
    PAPER_OMEGA_RAD_S,
    Quality,
)

LOGS = Path("logs")
SECOND_SPEED = 1
"""Index of 40 km/h among the paper's four speeds."""

_OMEGA_HINT = (
    f"(default: the paper's for 40 km/h, {PAPER_OMEGA_RAD_S[Lighting.DAY][SECOND_SPEED]} by day "
    f"and at dusk, {PAPER_OMEGA_RAD_S[Lighting.NIGHT][SECOND_SPEED]} at night)"
)
_DISTANCE_HINT = (
    f"(default: the paper's {DEFAULT_DISTANCE_M[Lighting.DAY]} by day and at dusk, "
    f"{DEFAULT_DISTANCE_M[Lighting.NIGHT]} at night)"
)
_ILLUMINANCE_HINT = (
    f"(default: {DEFAULT_ILLUMINANCE_LUX[Lighting.DAY]:g} by day, "
    f"{DEFAULT_ILLUMINANCE_LUX[Lighting.DUSK]:g} at dusk, "
    f"{DEFAULT_ILLUMINANCE_LUX[Lighting.NIGHT]:g} at night)"
)


@dataclass(frozen=True)
class Run:
    """Render one crossing, emulate the sensor, detect the direction."""

    GROUPS: ClassVar = {
        "scene": ("profile", "paint_reflectance", "distance_m", "street_seed"),
        "light": ("illuminance_lux", "sun_azimuth_deg", "sun_elevation_deg"),
        "distractors": (),
        "sensor": ("seed", "noise"),
        "detector": ("filter", "also"),
        "output": ("recording", "event_labels", "only_events", "events_format"),
        "rendering": ("quality", "lead_s", "step_px", "supersample", "keyframe_px"),
        "cache": (),
    }
    lighting: Literal["day", "dusk", "night"] = "day"
    """Time of day: sun and sky, a fading sky with lamps, or street lamps and headlights."""
    omega: Annotated[
        float | None,
        tyro.conf.arg(
            metavar="RAD_S",
            help_behavior_hint=_OMEGA_HINT,
        ),
    ] = None
    """Angular velocity of the vehicle at closest approach, 0.05 to 10 [rad/s]."""
    speed_km_h: Annotated[
        float | None,
        tyro.conf.arg(metavar="KM_H", help_behavior_hint="(default: see --omega)"),
    ] = None
    """Speed of the vehicle [km/h]; use it instead of --omega."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Direction of the vehicle in the image. For up and down the camera is rolled by 90 deg."""
    profile: Literal["constant_speed", "constant_omega"] = "constant_speed"
    """Motion of the vehicle: constant speed on the road, or constant angular velocity."""
    vehicle: Literal["sedan", "van", "motorcycle"] = "sedan"
    """Kind of vehicle."""
    paint_reflectance: float = CrossingConfig.paint_reflectance
    """Paint reflectance, 0.04 (black) to 0.8 (white); 0.13 is almost that of the road by day."""
    distance_m: Annotated[
        float | None, tyro.conf.arg(metavar="METRES", help_behavior_hint=_DISTANCE_HINT)
    ] = None
    """Distance from the camera to the near side of the vehicle, 3 to 12 [m]."""
    illuminance_lux: Annotated[
        float | None, tyro.conf.arg(metavar="LUX", help_behavior_hint=_ILLUMINANCE_HINT)
    ] = None
    """Illuminance on the road in front of the camera, 0.1 to 100000 [lux]."""
    sun_azimuth_deg: float = CrossingConfig.sun_azimuth_deg
    """Azimuth of the sun by day, -180 to 180 [deg]: 0 is straight ahead, positive to the right."""
    sun_elevation_deg: float = CrossingConfig.sun_elevation_deg
    """Elevation of the sun above the horizon by day, 5 to 90 [deg]."""
    street_seed: int = 0
    """Seed of the street, 0 to 2^32 - 1: façades, trees, parked cars and lit windows."""
    distractors: tyro.conf.EnumChoicesFromValues[DistractorOptions] = field(
        default_factory=DistractorOptions
    )
    """Other motion and flicker in the scene. By default there is none."""
    seed: int = 0
    """Seed of the sensor's mismatch and noise, 0 to 2^32 - 1. Equal seeds give equal events."""
    method: MethodName = FLY
    filter: FilterName = None
    also: Annotated[
        tuple[str, ...],
        tyro.conf.arg(metavar="NAME ...", help_behavior_hint="(default: no other detectors)"),
    ] = ()
    """Further detectors to run on the same events, for comparison; names as for --method."""
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    noise: bool = True
    """Simulate all noise of events and frames; --no-noise needs the default sensor."""
    lead_s: float = 0.15
    """Time before the vehicle enters the image and after it has left, 0.05 to 10 [s]."""
    step_px: float = CrossingConfig.step_px
    """Largest motion in the image between two luminance samples, 0.05 to 8 [px]."""
    supersample: int = CrossingConfig.supersample
    """Sub-pixels per pixel along each axis that are rendered, 1 to 8."""
    keyframe_px: float = CrossingConfig.keyframe_px
    """Largest motion of an object in the image between two rendered keyframes, 1 to 64 [px]."""
    quality: Literal["draft", "full", "fine"] = "full"
    """draft has fewer samples, for a first look; in fine quality, events have more exact times."""
    recording: bool = True
    """Write the Rerun recording; --no-recording saves most of the folder's size and some time."""
    event_labels: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write the cause and the source of each event into events.h5."""
    only_events: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write only the events with --event-labels and the truth. The table still has the verdict."""
    events_format: Annotated[
        tuple[EventsFormat, ...], tyro.conf.arg(help_behavior_hint="(default: events.h5 only)")
    ] = ()
    """Further formats for the events, besides events.h5; aedat4 contains the APS frames too."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="DIR", help_behavior_hint="(default: a descriptive name under logs/)"
        ),
    ] = None
    """Folder to write; an earlier result in it is replaced."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def config(self) -> RunConfig:
        """Return the configuration that the arguments describe.

        Raises:
            SceneConfigError: a value of the scene is out of its range.
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
            quality=Quality(self.quality),
            vehicle=VehicleKind(self.vehicle),
            paint_reflectance=self.paint_reflectance,
            sun_azimuth_deg=self.sun_azimuth_deg,
            sun_elevation_deg=self.sun_elevation_deg,
            street_seed=self.street_seed,
            distractors=self.distractors.checked(),
        )
        crossing = replace(crossing, omega_rad_s=self._omega(lighting))
        method = behind_filter(self.filter, self.method)
        return RunConfig(crossing, self._sensor(), method=method, seed=self.seed)

    def execute(self) -> int:
        """Run the sequence, write its folder and print a table of the results."""
        config, cache = self.config(), self.cache.open()
        others = "".join(f"_{method.replace(':', '.')}" for method in self.also)
        folder = self.out or LOGS / f"{config.name}{others and '_also'}{others}"
        check_output_folder(folder, needed_bytes=estimated_bytes(config))
        place = folder.absolute()  # a detector may change the current folder
        make_detector(config)
        for method in (self.method, *self.also):
            check_frames(self.sensor.preset, method)
        make_extra_detectors(config, self.also)
        with progress_bar() as progress:
            summary = record_run(
                config,
                place,
                progress.track(config.title),
                cache=cache,
                also=self.also,
                events_formats=self.events_format,
                parts=RunParts(
                    recording=self.recording and not self.only_events,
                    estimates=not self.only_events,
                    event_labels=self.event_labels or self.only_events,
                ),
            )
        print_runs([(folder, summary)])
        return report_failures(failures(summary))

    def _sensor(self) -> SensorConfig:
        if self.noise:
            return self.sensor.config()
        if not self.sensor.is_default:
            raise ScenarioError(
                f"{' '.join(self.sensor.arguments())} and --no-noise are given. Allowed is "
                "--no-noise with the default sensor. For less noise, choose --sensor ideal or "
                "v2e_clean."
            )
        return SensorConfig.noise_free()

    def _omega(self, lighting: Lighting) -> float:
        if self.speed_km_h is None:
            paper = PAPER_OMEGA_RAD_S.get(lighting, PAPER_OMEGA_RAD_S[Lighting.DAY])
            return paper[SECOND_SPEED] if self.omega is None else self.omega
        if self.omega is not None:
            raise ScenarioError(
                f"--omega is {self.omega} and --speed-km-h is {self.speed_km_h}. Allowed is one of "
                "them. Leave the other out."
            )
        return omega_from_speed(self.speed_km_h, self.distance_m or DEFAULT_DISTANCE_M[lighting])


if __name__ == "__main__":
    run_cli(Run)
