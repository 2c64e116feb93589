"""`flybench view`: open a run's recording, in a window, in the browser, or as a picture."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import rerun_cli
import tyro

from scenarios.errors import ScenarioError
from scenarios.output import RECORDING
from scenarios.recording.screenshot import screenshot
from scenarios.terminal import has_display, script

MAGIC = b"RRF2"


@dataclass(frozen=True)
class View:
    """Open a recording in the Rerun viewer."""

    path: Annotated[Path, tyro.conf.Positional]
    """A run's folder, or a recording (.rrd)."""
    web: bool = False
    """Serve it on 127.0.0.1 for a browser, instead of opening a window."""
    screenshot: Annotated[Path | None, tyro.conf.arg(metavar="PNG")] = None
    """Write a picture of the viewer instead; needs no display."""
    at_s: float | None = None
    """Time that the screenshot shows [s]; the middle of the crossing where not given."""

    def execute(self) -> int:
        """Open it; returns the viewer's exit status."""
        recording = find_recording(self.path)
        if self.screenshot is not None:
            screenshot(recording, self.screenshot, at_s=self.at_s)
            print(f"wrote {self.screenshot}")
            return 0
        if not self.web and not has_display():
            raise ScenarioError(
                "there is no display to open a window on; use --web to serve the recording to a "
                "browser, or --screenshot FILE.png for a picture"
            )
        command = [viewer_program(), str(recording), "--bind", "127.0.0.1"]
        return subprocess.call(command + (["--serve-web"] if self.web else []))


def find_recording(path: Path) -> Path:
    """The recording at `path`, or in the folder `path`.

    Raises:
        ScenarioError: there is none.
    """
    recording = path / RECORDING if path.is_dir() else path
    if not recording.is_file() or not _is_recording(recording):
        raise ScenarioError(
            f"there is no recording at {path}; allowed is a folder that flybench run wrote, or "
            "an .rrd file; make one with: flybench run"
        )
    return recording


def viewer_program() -> str:
    """Rerun's viewer itself; started through Python it would outlive an end of this command."""
    return str(Path(rerun_cli.__file__).with_name("rerun"))


def _is_recording(path: Path) -> bool:
    """Whether a file begins as Rerun's files do."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


if __name__ == "__main__":
    script(View)
