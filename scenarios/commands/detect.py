"""`flybench detect`: detect the direction of motion in a recording of any event camera."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, ClassVar

import tyro

from detector.estimate import FrameDetector
from formats import EventFile, FormatError
from scenarios.commands.view import is_recording
from scenarios.detect.estimate_output import (
    EstimateJson,
    EstimatePrinter,
    EstimateTable,
    Outcome,
    file_line,
)
from scenarios.detect.plot import write_plot
from scenarios.detect.plot_data import PlotData
from scenarios.detect.run_detector import RecordingSlice, run_detector
from scenarios.detect.spans import LEAST_SPAN_US
from scenarios.detect.verdict import LEAST_SHARE, RecordingVerdict, memory_us, percent
from scenarios.errors import ScenarioError
from scenarios.options.method import FilterName, MethodName, behind_filter
from scenarios.options.recording import RecordingOptions, events_file
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.streams import SafeConsole, own_output
from scenarios.output.terminal import report_failures, run_cli
from scenarios.pipeline.feeding import DetectorFeed, fly_maps
from scenarios.pipeline.registry import ROBUST
from scenarios.pipeline.scaled_detectors import ScaledDetector, make_scaled
from scenarios.recording import FileRecorder
from scenarios.runs.run_table import view_command
from scenarios.styles.method_style import method_style


@dataclass(frozen=True)
class Detect:
    """Detect the direction of motion in a recording."""

    GROUPS: ClassVar = {
        "detector": ("scale_to_sensor", "time_scale"),
        "output": ("json", "rrd", "plot", "overwrite"),
        "input": (),
    }

    file: Annotated[
        Path,
        tyro.conf.Positional,
        tyro.conf.arg(
            help="Recording to read, or the folder of a flybench run. The verdict is a direction "
            f"if at least {percent(LEAST_SHARE)} of the steps that name one name it (assumed), "
            f"for at least {LEAST_SPAN_US // 1000} ms (Δt of the paper). The page "
            "docs/reference/detect.md gives all its limits."
        ),
    ]
    method: MethodName = ROBUST
    filter: FilterName = None
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
    input: tyro.conf.OmitArgPrefixes[RecordingOptions] = field(default_factory=RecordingOptions)

    def execute(self) -> int:
        """Read the recording and print the estimates and the verdict."""
        if self.filter is not None:
            method = behind_filter(self.filter, self.method)
            return replace(self, method=method, filter=None).execute()
        path = events_file(self.file)
        self._check_outputs(path)
        check_not_rerun(path)
        # absolute, because a detector may change the current folder
        rrd, plot = (name and name.absolute() for name in (self.rrd, self.plot))
        with self.input.open(path) as file:
            scaled = self._make_detector(file)
            size = {"width": file.width, "height": file.height}
            feed = DetectorFeed(self.method, scaled.detector, **size)
            self._notes().print(file_line(file), soft_wrap=True)
            with self._printer() as printer:
                verdict, error = self._read(file, scaled, feed, printer, rrd, plot)
                failure = None if feed.failure is None else str(feed.failure)
                reason = None if error is None else str(error)
                outcome = Outcome(file, self.method, scaled.changes, verdict, failure, reason)
                printer.finish(outcome)
        self._print_outputs()
        status = report_failures([failure] if failure else [])
        if error is not None:
            raise error
        return status

    def _notes(self) -> SafeConsole:
        """Return where to print what is not the result."""
        return SafeConsole(stderr=self.json)

    def _printer(self) -> EstimatePrinter:
        stream = own_output()
        return EstimateJson(stream) if self.json else EstimateTable(SafeConsole())

    def _read(
        self,
        file: EventFile,
        scaled: ScaledDetector,
        feed: DetectorFeed,
        printer: EstimatePrinter,
        rrd: Path | None,
        plot: Path | None,
    ) -> tuple[RecordingVerdict, FormatError | None]:
        """Run the detector on the file, or on what comes before an error, and write the outputs."""
        verdict, plot_data = RecordingVerdict(memory_us(scaled.detector)), PlotData()
        error: FormatError | None = None
        with ExitStack() as stack:
            log = self._recorder(stack, file, scaled, rrd) if rrd else None
            try:
                for part in run_detector(file, feed):
                    verdict.add(part)
                    for estimate in part.estimates:
                        printer.add(estimate)
                    if plot:
                        plot_data.add(part)
                    if log:
                        log(part)
            except FormatError as caught:
                if not file.statistics.events:
                    raise
                error = caught
            check_not_empty(file)
            if plot:
                png = stack.enter_context(atomic_file(plot, overwrite=self.overwrite))
                size = file.width, file.height
                title = f"{file.path.name}, {method_style(self.method).label}"
                title += ", up to an error in the file" if error else ""
                write_plot(png, plot_data, size, title, verdict, method=self.method)
        return verdict, error

    def _recorder(
        self, stack: ExitStack, file: EventFile, scaled: ScaledDetector, rrd: Path
    ) -> Callable[[RecordingSlice], None]:
        """Return a function that logs slices; it opens the recorder at the first slice."""
        work = stack.enter_context(atomic_file(rrd, overwrite=self.overwrite))
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

    def _check_outputs(self, source: Path) -> None:
        for path, option, suffix in ((self.rrd, "--rrd", ".rrd"), (self.plot, "--plot", ".png")):
            if path is None:
                continue
            if path.suffix.lower() != suffix:
                raise ScenarioError(
                    f"{option} is {path}. Allowed is a name that ends in {suffix}. Add the ending."
                )
            check_output_file(path, option, overwrite=self.overwrite, sources=(source,))

    def _print_outputs(self) -> None:
        console = self._notes()
        if self.plot:
            console.print(f"wrote {self.plot}", soft_wrap=True)
        if self.rrd:
            command = view_command(self.rrd)
            text = f"wrote {self.rrd}   open it with: {command}"
            console.print(text, soft_wrap=True)


def _log(recorder: FileRecorder, method: str, part: RecordingSlice) -> None:
    recorder.log_events(part.events)
    for frame in part.frames:
        recorder.log_aps(frame)
    for estimate in part.estimates:
        recorder.log_estimate(method, estimate, part.maps)


def check_not_rerun(path: Path) -> None:
    """Check that a file is not a Rerun recording, which contains no events to read."""
    if path.is_file() and is_recording(path):
        raise ScenarioError(
            f"{path} is a Rerun recording, which can only be viewed. Allowed is a file of events. "
            f"View it with: flybench view {path}"
        )


def check_not_empty(file: EventFile) -> None:
    """Check that a file that was read to its end had events or frames."""
    if not file.statistics.events and not file.statistics.frames:
        raise ScenarioError(
            f"{file.path} contains no events and no frames. Record it again, or give another file."
        )


if __name__ == "__main__":
    run_cli(Detect)
