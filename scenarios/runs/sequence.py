"""One sequence from light to decision, written to one folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Literal

from detector.estimate import Detector, MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import SensorOutput
from formats import ENDINGS, EventWriter, open_writer
from formats.writers.dsec import DsecWriter
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import (
    ESTIMATES,
    EVENTS,
    RECORDING,
    TRUTH,
    atomic_folder,
    write_summary,
)
from scenarios.output.tables import (
    ESTIMATE_COLUMNS,
    TRUTH_COLUMNS,
    estimate_row,
    truth_row,
    write_table,
)
from scenarios.pipeline.feeding import feed
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import (
    TOTAL,
    Step,
    Stopwatch,
    make_crossing,
    make_detector,
    note,
    run_steps,
)
from scenarios.pipeline.scoring import Track, judge
from scenarios.pipeline.summary import EventTally, summarise
from scenarios.pipeline.user_detectors import find_method
from scenarios.recording import SequenceRecorder
from sim import Crossing, LuminanceCache

Progress = Callable[[int, int], None]
"""Called with the time reached and the whole duration [µs]."""
EventsFormat = Literal["aedat4", "evt3", "text", "csv", "npz"]
"""What the events may be written as besides DSEC's HDF5; see `formats.WRITERS`."""


class Rival:
    """A method that looks at what the run's own looks at.

    Attributes:
        method: its name.
        detector: a fresh one.
        estimates: all that it said so far.
    """

    def __init__(self, method: str, config: RunConfig) -> None:
        """Make one for the sensor of a run.

        Raises:
            MethodError: there is none of that name, or it does not obey the protocol.
        """
        size = {"width": config.sensor.width, "height": config.sensor.height}
        self.method, self.detector = method, find_method(method).make(**size)
        self.estimates: list[MotionEstimate] = []

    def see(self, step: Step) -> list[MotionEstimate]:
        """Take what the sensor said, and answer with what became due."""
        due = feed(
            self.detector,
            step.output.events,
            until_us=step.sample.t_us + 1,
            frames=step.output.aps_frames,
            said=self.estimates,
        )
        self.estimates += due
        return due


def make_rivals(config: RunConfig, also: Sequence[str]) -> list[Rival]:
    """Fresh detectors of the methods that run beside the run's own.

    Raises:
        ScenarioError: a method is named twice.
        MethodError: there is none of a name, or it does not obey the protocol.
    """
    names = [config.method, *also]
    for n, name in enumerate(names):
        if name in names[:n]:
            raise ScenarioError(
                f"--also names {name}, which runs already; allowed is each method once; leave it "
                "out"
            )
    return [Rival(method, config) for method in also]


def run_sequence(
    config: RunConfig,
    folder: Path,
    progress: Progress = lambda _done, _all: None,
    *,
    cache: LuminanceCache | None = None,
    also: Sequence[str] = (),
    events_formats: Sequence[EventsFormat] = (),
) -> Any:
    """Run one sequence and write its folder: recording, events, tables and summary.

    Args:
        config: the run.
        folder: where to; one of an earlier run is replaced once the new one is whole.
        progress: told after every sample.
        cache: where rendered light is kept; None: nowhere.
        also: names of methods that look at the same events, for comparison.
        events_formats: further files of the events, such as events.aedat4; frames go into those
            that hold some.

    Returns:
        What `summary.json` holds.

    Raises:
        OutputError: the folder is somebody else's, or cannot be made.
        ScenarioError: a method is named twice.
        MethodError: there is no such detector.
        RendererError: this machine cannot render.
        MissingLibraryError: a format needs a library that is not installed.
    """
    watch, drawn = Stopwatch(), cache.rendered if cache else 0
    with atomic_folder(folder) as work:
        with watch.stage(TOTAL):
            rivals = make_rivals(config, also)
            summary = _run_into(work, config, watch, progress, cache, rivals, events_formats)
        summary["light"] = "rendered" if cache is None or cache.rendered > drawn else "kept"
        summary["wall_s"] = {name: round(seconds, 3) for name, seconds in watch.wall_s.items()}
        write_summary(work, summary)
    return summary


