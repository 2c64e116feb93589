"""One crossing, drawn once and seen by a sensor a seed, before each of which stand all methods."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from detector.metrics import within
from emulator import ApsFrame, EventSensor, SensorConfig
from flybench.direction import Direction
from flybench.events import Events
from scenarios.options.cache import CacheOptions
from scenarios.pipeline.registry import gives_velocity, is_fly
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing, note
from scenarios.pipeline.scoring import SETTLING_US, Track, judge
from scenarios.recording import SequenceRecorder
from scenarios.study.results import MethodRun, Snapshot
from scenarios.study.results import Sequence as Result
from scenarios.study.snapshots import Album
from scenarios.study.watcher import (
    CHUNK_US,
    CONTRAST_HOP_US,
    Watcher,
    gathered,
    make_watcher,
    warm_up,
)
from sim import Crossing, CrossingConfig, Sample

MAPS_PERIOD_US = 50_000
"""How often the recording shows the fly's maps, which would take most of its space: its Δt."""
Progress = Callable[[int, int], None]
"""Called with the time reached and the whole duration [µs]."""


@dataclass(frozen=True)
class SequenceTask:
    """What to do with one crossing.

    Attributes:
        crossing: the scene and its motion.
        sensor: every seed's.
        methods: names of the detectors.
        seeds: of the sensors.
        light: where rendered light is kept.
        contrast_hop_us: step between the windows of contrast maximisation [µs].
        recording: file to record the first seed to; None: none.
    """

    crossing: CrossingConfig
    methods: tuple[str, ...]
    seeds: tuple[int, ...]
    sensor: SensorConfig = field(default_factory=SensorConfig)
    light: CacheOptions = field(default_factory=CacheOptions)
    contrast_hop_us: int = CONTRAST_HOP_US
    recording: Path | None = None

    @property
    def name(self) -> str:
        """Light and velocity; see `results.Sequence.name`."""
        return f"{self.crossing.lighting}_{self.crossing.omega_rad_s:.2f}"

    def config(self) -> RunConfig:
        """The run of the first seed and the first method, as single runs are told."""
        return RunConfig(self.crossing, self.sensor, method=self.methods[0], seed=self.seeds[0])

    def watchers(self, seed: int) -> list[Watcher]:
        """All methods before the sensor of a seed, fresh."""
        size = {"width": self.sensor.width, "height": self.sensor.height}
        return [
            make_watcher(method, seed, contrast_hop_us=self.contrast_hop_us, **size)
            for method in self.methods
        ]


def run_one(task: SequenceTask, progress: Progress = lambda _done, _all: None) -> Result:
    """Do what a task says.

    Args:
        task: the crossing, and who looks at it.
        progress: told after every sample.

    Raises:
        RendererError: this machine cannot render.
        OSError: the recording cannot be written.
    """
    cv2.setNumThreads(1)  # the other cores have sequences of their own
    _compile(task.methods, task.sensor.width, task.sensor.height, task.contrast_hop_us)
    config = task.config()
    crossing = make_crossing(config, task.light.open())
    begun_us = _draw_ahead(crossing, progress)
    with ExitStack() as stack:
        recorder = None
        if task.recording is not None:
            recorder = stack.enter_context(_recorder(task, task.recording, crossing))
        audience = Audience(task, recorder)
        for sample in crossing.samples():
            audience.show(sample)
            progress(begun_us + sample.t_us, begun_us + crossing.duration_us)
        audience.end()
    return audience.result(crossing)


def _draw_ahead(crossing: Crossing, progress: Progress) -> int:
    """Draw light before the sensors are there, where it can be kept: both take much memory.

    Returns:
        Time drawn [µs]; 0 where light was there.
    """
    drawn_us = 0
    for drawn_us in crossing.draw_ahead():
        progress(drawn_us, 2 * crossing.duration_us)
    return drawn_us


def _recorder(task: SequenceTask, path: Path, crossing: Crossing) -> SequenceRecorder:
    c = task.crossing
    parameters = {
        name: value for name, value in task.config().parameters().items() if name != "method"
    }
    return SequenceRecorder(
        path,
        crossing=crossing,
        parameters=parameters | {"methods": ", ".join(task.methods)},
        methods=task.methods,
        maps_of=next((method for method in task.methods if is_fly(method)), None),
        name=f"{c.lighting} {c.omega_rad_s:.2f}",
        one_of_several=True,
    )


@lru_cache
def _compile(methods: tuple[str, ...], width: int, height: int, contrast_hop_us: int) -> None:
    """Once a process; see `warm_up`."""
    for method in methods:
        watcher = make_watcher(
            method, 0, width=width, height=height, contrast_hop_us=contrast_hop_us
        )
        warm_up(watcher, width=width, height=height)


