"""Run one sequence and write its folder."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from detector.estimate import MotionEstimate
from emulator import SensorOutput
from formats import ENDINGS, EventWriter, open_writer
from formats.writers.dsec import DsecWriter
from scenarios.output.atomic_folder import (
    ESTIMATES,
    EVENTS,
    RECORDING,
    TRUTH,
    atomic_folder,
    write_summary,
)
from scenarios.output.progress import Advance
from scenarios.output.tables import (
    ESTIMATE_COLUMNS,
    TRUTH_COLUMNS,
    estimate_row,
    truth_row,
    write_table,
)
from scenarios.pipeline.feeding import DetectorFeed, fly_maps
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import (
    TOTAL,
    Stopwatch,
    add_truth,
    make_crossing,
    make_feed,
    run_steps,
)
from scenarios.pipeline.scoring import TargetTrack
from scenarios.pipeline.summary import EventTally, method_scores, summarise
from scenarios.recording import SequenceRecorder
from scenarios.runs.event_labels import EventLabels
from scenarios.runs.extra_detectors import ExtraDetector, make_extra_detectors
from sim import Crossing, LuminanceCache, Sample

BYTES_RAD_S = 45e6
"""Size of a run's folder times its angular velocity (measured at 1.61 rad/s by day: 28 MB)."""
EventsFormat = Literal["aedat4", "evt3", "text", "csv", "npz"]
"""Formats of further event files, besides DSEC's HDF5; see `formats.WRITERS`."""


@dataclass(frozen=True)
class RunParts:
    """What the folder of a run contains, besides events, truth and summary.

    Attributes:
        recording: True for the Rerun recording.
        estimates: True for the tables of estimates.
        event_labels: True for cause and source of each event, in events.h5.
    """

    recording: bool = True
    estimates: bool = True
    event_labels: bool = False


def estimated_bytes(config: RunConfig) -> int:
    """Return the size of a run's folder [bytes]; a slower vehicle is in view for longer."""
    return round(BYTES_RAD_S / config.crossing.omega_rad_s)


def record_run(
    config: RunConfig,
    folder: Path,
    progress: Advance = lambda _done, _all, _phase="", _note="": None,
    *,
    cache: LuminanceCache | None = None,
    also: Sequence[str] = (),
    events_formats: Sequence[EventsFormat] = (),
    parts: RunParts = RunParts(),
) -> Any:
    """Run one sequence, and write its folder: recording, events, tables and summary.

    Args:
        config: configuration of the run.
        folder: output folder; an earlier run in it is replaced when the new one is complete.
        progress: function that is called at the start of every phase and after every sample, with
            the time reached and the duration of the sequence [µs].
        cache: cache for rendered luminance; None: no cache.
        also: names of further methods that get the same events, for comparison.
        events_formats: formats of further event files, such as events.aedat4; APS frames are
            written too if the format holds frames.
        parts: what the folder contains.

    Returns:
        The contents of `summary.json`. A detector that failed has "failed", the reason, instead of
        scores; see `failures`.

    Raises:
        OutputError: the folder was not written by flybench, or cannot be created.
        ScenarioError: a method is named twice.
        MethodError: a method does not exist.
        RendererError: this machine cannot render.
        MissingLibraryError: a format needs a library that is not installed.
    """
    watch, rendered_before = Stopwatch(), cache.rendered if cache else 0
    with atomic_folder(folder) as work:
        with watch.stage(TOTAL):
            extra = make_extra_detectors(config, also)
            summary = _run_into(work, config, watch, progress, cache, extra, events_formats, parts)
        summary["recording"] = parts.recording
        is_rendered = cache is None or cache.rendered > rendered_before
        summary["luminance"] = "rendered" if is_rendered else "from the cache"
        summary["wall_s"] = {name: round(seconds, 3) for name, seconds in watch.wall_s.items()}
        write_summary(work, summary)
    return summary


