"""Take a screenshot of a recording with a Rerun viewer that needs no display."""

from __future__ import annotations

import os
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from rerun.experimental import ViewerClient

from scenarios.errors import ScenarioError
from scenarios.recording.entities import TIMELINE
from scenarios.recording.viewer_process import HOST, end_with_parent, free_port, viewer_program

TIMEOUT_S = 60.0
"""Longest time for the viewer to start or to load (assumed: far more than it needs)."""
POLL_S = 0.1
DISCARDED_SCREENSHOTS = 8
"""The viewer shows a message with its port until it has drawn a few frames (measured: at most 5).
Waiting does not help, because its clock only advances when it draws."""

_HIDE_PANELS = (
    "ui.toggle_top_panel",
    "ui.expand_blueprint_panel",
    "ui.toggle_blueprint_panel",
)
"""Commands that hide all panels; the left panel is open in some recordings only."""

NO_VIEWER = (
    "The Rerun viewer does not run on this machine, probably because it has no Vulkan driver. "
    "`flybench doctor` shows what is missing."
)


class ScreenshotError(ScenarioError):
    """The viewer does not run on this machine, or cannot show the recording."""


def screenshot(
    recording: Path,
    png: Path,
    *,
    at_s: float | None = None,
    size_px: tuple[int, int] = (1920, 1080),
) -> None:
    """Write a screenshot of a recording at a given time.

    Args:
        recording: path of an .rrd file.
        png: path of the image; an existing file is replaced.
        at_s: time since the start of the sequence [s]; None: half of the duration.
        size_px: width and height of the viewer [px].

    Raises:
        ScreenshotError: the recording or the folder of the image does not exist, `at_s` is outside
            the recording, or the viewer does not run on this machine.
    """
    if not recording.is_file():
        raise ScreenshotError(
            f"The recording {recording} is not a file. Allowed is an .rrd file. Create one with "
            "flybench run."
        )
    if not png.absolute().parent.is_dir():
        raise ScreenshotError(
            f"The folder of the screenshot {png} does not exist. Allowed is an existing folder. "
            "Create it first."
        )
    with _viewer(size_px) as viewer:
        viewer.open(str(recording.absolute()))
        start_ns, end_ns = _time_range(viewer, recording)
        at_ns = (start_ns + end_ns) / 2 if at_s is None else at_s * 1e9
        if not start_ns <= at_ns <= end_ns:
            raise ScreenshotError(
                f"The time is {at_s} s. Allowed is {start_ns * 1e-9:g} to {end_ns * 1e-9:g} s in "
                f"{recording}. Choose another time, or leave it out."
            )
        viewer.set_time(TIMELINE, duration=np.timedelta64(round(at_ns), "ns"), play_state="paused")
        for command in _HIDE_PANELS:
            viewer.run_command(command)
        png.write_bytes(_stable_screenshot(viewer))


def _stable_screenshot(viewer: ViewerClient) -> bytes:
    """Return a PNG taken after the first message is gone and all images are decoded."""
    images = [viewer.take_screenshot() for _ in range(DISCARDED_SCREENSHOTS)]
    deadline = time.monotonic() + TIMEOUT_S
    while images[-1] != images[-2] and time.monotonic() < deadline:
        time.sleep(POLL_S)
        images.append(viewer.take_screenshot())
    return images[-1]


@contextmanager
def _viewer(size_px: tuple[int, int]) -> Iterator[ViewerClient]:
    """Start a viewer without a window, and stop it at the end of the block.

    It is started as a command, because the library's own function listens on the network.
    """
    port = free_port()
    process = subprocess.Popen(
        [
            *(viewer_program(), "--headless", "--hide-welcome-screen"),
            *("--bind", HOST, "--port", str(port), "--window-size", "{}x{}".format(*size_px)),
        ],
        # The viewer shows log messages in front of the views, so only errors are logged.
        env={**os.environ, "RERUN_APP_ONLY": "true", "RUST_LOG": "error"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=end_with_parent(),
    )
    try:
        _wait_for_port(process, port)
        yield ViewerClient.connect(f"rerun+http://{HOST}:{port}/proxy")
    except ConnectionError as error:
        raise ScreenshotError(NO_VIEWER) from error
    except TimeoutError as error:
        raise ScreenshotError(
            "The Rerun viewer did not answer in time. Other programs may keep the machine busy. "
            "Try again."
        ) from error
    finally:
        process.terminate()
        process.wait()


def _wait_for_port(process: subprocess.Popen[bytes], port: int) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while process.poll() is None and time.monotonic() < deadline:
        try:
            socket.create_connection((HOST, port), timeout=1.0).close()
        except OSError:
            time.sleep(POLL_S)
        else:
            return
    raise ScreenshotError(NO_VIEWER)


def _time_range(viewer: ViewerClient, recording: Path) -> tuple[int, int]:
    """Wait until the recording is loaded, and return its first and last time [ns]."""
    deadline = time.monotonic() + TIMEOUT_S
    while time.monotonic() < deadline:
        state = viewer.get_state()
        for timeline in (t for r in state.recordings for t in r.timelines):
            if timeline.name != TIMELINE or state.loading:
                continue
            if timeline.start is not None and timeline.end is not None:
                return timeline.start, timeline.end
        time.sleep(POLL_S)
    raise ScreenshotError(
        f"The viewer found no time line {TIMELINE!r} in {recording}. Allowed is a complete "
        "recording of flybench. Run the command again."
    )
