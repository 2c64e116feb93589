"""A picture of a recording, taken by a Rerun viewer that needs no display."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from rerun.experimental import ViewerClient

from scenarios.errors import ScenarioError
from scenarios.recording.entities import TIMELINE

HOST = "127.0.0.1"
PATIENCE_S = 60.0
"""How long the viewer may take to start, or to load (assumed: far more than it needs)."""
POLL_S = 0.1
GREETING_PICTURES = 8
"""The viewer shows its port in front of all else until it has painted so often (measured: 5
pictures at most); sleeping does not help, since its clock stands still meanwhile."""

_PANELS_AWAY = (
    "ui.toggle_top_panel",
    "ui.expand_blueprint_panel",
    "ui.toggle_blueprint_panel",
)
"""Leave the views alone in the picture; the left panel is open in some recordings only."""

NO_VIEWER = (
    "the Rerun viewer does not run here, probably for want of a Vulkan driver; flybench doctor "
    "tells what is missing"
)


class ScreenshotError(ScenarioError):
    """The viewer does not run here, or cannot show the recording."""


def screenshot(
    recording: Path,
    png: Path,
    *,
    at_s: float | None = None,
    size_px: tuple[int, int] = (1920, 1080),
) -> None:
    """Write a picture of what the viewer shows at a time.

    Args:
        recording: an .rrd file.
        png: where to; one that exists is replaced.
        at_s: time since the start of the sequence [s]; None: half way.
        size_px: width and height of the viewer [px].

    Raises:
        ScreenshotError: there is no such recording or no folder for the picture, `at_s` is outside
            of the recording, or no viewer runs here.
    """
    if not recording.is_file():
        raise ScreenshotError(
            f"the recording {recording} is no file; allowed is an .rrd file; make one with "
            "flybench run"
        )
    if not png.absolute().parent.is_dir():
        raise ScreenshotError(
            f"the picture {png} is to be in a folder that is not there; allowed is one that is; "
            "make it first"
        )
    with _viewer(size_px) as viewer:
        viewer.open(str(recording.absolute()))
        start_ns, end_ns = _time_range(viewer, recording)
        at_ns = (start_ns + end_ns) / 2 if at_s is None else at_s * 1e9
        if not start_ns <= at_ns <= end_ns:
            raise ScreenshotError(
                f"the time is {at_s} s; allowed is {start_ns * 1e-9:g} to {end_ns * 1e-9:g} s in "
                f"{recording}; choose another or leave it out"
            )
        viewer.set_time(TIMELINE, duration=np.timedelta64(round(at_ns), "ns"), play_state="paused")
        for command in _PANELS_AWAY:
            viewer.run_command(command)
        png.write_bytes(_settled_picture(viewer))


def _settled_picture(viewer: ViewerClient) -> bytes:
    """A PNG, taken when the greeting is gone and the images are decoded."""
    pictures = [viewer.take_screenshot() for _ in range(GREETING_PICTURES)]
    deadline = time.monotonic() + PATIENCE_S
    while pictures[-1] != pictures[-2] and time.monotonic() < deadline:
        time.sleep(POLL_S)
        pictures.append(viewer.take_screenshot())
    return pictures[-1]


@contextmanager
def _viewer(size_px: tuple[int, int]) -> Iterator[ViewerClient]:
    """A viewer without a window, which ends with the block.

    It is started as a command, since the library's own way to start one listens to the network.
    """
    port = _free_port()
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "rerun_cli", "--headless", "--hide-welcome-screen"),
            *("--bind", HOST, "--port", str(port), "--window-size", "{}x{}".format(*size_px)),
        ],
        # Fewer messages, since the viewer shows them in front of what is to be seen.
        env={**os.environ, "RERUN_APP_ONLY": "true", "RUST_LOG": "error"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        _wait_for(process, port)
        yield ViewerClient.connect(f"rerun+http://{HOST}:{port}/proxy")
    except ConnectionError as error:
        raise ScreenshotError(NO_VIEWER) from error
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGTERM)
        process.wait()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


def _wait_for(process: subprocess.Popen[bytes], port: int) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while process.poll() is None and time.monotonic() < deadline:
        try:
            socket.create_connection((HOST, port), timeout=1.0).close()
        except OSError:
            time.sleep(POLL_S)
        else:
            return
    raise ScreenshotError(NO_VIEWER)


def _time_range(viewer: ViewerClient, recording: Path) -> tuple[int, int]:
    """First and last time on the time line [ns], once all is loaded."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        state = viewer.get_state()
        for timeline in (t for r in state.recordings for t in r.timelines):
            if timeline.name != TIMELINE or state.loading:
                continue
            if timeline.start is not None and timeline.end is not None:
                return timeline.start, timeline.end
        time.sleep(POLL_S)
    raise ScreenshotError(
        f"the viewer found no time line {TIMELINE!r} in {recording}; allowed is a recording that "
        "flybench run wrote, whole; run it again"
    )
