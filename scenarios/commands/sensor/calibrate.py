"""`flybench calibrate`: estimate the parameters of a sensor from a recording with frames."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tyro
from rich.table import Table

from emulator import SensorConfig
from flybench.checks import Range
from flybench.version import __version__
from formats import EventFile
from scenarios.calibrate.calibration import STEPS, Calibration, calibrate
from scenarios.calibrate.json_export import calibration_dict
from scenarios.calibrate.page import parameter_rows, prediction_rows, render_page
from scenarios.calibrate.prediction import Prediction, predict_second_half
from scenarios.calibrate.recording import (
    CalibrationRecording,
    check_recording,
    from_aps,
    read_recording,
)
from scenarios.calibrate.toml_export import sensor_toml
from scenarios.calibrate.video_frames import read_video
from scenarios.commands.detect import check_not_rerun
from scenarios.emulate.frame_times import TimeOptions
from scenarios.errors import ScenarioError
from scenarios.options.recording import RecordingOptions
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import run_cli
from scenarios.output.versions import versions

LOGS = Path("logs")
PAGE, NUMBERS, SENSOR = "calibration.html", "calibration.json", "sensor.toml"
NEEDED_BYTES = 1_000_000
"""Size of the output [bytes] (measured: 0.3 MB)."""
WHITE_CD_M2 = 200.0
"""Luminance of the highest grey level of a video (assumed: a display)."""
_FRAMES_FROM_MS = Range(-1e12, 1e12, "ms", "Give the time of the first frame, such as 120.")
_OF_FRAMES = {
    "fps": "Frames in a recording have their own times.",
    "frames_from_ms": "Frames in a recording have their own times.",
    "white_cd_m2": "Frames in a recording have the sensitivity that --sensor states.",
    "transfer": "Frames in a recording are linear.",
}
"""Options that --frames needs, and why the frames of a recording do not."""
_LIBRARIES = ("flybench", "numpy", "numba", "scipy", "matplotlib")


@dataclass(frozen=True)
class Calibrate:
    """Estimate the parameters of a sensor from a recording."""

    path: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RECORDING")]
    """Recording of events and frames (AEDAT 4, ROS), or of events with --frames."""
    frames: Annotated[
        Path | None,
        tyro.conf.arg(metavar="VIDEO", help_behavior_hint="(default: the frames of the recording)"),
    ] = None
    """Video, folder of images or .npy array of the same view, scaled to fill the sensor."""
    fps: Annotated[
        float | None,
        tyro.conf.arg(metavar="HZ", help_behavior_hint="(default: each frame's own time)"),
    ] = None
    """Frames per second of --frames, 0.1 to 100000."""
    frames_from_ms: float = 0.0
    """Time of the first frame of --frames on the clock of the events [ms]."""
    white_cd_m2: Annotated[float, tyro.conf.arg(metavar="CD_M2")] = WHITE_CD_M2
    """Luminance of the highest grey level of --frames [cd/m²], above 0."""
    transfer: Literal["srgb", "linear"] = "srgb"
    """Relation of grey levels of --frames to luminance: sRGB, as in most videos, or linear."""
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    check: bool = True
    """Also fit the first half of the recording alone, and predict the events of the second."""
    json: bool = False
    """Print one JSON document instead of the table."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(metavar="DIR", help_behavior_hint="(default: logs/calibration_RECORDING)"),
    ] = None
    """Folder to write; an earlier result in it is replaced."""
    input: tyro.conf.OmitArgPrefixes[RecordingOptions] = field(default_factory=RecordingOptions)

    def execute(self) -> int:
        """Read the recording, run all fits, write the folder and print the parameters."""
        start, changes = self.sensor.config(), self.sensor.changes()
        folder = self.out or LOGS / f"calibration_{self.path.stem}"
        check_not_rerun(self.path)
        check_output_folder(folder, needed_bytes=NEEDED_BYTES)
        recording = self._read(start)
        rows, columns = recording.shape
        start = replace(start, width=columns, height=rows)
        with atomic_folder(folder) as work:
            with progress_bar() as progress:
                advance = progress.track(self.path.name)
                calibration = calibrate(recording, start, lambda done, _: advance(done, STEPS + 1))
                prediction = predict_second_half(recording, start) if self.check else None
                advance(STEPS + 1, STEPS + 1)
            document = calibration_dict(
                calibration,
                prediction,
                recording=self.path.name,
                changes=changes,
                versions=versions(_LIBRARIES),
            )
            self._write(work, calibration, prediction, recording, start, document)
        if self.json:
            say(json.dumps(document, allow_nan=False))
        else:
            print_calibration(calibration, prediction, start)
            say(f"wrote {folder / SENSOR} and {PAGE}")
        return 0

    def _read(self, start: SensorConfig) -> CalibrationRecording:
        self._check_options_of_frames()
        name = str(self.path)
        with self.input.open(self.path) as file:
            size = {"width": file.width, "height": file.height}
            events, frames, whole = read_recording(file, **size, name=name)
            if self.frames is None:
                return from_aps(events, frames, start.aps, name=name, whole=whole)
            video = self._video(self.frames, file, start)
        per_level = np.full(len(video.frames), video.lux_per_level)
        recording = CalibrationRecording(events, video.frames, per_level, whole)
        check_recording(recording, f"{name} with {self.frames}")
        return recording

    def _check_options_of_frames(self) -> None:
        _FRAMES_FROM_MS.check("--frames-from-ms", self.frames_from_ms, ScenarioError)
        if self.frames is not None:
            return
        for own in fields(self):
            value = getattr(self, own.name)
            if own.name in _OF_FRAMES and value != own.default:
                shown = f"{value:g}" if isinstance(value, float) else value
                raise ScenarioError(
                    f"--{own.name.replace('_', '-')} is {shown}, but --frames is not given. "
                    f"{_OF_FRAMES[own.name]} Leave it out, or give --frames."
                )

    def _video(self, path: Path, file: EventFile, start: SensorConfig) -> Any:
        return read_video(
            path,
            replace(start, width=file.width, height=file.height),
            times=TimeOptions(self.fps),
            first_us=round(1e3 * self.frames_from_ms),
            white_cd_m2=self.white_cd_m2,
            transfer=self.transfer,
        )

    def _write(
        self,
        work: Path,
        calibration: Calibration,
        prediction: Prediction | None,
        recording: CalibrationRecording,
        start: SensorConfig,
        document: Mapping[str, Any],
    ) -> None:
        changes, name = self.sensor.changes(), self.path.name
        text = sensor_toml(calibration, changes, name=name, version=__version__)
        (work / SENSOR).write_text(text, encoding="utf-8")
        page = render_page(
            calibration,
            prediction,
            recording=name,
            facts=facts_of(recording),
            start=start,
            versions=document["versions"],
        )
        (work / PAGE).write_text(page, encoding="utf-8")
        numbers = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False)
        (work / NUMBERS).write_text(numbers + "\n", encoding="utf-8")
        summary = {"command": "calibrate", "recording": str(self.path), "sensor": dict(changes)}
        write_summary(work, summary | {"versions": document["versions"]})


