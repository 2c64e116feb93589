"""Base of all recordings: events, frames and estimates on one time line, as they arrive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Self

import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb

from detector.estimate import MotionEstimate
from detector.fly.detector import FlyMaps
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import Events
from flybench.printable import printable
from scenarios.errors import ScenarioError
from scenarios.pipeline.registry import gives_velocity
from scenarios.recording import entities as at
from scenarios.recording.column_buffer import ColumnBuffer, time_column
from scenarios.recording.event_batches import BATCH_US, EventBatches, EventBuffer
from scenarios.recording.piped_file import PipedFile
from scenarios.recording.static_content import log_parameters, log_static

APPLICATION = "flybench"
BRIGHTEST_SHARE = 0.995
"""Quantile of a map's values that gets the brightest colour; the few values above it share it."""
MAX_ROWS = 200_000
"""Rows of small values that are kept in memory before they are written (assumed: about 20 MB)."""
MAX_ZEROS_US = 10_000_000
"""Longest time without events that gets one row per millisecond in the event rate; longer ones get
one row at each end."""


class StreamRecorder:
    """One recording. Use it as a context manager, so that everything is written.

    It keeps at most `MAX_ROWS` rows in memory, however long the stream is.
    """

    def __init__(
        self,
        path: Path,
        *,
        view: rrb.Blueprint,
        name: str,
        parameters: Mapping[str, object],
        methods: Mapping[str, at.MethodPaths],
        start_us: int = 0,
        knows_noise: bool = True,
    ) -> None:
        """Create the file.

        Args:
            path: path of the .rrd file; an existing file is replaced.
            view: default layout in the viewer.
            name: name of the recording in the viewer.
            parameters: parameters by name; see `log_parameters`.
            methods: entity paths of each method, by name.
            start_us: time from which the event rate is shown [µs].
            knows_noise: True if the causes of events are known; noise then gets its own curve in
                the event rate.

        Raises:
            OSError: the file cannot be written.
        """
        self._methods = methods
        self._rates = (at.RATE_ON, at.RATE_OFF, at.RATE_NOISE)[: 3 if knows_noise else 2]
        self._events = EventBuffer()
        self._rate_from_us = start_us // BATCH_US * BATCH_US
        self._columns = ColumnBuffer()
        self._scaled: set[str] = set()
        self._brightest: dict[str, float] = {}
        self._file = PipedFile(path)
        self._stream = rr.RecordingStream(APPLICATION)
        self._stream.set_log_time_enabled(False)
        self._stream.set_log_tick_enabled(False)
        self._stream.save(self._file.entry, default_blueprint=view)
        self._file.opened()
        self._stream.send_recording_name(printable(name))
        log_parameters(self._stream, parameters)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self, end_us: int = 0) -> None:
        """Write everything that is still in memory, and close the file.

        Args:
            end_us: time until which the event rate is shown, if no event is later [µs].

        Raises:
            OSError: the file could not be written.
        """
        self._send_events(self._events.flush())
        self._log_no_events(end_us + BATCH_US)
        self._columns.send(self._stream)
        for path, brightest in self._brightest.items():
            scale = rr.DepthImage.from_fields(depth_range=[0.0, brightest or 1.0])
            log_static(self._stream, path, scale)
        self._stream.flush()
        self._stream.disconnect()
        self._file.close()

    def log_events(self, events: Events, causes: npt.NDArray[np.uint8] | None = None) -> None:
        """Add the next events of the stream.

        Args:
            events: (n,) of `EVENT_DTYPE`, sorted by t, none earlier than those logged before.
            causes: (n,) `Cause` of each event; None: all are signal.

        Raises:
            OSError: the file cannot be written.
        """
        self._file.check()
        self._send_events(self._events.push(events, causes))

    def log_aps(self, frame: ApsFrame) -> None:
        """Show an APS frame, in raw DN, from the end of its exposure on."""
        self._log(at.APS, frame.end_us, rr.Image(frame.image))

    def log_estimate(
        self, method: str, estimate: MotionEstimate, maps: FlyMaps | None = None
    ) -> None:
        """Show an estimate of a method.

        Args:
            method: name of one of the recording's methods.
            estimate: the estimate. Estimates of one method must be in order of time.
            maps: the fly's maps at this estimate; None: no maps.
        """
        t_us, columns, paths = estimate.t_us, self._columns, self._methods[method]
        columns.scalar(paths.hs, t_us, estimate.hs)
        columns.scalar(paths.vs, t_us, estimate.vs)
        is_none = estimate.direction is Direction.NONE
        columns.state(paths.direction, t_us, "" if is_none else estimate.direction)
        columns.box(paths.roi, t_us, estimate.roi_px)
        columns.point(paths.view_centre, t_us, estimate.view_centre_px)
        if gives_velocity(method):
            columns.scalar(paths.velocity_x, t_us, estimate.response[0])
            columns.scalar(paths.velocity_y, t_us, estimate.response[1])
        if maps is not None:
            self._log_maps(t_us, maps.cell_px, {paths.on: maps.on, paths.off: maps.off})
            self._log_maps(t_us, maps.cell_px, dict(zip(paths.motion, maps.motion, strict=True)))
            self._log_maps(t_us, maps.cell_px, {paths.saliency: maps.saliency})
        self._send_full_buffer()

    def _log_maps(
        self, t_us: int, cell_px: int, maps: Mapping[str, npt.NDArray[np.float32]]
    ) -> None:
        """Show maps on a common brightness scale, so that they can be compared."""
        brightest = float(np.quantile(list(maps.values()), BRIGHTEST_SHARE))
        for path, values in maps.items():
            self._scale(path, cell_px)
            self._brightest[path] = max(self._brightest.get(path, 0.0), brightest)
            self._log(path, t_us, rr.DepthImage(values.astype(np.float16), colormap=at.COLORMAP))

    def _log(self, path: str, t_us: int, what: rr.AsComponents) -> None:
        self._stream.set_time(at.TIMELINE, duration=np.timedelta64(t_us, "us"))
        self._stream.log(path, what, strict=True)

    def _scale(self, path: str, factor: float) -> None:
        """Scale an image of another resolution to sensor pixels."""
        if path not in self._scaled:
            self._scaled.add(path)
            log_static(self._stream, path, rr.Transform3D(scale=[factor, factor, 1.0]))

    def _send_events(self, batches: EventBatches | None) -> None:
        if batches is None:
            return
        self._log_rates(batches)
        columns = rr.Points2D.columns(
            positions=batches.positions_px, class_ids=batches.class_ids
        ).partition(batches.lengths)
        self._stream.send_columns(at.EVENTS, [time_column(batches.t_us)], columns, strict=True)
        self._send_full_buffer()

    def _log_rates(self, batches: EventBatches) -> None:
        """Log events per millisecond, which is kev/s, including milliseconds without events."""
        gaps_us = np.diff(batches.t_us, prepend=self._rate_from_us - BATCH_US)
        for part in np.split(np.arange(gaps_us.size), np.flatnonzero(gaps_us > MAX_ZEROS_US)):
            if not part.size:
                continue
            first_us, last_us = int(batches.t_us[part[0]]), int(batches.t_us[part[-1]])
            self._log_no_events(first_us)
            times_us = np.arange(first_us, last_us + BATCH_US, BATCH_US)
            rows = (batches.t_us[part] - first_us) // BATCH_US
            counts = (batches.on, batches.off, batches.noise)
            for path, count in zip(self._rates, counts, strict=False):
                rate = np.zeros(times_us.size)
                rate[rows] = count[part]
                self._columns.curve(path, times_us, rate)
            self._rate_from_us = last_us + BATCH_US

    def _log_no_events(self, until_us: int) -> None:
        """Log a rate of zero from the end of the curve until before a time."""
        last_us = (until_us - 1) // BATCH_US * BATCH_US
        if last_us < self._rate_from_us:
            return
        if last_us - self._rate_from_us <= MAX_ZEROS_US:
            times_us = np.arange(self._rate_from_us, last_us + BATCH_US, BATCH_US)
        else:
            times_us = np.array([self._rate_from_us, last_us])
        for path in self._rates:
            self._columns.curve(path, times_us, np.zeros(times_us.size))
        self._rate_from_us = last_us + BATCH_US

    def _send_full_buffer(self) -> None:
        if self._columns.rows >= MAX_ROWS:
            self._columns.send(self._stream)


def check_methods(methods: Sequence[str], maps_of: str | None) -> None:
    """Check the methods of a recording.

    Raises:
        ScenarioError: a method is named twice, or `maps_of` is not one of the methods.
    """
    twice = [method for n, method in enumerate(methods) if method in methods[:n]]
    if twice:
        raise ScenarioError(
            f"The method {twice[0]} is recorded twice. Allowed is each method once. Leave one out."
        )
    if maps_of is not None and maps_of not in methods:
        raise ScenarioError(
            f"The maps are of {maps_of}. Allowed is one of the recorded methods "
            f"({', '.join(methods) or 'there are none'}). Choose one of them, or None."
        )
