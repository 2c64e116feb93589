"""Record a run and its ground truth in one Rerun file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr

from scenarios.pipeline.registry import FLY
from scenarios.recording import entities as at
from scenarios.recording.blueprint import blueprint
from scenarios.recording.static_content import body_path, log_static_content
from scenarios.recording.stream_recorder import StreamRecorder, check_methods
from sim import Crossing, GroundTruth
from sim.truth.body_meshes import MovingBodies


class Recorder(StreamRecorder):
    """Recording of a crossing with its ground truth."""

    def __init__(
        self,
        path: Path,
        *,
        crossing: Crossing,
        parameters: Mapping[str, object],
        methods: Sequence[str] = (FLY,),
        maps_of: str | None = None,
        name: str | None = None,
        one_of_several: bool = False,
    ) -> None:
        """Create the file and write everything that does not change with time.

        Args:
            path: path of the .rrd file; an existing file is replaced.
            crossing: crossing that is recorded.
            parameters: parameters of the run, by name; see `log_parameters`.
            methods: names of the methods whose estimates are logged, in the order of display; there
                may be none.
            maps_of: name of the method that has a fly's maps. The layout shows these maps, and the
                region of this method. None: no method has maps, and the region of the first method
                is shown.
            name: name of the recording in the viewer; None: lighting, speed and direction.
            one_of_several: True if other recordings are opened with it; the viewer then lists them.

        Raises:
            OSError: the file cannot be written.
            ScenarioError: a method is named twice, or `maps_of` is not one of the methods.
        """
        check_methods(methods, maps_of)
        paths = {method: at.paths_of(method, n) for n, method in enumerate(methods)}
        super().__init__(
            path,
            view=blueprint(crossing, paths, maps_of, lists_recordings=one_of_several),
            name=name or recording_name(crossing),
            parameters=parameters,
            methods=paths,
        )
        self._crossing = crossing
        self._bodies = MovingBodies(crossing.scene)
        log_static_content(self._stream, crossing, paths)

    def close(self, end_us: int = 0) -> None:
        """Write everything that is still in memory, and close the file.

        Args:
            end_us: time until which the event rate is shown, at least to the end of the crossing
                [µs].
        """
        super().close(max(end_us, self._crossing.duration_us))

    def log_preview(self, jpeg: bytes, truth: GroundTruth, *, scale: float) -> None:
        """Show a colour preview and the true target from the time of `truth` on.

        Args:
            jpeg: preview of the whole image.
            truth: ground truth at the same time.
            scale: preview pixels per sensor pixel along each axis; equal for all previews.
        """
        t_us, columns, centroid = truth.t_us, self._columns, truth.centroid_px
        self._scale(at.PREVIEW, 1 / scale)
        self._log(at.PREVIEW, t_us, rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
        self._log(at.TRUTH_MASK, t_us, rr.SegmentationImage(truth.mask.astype(np.uint8)))
        columns.box(at.PREVIEW_BOX, t_us, truth.bounding_box_px)
        columns.point(at.PREVIEW_CENTROID, t_us, None if centroid is None else tuple(centroid))

    def log_truth(self, truth: GroundTruth) -> None:
        """Show the true box, direction, velocities and poses."""
        t_us, columns = truth.t_us, self._columns
        columns.box(at.TRUTH_BOX, t_us, truth.bounding_box_px)
        columns.state(at.TRUE_DIRECTION, t_us, truth.direction if truth.in_view else "")
        columns.scalar(at.ANGULAR_VELOCITY, t_us, truth.angular_velocity_rad_s)
        columns.scalar(at.TRUE_VELOCITY_X, t_us, float(truth.image_velocity_px_s[0]))
        columns.scalar(at.TRUE_VELOCITY_Y, t_us, float(truth.image_velocity_px_s[1]))
        for name, pose in self._bodies.poses(self._crossing.seconds(t_us)).items():
            columns.pose(body_path(name), t_us, pose)


def recording_name(crossing: Crossing) -> str:
    """Return the name of a recording in the viewer, such as "day, 1.61 rad/s, right"."""
    c = crossing.config
    return f"{c.lighting}, {c.omega_rad_s:g} rad/s, {c.direction}"