def _run_into(
    work: Path,
    config: RunConfig,
    watch: Stopwatch,
    progress: Progress,
    cache: LuminanceCache | None,
    rivals: Sequence[Rival],
    events_formats: Sequence[EventsFormat],
) -> Any:
    detector, crossing = make_detector(config), make_crossing(config, cache)
    tally, track = EventTally(), Track()
    estimates: list[MotionEstimate] = []
    truth_rows = []
    size = {"width": config.sensor.width, "height": config.sensor.height}
    with ExitStack() as stack:
        with watch.stage("record"):
            recorder = stack.enter_context(_recorder(work, config, crossing, detector, rivals))
            events = stack.enter_context(DsecWriter(work / EVENTS, **size))
            files = [
                stack.enter_context(
                    open_writer(path, width=config.sensor.width, height=config.sensor.height)
                )
                for path in _further_files(work, events_formats)
            ]
        for step in run_steps(config, crossing, detector, watch):
            with watch.stage("record"):
                events.write(step.output.events)
                _write(files, step.output)
                recorder.log(step.sample, step.output)
            _record(recorder, config.method, detector, step.estimates, watch)
            for rival in rivals:
                with watch.stage("detect"):
                    due = rival.see(step)
                _record(recorder, rival.method, rival.detector, due, watch)
            tally.add(step.output)
            note(track, step.sample.truth)
            estimates += step.estimates
            truth_rows.append(truth_row(step.sample.truth))
            progress(step.sample.t_us, crossing.duration_us)
    write_table(work / TRUTH, TRUTH_COLUMNS, truth_rows)
    write_table(work / ESTIMATES, ESTIMATE_COLUMNS, map(estimate_row, estimates))
    for rival in rivals:
        rows = map(estimate_row, rival.estimates)
        write_table(work / estimates_file(rival.method), ESTIMATE_COLUMNS, rows)
    summary = summarise(config, crossing, tally, estimates, track)
    return summary | {"detectors": [summary["detector"], *_verdicts(config, rivals, track)]}


def estimates_file(method: str) -> str:
    """Name of the table of a method that ran beside the run's own."""
    return f"estimates_{method.replace(':', '.')}.csv"


def _further_files(work: Path, events_formats: Sequence[EventsFormat]) -> list[Path]:
    endings = {name: ending for ending, name in ENDINGS.items()}
    return [work / f"events{endings[name]}" for name in dict.fromkeys(events_formats)]


def _write(files: Sequence[EventWriter], output: SensorOutput) -> None:
    for file in files:
        file.write(output.events)
        if file.takes_frames:
            for frame in output.aps_frames:
                file.write_frame(frame)


def _recorder(
    work: Path, config: RunConfig, crossing: Crossing, detector: Detector, rivals: Sequence[Rival]
) -> SequenceRecorder:
    seers = {config.method: detector} | {rival.method: rival.detector for rival in rivals}
    maps_of = next((name for name, seer in seers.items() if _maps(seer) is not None), None)
    return SequenceRecorder(
        work / RECORDING,
        crossing=crossing,
        parameters=config.parameters(),
        methods=list(seers),
        maps_of=maps_of,
    )


def _record(
    recorder: SequenceRecorder,
    method: str,
    detector: Detector,
    estimates: Sequence[MotionEstimate],
    watch: Stopwatch,
) -> None:
    with watch.stage("record"):
        for estimate in estimates:
            recorder.log_estimate(method, estimate, _maps(detector))


def _verdicts(config: RunConfig, rivals: Sequence[Rival], track: Track) -> list[dict[str, Any]]:
    return [
        {"method": rival.method}
        | judge(rival.estimates, config.crossing.direction, track.in_view_us, track)
        for rival in rivals
    ]


def _maps(detector: Detector) -> FlyMaps | None:
    """What the fly saw at its last estimate; another detector has no such maps."""
    maps = getattr(detector, "maps", None)
    return maps if isinstance(maps, FlyMaps) else None
