"""Writes a run to one Rerun file, on one time line, as the run goes on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr

from detector.estimate import Direction, MotionEstimate
from detector.fly import FlyMaps
from emulator import ApsFrame, Events
from scenarios.recording import entities as at
from scenarios.recording.blueprint import blueprint
from scenarios.recording.column_buffer import ColumnBuffer, time_column
from scenarios.recording.event_batches import BATCH_US, EventBatches, EventBuffer
from scenarios.recording.stage import body_path, log_parameters, log_stage, log_static
from sim import Crossing, GroundTruth
from sim.geometry import MovingBodies

APPLICATION = "flybench"
JPEG_QUALITY = 85
"""Of the colour preview, which is for the eye only (by eye)."""
BRIGHTEST_SHARE = 0.995
"""Cells up to this share have a colour of their own; the few that are brighter look alike."""


class Recorder:
    """One recording; use it as a context manager, so that all of it is written."""

    def __init__(
        self,
        path: Path,
        *,
        crossing: Crossing,
        parameters: Mapping[str, object],
        has_maps: bool = True,
    ) -> None:
        """Begin the file with all that does not change with time.

        Args:
            path: the .rrd file; one that exists is replaced.
            crossing: what is recorded.
            parameters: of the run, by name; see `log_parameters`.
            has_maps: whether the detector has a fly's maps, and the view a place for them.

        Raises:
            OSError: the file cannot be written.
        """
        self._crossing = crossing
        self._bodies = MovingBodies(crossing.scene)
        self._events = EventBuffer()
        self._rates: list[npt.NDArray[np.int64]] = []
        self._columns = ColumnBuffer()
        self._scaled: set[str] = set()
        self._brightest: dict[str, float] = {}
        path.touch()
        self._stream = rr.RecordingStream(APPLICATION)
        self._stream.set_log_time_enabled(False)
        self._stream.set_log_tick_enabled(False)
        self._stream.save(path, default_blueprint=blueprint(crossing, has_maps=has_maps))
        log_parameters(self._stream, parameters)
        log_stage(self._stream, crossing)

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Write what is still in memory, and end the file."""
        self._send_events(self._events.flush())
        self._keep_rates()
        self._columns.send(self._stream)
        for path, brightest in self._brightest.items():
            scale = rr.DepthImage.from_fields(depth_range=[0.0, brightest or 1.0])
            log_static(self._stream, path, scale)
        self._stream.flush()
        self._stream.disconnect()

    def log_events(self, events: Events, causes: npt.NDArray[np.uint8] | None = None) -> None:
        """Add the next events of the stream.

        Args:
            events: (n,) of `EVENT_DTYPE`, sorted by t, none before those logged earlier.
            causes: (n,) the `Cause` of each; None: all are the signal's.
        """
        self._send_events(self._events.push(events, causes))

    def log_aps(self, frame: ApsFrame) -> None:
        """Show an APS frame, in raw levels [DN], from the end of its exposure on."""
        self._log(at.APS, frame.end_us, rr.Image(frame.image))

    def log_preview(self, t_us: int, rgb: npt.NDArray[np.uint8]) -> None:
        """Show a colour picture from `t_us` on.

        Args:
            t_us: time [µs].
            rgb: (height·scale, width·scale, 3) sRGB, of any scale.
        """
        self._scale(at.PREVIEW, self._crossing.intrinsics.width / rgb.shape[1])
        bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
        _, jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        picture = rr.EncodedImage(contents=jpeg.tobytes(), media_type="image/jpeg")
        self._log(at.PREVIEW, t_us, picture)

    def log_truth(self, truth: GroundTruth) -> None:
        """Show the target: in the image, in the 3-D scene, its direction and its velocity."""
        t_us, columns, centroid = truth.t_us, self._columns, truth.centroid_px
        self._log(at.TRUTH_MASK, t_us, rr.SegmentationImage(truth.mask.astype(np.uint8)))
        columns.box(at.TRUTH_BOX, t_us, truth.bounding_box_px)
        columns.point(at.TRUTH_CENTROID, t_us, None if centroid is None else tuple(centroid))
        columns.state(at.TRUE_DIRECTION, t_us, truth.direction if truth.in_view else "")
        columns.scalar(at.ANGULAR_VELOCITY, t_us, truth.angular_velocity_rad_s)
        columns.scalar(at.IMAGE_VELOCITY_X, t_us, float(truth.image_velocity_px_s[0]))
        columns.scalar(at.IMAGE_VELOCITY_Y, t_us, float(truth.image_velocity_px_s[1]))
        for name, pose in self._bodies.poses(self._crossing.seconds(t_us)).items():
            columns.pose(body_path(name), t_us, pose)

    def log_estimate(self, estimate: MotionEstimate, maps: FlyMaps | None = None) -> None:
        """Show what was concluded at the end of a window, and the fly's maps that led to it."""
        t_us, columns, direction = estimate.t_us, self._columns, estimate.direction
        columns.scalar(at.HS, t_us, estimate.hs)
        columns.scalar(at.VS, t_us, estimate.vs)
        columns.state(at.FLY_DIRECTION, t_us, "" if direction is Direction.NONE else direction)
        columns.box(at.ROI, t_us, estimate.roi_px)
        columns.point(at.VIEW_CENTRE, t_us, estimate.view_centre_px)
        if maps is None:
            return
        self._log_maps(t_us, maps.cell_px, {at.SURFACE_ON: maps.on, at.SURFACE_OFF: maps.off})
        self._log_maps(t_us, maps.cell_px, dict(zip(at.MOTION, maps.motion, strict=True)))
        self._log_maps(t_us, maps.cell_px, {at.SALIENCY: maps.saliency})

    def _log_maps(
        self, t_us: int, cell_px: int, maps: Mapping[str, npt.NDArray[np.float32]]
    ) -> None:
        """Show maps that are to be compared, so on one scale of brightness."""
        brightest = float(np.quantile(list(maps.values()), BRIGHTEST_SHARE))
        for path, values in maps.items():
            self._scale(path, cell_px)
            self._brightest[path] = max(self._brightest.get(path, 0.0), brightest)
            self._log(path, t_us, rr.DepthImage(values.astype(np.float16), colormap=at.COLORMAP))

    def _log(self, path: str, t_us: int, what: rr.AsComponents) -> None:
        self._stream.set_time(at.TIMELINE, duration=np.timedelta64(t_us, "us"))
        self._stream.log(path, what, strict=True)

    def _scale(self, path: str, factor: float) -> None:
        """Draw an image of another resolution in sensor pixels."""
        if path not in self._scaled:
            self._scaled.add(path)
            log_static(self._stream, path, rr.Transform3D(scale=[factor, factor, 1.0]))

    def _send_events(self, batches: EventBatches | None) -> None:
        if batches is None:
            return
        self._rates.append(np.stack([batches.t_us, batches.on, batches.off, batches.noise]))
        columns = rr.Points2D.columns(
            positions=batches.positions_px, class_ids=batches.class_ids
        ).partition(batches.lengths)
        self._stream.send_columns(at.EVENTS, [time_column(batches.t_us)], columns, strict=True)

    def _keep_rates(self) -> None:
        """Events a millisecond, which is kev/s; also of the milliseconds without any."""
        t_us, *counts = np.concatenate([np.zeros((4, 0), np.int64), *self._rates], axis=1)
        end_us = int(t_us.max(initial=self._crossing.duration_us))
        times_us = np.arange(0, end_us + BATCH_US, BATCH_US)
        for path, count in zip((at.RATE_ON, at.RATE_OFF, at.RATE_NOISE), counts, strict=True):
            rate = np.zeros(times_us.size)
            rate[t_us // BATCH_US] = count
            self._columns.curve(path, times_us, rate)
