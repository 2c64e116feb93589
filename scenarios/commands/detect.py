"""`flybench detect`: detect the direction of motion in a recording of any event camera."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.console import Console

from detector.estimate import FrameDetector
from formats import FORMATS, EventFile, open_events
from scenarios.commands.view import is_recording
from scenarios.detect.estimate_output import EstimateJson, EstimatePrinter, EstimateTable
from scenarios.detect.plot import write_plot
from scenarios.detect.plot_data import PlotData
from scenarios.detect.run_detector import RecordingSlice, run_detector
from scenarios.detect.verdict import RecordingVerdict
from scenarios.errors import ScenarioError
from scenarios.options.method import MethodName
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.atomic_folder import EVENTS
from scenarios.output.terminal import run_cli
from scenarios.pipeline.feeding import fly_maps
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.scaled_detectors import ScaledDetector, make_scaled
from scenarios.recording import FileRecorder
from scenarios.runs.run_table import view_command

_SIZE = re.compile(r"(\d{1,5})[x×](\d{1,5})")
_FROM_FILE = "(default: from the file, or inferred from its values)"


@dataclass(frozen=True)
class Detect:
    """Detect the direction of motion in a recording of any event camera."""

    file: Annotated[Path, tyro.conf.Positional]
    """Recording to read, or the folder of a flybench run."""
    method: MethodName = FLY
    json: bool = False
    """Print one JSON document with estimates, verdict and file statistics instead of tables."""
    rrd: Annotated[
        Path | None, tyro.conf.arg(metavar="FILE", help_behavior_hint="(default: no recording)")
    ] = None
    """Also write a Rerun recording (.rrd), which `flybench view FILE` opens."""
    plot: Annotated[
        Path | None, tyro.conf.arg(metavar="PNG", help_behavior_hint="(default: no figure)")
    ] = None
    """Also write a figure (.png) of the events, the responses and the event rate."""
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace existing files of --rrd and --plot."""
    scale_to_sensor: bool = False
    """Scale the detector's lengths in pixels by width / 346; 346 is the width of a DAVIS346."""
    time_scale: float = 1.0
    """Factor for all times of the detector, 0.001 to 1000; above 1 for slower motion."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH", help_behavior_hint=_FROM_FILE)] = None
    """Sensor size [px], such as 346x260, if the file does not state it, or states a wrong size."""
    format: Annotated[
        str | None,
        tyro.conf.arg(
            metavar="NAME",
            help=f"Format of the file, if it is not recognised: {', '.join(FORMATS)}.",
            help_behavior_hint="(default: recognised by the file's first bytes)",
        ),
    ] = None
    time_unit: Annotated[
        str | None, tyro.conf.arg(metavar="s|ms|us|ns", help_behavior_hint=_FROM_FILE)
    ] = None
    """Unit of the timestamps, if a text, HDF5 or NumPy file does not state it or is wrong."""

    def execute(self) -> int:
        """Read the recording and print the estimates and the verdict."""
        events_of_run = self.file / EVENTS
        path = events_of_run if events_of_run.is_file() else self.file
        self._check_outputs(path)
        _check_not_rerun(path)
        with open_events(
            path, format=self.format, size=self._size(), time_unit=self.time_unit
        ) as file:
            scaled = self._make_detector(file)
            with EstimateJson(sys.stdout) if self.json else EstimateTable(Console()) as printer:
                verdict = self._read(file, scaled, printer)
                printer.finish(file, self.method, scaled.changes, verdict)
        self._print_outputs()
        return 0

    def _read(
        self, file: EventFile, scaled: ScaledDetector, printer: EstimatePrinter
    ) -> RecordingVerdict:
        """Run the detector on the file and write the outputs atomically."""
        verdict, plot_data = RecordingVerdict(), PlotData()
        with ExitStack() as stack:
            log = self._recorder(stack, file, scaled) if self.rrd else None
            for part in run_detector(file, scaled.detector):
                for estimate in part.estimates:
                    verdict.add(estimate)
                    printer.add(estimate)
                if self.plot:
                    plot_data.add(part)
                if log:
                    log(part)
            _check_not_empty(file)
            if self.plot:
                png = stack.enter_context(atomic_file(self.plot, overwrite=self.overwrite))
                title = f"{self._title(file)}: {verdict.direction.value}"
                write_plot(png, plot_data, (file.width, file.height), title)
        return verdict

    def _recorder(
        self, stack: ExitStack, file: EventFile, scaled: ScaledDetector
    ) -> Callable[[RecordingSlice], None]:
        """Return a function that logs slices; it opens the recorder at the first slice."""
        assert self.rrd is not None
        work = stack.enter_context(atomic_file(self.rrd, overwrite=self.overwrite))
        opened: list[FileRecorder] = []

        def log(part: RecordingSlice) -> None:
            if not opened:
                recorder = FileRecorder(
                    work,
                    width=file.width,
                    height=file.height,
                    method=self.method,
                    has_maps=fly_maps(scaled.detector) is not None,
                    has_frames=file.has_frames,
                    name=self._title(file),
                    parameters=self._parameters(file, scaled),
                    start_us=part.start_us,
                )
                opened.append(stack.enter_context(recorder))
            _log(opened[0], self.method, part)

        return log

    def _title(self, file: EventFile) -> str:
        return f"{file.path.name}, {self.method}"

    def _parameters(self, file: EventFile, scaled: ScaledDetector) -> dict[str, object]:
        changes = {f"scaled.{name}": value for name, value in scaled.changes.items()}
        facts = {"file": file.path.name, "format": file.format, "method": self.method}
        return {**facts, "width": file.width, "height": file.height, **changes}

    def _make_detector(self, file: EventFile) -> ScaledDetector:
        scaled = make_scaled(
            self.method,
            width=file.width,
            height=file.height,
            to_sensor=self.scale_to_sensor,
            time_scale=self.time_scale,
        )
        if isinstance(scaled.detector, FrameDetector) and not file.has_frames:
            raise ScenarioError(
                f"--method {self.method} needs APS frames, and {file.path} contains none. Choose "
                "another method, such as fly."
            )
        return scaled

    def _size(self) -> tuple[int, int] | None:
        if self.size is None:
            return None
        sides = _SIZE.fullmatch(self.size.strip())
        if sides is None:
            raise ScenarioError(
                f"--size is {self.size!r}. Allowed is width and height in pixels, such as --size "
                "346x260."
            )
        return int(sides[1]), int(sides[2])

    def _check_outputs(self, source: Path) -> None:
        for path, option, suffix in ((self.rrd, "--rrd", ".rrd"), (self.plot, "--plot", ".png")):
            if path is None:
                continue
            if path.suffix.lower() != suffix:
                raise ScenarioError(
                    f"{option} is {path}. Allowed is a name that ends in {suffix}. Add the ending."
                )
            if path.absolute() == source.absolute():
                raise ScenarioError(
                    f"{option} is {path}, which is the recording to read. Choose another name."
                )
            check_output_file(path, option, overwrite=self.overwrite)

    def _print_outputs(self) -> None:
        console = Console(stderr=True) if self.json else Console()
        if self.plot:
            console.print(f"wrote {self.plot}", soft_wrap=True, markup=False)
        if self.rrd:
            command = view_command(self.rrd)
            text = f"wrote {self.rrd}   open it with: {command}"
            console.print(text, soft_wrap=True, markup=False)


def _log(recorder: FileRecorder, method: str, part: RecordingSlice) -> None:
    recorder.log_events(part.events)
    for frame in part.frames:
        recorder.log_aps(frame)
    for estimate in part.estimates:
        recorder.log_estimate(method, estimate, part.maps)


def _check_not_rerun(path: Path) -> None:
    if path.is_file() and is_recording(path):
        raise ScenarioError(
            f"{path} is a Rerun recording, which can only be viewed. Allowed is a file of events. "
            f"View it with: flybench view {path}"
        )


def _check_not_empty(file: EventFile) -> None:
    if not file.statistics.events and not file.statistics.frames:
        raise ScenarioError(
            f"{file.path} contains no events and no frames. Record it again, or give another file."
        )


if __name__ == "__main__":
    run_cli(Detect)
