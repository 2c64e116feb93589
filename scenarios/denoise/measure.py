"""Measure filters on one crossing: their curves, and the steps of detectors behind them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.denoise import FILTERS
from emulator import ApsFrame, EventSensor
from flybench.events import Cause, Events, concatenate_events
from flybench.memory import count_memory
from scenarios.denoise.roc import Roc, measure_roc
from scenarios.errors import ScenarioError
from scenarios.output.progress import Advance
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import add_truth, make_crossing
from scenarios.pipeline.scoring import TargetTrack, score_estimates
from scenarios.pipeline.user_detectors import find_method
from sim import LuminanceCache

NO_FILTER = "none"
_BYTES_PER_EVENT = 60
"""Memory per event: the event, its joined copy and the scores of a filter [bytes] (estimated)."""
Row = dict[str, Any]


@dataclass
class Stream:
    """Output of the sensor over one crossing.

    Attributes:
        times_us: time of each sensor step [µs].
        events: events of each step.
        frames: frames of each step.
        causes: cause of every event.
        track: ground truth of the target.
    """

    times_us: list[int]
    events: list[Events]
    frames: list[tuple[ApsFrame, ...]]
    causes: npt.NDArray[np.uint8]
    track: TargetTrack

    @property
    def whole(self) -> Events:
        """All events."""
        return concatenate_events(self.events)


def record_stream(config: RunConfig, cache: LuminanceCache | None, progress: Advance) -> Stream:
    """Render a crossing, or load it from the cache, and show it to the sensor.

    Raises:
        MemoryBudgetError: the events do not fit into the memory budget.
        ScenarioError: no event is noise, or none is signal, so that there is nothing to filter.
    """
    progress(0, 0, "building street")
    crossing = make_crossing(config, cache)
    progress(0, 0, "first keyframes")
    sensor, causes = EventSensor(config.sensor, seed=config.seed), [np.empty(0, np.uint8)]
    stream, count = Stream([], [], [], causes[0], TargetTrack()), 0
    for sample in crossing.samples():
        output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
        count += output.events.size
        count_memory(stream, f"A stream of {count} events", count * _BYTES_PER_EVENT)
        stream.times_us.append(sample.t_us)
        stream.events.append(output.events)
        stream.frames.append(output.aps_frames)
        causes.append(output.causes)
        add_truth(stream.track, sample.truth)
        progress(sample.t_us, crossing.duration_us)
    stream.causes = np.concatenate(causes)
    signal = int(np.count_nonzero(stream.causes == Cause.SIGNAL))
    if not 0 < signal < count:
        raise ScenarioError(
            f"At {config.crossing.illuminance:g} lux, {signal} of {count} events are signal. "
            "Allowed are streams with signal and noise. Choose another illuminance or sensor."
        )
    return stream


def measure_filters(
    config: RunConfig, stream: Stream, names: Sequence[str]
) -> tuple[list[Row], dict[str, Roc]]:
    """Measure every filter on the events of a stream.

    Returns:
        One row for each filter, with the CPU time of an event; and the curves by filter.
    """
    events, is_signal = stream.whole, stream.causes == Cause.SIGNAL
    size = {"width": config.sensor.width, "height": config.sensor.height}
    rows, curves = [], {}
    for name in names:
        FILTERS[name](**size).scores(events[:1000])  # compiles it
        start_s = time.process_time()
        FILTERS[name](**size).scores(events)
        cpu_s = time.process_time() - start_s
        curves[name] = roc = measure_roc(name, events, is_signal, **size)
        signal, noise = roc.at_default
        shares = {"kept_signal": signal, "kept_noise": noise}
        cost = {"cpu_ns_per_event": 1e9 * cpu_s / len(events)}
        rows.append(_known(config, stream) | {"filter": name, "auc": roc.area} | shares | cost)
    return rows, curves


def measure_steps(
    config: RunConfig, stream: Stream, names: Sequence[str], methods: Sequence[str]
) -> tuple[list[Row], list[str]]:
    """Score every detector without a filter and behind each filter.

    Returns:
        One row for each pair; and the reasons why detectors failed.
    """
    rows, failed = [], []
    for method in methods:
        for name in (NO_FILTER, *names):
            full = method if name == NO_FILTER else f"{name}+{method}"
            feed = DetectorFeed(full, _make(full, config), **_size(config))
            estimates = []
            for t_us, events, frames in zip(
                stream.times_us, stream.events, stream.frames, strict=True
            ):
                estimates += feed.feed(events, until_us=t_us + 1, frames=frames)
            if feed.failure is not None:
                failed.append(str(feed.failure))
                continue
            direction, in_view_us = config.crossing.direction, stream.track.in_view_us
            scores = score_estimates(estimates, direction, in_view_us, stream.track)
            rows.append(_known(config, stream) | {"method": method, "filter": name} | scores)
    return rows, failed


def _size(config: RunConfig) -> dict[str, int]:
    return {"width": config.sensor.width, "height": config.sensor.height}


def _make(method: str, config: RunConfig) -> Any:
    return find_method(method).make(**_size(config))


def _known(config: RunConfig, stream: Stream) -> Row:
    signal = float(np.mean(stream.causes == Cause.SIGNAL))
    return {
        "lighting": config.crossing.lighting.value,
        "illuminance_lux": config.crossing.illuminance,
        "events": len(stream.causes),
        "noise_share": 1 - signal,
    }
