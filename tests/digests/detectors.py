"""Digests of the estimates of every detector for one stream."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from functools import lru_cache, partial
from typing import Any

from detector.estimate import Detector, MotionEstimate
from detector.fly.config import FlyConfig
from detector.fly.detector import FlyDetector
from detector.fly.model_variants import (
    Attention,
    Averaging,
    GrmsResponse,
    LocalMotion,
    Normalisation,
    Offsets,
    PairLocation,
    ReceptiveFields,
    RegionActivity,
    SurfaceEvents,
)
from detector.metrics import grms
from emulator import EventSensor, SensorOutput
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.registry import DETECTORS, FLY
from scenarios.pipeline.user_detectors import find_method
from tests.digests.exact import Case
from tests.digests.sensor import moving_box

WIDTH, HEIGHT = 346, 260
MODEL_VARIANTS: dict[str, type[StrEnum]] = {
    "time_surface": SurfaceEvents,
    "averaging": Averaging,
    "receptive_fields": ReceptiveFields,
    "offsets": Offsets,
    "pair_location": PairLocation,
    "attention": Attention,
    "local_motion": LocalMotion,
    "roi_activity": RegionActivity,
    "normalisation": Normalisation,
}
OTHERS: dict[str, dict[str, Any]] = {
    "neighbourhood": {"neighbourhood_px": 1},
    "radius": {"roi_radius_px": 150},
    "floors": {"snr_floor": 0.0, "share_floor": 0.0, "saliency_floor": 0.0},
    "delays": {"further_delays_us": (100_000,), "cell_px": 5},
}


@lru_cache
def stream() -> list[SensorOutput]:
    """Return the output of a DAVIS346 for synthetic luminance."""
    return list(EventSensor(seed=2).stream(moving_box(WIDTH, HEIGHT)))


def estimates(detector: Detector) -> list[MotionEstimate]:
    """Return all estimates of a detector that reads the stream step by step."""
    estimates: list[MotionEstimate] = []
    feed = DetectorFeed("any", detector, width=WIDTH, height=HEIGHT)
    until_us = 1
    for output in stream():
        estimates += feed.feed(output.events, until_us=until_us, frames=output.aps_frames)
        feed.raise_failure()
        until_us += 2_000
    return estimates


def of_method(name: str) -> list[MotionEstimate]:
    """Return the estimates of a method."""
    return estimates(find_method(name).make(width=WIDTH, height=HEIGHT))


def of_fly(config: FlyConfig) -> list[MotionEstimate]:
    """Return the estimates of a fly with other parameters."""
    return estimates(FlyDetector(config, width=WIDTH, height=HEIGHT))


def gradients() -> list[float | None]:
    """Return the GRMS of the fly for each definition."""
    return [grms(of_method(FLY), crossing_us=(100_000, 400_000), of=of) for of in GrmsResponse]


def _fly_case(**changes: Any) -> Case:
    return Case(partial(of_fly, replace(FlyConfig(), **changes)))


CASES: dict[str, Case] = (
    {f"detector.{name}": Case(partial(of_method, name)) for name in DETECTORS}
    | {
        f"detector.fly.{field}_{value.value}": _fly_case(**{field: value})
        for field, choices in MODEL_VARIANTS.items()
        for value in choices
        if value not in (getattr(FlyConfig(), field), SurfaceEvents.SATURATING)
    }
    | {f"detector.fly.{name}": _fly_case(**changes) for name, changes in OTHERS.items()}
    | {"detector.grms": Case(gradients)}
)
