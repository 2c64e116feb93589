"""`flybench view`: open a run or a study, in a window, in the browser, or as a picture."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import rerun_cli
import tyro

from scenarios.errors import ScenarioError
from scenarios.output.folder import RECORDING
from scenarios.output.terminal import has_display, script
from scenarios.recording.screenshot import screenshot

MAGIC = b"RRF2"
RECORDINGS, SUFFIX = "recordings", ".rrd"
"""A study's folder in which its recordings lie, and how their names end."""


@dataclass(frozen=True)
class View:
    """Open a recording, or all of a study, in the Rerun viewer."""

    path: Annotated[Path, tyro.conf.Positional]
    """A run's or a study's folder, or a recording (.rrd)."""
    recording: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None
    """One of a study's recordings, such as day_1.61; all where not given."""
    web: bool = False
    """Serve it on 127.0.0.1 for a browser, instead of opening a window."""
    screenshot: Annotated[Path | None, tyro.conf.arg(metavar="PNG")] = None
    """Write a picture of the viewer instead, of a study's first recording; needs no display."""
    at_s: float | None = None
    """Time that the screenshot shows [s]; the middle of the crossing where not given."""

    def execute(self) -> int:
        """Open it; returns the viewer's exit status."""
        if self.screenshot is not None and self.screenshot.suffix.lower() != ".png":
            raise ScenarioError(
                f"--screenshot is {self.screenshot}; allowed is a name that ends in .png; add it"
            )
        recordings = find_recordings(self.path, self.recording)
        if self.screenshot is not None:
            screenshot(recordings[0], self.screenshot, at_s=self.at_s)
            print(f"wrote {self.screenshot}, of {recordings[0]}")
            return 0
        if not self.web and not has_display():
            raise ScenarioError(
                "there is no display to open a window on; use --web to serve the recording to a "
                "browser, or --screenshot FILE.png for a picture"
            )
        command = [viewer_program(), *map(str, recordings), "--bind", "127.0.0.1"]
        return subprocess.call(command + (["--serve-web"] if self.web else []))


def find_recordings(path: Path, name: str | None = None) -> list[Path]:
    """The recording at `path`, that in the folder `path` of a run, or those of a study.

    Args:
        path: a file or a folder.
        name: of one of a study's; None: all, in the order of their names.

    Raises:
        ScenarioError: there is none, or none of that name.
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
            f"there is no recording at {path}; allowed is a folder that flybench run or flybench "
            f"study wrote, or an {SUFFIX} file; make one with: flybench run"
        )
    return [recording]


def viewer_program() -> str:
    """Rerun's viewer itself; started through Python it would outlive an end of this command."""
    return str(Path(rerun_cli.__file__).with_name("rerun"))


def _named(found: list[Path], name: str, study: Path) -> Path:
    names = [file.stem for file in found]
    if name not in names:
        allowed = ", ".join(names) or "none, since no study's recordings are there"
        raise ScenarioError(
            f"--recording is {name}; allowed in {study} is {allowed}; choose one, or leave it out"
        )
    return found[names.index(name)]


def is_recording(path: Path) -> bool:
    """Whether a file begins as Rerun's files do."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


if __name__ == "__main__":
    script(View)
