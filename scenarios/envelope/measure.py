"""Show synthetic stimuli to detectors and score the estimates."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import cv2
import numpy as np

from detector.estimate import MotionEstimate
from emulator import SensorConfig
from scenarios.envelope.drawing import DrawnStimulus, draw_stimulus
from scenarios.envelope.pixels import DEFAULT_SENSOR
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import MethodError
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.parallel import run_locally
from scenarios.pipeline.scoring import score_estimates
from scenarios.pipeline.user_detectors import find_method

CHUNK_US = 10_000
"""Length of the chunks in which a detector gets its events, as a camera sends them."""
FAILED = "failed"
Row = dict[str, Any]


def measure_all(
    points: Sequence[Stimulus],
    methods: Sequence[str],
    *,
    jobs: int,
    sensor: SensorConfig = DEFAULT_SENSOR,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> tuple[list[Row], dict[str, str]]:
    """Measure every point with every method, in processes of one thread each.

    Args:
        points: the stimuli.
        methods: names that `find_method` knows.
        jobs: number of processes; −1: one per core.
        sensor: sensor whose thresholds the pixels have.
        progress: function that is called after every point, with the numbers of finished points
            and of all points.

    Returns:
        Rows in the order of the points, and for each point in the order of the methods. They do not
        depend on the number of processes. Methods that failed at any point are left out; the
        second value is the first reason of each, by name.

    Raises:
        ScenarioError: the number of processes is out of range.
        MethodError: all methods failed.
    """
    done: dict[int, list[Row]] = {}
    one = partial(measure, methods=tuple(methods), sensor=sensor)
    results = run_locally(one, points, jobs=jobs)
    progress(0, len(points))
    for n, rows in results:
        done[n] = rows
        progress(len(done), len(points))
    rows = [row for n in range(len(points)) for row in done[n]]
    failed: dict[str, str] = {}
    for row in rows:
        if FAILED in row:
            failed.setdefault(row["method"], row[FAILED])
    kept = [row for row in rows if row["method"] not in failed]
    if not kept:
        raise MethodError(next(iter(failed.values())))
    return kept, failed


def measure(
    stimulus: Stimulus, methods: Sequence[str], sensor: SensorConfig = DEFAULT_SENSOR
) -> list[Row]:
    """Show a stimulus to fresh detectors, and score them.

    Args:
        stimulus: the stimulus.
        methods: names that `find_method` knows.
        sensor: sensor whose thresholds the pixels have.

    Returns:
        One row per method: its name, the fields of the stimulus, all scores of `score_estimates`
        (with "verdict" for its direction), the number of events, and the CPU time of the detector
        [s]. If the detector fails, its name and the reason (`FAILED`) only.

    Raises:
        MethodError: there is no such method.
    """
    cv2.setNumThreads(1)  # other processes use the other cores
    drawn = draw_stimulus(stimulus, sensor)
    return [_row(name, drawn) for name in methods]


def _row(name: str, drawn: DrawnStimulus) -> Row:
    s = drawn.stimulus
    size = {"width": s.width, "height": s.height}
    feed = DetectorFeed(name, find_method(name).make(**size), **size)
    start_s = time.process_time()
    estimates = _feed_all(feed, drawn)
    if feed.failure is not None:
        return {"method": name, FAILED: str(feed.failure)}
    spent_s = time.process_time() - start_s
    scores = score_estimates(estimates, s.direction, drawn.in_view_us, drawn)
    scores = {"verdict": scores.pop("direction")} | scores
    events = {"events": int(drawn.events.size), "detector_cpu_s": round(spent_s, 4)}
    return {"method": name} | asdict(s) | scores | events


def _feed_all(feed: DetectorFeed, drawn: DrawnStimulus) -> list[MotionEstimate]:
    ends_us = np.append(np.arange(CHUNK_US, drawn.duration_us, CHUNK_US), drawn.duration_us + 1)
    cuts = np.searchsorted(drawn.events["t"], ends_us)
    estimates: list[MotionEstimate] = []
    start = 0
    for end_us, cut in zip(ends_us, cuts, strict=True):
        chunk = drawn.events[start:cut]
        estimates += feed.feed(chunk, until_us=int(end_us))
        start = cut
    return estimates
