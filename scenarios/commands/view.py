"""`flybench view`: show recordings in a window or a browser, or save a picture of them."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import rerun_cli
import tyro

from scenarios.errors import ScenarioError
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.atomic_folder import RECORDING
from scenarios.output.terminal import has_display, run_cli
from scenarios.recording.screenshot import screenshot

MAGIC = b"RRF2"
RECORDINGS, SUFFIX = "recordings", ".rrd"
"""Folder of the recordings in that of a study, and the ending of their names."""


@dataclass(frozen=True)
class View:
    """Open the recording of a run, or all recordings of a study, in the Rerun viewer."""

    path: Annotated[Path, tyro.conf.Positional]
    """Folder of a run or a study, or a recording (.rrd)."""
    recording: Annotated[
        str | None, tyro.conf.arg(metavar="NAME", help_behavior_hint="(default: all)")
    ] = None
    """Open only this recording of a study, such as day_1.61."""
    web: bool = False
    """Serve the viewer to a browser at 127.0.0.1 instead of opening a window."""
    screenshot: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="PNG",
            help="Write a picture of the viewer to this file instead of opening a window; works "
            "without a display. For a study, it shows the first recording, or that of --recording.",
            help_behavior_hint="(default: no picture)",
        ),
    ] = None
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace an existing file of --screenshot."""
    at_s: Annotated[
        float | None,
        tyro.conf.arg(metavar="SECONDS", help_behavior_hint="(default: middle of the crossing)"),
    ] = None
    """Time in the recording that the picture shows [s]."""

    def execute(self) -> int:
        """Open the viewer or write the picture; the exit status is that of the viewer."""
        if self.screenshot is not None and self.screenshot.suffix.lower() != ".png":
            raise ScenarioError(
                f"--screenshot is {self.screenshot}. Allowed is a name that ends in .png. Add the "
                "ending."
            )
        recordings = find_recordings(self.path, self.recording)
        if self.screenshot is not None:
            check_output_file(self.screenshot, "--screenshot", overwrite=self.overwrite)
            with atomic_file(self.screenshot, overwrite=self.overwrite) as png:
                screenshot(recordings[0], png, at_s=self.at_s)
            print(f"wrote {self.screenshot}, a picture of {recordings[0]}")
            return 0
        if not self.web and not has_display():
            raise ScenarioError(
                "There is no display for a window. Use --web to serve the viewer to a browser, or "
                "--screenshot FILE.png for a picture."
            )
        command = [viewer_program(), *map(str, recordings), "--bind", "127.0.0.1"]
        return subprocess.call(command + (["--serve-web"] if self.web else []))


def find_recordings(path: Path, name: str | None = None) -> list[Path]:
    """Return the recordings to open.

    Args:
        path: a recording, or the folder of a run or a study.
        name: name of one recording of a study; None: all, sorted by name.

    Raises:
        ScenarioError: there is no recording, or none of that name.
    """
    study = path / RECORDINGS
    found = sorted(file for file in study.glob(f"*{SUFFIX}") if is_recording(file))
    if found and name is None:
        return found
    if name is not None:
        return [_named(found, name, study)]
    recording = path / RECORDING if path.is_dir() else path
    if not recording.is_file() or not is_recording(recording):
        raise ScenarioError(
            f"There is no recording at {path}. Allowed is a folder that flybench run or flybench "
            f"study wrote, or an {SUFFIX} file. Make one with: flybench run"
        )
    return [recording]


def viewer_program() -> str:
    """Return the path of the Rerun viewer.

    Its Python entry point would start it as another process, which would survive this command.
    """
    return str(Path(rerun_cli.__file__).with_name("rerun"))


def _named(found: list[Path], name: str, study: Path) -> Path:
    names = [file.stem for file in found]
    if name not in names:
        allowed = ", ".join(names) or "none, because this folder has no recordings of a study"
        raise ScenarioError(
            f"--recording is {name}. Allowed in {study} is {allowed}. Choose one of them, or leave "
            "--recording out."
        )
    return found[names.index(name)]


def is_recording(path: Path) -> bool:
    """Return True if a file begins like the files of Rerun."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


if __name__ == "__main__":
    run_cli(View)
