"""The evaluation of one sequence: sensors of all seeds, and the detectors that see their output."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from detector.metrics import within
from emulator import ApsFrame, EventSensor, SensorConfig
from flybench.direction import Direction
from flybench.events import Events
from scenarios.pipeline.registry import gives_velocity
from scenarios.pipeline.running import add_truth
from scenarios.pipeline.scoring import SETTLING_US, TargetTrack, score_estimates
from scenarios.recording import SequenceRecorder
from scenarios.study.results import STILL, MethodRun, SequenceResult
from scenarios.study.snapshots import SnapshotCollector
from scenarios.study.timed_detector import CHUNK_US, TimedDetector, join_outputs
from sim import Crossing, CrossingConfig, Sample

MAPS_PERIOD_US = 50_000
"""Time between the maps of the fly in the recording, its Δt [µs]; more would fill the recording."""


SensorKey = tuple[str, int]
"""Name of a sensor's configuration, and its seed."""


class SequenceEvaluation:
    """Runs all sensors and detectors on the samples of one sequence.

    It keeps one chunk of samples in memory, never a whole sequence.
    """

    def __init__(
        self,
        config: CrossingConfig,
        sensors: Mapping[str, SensorConfig],
        detectors: Mapping[SensorKey, Sequence[TimedDetector]],
        recorder: SequenceRecorder | None = None,
        *,
        background: str = STILL,
    ) -> None:
        """Start without samples.

        Args:
            config: configuration of the crossing.
            sensors: configurations of the sensors by name.
            detectors: fresh detectors by name and seed of their sensor.
            recorder: records the output of the first sensor and its detectors.
            background: what moves in the background. If anything does, the samples are those of a
                section, at whose start the target is in view, so that there is no latency.
        """
        self._config, self._detectors, self._recorder = config, detectors, recorder
        self._background = background
        self._sensors = {
            (name, seed): EventSensor(sensors[name], seed=seed) for name, seed in detectors
        }
        self._first = next(iter(detectors))
        self._first_us: int | None = None
        self._last_us = 0
        self._samples: list[Sample] = []
        self._track, self._snapshots = TargetTrack(), SnapshotCollector()
        self._velocity: list[tuple[int, float]] = []
        self._due_us = CHUNK_US

    def add(self, sample: Sample) -> None:
        """Add the next sample, and process the chunk if it is full.

        Each sensor sees a whole chunk before the next sensor does, so that its state stays in the
        processor's caches.
        """
        self._first_us = sample.t_us if self._first_us is None else self._first_us
        self._last_us = sample.t_us
        add_truth(self._track, sample.truth)
        if not self._velocity or sample.t_us >= self._velocity[-1][0] + CHUNK_US:
            velocity_px_s = float(sample.truth.image_velocity_px_s[0])
            self._velocity.append((sample.t_us, velocity_px_s))
        self._samples.append(sample)
        if sample.t_us >= self._due_us:
            self._process_chunk()
            self._due_us = (sample.t_us // CHUNK_US + 1) * CHUNK_US

    def finish(self) -> None:
        """Process the remaining samples, after the last one."""
        if self._samples:
            self._process_chunk()

    def result(self, crossing: Crossing) -> SequenceResult:
        """Return the result, once the evaluation is finished."""
        result = SequenceResult(
            lighting=self._config.lighting.value,
            omega_rad_s=self._config.omega_rad_s,
            speed_km_h=crossing.trajectory.speed_m_s(0.0) * 3.6,
            duration_us=self._last_us - (self._first_us or 0),
            in_view_us=self._track.in_view_us,
            velocity_t_us=np.array([t for t, _ in self._velocity], np.int64),
            velocity_px_s=np.array([v for _, v in self._velocity], np.float64),
            snapshots=self._snapshots.select(self._track.in_view_us),
            runs=(),
            direction=self._config.direction.value,
            background=self._background,
        )
        return replace(result, runs=tuple(self._runs(result)))

    def _process_chunk(self) -> None:
        until_us = self._samples[-1].t_us + 1
        for key, detectors in self._detectors.items():
            is_first = key == self._first
            events, frames = self._sense(self._sensors[key], is_first=is_first)
            for detector in detectors:
                estimates = detector.process(events, frames, until_us=until_us)
                if is_first:
                    self._keep(detector, estimates)
            if is_first:
                self._snapshots.add_frames(frames)
        self._samples = []

    def _sense(self, sensor: EventSensor, *, is_first: bool) -> tuple[Events, list[ApsFrame]]:
        """Return the output of a sensor for the chunk."""
        outputs = [sensor.step(s.t_us, s.luminance, changed=s.changed) for s in self._samples]
        if is_first and self._recorder is not None:
            for sample, output in zip(self._samples, outputs, strict=True):
                self._recorder.log(sample, output)
        return join_outputs(outputs)

    def _keep(self, detector: TimedDetector, estimates: Sequence[MotionEstimate]) -> None:
        """Keep estimates from the first sensor for snapshots and recording."""
        maps = detector.maps
        if estimates and maps is not None:
            last = estimates[-1]
            self._snapshots.add(detector.method, last, maps, self._track.box_px(last.t_us))
        if self._recorder is not None:
            for estimate in estimates:
                is_due = estimate is estimates[-1] and estimate.t_us % MAPS_PERIOD_US == 0
                self._recorder.log_estimate(detector.method, estimate, maps if is_due else None)

    def _runs(self, result: SequenceResult) -> Iterable[MethodRun]:
        for run in (run for detectors in self._detectors.values() for run in detectors):
            errors = velocity_errors(run.method, run.estimates, result)
            rms = None if errors is None else float(np.sqrt(np.mean(errors**2)))
            scores = score_estimates(
                run.estimates, result.direction, result.in_view_us, self._track
            )
            if self._background != STILL:
                scores["latency_ms"] = None
            yield MethodRun(
                method=run.method,
                seed=run.seed,
                estimates=tuple(run.estimates),
                scores=scores,
                velocity_error_px_s=rms,
                cpu_s=run.cpu_s,
                events=run.events,
                velocity_bias_px_s=None if errors is None else float(np.mean(errors)),
                failure=None if run.feed.failure is None else str(run.feed.failure),
                sensor=run.sensor,
            )


def velocity_errors(
    method: str, estimates: Sequence[MotionEstimate], result: SequenceResult
) -> npt.NDArray[np.float64] | None:
    """Return the errors of the horizontal velocity [px/s].

    Only the steps after 100 ms in view that name a direction count.

    Args:
        method: name of the method.
        estimates: all its estimates.
        result: result of the sequence; its runs are not used.

    Returns:
        (n,) errors; None if the method gives no velocity, or if there is no such step.
    """
    if not gives_velocity(method):
        return None
    settled_us = result.in_view_us[0] + SETTLING_US, result.in_view_us[1]
    named = [e for e in within(estimates, settled_us) if e.direction is not Direction.NONE]
    if not named:
        return None
    truth = np.interp([e.t_us for e in named], result.velocity_t_us, result.velocity_px_s)
    return np.array([e.response[0] for e in named]) - truth