class Audience:
    """The sensors of all seeds, and the methods before them. It holds a chunk, never a clip."""

    def __init__(self, task: SequenceTask, recorder: SequenceRecorder | None = None) -> None:
        """Begin with nothing seen.

        Args:
            task: which sensors, and which methods.
            recorder: takes down what the first seed's sensor and methods say.
        """
        self._task, self._recorder = task, recorder
        self._sensors = [EventSensor(task.sensor, seed=seed) for seed in task.seeds]
        self._samples: list[Sample] = []
        self._watchers = [task.watchers(seed) for seed in task.seeds]
        self._track, self._album = Track(), Album()
        self._velocity: list[tuple[int, float]] = []
        self._due_us = CHUNK_US

    def show(self, sample: Sample) -> None:
        """Take the next sample of light, to show to every sensor with the others of its chunk.

        One sensor after the other sees a whole chunk, so that a processor's caches hold its state.
        """
        note(self._track, sample.truth)
        if not self._velocity or sample.t_us >= self._velocity[-1][0] + CHUNK_US:
            velocity_px_s = float(sample.truth.image_velocity_px_s[0])
            self._velocity.append((sample.t_us, velocity_px_s))
        self._samples.append(sample)
        if sample.t_us >= self._due_us:
            self._pass_on()
            self._due_us = (sample.t_us // CHUNK_US + 1) * CHUNK_US

    def end(self) -> None:
        """Pass on what is left, after the last sample."""
        self._pass_on()

    def _pass_on(self) -> None:
        if not self._samples:
            return
        until_us = self._samples[-1].t_us + 1
        for n, (sensor, watchers) in enumerate(zip(self._sensors, self._watchers, strict=True)):
            events, frames = self._seen(sensor, is_first=n == 0)
            for watcher in watchers:
                said = watcher.watch(events, frames, until_us=until_us)
                if n == 0:
                    self._take_down(watcher, said)
            if n == 0:
                self._album.add_frames(frames)
        self._samples = []

    def _seen(self, sensor: EventSensor, *, is_first: bool) -> tuple[Events, list[ApsFrame]]:
        """What a sensor says of the chunk."""
        outputs = [sensor.step(s.t_us, s.luminance, changed=s.changed) for s in self._samples]
        if is_first and self._recorder is not None:
            for sample, output in zip(self._samples, outputs, strict=True):
                self._recorder.log(sample, output)
        return gathered(outputs)

    def _take_down(self, watcher: Watcher, said: Sequence[MotionEstimate]) -> None:
        maps = watcher.maps
        if said and maps is not None:
            self._album.add(watcher.method, said[-1], maps, self._track.box_px(said[-1].t_us))
        if self._recorder is not None:
            for estimate in said:
                is_due = estimate is said[-1] and estimate.t_us % MAPS_PERIOD_US == 0
                self._recorder.log_estimate(watcher.method, estimate, maps if is_due else None)

    def result(self, crossing: Crossing) -> Result:
        """What was seen and said, once all is passed on."""
        c, times_us = self._task.crossing, [t for t, _ in self._velocity]
        velocity_px_s = np.array([v for _, v in self._velocity], np.float64)
        result = Result(
            lighting=c.lighting.value,
            omega_rad_s=c.omega_rad_s,
            speed_km_h=crossing.trajectory.speed_m_s(0.0) * 3.6,
            duration_us=crossing.duration_us,
            in_view_us=self._track.in_view_us,
            velocity_t_us=np.array(times_us, np.int64),
            velocity_px_s=velocity_px_s,
            snapshots=self._snapshots(),
            runs=(),
            direction=c.direction.value,
        )
        return replace(result, runs=tuple(self._runs(result)))

    def _snapshots(self) -> tuple[Snapshot, ...]:
        return self._album.choose(self._track.in_view_us)

    def _runs(self, result: Result) -> Iterable[MethodRun]:
        for watcher in (watcher for watchers in self._watchers for watcher in watchers):
            errors = velocity_errors(watcher.method, watcher.estimates, result)
            rms = None if errors is None else float(np.sqrt(np.mean(errors**2)))
            yield MethodRun(
                method=watcher.method,
                seed=watcher.seed,
                estimates=tuple(watcher.estimates),
                judgement=judge(
                    watcher.estimates, result.direction, result.in_view_us, self._track
                ),
                velocity_error_px_s=rms,
                cpu_s=watcher.cpu_s,
                events=watcher.events,
                velocity_bias_px_s=None if errors is None else float(np.mean(errors)),
            )


def velocity_errors(
    method: str, estimates: Sequence[MotionEstimate], result: Result
) -> npt.NDArray[np.float64] | None:
    """Errors of the horizontal velocity in the settled steps that name a direction [px/s].

    Args:
        method: its name.
        estimates: all that it said.
        result: of the sequence; its runs are not looked at.

    Returns:
        (n,), or None of a method that gives no velocity, and where there is no such step.
    """
    if not gives_velocity(method):
        return None
    settled_us = result.in_view_us[0] + SETTLING_US, result.in_view_us[1]
    named = [e for e in within(estimates, settled_us) if e.direction is not Direction.NONE]
    if not named:
        return None
    truth = np.interp([e.t_us for e in named], result.velocity_t_us, result.velocity_px_s)
    return np.array([e.response[0] for e in named]) - truth
