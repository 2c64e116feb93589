"""Recording of a sequence: all events, and previews and ground truth at lower rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import SensorOutput
from scenarios.pipeline.registry import FLY
from scenarios.recording.recorder import Recorder
from sim import Crossing, Sample, preview_jpegs
from sim.preview import PREVIEW_SCALE

PREVIEW_PERIOD_US = 50_000
"""Time between colour previews (assumed): two per second when played at a tenth of the speed."""
TRUTH_PERIOD_US = 10_000
"""Time between samples of the ground truth, in curves, events and 3-D scene (assumed)."""


class SequenceRecorder:
    """A `Recorder` that also renders the colour previews; use it as a context manager."""

    def __init__(
        self,
        path: Path,
        *,
        crossing: Crossing,
        parameters: Mapping[str, object],
        methods: Sequence[str] = (FLY,),
        maps_of: str | None = None,
        name: str | None = None,
        one_of_several: bool = False,
        preview_period_us: int = PREVIEW_PERIOD_US,
    ) -> None:
        """Create the file; the arguments are those of `Recorder`, and the time between previews.

        Raises:
            RendererError: this machine cannot render.
            OSError: the file cannot be written.
            ScenarioError: a method is named twice, or `maps_of` is not one of the methods.
        """
        self._preview_period_us = preview_period_us
        times_us = range(0, crossing.duration_us + 1, preview_period_us)
        self._previews = dict(enumerate(preview_jpegs(crossing, times_us)))
        self._recorder = Recorder(
            path,
            crossing=crossing,
            parameters=parameters,
            methods=methods,
            maps_of=maps_of,
            name=name,
            one_of_several=one_of_several,
        )
        self._truth_due_us = 0

    def __enter__(self) -> SequenceRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self._recorder.close()

    def log(self, sample: Sample, output: SensorOutput) -> None:
        """Record a luminance sample, and the sensor's output since the previous one.

        Args:
            sample: next sample, in order of time.
            output: output of the sensor up to the time of the sample.
        """
        self._recorder.log_events(output.events, output.causes)
        for frame in output.aps_frames:
            self._recorder.log_aps(frame)
        if sample.t_us >= self._truth_due_us:
            self._recorder.log_truth(sample.truth)
            self._truth_due_us = sample.t_us + TRUTH_PERIOD_US
        jpeg = self._previews.pop(sample.t_us // self._preview_period_us, None)
        if jpeg is not None:
            self._recorder.log_preview(jpeg, sample.truth, scale=PREVIEW_SCALE)

    def log_estimate(
        self, method: str, estimate: MotionEstimate, maps: FlyMaps | None = None
    ) -> None:
        """Record an estimate of a method; see `Recorder.log_estimate`."""
        self._recorder.log_estimate(method, estimate, maps)
