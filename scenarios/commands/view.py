"""`flybench view`: show recordings in a window or a browser, or save a picture of them."""

from __future__ import annotations

import os
import socket
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated
from urllib.parse import quote

import tyro

from flybench.checks import Range
from scenarios.errors import ScenarioError
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.atomic_folder import RECORDING
from scenarios.output.streams import complain, own_output, say
from scenarios.output.terminal import has_display, run_cli
from scenarios.recording.screenshot import screenshot
from scenarios.recording.viewer_process import (
    HOST,
    end_with_parent,
    free_port,
    is_free,
    viewer_program,
)

MAGIC = b"RRF2"
RECORDINGS, SUFFIX = "recordings", ".rrd"
"""Folder of the recordings in that of a study, and the ending of their names."""
WEB_PORT, DATA_PORT = 9090, 9876
"""Ports that the viewer prefers for its page and its data, as Rerun does."""
_PORT = Range(1, 65535)


@dataclass(frozen=True)
class View:
    """Open recordings of runs or of a study in the Rerun viewer."""

    path: Annotated[Path, tyro.conf.Positional]
    """Folder of a run or a study, or a recording (.rrd)."""
    recording: Annotated[
        str | None, tyro.conf.arg(metavar="NAME", help_behavior_hint="(default: all)")
    ] = None
    """Open only this recording of a study, such as day_1.61."""
    web: bool = False
    """Serve the viewer to a browser at 127.0.0.1 instead of opening a window."""
    port: Annotated[
        int | None,
        tyro.conf.arg(
            metavar="N",
            help_behavior_hint=f"(default: {WEB_PORT}, or a free one if that is in use)",
        ),
    ] = None
    """Port of the page that --web serves, 1 to 65535; its data have a second port, 9876 if free."""
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
            check_output_file(
                self.screenshot, "--screenshot", overwrite=self.overwrite, sources=recordings
            )
            with atomic_file(self.screenshot, overwrite=self.overwrite) as png:
                screenshot(recordings[0], png, at_s=self.at_s)
            say(f"wrote {self.screenshot}, a picture of {recordings[0]}")
            return 0
        if not self.web and not has_display():
            raise ScenarioError(
                "There is no display for a window. Use --web to serve the viewer to a browser, or "
                "--screenshot FILE.png for a picture."
            )
        page, data = self._ports()
        command = [viewer_program(), *map(str, recordings), "--bind", HOST, "--port", str(data)]
        if page is not None:
            command += ["--serve-web", "--web-viewer-port", str(page)]
            say(web_message(page, data))
            own_output().flush()
        quiet = {**os.environ, "RUST_LOG": os.environ.get("RUST_LOG", "error")}
        status = subprocess.call(command, env=quiet, preexec_fn=end_with_parent())
        if status > 0:
            complain(f"The viewer ended with status {status}. Its own message is above.")
        return status

    def _ports(self) -> tuple[int | None, int]:
        """Return the ports of the page and of the data; a window has no page."""
        if not self.web:
            if self.port is not None:
                raise ScenarioError(
                    f"--port is {self.port} without --web. Allowed is --port with --web only, "
                    "because a window has no port. Add --web, or leave --port out."
                )
            return None, free_port(DATA_PORT)
        if self.port is not None:
            _PORT.check("--port", self.port, ScenarioError)
            if not is_free(self.port):
                raise ScenarioError(
                    f"--port is {self.port}, which is in use, perhaps by another viewer. Allowed "
                    "is a free port. Choose another, or leave --port out for any free one."
                )
        page = self.port or free_port(WEB_PORT)
        return page, free_port(DATA_PORT, reserved=page)


def web_message(page: int, data: int) -> str:
    """Return what to open in a browser, here and on another machine.

    Args:
        page: port of the page.
        data: port from which the page loads the recording; it must have the same number on both
            machines, because it is part of the address.
    """
    address = f"http://{HOST}:{page}?url={quote(f'rerun+http://{HOST}:{data}/proxy', safe='')}"
    tunnel = f"ssh -L {page}:{HOST}:{page} -L {data}:{HOST}:{data} {socket.gethostname()}"
    return (
        f"Open {address} in a browser.\nFrom another machine, first run there: {tunnel}\n"
        "End with Ctrl-C."
    )


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
    if not is_recording(recording):
        raise ScenarioError(
            f"There is no recording at {path}. Allowed is a folder that flybench run or flybench "
            f"study wrote, or an {SUFFIX} file. Make one with: flybench run"
        )
    return [recording]


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
    if not path.is_file():  # opening a FIFO would block
        return False
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


if __name__ == "__main__":
    run_cli(View)
