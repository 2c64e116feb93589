"""Buffer of values that change over time; it writes one column per entity."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr

from scenarios.recording.entities import TIMELINE
from sim.truth.body_meshes import BodyPose

Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open [px]."""
Point = tuple[float, float]


def time_column(t_us: npt.ArrayLike) -> rr.TimeColumn:
    """Return times in µs as the index of the recording."""
    return rr.TimeColumn(TIMELINE, duration=np.asarray(t_us, np.int64).astype("timedelta64[us]"))


class ColumnBuffer:
    """Rows by entity, until they are sent; a row takes about a hundred bytes.

    Attributes:
        rows: number of rows in the buffer.
    """

    def __init__(self) -> None:
        self._last_states: dict[str, str] = {}
        self._clear()

    def _clear(self) -> None:
        self.rows = 0
        self._times: defaultdict[str, list[int]] = defaultdict(list)
        self._scalars: defaultdict[str, list[float]] = defaultdict(list)
        self._boxes: defaultdict[str, list[Box | None]] = defaultdict(list)
        self._points: defaultdict[str, list[Point | None]] = defaultdict(list)
        self._states: defaultdict[str, list[str]] = defaultdict(list)
        self._poses: defaultdict[str, list[BodyPose]] = defaultdict(list)

    def scalar(self, path: str, t_us: int, value: float) -> None:
        """Add one value to a curve."""
        self.rows += 1
        self._times[path].append(t_us)
        self._scalars[path].append(value)

    def curve(
        self, path: str, t_us: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
    ) -> None:
        """Add many values to a curve."""
        self.rows += values.size
        self._times[path].extend(t_us.tolist())
        self._scalars[path].extend(values.tolist())

    def box(self, path: str, t_us: int, box: Box | None) -> None:
        """Show a box from this time on; None: show none."""
        self.rows += 1
        self._times[path].append(t_us)
        self._boxes[path].append(box)

    def point(self, path: str, t_us: int, point: Point | None) -> None:
        """Show a point from this time on; None: show none."""
        self.rows += 1
        self._times[path].append(t_us)
        self._points[path].append(point)

    def state(self, path: str, t_us: int, state: str) -> None:
        """Enter a state; "" means none. A state that does not change adds no row."""
        if self._last_states.get(path) != state:
            self._last_states[path] = state
            self.rows += 1
            self._times[path].append(t_us)
            self._states[path].append(state)

    def pose(self, path: str, t_us: int, pose: BodyPose) -> None:
        """Set the pose of a body from this time on."""
        self.rows += 1
        self._times[path].append(t_us)
        self._poses[path].append(pose)

    def send(self, stream: rr.RecordingStream) -> None:
        """Write all rows to the stream, and empty the buffer."""
        for path, values in self._scalars.items():
            self._send(stream, path, rr.Scalars.columns(scalars=values))
        for path, boxes in self._boxes.items():
            self._send(stream, path, _box_columns(boxes))
        for path, points in self._points.items():
            present, lengths = _present(points)
            positions = np.array(present, np.float32).reshape(-1, 2)
            columns = rr.Points2D.columns(positions=positions).partition(lengths)
            self._send(stream, path, columns)
        for path, states in self._states.items():
            self._send(stream, path, rr.StateChange.columns(state=states))
        for path, poses in self._poses.items():
            columns = rr.Transform3D.columns(
                translation=[pose.position_m for pose in poses],
                mat3x3=[pose.rotation for pose in poses],
            )
            self._send(stream, path, columns)
        self._clear()

    def _send(
        self, stream: rr.RecordingStream, path: str, columns: Iterable[rr.ComponentColumn]
    ) -> None:
        stream.send_columns(path, [time_column(self._times[path])], columns, strict=True)


def _box_columns(boxes: Sequence[Box | None]) -> rr.ComponentColumnList:
    present, lengths = _present(boxes)
    corners = np.array(present, np.float32).reshape(-1, 2, 2)
    return rr.Boxes2D.columns(
        centers=corners.mean(axis=1), half_sizes=(corners[:, 1] - corners[:, 0]) / 2
    ).partition(lengths)


def _present(rows: Sequence[tuple[float, ...] | None]) -> tuple[list[tuple[float, ...]], list[int]]:
    """Return the values that are not None, and the number of values in each row, 1 or 0."""
    return [row for row in rows if row is not None], [row is not None for row in rows]
