"""The registry of built-in detectors: what commands and figures know about each of them.

To add a detector, write its file in `detector/`, add one entry to `DETECTORS`, and test it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from detector import (
    ContrastConfig,
    ContrastMaximisation,
    Detector,
    EdgeInformedConfig,
    EdgeInformedContrast,
    FlyConfig,
    FlyDetector,
    FrameFly,
    FrameFlyConfig,
    PlaneFit,
    PlaneFitConfig,
    SpaceTimeFilters,
    SpaceTimeFiltersConfig,
    SpikingDelays,
    SpikingDelaysConfig,
    TimeDifference,
    TimeDifferenceConfig,
)
from detector.fly.model_variants import Attention

FLY, WIDE, ROBUST = "fly", "wide", "robust"
FLY_EVERYWHERE, WIDE_EVERYWHERE = "fly-no-attention", "wide-no-attention"
ROBUST_EVERYWHERE = "robust-no-attention"
FRAME_FLY, CONTRAST, PLANE_FIT = "frame-fly", "contrast-maximisation", "plane-fit"
EDGE_INFORMED = "edge-informed-contrast"
SPACE_TIME, SPIKING, TIME_DIFFERENCE = "space-time-filters", "spiking-delays", "time-difference"
COARSE_FRAME_FLY, FLOORLESS_FRAME_FLY = "frame-fly-coarse", "frame-fly-no-floor"


class Family(StrEnum):
    """Kinds of detectors; each but the last has one panel in the figures of the study."""

    EVENT_FLY = "event-driven fly"
    FRAME_FLY = "frame-based fly"
    VELOCITY = "velocity estimation"
    VISION_MODEL = "other model of motion vision"


@dataclass(frozen=True, kw_only=True)
class DetectorEntry:
    """One built-in detector.

    Attributes:
        name: name for `--method`, in tables and in file names.
        factory: class of the detector; called with the configuration, width and height.
        config: its parameters, a frozen dataclass.
        family: kind of detector, and so its panel in the study's figures.
        label: name in figures and tables.
        colour: colour of its curves, as #rrggbb.
        marker: matplotlib marker of its points, which distinguishes it without colour.
        gives_velocity: True if `MotionEstimate.response` is the image velocity itself [px/s].
        looks_at_frames: True if it needs APS frames.
        in_study: True if `flybench study` runs it by default.
        study_sensors: largest number of sensors for which `flybench study` runs it, because it is
            slow; None: all.
        without_attention: name of the entry that differs only in having no attention; None: there
            is none.
    """

    name: str
    factory: Callable[..., Detector]
    config: Any
    family: Family
    label: str
    colour: str
    marker: str
    gives_velocity: bool = False
    looks_at_frames: bool = False
    in_study: bool = True
    study_sensors: int | None = None
    without_attention: str | None = None

    def make(self, *, width: int, height: int) -> Detector:
        """Return a fresh detector for a sensor of this size [px]."""
        return self.factory(self.config, width=width, height=height)

    def make_with(self, changes: dict[str, Any], *, width: int, height: int) -> Detector:
        """Return a fresh detector with some parameters changed.

        Raises:
            DetectorConfigError: a parameter is out of its range.
        """
        return self.factory(replace(self.config, **changes), width=width, height=height)


_ENTRIES = (
    DetectorEntry(
        name=FLY,
        factory=FlyDetector,
        config=FlyConfig.preset("paper"),
        family=Family.EVENT_FLY,
        label="event-driven fly",
        colour="#00A884",
        marker="o",
        without_attention=FLY_EVERYWHERE,
    ),
    DetectorEntry(
        name=WIDE,
        factory=FlyDetector,
        config=FlyConfig.preset("wide"),
        family=Family.EVENT_FLY,
        label="event-driven fly, wide",
        colour="#3C6C3C",
        marker="p",
        without_attention=WIDE_EVERYWHERE,
    ),
    DetectorEntry(
        name=FLY_EVERYWHERE,
        factory=FlyDetector,
        config=replace(FlyConfig.preset("paper"), attention=Attention.EVERYWHERE),
        family=Family.EVENT_FLY,
        label="event-driven fly, no attention",
        colour="#D860A8",
        marker="P",
        in_study=False,
    ),
    DetectorEntry(
        name=WIDE_EVERYWHERE,
        factory=FlyDetector,
        config=replace(FlyConfig.preset("wide"), attention=Attention.EVERYWHERE),
        family=Family.EVENT_FLY,
        label="event-driven fly, wide, no attention",
        colour="#5478FC",
        marker="H",
        in_study=False,
    ),
    DetectorEntry(
        name=ROBUST,
        factory=FlyDetector,
        config=FlyConfig.preset("robust"),
        family=Family.EVENT_FLY,
        label="event-driven fly, robust",
        colour="#009CB4",
        marker="*",
        without_attention=ROBUST_EVERYWHERE,
    ),
    DetectorEntry(
        name=ROBUST_EVERYWHERE,
        factory=FlyDetector,
        config=replace(FlyConfig.preset("robust"), attention=Attention.EVERYWHERE),
        family=Family.EVENT_FLY,
        label="event-driven fly, robust, no attention",
        colour="#A8249C",
        marker="8",
        in_study=False,
    ),
    DetectorEntry(
        name=FRAME_FLY,
        factory=FrameFly,
        config=FrameFlyConfig(),
        family=Family.FRAME_FLY,
        label="frame-based fly",
        colour="#D80C48",
        marker="s",
        looks_at_frames=True,
    ),
    DetectorEntry(
        name=FLOORLESS_FRAME_FLY,
        factory=FrameFly,
        config=FrameFlyConfig(snr_floor=0.0),
        family=Family.FRAME_FLY,
        label="frame-based fly, no floor",
        colour="#E46078",
        marker="h",
        looks_at_frames=True,
    ),
    DetectorEntry(
        name=COARSE_FRAME_FLY,
        factory=FrameFly,
        config=FrameFlyConfig.preset("coarse"),
        family=Family.FRAME_FLY,
        label="frame-based fly, coarse",
        colour="#C0240C",
        marker="D",
        looks_at_frames=True,
        in_study=False,
    ),
    DetectorEntry(
        name=CONTRAST,
        factory=ContrastMaximisation,
        config=ContrastConfig(),
        family=Family.VELOCITY,
        label="contrast maximisation",
        colour="#543CFC",
        marker="^",
        gives_velocity=True,
    ),
    DetectorEntry(
        name=EDGE_INFORMED,
        factory=EdgeInformedContrast,
        config=EdgeInformedConfig(),
        family=Family.VELOCITY,
        label="edge-informed contrast",
        colour="#9030CC",
        marker="d",
        gives_velocity=True,
        looks_at_frames=True,
        in_study=False,
        study_sensors=1,
    ),
    DetectorEntry(
        name=PLANE_FIT,
        factory=PlaneFit,
        config=PlaneFitConfig(),
        family=Family.VELOCITY,
        label="plane fit",
        colour="#B478E4",
        marker="v",
        gives_velocity=True,
    ),
    DetectorEntry(
        name=SPACE_TIME,
        factory=SpaceTimeFilters,
        config=SpaceTimeFiltersConfig(),
        family=Family.VISION_MODEL,
        label="space-time filters",
        colour="#845478",
        marker="<",
        study_sensors=1,
    ),
    DetectorEntry(
        name=SPIKING,
        factory=SpikingDelays,
        config=SpikingDelaysConfig(),
        family=Family.VISION_MODEL,
        label="spiking delays",
        colour="#E418FC",
        marker=">",
        gives_velocity=True,
        in_study=False,
        study_sensors=1,
    ),
    DetectorEntry(
        name=TIME_DIFFERENCE,
        factory=TimeDifference,
        config=TimeDifferenceConfig(),
        family=Family.VISION_MODEL,
        label="time difference encoder",
        colour="#CC8448",
        marker="X",
        study_sensors=1,
    ),
)
"""All entries.

The colours have a contrast of 3 to 1 or more on white and on #0D1117. They were chosen one by one,
each as far as possible from the others and from ON and OFF in CIELAB, also as people with
deuteranopia and protanopia see them (Machado et al. 2009). Markers distinguish them too.
"""

DETECTORS: dict[str, DetectorEntry] = {entry.name: entry for entry in _ENTRIES}
"""All built-in detectors by name; the paper's detector is first."""


def gives_velocity(method: str) -> bool:
    """Return True if a method's responses are image velocities [px/s]; False for user classes.

    A filter before the method, as in "stcf+plane-fit", does not matter.
    """
    detector = method.rpartition("+")[2]
    return detector in DETECTORS and DETECTORS[detector].gives_velocity


def study_sensors(method: str) -> float:
    """Return the largest number of sensors for which the study runs a method; infinity: all."""
    most = DETECTORS[method].study_sensors if method in DETECTORS else None
    return math.inf if most is None else most


def is_fly(method: str) -> bool:
    """Return True if a method is the event-driven fly, with any of its parameter presets."""
    return method in DETECTORS and DETECTORS[method].family is Family.EVENT_FLY
