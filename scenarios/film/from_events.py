"""What a film shows of a recording of events: a detector runs on it, and truth is read if known."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

from flybench.direction import Direction
from formats import EventFile
from scenarios.detect.run_detector import run_detector
from scenarios.errors import ScenarioError
from scenarios.film.material import Box, Estimates, Material, Part, Truth
from scenarios.film.track import Track
from scenarios.output.atomic_folder import TRUTH
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.user_detectors import find_method


def events_material(
    open_file: Callable[[], EventFile],
    method: str,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
) -> Material:
    """Run a detector on a recording, and return what a film shows of it.

    Args:
        open_file: function that opens the recording.
        method: name of the detector.
        progress: function that is called with the share of the file that is read, of 100.

    Raises:
        FormatError: the file cannot be read.
        MethodError: there is no such method, or it failed.
        ScenarioError: the file contains no events.
    """
    estimates = Estimates(method)
    with open_file() as file:
        size = {"width": file.width, "height": file.height}
        feed = DetectorFeed(method, find_method(method).make(**size), **size)
        for part in run_detector(file, feed):
            for estimate in part.estimates:
                estimates.hs.add(estimate.t_us, estimate.hs)
                estimates.vs.add(estimate.t_us, estimate.vs)
                is_none = estimate.direction is Direction.NONE
                estimates.direction.add(estimate.t_us, "" if is_none else estimate.direction)
                estimates.region.add(estimate.t_us, estimate.roi_px)
            progress(round(100 * (file.read_share or 0.0)), 100)
        feed.raise_failure()
        found = file.statistics
        if not found.events:
            raise ScenarioError(f"{file.path} contains no events. Give another recording.")
        return Material(
            name=file.path.name,
            width=file.width,
            height=file.height,
            from_us=found.first_us,
            to_us=found.last_us,
            estimates=estimates,
            truth=read_truth(file.path.with_name(TRUTH)),
            read=lambda: _parts(open_file),
        )


def read_truth(path: Path) -> Truth | None:
    """Return the ground truth beside the events of a run; None if there is none."""
    if not path.is_file():
        return None
    direction: Track[str] = Track()
    box: Track[Box | None] = Track()
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            sides = [row[f"box_{side}_px"] for side in ("x0", "y0", "x1", "y1")]
            x0, y0, x1, y1 = (int(side) if side else 0 for side in sides)
            direction.add(int(row["t_us"]), row["direction"] if all(sides) else "")
            box.add(int(row["t_us"]), (x0, y0, x1, y1) if all(sides) else None)
    return Truth(direction, box)


def _parts(open_file: Callable[[], EventFile]) -> Iterator[Part]:
    with open_file() as file:
        for chunk in file:
            yield chunk.events, tuple((frame.end_us, frame.image) for frame in chunk.frames)
