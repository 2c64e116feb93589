"""Check of a calibration: half of the recording predicts the events of the other half.

The sensor is fitted to the first half. Then the frames of the second half, interpolated by optical
flow, are shown to two emulated sensors, the fitted one and the one from which the fits started.
Their events are compared with those of the camera, pixel by pixel. The error is the mean absolute
difference of the number of events of a pixel and polarity, |n − n_camera|. A pixel of the frames
keeps its light until it changes by more than their noise, which is not the noise of events.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from emulator import EventSensor, SensorConfig
from emulator.pixel.optics import lux_per_cd_m2
from flybench.events import Events
from scenarios.calibrate.calibration import calibrate
from scenarios.calibrate.fits.frame_noise import frame_noise
from scenarios.calibrate.recording import CalibrationRecording
from scenarios.emulate.luminance_samples import STEP_PX
from scenarios.emulate.motion import MotionMeter, interpolated, interpolation_count
from scenarios.errors import ScenarioError

_DEVIATIONS = 5.0
"""Standard deviations of a change that is no noise of the frames (assumed)."""

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Prediction:
    """Errors of the prediction of the second half of a recording.

    Attributes:
        from_s: start of the predicted part, on the clock of the recording [s].
        to_s: its end [s].
        camera: mean number of events of a pixel and polarity in it.
        fitted: the same of the sensor that is fitted to the first half.
        start: the same of the sensor from which the fits started.
        fitted_error: mean absolute difference to the camera of the fitted sensor.
        start_error: that of the sensor from which the fits started.
    """

    from_s: float
    to_s: float
    camera: float
    fitted: float
    start: float
    fitted_error: float
    start_error: float


def predict_second_half(recording: CalibrationRecording, start: SensorConfig) -> Prediction | None:
    """Fit the first half of a recording, and predict the second; None if a half is too short.

    Args:
        recording: events and frames.
        start: sensor from which the fits start, and with which the result is compared.
    """
    first_us, last_us = recording.span_us
    middle_us = (first_us + last_us) // 2
    try:
        first = recording.between(first_us, middle_us)
        second = recording.between(middle_us, last_us + 1)
    except ScenarioError:
        return None
    rows, columns = recording.shape
    start = replace(start, width=columns, height=rows)
    fitted = calibrate(first, start).sensor
    starts, ends, _ = second.exposures_us()
    from_us, to_us = int(starts[0] + ends[0]) // 2, int(starts[-1] + ends[-1]) // 2
    camera = _counts(second.events, from_us, to_us, second.shape)
    both = [_emulated(second, sensor) for sensor in (fitted, start)]
    errors = [float(np.abs(counts - camera).mean()) for counts in both]
    means = [float(counts.mean()) for counts in (camera, *both)]
    return Prediction(from_us * 1e-6, to_us * 1e-6, *means, *errors)


def _counts(events: Events, from_us: int, to_us: int, shape: tuple[int, int]) -> I64:
    """Return the number of events of each polarity and pixel in (from, to], (2, pixels)."""
    t = events["t"]
    chosen = events[(t > from_us) & (t <= to_us)]
    pixel = chosen["y"].astype(np.int64) * shape[1] + chosen["x"]
    size = shape[0] * shape[1]
    return np.stack([np.bincount(pixel[chosen["p"] == on], minlength=size) for on in (False, True)])


def _emulated(recording: CalibrationRecording, sensor: SensorConfig) -> I64:
    """Return the events that a sensor gives when it sees the frames, as `_counts`."""
    model = EventSensor(sensor, seed=0)
    total = np.zeros((2, recording.frames[0].image.size), np.int64)
    for t_us, luminance in _samples(recording, sensor):
        events = model.step(t_us, luminance).events
        total += _counts(events, -1, t_us, recording.shape)
    return total


def _samples(recording: CalibrationRecording, sensor: SensorConfig) -> Iterator[tuple[int, F32]]:
    """Yield the luminance of the frames [cd/m²] and of those interpolated between them."""
    per_cd_m2 = lux_per_cd_m2(f_number=sensor.f_number, transmission=sensor.transmission)
    meter = MotionMeter(None)
    starts, ends, _ = recording.exposures_us()
    middles = (starts + ends) // 2
    before: F32 | None = None
    for k, lux in enumerate(_without_noise(recording)):
        luminance = np.asarray(lux / per_cd_m2, np.float32)
        if before is not None:
            forward = meter.flow_px(before, luminance)
            count = interpolation_count(meter.motion_px(before, luminance, forward), STEP_PX)
            backward = meter.flow_px(luminance, before)
            for share, mixed in interpolated(before, luminance, forward, backward, count):
                yield round(middles[k - 1] + share * (middles[k] - middles[k - 1])), mixed
        yield int(middles[k]), luminance
        before = luminance


def _without_noise(recording: CalibrationRecording) -> Iterator[F64]:
    """Yield the illuminance of each frame [lux]; a pixel keeps it until it changes beyond noise."""
    noise = frame_noise(recording)
    held = recording.frames[0].image * recording.lux_per_level[0]
    yield held
    for k, frame in enumerate(recording.frames[1:], start=1):
        lux = recording.lux_per_level[k]
        change = np.abs(frame.image * lux - held)
        held = np.where(change > _DEVIATIONS * noise[k - 1] * lux, frame.image * lux, held)
        yield held
