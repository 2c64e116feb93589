"""What a film shows of a Rerun recording: a run, a sequence of a study, or `detect --rrd`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from flybench.events import EVENT_DTYPE, Events
from scenarios.errors import ScenarioError
from scenarios.film.material import Box, Estimates, Material, Part, Picture, Truth
from scenarios.film.rerun_tables import RerunTables
from scenarios.recording import entities as at

_STATE, _SCALAR = "StateChange:state", "Scalars:scalars"
_BOX = "Boxes2D:centers", "Boxes2D:half_sizes"
_EVENTS = "Points2D:positions", "Points2D:class_ids"
_IMAGE = "Image:buffer", "Image:format"


def rerun_material(path: Path, method: str | None = None) -> Material:
    """Return what a film shows of a recording.

    Args:
        path: the recording.
        method: method whose estimates are shown; None: the first one, if there is one.

    Raises:
        ScenarioError: the file is damaged, contains no events or no size of the sensor, or has no
            estimates of the method.
        MemoryBudgetError: its events need more memory than the budget allows.
    """
    tables = RerunTables(path)
    width, height = _size(tables)
    parts = list(_parts(tables))
    ends = [int(t) for events, _ in parts for t in events["t"][[0, -1]]]
    if not ends:
        raise ScenarioError(f"{path} contains no events. Give another recording.")
    truth = None
    if "0_truth" in tables.entities(at.DIRECTION):
        direction = tables.track(at.TRUE_DIRECTION, _word, _STATE)
        truth = Truth(direction, tables.track(at.TRUTH_BOX, _box, *_BOX))
    return Material(
        name=_first(tables.properties.get("RecordingInfo:name"), path.stem),
        width=width,
        height=height,
        from_us=min(ends),
        to_us=max(ends),
        estimates=_estimates(tables, method),
        truth=truth,
        read=lambda: iter(parts),
    )


def _size(tables: RerunTables) -> tuple[int, int]:
    resolution = _first(tables.properties.get("Pinhole:resolution"), None)
    width, height = resolution or (
        _first(tables.properties.get(name), None) for name in ("width", "height")
    )
    if width is None or height is None:
        raise ScenarioError(
            f"{tables.path} does not state the size of the sensor. Allowed is a recording of "
            "flybench run, study or detect --rrd. Give another one."
        )
    return int(width), int(height)


def _estimates(tables: RerunTables, method: str | None) -> Estimates:
    lanes = [name.split("_", 1) for name in tables.entities(at.DIRECTION)]
    numbers = {lane: int(number) for number, lane in lanes if number != "0"}
    curves = {name.replace("\\", "") for name in tables.entities(at.HS)}
    names = sorted(curves, key=lambda name: numbers.get(at.lane_name(name), len(curves)))
    if method is None and not names:
        return Estimates()
    if method is not None and method not in names:
        raise ScenarioError(
            f"--method is {method}. Allowed in {tables.path} is "
            f"{', '.join(names) or 'none, because it has no estimates'}. Choose one of them, or "
            "leave --method out."
        )
    chosen = method or names[0]
    paths = at.paths_of(chosen, numbers.get(at.lane_name(chosen), 1) - 1)
    return Estimates(
        method=chosen,
        hs=tables.track(paths.hs, _number, _SCALAR),
        vs=tables.track(paths.vs, _number, _SCALAR),
        direction=tables.track(paths.direction, _word, _STATE),
        region=tables.track(paths.roi, _box, *_BOX),
    )


def _parts(tables: RerunTables) -> Iterator[Part]:
    """Yield the events, with the frames that ended before the last one of them."""
    frames = _frames(tables)
    for t_us, (positions, classes) in tables.columns(at.EVENTS, *_EVENTS):
        ids = classes.flatten().to_numpy()
        places = positions.flatten().flatten().to_numpy().reshape(-1, 2)
        events: Events = np.empty(ids.size, EVENT_DTYPE)
        events["t"] = np.repeat(t_us, classes.value_lengths().to_numpy())
        events["x"], events["y"], events["p"] = places[:, 0], places[:, 1], ids % 2
        due = sum(end_us <= t_us[-1] for end_us, _ in frames)
        yield events, tuple(frames[:due])
        frames = frames[due:]


def _frames(tables: RerunTables) -> list[Picture]:
    found = tables.track(at.APS, _image, *_IMAGE)
    return list(zip(found.t_us, found.values, strict=True))


def _image(buffer: Any, formats: Any) -> npt.NDArray[Any]:
    size = formats[0]["height"], formats[0]["width"]
    content = np.asarray(buffer[0], np.uint8)
    depth = np.uint16 if content.size == 2 * size[0] * size[1] else np.uint8
    return content.view(depth).reshape(size)


def _word(cell: list[str] | None) -> str:
    return cell[0] if cell else ""


def _number(cell: list[float] | None) -> float:
    return float(cell[0]) if cell else 0.0


def _box(centers: Any, half_sizes: Any) -> Box | None:
    if not centers:
        return None
    (x, y), (dx, dy) = centers[0], half_sizes[0]
    return round(x - dx), round(y - dy), round(x + dx), round(y + dy)


def _first(cell: Any, otherwise: Any) -> Any:
    return cell[0] if cell else otherwise
