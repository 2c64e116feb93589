"""One sequence from light to decision, written to one folder."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from detector.estimate import Detector, MotionEstimate
from detector.fly import FlyMaps
from scenarios.config import RunConfig
from scenarios.eventfile import DsecWriter
from scenarios.judgement import Track
from scenarios.output import ESTIMATES, EVENTS, RECORDING, SUMMARY, TRUTH, whole_folder
from scenarios.pipeline import (
    TOTAL,
    Step,
    Stopwatch,
    make_crossing,
    make_detector,
    note,
    run_steps,
)
from scenarios.recording.recorder import Recorder
from scenarios.summary import EventTally, summarise
from scenarios.tables import ESTIMATE_COLUMNS, TRUTH_COLUMNS, estimate_row, truth_row, write_table
from sim import Crossing, LightCache, Preview

PREVIEW_PERIOD_US = 33_333
TRUTH_PERIOD_US = 10_000
"""How often the recording shows the colour picture and the truth; the tables have every step."""

Progress = Callable[[int, int], None]
"""Called with the time reached and the whole duration [µs]."""


def run_sequence(
    config: RunConfig,
    folder: Path,
    progress: Progress = lambda _done, _all: None,
    *,
    cache: LightCache | None = None,
) -> Any:
    """Run one sequence and write its folder: recording, events, tables and summary.

    Args:
        config: the run.
        folder: where to; one of an earlier run is replaced once the new one is whole.
        progress: told after every sample.
        cache: where rendered light is kept; None: nowhere.

    Returns:
        What `summary.json` holds.

    Raises:
        OutputError: the folder is somebody else's, or cannot be made.
        MethodError: there is no such detector.
        RendererError: this machine cannot render.
    """
    watch, drawn = Stopwatch(), cache.drawn if cache else 0
    with whole_folder(folder) as work:
        with watch.stage(TOTAL):
            summary = _run_into(work, config, watch, progress, cache)
        summary["light"] = "rendered" if cache is None or cache.drawn > drawn else "kept"
        summary["wall_s"] = {name: round(seconds, 3) for name, seconds in watch.wall_s.items()}
        text = json.dumps(summary, indent=2)
        (work / SUMMARY).write_text(text + "\n", encoding="utf-8")
    return summary


def _run_into(
    work: Path,
    config: RunConfig,
    watch: Stopwatch,
    progress: Progress,
    cache: LightCache | None,
) -> Any:
    detector, crossing = make_detector(config), make_crossing(config, cache)
    tally, track = EventTally(), Track()
    estimates: list[MotionEstimate] = []
    truth_rows = []
    size = {"width": config.sensor.width, "height": config.sensor.height}
    with ExitStack() as stack:
        logger = stack.enter_context(
            _Logger(work / RECORDING, config, crossing, has_maps=_maps(detector) is not None)
        )
        events = stack.enter_context(DsecWriter(work / EVENTS, **size))
        for step in run_steps(config, crossing, detector, watch):
            with watch.stage("record"):
                events.write(step.output.events)
                logger.log(step, _maps(detector))
            tally.add(step.output)
            note(track, step.sample.truth)
            estimates += step.estimates
            truth_rows.append(truth_row(step.sample.truth))
            progress(step.sample.t_us, crossing.duration_us)
    write_table(work / TRUTH, TRUTH_COLUMNS, truth_rows)
    write_table(work / ESTIMATES, ESTIMATE_COLUMNS, map(estimate_row, estimates))
    return summarise(config, crossing, tally, estimates, track)


def _maps(detector: Detector) -> FlyMaps | None:
    """What the fly saw at its last estimate; another detector has no such maps."""
    maps = getattr(detector, "maps", None)
    return maps if isinstance(maps, FlyMaps) else None


class _Logger:
    """Feeds the Rerun recording: events always, pictures and truth at their own pace."""

    def __init__(
        self, path: Path, config: RunConfig, crossing: Crossing, *, has_maps: bool
    ) -> None:
        self._crossing = crossing
        self._stack = ExitStack()
        self._preview = self._stack.enter_context(Preview(crossing))
        self._recorder = self._stack.enter_context(
            Recorder(path, crossing=crossing, parameters=config.parameters(), has_maps=has_maps)
        )
        self._preview_due_us = self._truth_due_us = 0

    def __enter__(self) -> _Logger:
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    def log(self, step: Step, maps: FlyMaps | None) -> None:
        t_us, recorder = step.sample.t_us, self._recorder
        recorder.log_events(step.output.events, step.output.causes)
        for frame in step.output.aps_frames:
            recorder.log_aps(frame)
        for estimate in step.estimates:
            recorder.log_estimate(estimate, maps)
        if t_us >= self._truth_due_us:
            recorder.log_truth(step.sample.truth)
            self._truth_due_us = t_us + TRUTH_PERIOD_US
        if t_us >= self._preview_due_us:
            recorder.log_preview(t_us, self._preview.draw(t_us))
            self._preview_due_us = t_us + PREVIEW_PERIOD_US
