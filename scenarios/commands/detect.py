"""`flybench detect`: the direction of motion in a recording of anybody's event camera."""

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
from formats import EventFile, open_events
from scenarios.commands.view import is_recording
from scenarios.detect.plot import write_plot
from scenarios.detect.steps import StepsJson, StepsPrinter, StepsTable
from scenarios.detect.tally import Curves, Verdict
from scenarios.detect.watching import Look, maps_of, watch
from scenarios.errors import ScenarioError
from scenarios.output.folder import EVENTS
from scenarios.output.terminal import script
from scenarios.output.whole_file import check_place, whole_file
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.scaled_detectors import ScaledDetector, make_scaled
from scenarios.recording import FileRecorder
from scenarios.runs.run_table import view_command

_SIZE = re.compile(r"(\d{1,5})[x×](\d{1,5})")


@dataclass(frozen=True)
class Detect:
    """Read the direction of motion from a recording of any event camera."""

    file: Annotated[Path, tyro.conf.Positional]
    """The recording, or the folder of a flybench run."""
    method: Annotated[str, tyro.conf.arg(metavar="NAME")] = FLY
    """Detector: fly, wide, frame-fly, frame-fly-coarse, frame-fly-no-floor, contrast-maximisation,
    plane-fit, or package.module:Class."""
    json: bool = False
    """Print JSON on standard output, and nothing else: steps, verdict, and what was found."""
    rrd: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Write a Rerun recording too; open it with flybench view FILE."""
    plot: Annotated[Path | None, tyro.conf.arg(metavar="PNG")] = None
    """Write a figure too: events, responses, event rate."""
    scale_to_sensor: bool = False
    """Multiply the settings in pixels by the sensor's width over the DAVIS346's 346."""
    time_scale: float = 1.0
    """Multiply the settings in milliseconds; above 1 for slower motion."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WxH")] = None
    """Size of the sensor, where the file does not say or is wrong, such as 346x260."""
    format: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None
    """Format of the file, where it is not recognised: aedat4, evt3, dat, hdf5, text, ..."""
    time_unit: Annotated[str | None, tyro.conf.arg(metavar="s|ms|us|ns")] = None
    """Unit of time, where the file does not say or is wrong."""

    def execute(self) -> int:
        """Read, and print a table or JSON."""
        run = self.file / EVENTS
        path = run if run.is_file() else self.file
        self._check_outputs(path)
        _check_events(path)
        with open_events(
            path, format=self.format, size=self._size(), time_unit=self.time_unit
        ) as file:
            made = self._make(file)
            with StepsJson(sys.stdout) if self.json else StepsTable(Console()) as printer:
                verdict = self._read(file, made, printer)
                printer.finish(file, self.method, made.changes, verdict)
        self._tell_outputs()
        return 0

    def _read(self, file: EventFile, made: ScaledDetector, printer: StepsPrinter) -> Verdict:
        """Pass the file before the detector and write the outputs, whole or not at all."""
        verdict, curves = Verdict(), Curves()
        with ExitStack() as stack:
            log = self._recorder(stack, file, made) if self.rrd else None
            for look in watch(file, made.detector):
                for estimate in look.estimates:
                    verdict.add(estimate)
                    printer.add(estimate)
                if self.plot:
                    curves.add(look)
                if log:
                    log(look)
            _check_something(file)
            if self.plot:
                png, size = stack.enter_context(whole_file(self.plot)), (file.width, file.height)
                write_plot(png, curves, verdict, size, f"{file.path.name}, {self.method}")
        return verdict

    def _recorder(
        self, stack: ExitStack, file: EventFile, made: ScaledDetector
    ) -> Callable[[Look], None]:
        """What writes pieces into the recording, which begins with the first of them."""
        assert self.rrd is not None
        work = stack.enter_context(whole_file(self.rrd))
        begun: list[FileRecorder] = []

        def log(look: Look) -> None:
            if not begun:
                begun.append(
                    stack.enter_context(
                        FileRecorder(
                            work,
                            width=file.width,
                            height=file.height,
                            method=self.method,
                            has_maps=maps_of(made.detector) is not None,
                            has_frames=file.has_frames,
                            name=f"{file.path.name}, {self.method}",
                            parameters=self._parameters(file, made),
                            start_us=look.start_us,
                        )
                    )
                )
            _log(begun[0], self.method, look)

        return log

    def _parameters(self, file: EventFile, made: ScaledDetector) -> dict[str, object]:
        scaled = {f"scaled.{name}": value for name, value in made.changes.items()}
        facts = {"file": file.path.name, "format": file.format, "method": self.method}
        return {**facts, "width": file.width, "height": file.height, **scaled}

    def _make(self, file: EventFile) -> ScaledDetector:
        made = make_scaled(
            self.method,
            width=file.width,
            height=file.height,
            to_sensor=self.scale_to_sensor,
            time_scale=self.time_scale,
        )
        if isinstance(made.detector, FrameDetector) and not file.has_frames:
            raise ScenarioError(
                f"--method {self.method} looks at frames, and {file.path} holds none; choose "
                "another method, such as fly"
            )
        return made

    def _size(self) -> tuple[int, int] | None:
        if self.size is None:
            return None
        sides = _SIZE.fullmatch(self.size.strip())
        if sides is None:
            raise ScenarioError(
                f"--size is {self.size!r}; allowed is width and height in pixels; write it as "
                "--size 346x260"
            )
        return int(sides[1]), int(sides[2])

    def _check_outputs(self, source: Path) -> None:
        for path, option, suffix in ((self.rrd, "--rrd", ".rrd"), (self.plot, "--plot", ".png")):
            if path is None:
                continue
            if path.suffix.lower() != suffix:
                raise ScenarioError(
                    f"{option} is {path}; allowed is a name that ends in {suffix}; add it"
                )
            check_place(path, option)
            if path.absolute() == source.absolute():
                raise ScenarioError(f"{option} is the recording itself; choose another name")

    def _tell_outputs(self) -> None:
        to = Console(stderr=True) if self.json else Console()
        if self.plot:
            to.print(f"wrote {self.plot}", soft_wrap=True, markup=False)
        if self.rrd:
            how = view_command(self.rrd)
            to.print(f"wrote {self.rrd}   open it with: {how}", soft_wrap=True, markup=False)


def _log(recorder: FileRecorder, method: str, look: Look) -> None:
    recorder.log_events(look.events)
    for frame in look.frames:
        recorder.log_aps(frame)
    for estimate in look.estimates:
        recorder.log_estimate(method, estimate, look.maps)


def _check_events(path: Path) -> None:
    if path.is_file() and is_recording(path):
        raise ScenarioError(
            f"{path} is a Rerun recording, made to be looked at; allowed is a file of events; open "
            f"it with: flybench view {path}"
        )


def _check_something(file: EventFile) -> None:
    if not file.found.events and not file.found.frames:
        raise ScenarioError(
            f"{file.path} holds no event and no frame, so that there is nothing to detect; record "
            "it again, or give another file"
        )


if __name__ == "__main__":
    script(Detect)