def _run_into(
    work: Path,
    config: RunConfig,
    watch: Stopwatch,
    progress: Advance,
    cache: LuminanceCache | None,
    extra: Sequence[ExtraDetector],
    events_formats: Sequence[EventsFormat],
    parts: RunParts,
) -> Any:
    progress(0, 0, "building street")
    feed, crossing = make_feed(config), make_crossing(config, cache)
    tally, track, labels = EventTally(), TargetTrack(), EventLabels()
    estimates: list[MotionEstimate] = []
    truth_rows = []
    with ExitStack() as stack:
        recorder: SequenceRecorder | None = None
        with watch.stage("record"):
            if parts.recording:
                progress(0, 0, "colour previews")
                feeds = [feed, *(other.feed for other in extra)]
                recorder = stack.enter_context(_recorder(work, config, crossing, feeds))
            files = _open_event_files(stack, work, config, events_formats)

        def record(sample: Sample, output: SensorOutput) -> None:
            _write_events(files, output)
            if parts.event_labels:
                labels.add(output)
            if recorder is not None:
                recorder.log(sample, output)

        progress(0, 0, "first keyframes")
        for step in run_steps(config, crossing, feed, watch, record):
            _log_estimates(recorder, feed, step.estimates, watch)
            for other in extra:
                with watch.stage("detect"):
                    new = other.process(step)
                _log_estimates(recorder, other.feed, new, watch)
            tally.add(step.output)
            add_truth(track, step.sample.truth)
            estimates += step.estimates
            truth_rows.append(truth_row(step.sample.truth))
            progress(step.sample.t_us, crossing.duration_us, "crossing")
        progress(0, 0, "writing")
    if parts.event_labels:
        progress(0, 0, "sources of the events")
        labels.write(work / EVENTS, crossing)
    write_table(work / TRUTH, TRUTH_COLUMNS, truth_rows)
    if parts.estimates:
        write_table(work / ESTIMATES, ESTIMATE_COLUMNS, map(estimate_row, estimates))
        for other in extra:
            rows = map(estimate_row, other.estimates)
            write_table(work / estimates_file(other.feed.method), ESTIMATE_COLUMNS, rows)
    progress(crossing.duration_us, crossing.duration_us)
    scores = method_scores(feed, estimates, config, track)
    others = [method_scores(other.feed, other.estimates, config, track) for other in extra]
    return summarise(config, crossing, tally, scores, track) | {"detectors": [scores, *others]}


def failures(summary: dict[str, Any]) -> list[str]:
    """Return the reason of each detector that failed in a run."""
    return [scores["failed"] for scores in summary["detectors"] if "failed" in scores]


def estimates_file(method: str) -> str:
    """Return the name of the file with the estimates of a method of `--also`."""
    return f"estimates_{method.replace(':', '.')}.csv"


def _open_event_files(
    stack: ExitStack, work: Path, config: RunConfig, events_formats: Sequence[EventsFormat]
) -> list[EventWriter]:
    """Open events.h5 and one file for each further format."""
    width, height = config.sensor.width, config.sensor.height
    dsec = DsecWriter(work / EVENTS, width=width, height=height)
    writers: list[EventWriter] = [stack.enter_context(dsec)]
    endings = {name: ending for ending, name in ENDINGS.items()}
    paths = [work / f"events{endings[name]}" for name in dict.fromkeys(events_formats)]
    writers += [
        stack.enter_context(open_writer(path, width=width, height=height)) for path in paths
    ]
    return writers


def _write_events(files: Sequence[EventWriter], output: SensorOutput) -> None:
    for file in files:
        file.write(output.events)
        if file.takes_frames:
            for frame in output.aps_frames:
                file.write_frame(frame)


def _recorder(
    work: Path,
    config: RunConfig,
    crossing: Crossing,
    feeds: Sequence[DetectorFeed],
) -> SequenceRecorder:
    maps_of = next((feed.method for feed in feeds if fly_maps(feed.detector) is not None), None)
    return SequenceRecorder(
        work / RECORDING,
        crossing=crossing,
        parameters=config.parameters(),
        methods=[feed.method for feed in feeds],
        maps_of=maps_of,
    )


def _log_estimates(
    recorder: SequenceRecorder | None,
    feed: DetectorFeed,
    estimates: Sequence[MotionEstimate],
    watch: Stopwatch,
) -> None:
    if recorder is None:
        return
    with watch.stage("record"):
        for estimate in estimates:
            recorder.log_estimate(feed.method, estimate, fly_maps(feed.detector))
