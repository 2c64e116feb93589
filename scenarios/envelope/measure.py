"""One point of the envelope: a stimulus drawn, shown to every method, and judged."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import cv2
import numpy as np

from detector.estimate import Detector, MotionEstimate
from scenarios.envelope.drawing import Drawn, draw
from scenarios.envelope.stimulus import Stimulus
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.scoring import judge
from scenarios.pipeline.user_detectors import find_method

CHUNK_US = 10_000
"""Events are passed in pieces as a camera sends them."""
Row = dict[str, Any]


def measure(stimulus: Stimulus, methods: Sequence[str]) -> list[Row]:
    """Show a stimulus to fresh detectors.

    Args:
        stimulus: the point.
        methods: names that `find_method` knows.

    Returns:
        A row a method: its name, the stimulus's fields, and what `judge` finds, with "verdict" for
        its direction; number of events, and CPU time the detector took [s].

    Raises:
        MethodError: there is no such method.
    """
    cv2.setNumThreads(1)  # the other cores have points of their own
    drawn = draw(stimulus)
    return [_row(name, drawn) for name in methods]


def _row(name: str, drawn: Drawn) -> Row:
    s = drawn.stimulus
    detector = find_method(name).make(width=s.width, height=s.height)
    start_s = time.process_time()
    estimates = _watch(detector, drawn)
    spent_s = time.process_time() - start_s
    found = judge(estimates, s.direction, drawn.in_view_us, drawn)
    found = {"verdict": found.pop("direction")} | found
    events = {"events": int(drawn.events.size), "detector_cpu_s": round(spent_s, 4)}
    return {"method": name} | asdict(s) | found | events


def _watch(detector: Detector, drawn: Drawn) -> list[MotionEstimate]:
    ends_us = np.append(np.arange(CHUNK_US, drawn.duration_us, CHUNK_US), drawn.duration_us + 1)
    cuts = np.searchsorted(drawn.events["t"], ends_us)
    estimates: list[MotionEstimate] = []
    start = 0
    for end_us, cut in zip(ends_us, cuts, strict=True):
        estimates += feed(detector, drawn.events[start:cut], until_us=int(end_us), said=estimates)
        start = cut
    return estimates
