"""A finished run for Python and notebooks: its results, its events, and how it displays itself."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import Events
from flybench.files import read_small_text
from flybench.printable import html_table
from formats import read_events
from scenarios.errors import ScenarioError
from scenarios.output.atomic_folder import ESTIMATES, EVENTS, GENERATOR, RECORDING, SUMMARY, TRUTH
from scenarios.runs.run_picture import response_svg
from scenarios.runs.run_table import run_rows

VIEWER_PX = (1000, 640)
"""Width and height of the viewer in a notebook [px]."""
_LOAD_S = 60.0
"""Longest time to read the recording for the viewer [s] (assumed: far more than it needs)."""


@dataclass(frozen=True, eq=False)
class RunFolder:
    """A finished run; as the last line of a notebook's cell it displays its results.

    Attributes:
        folder: folder that `flybench run` wrote.
        summary: contents of its `summary.json`.
    """

    folder: Path
    summary: dict[str, Any]

    @property
    def method(self) -> str:
        """Name of the detector."""
        return str(self.summary["detector"]["method"])

    @property
    def estimates(self) -> npt.NDArray[Any]:
        """(n,) structured array of the estimates: `t_us`, `hs`, `vs`, `direction` and more.

        Raises:
            ScenarioError: the table is missing or damaged.
        """
        return _table(self.folder / ESTIMATES)

    @property
    def truth(self) -> npt.NDArray[Any]:
        """(n,) structured array of the ground truth: `t_us`, `direction` and more.

        Raises:
            ScenarioError: the table is missing or damaged.
        """
        return _table(self.folder / TRUTH)

    def events(self) -> Events:
        """Return all events.

        Raises:
            FormatError: the file is missing or damaged.
            MemoryBudgetError: they do not fit into the memory budget.
        """
        return read_events(self.folder / EVENTS)

    def show(self, *, width_px: int = VIEWER_PX[0], height_px: int = VIEWER_PX[1]) -> None:
        """Display the recording in Rerun's viewer inside a notebook.

        Args:
            width_px: width of the viewer [px].
            height_px: height of the viewer [px].

        Raises:
            ScenarioError: the run has no recording, or Rerun's notebook viewer is not installed.
        """
        recording = self.folder / RECORDING
        if not recording.is_file():
            raise ScenarioError(
                f"{self.folder} has no {RECORDING}. Allowed is a run with a recording. Run it "
                "again."
            )
        if not has_notebook_viewer():
            raise ScenarioError(
                "Rerun's notebook viewer is not installed. Install it with `pip install "
                "rerun-notebook`, or open the recording with `flybench view`."
            )
        notebook_viewer(recording, width_px, height_px).display()

    def _repr_html_(self) -> str:
        rows = {name: text for name, text in run_rows(self.summary).items() if name}
        try:
            picture = response_svg(self.folder.name, self.method, self.summary, self.estimates)
        except ScenarioError:  # the run of a detector that failed at once has no estimates
            picture = ""
        table = html_table(f"flybench run {self.folder.name}", rows)
        return (
            '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start">'
            f"{table}{picture}</div>"
        )


def open_run(folder: Path | str) -> RunFolder:
    """Open the folder of a finished run.

    Args:
        folder: folder that `flybench run` or `flybench demo` wrote.

    Raises:
        ScenarioError: it is not the folder of a run.
    """
    path = Path(folder)
    try:
        summary = json.loads(read_small_text(path / SUMMARY))
        is_run = summary["generator"] == GENERATOR and "truth" in summary and "detector" in summary
    except (OSError, ValueError, RecursionError, TypeError, KeyError):
        is_run = False
    if not is_run:
        raise ScenarioError(
            f"{path} is not the folder of a run. Allowed is a folder with a {SUMMARY} of `flybench "
            "run`. Make one with `flybench run --out DIR`."
        )
    return RunFolder(path, summary)


def has_notebook_viewer() -> bool:
    """Return True if Rerun's notebook viewer is installed."""
    return importlib.util.find_spec("rerun_notebook") is not None


def notebook_viewer(recording: Path, width_px: int, height_px: int) -> Any:
    """Return Rerun's widget with a recording, for the output of a notebook's cell."""
    import rerun as rr
    from rerun.notebook import Viewer

    stream = rr.RecordingStream(GENERATOR)
    viewer = Viewer(width=width_px, height=height_px, recording=stream)
    stream.log_file_from_path(recording)
    stream.flush(timeout_sec=_LOAD_S)
    return viewer


def _table(path: Path) -> npt.NDArray[Any]:
    try:
        found = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ScenarioError(
            f"{path} cannot be read ({error}). Allowed is a table of a finished run. Run it again."
        ) from error
    return np.atleast_1d(found)