def facts_of(recording: CalibrationRecording) -> str:
    """Return size, events, frames and duration of a recording in one phrase."""
    rows, columns = recording.shape
    part = "" if recording.whole else "the first part of the recording: "
    return (
        f"{part}{columns}×{rows} px, {recording.events.size:,} events and "
        f"{len(recording.frames)} frames in {recording.duration_s:.3f} s"
    )


def print_calibration(
    calibration: Calibration, prediction: Prediction | None, start: SensorConfig
) -> None:
    """Print the parameters, the flicker and the prediction."""
    console = SafeConsole()
    table = Table(title="Parameters of the sensor", title_justify="left")
    for heading in ("parameter", "value", "95 % interval", "start", "evidence"):
        table.add_column(heading, justify="left", overflow="fold")
    for row in parameter_rows(calibration, start):
        table.add_row(row.name, row.value, row.interval, row.start, row.evidence)
    console.print(table)
    if (flicker := calibration.flicker) is not None:
        console.print(f"Lamps flicker at {flicker.hz:.2f} Hz in {flicker.pixels:,} pixels.")
    if prediction is None:
        return
    shown = Table(title="Prediction of the second half", title_justify="left")
    for heading in ("sensor", "events of a pixel and polarity", "error"):
        shown.add_column(heading)
    for cells in prediction_rows(prediction):
        shown.add_row(*cells)
    console.print(shown)


if __name__ == "__main__":
    run_cli(Calibrate)
