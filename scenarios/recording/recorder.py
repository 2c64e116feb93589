"""Writes a run to one Rerun file, on one time line, as the run goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr

from scenarios.pipeline.registry import FLY
from scenarios.recording import entities as at
from scenarios.recording.blueprint import blueprint
from scenarios.recording.stage import body_path, log_stage
from scenarios.recording.stream_recorder import StreamRecorder, check_methods
from sim import Crossing, GroundTruth
from sim.truth.body_meshes import MovingBodies


class Recorder(StreamRecorder):
    """The recording of a crossing, with its truth."""

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
        """Begin the file with all that does not change with time.

        Args:
            path: the .rrd file; one that exists is replaced.
            crossing: what is recorded.
            parameters: of the run, by name; see `log_parameters`.
            methods: names of all whose estimates are logged, in the order in which they are shown;
                there may be none.
            maps_of: which of them comes with a fly's maps; the view has a place for these, and
                shows what this one attends to. None: none does, and the first one's attention is
                shown.
            name: what the viewer calls the recording; None: light, speed and direction.
            one_of_several: whether others are opened with it; the viewer then lists them.

        Raises:
            OSError: the file cannot be written.
            ScenarioError: a method is there twice, or `maps_of` is none of them.
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
        log_stage(self._stream, crossing, paths)

    def close(self, end_us: int = 0) -> None:
        """Write what is still in memory, and end the file."""
        super().close(max(end_us, self._crossing.duration_us))

    def log_preview(self, jpeg: bytes, truth: GroundTruth, *, scale: float) -> None:
        """Show a colour picture, and the target in it, from the time of `truth` on.

        Args:
            jpeg: the picture, of the whole image.
            truth: of the same moment.
            scale: the picture's pixels per sensor pixel and axis, the same for all.
        """
        t_us, columns, centroid = truth.t_us, self._columns, truth.centroid_px
        self._scale(at.PREVIEW, 1 / scale)
        self._log(at.PREVIEW, t_us, rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
        self._log(at.TRUTH_MASK, t_us, rr.SegmentationImage(truth.mask.astype(np.uint8)))
        columns.box(at.PREVIEW_BOX, t_us, truth.bounding_box_px)
        columns.point(at.PREVIEW_CENTROID, t_us, None if centroid is None else tuple(centroid))

    def log_truth(self, truth: GroundTruth) -> None:
        """Show the target: its box, its place in the 3-D scene, its direction and its velocity."""
        t_us, columns = truth.t_us, self._columns
        columns.box(at.TRUTH_BOX, t_us, truth.bounding_box_px)
        columns.state(at.TRUE_DIRECTION, t_us, truth.direction if truth.in_view else "")
        columns.scalar(at.ANGULAR_VELOCITY, t_us, truth.angular_velocity_rad_s)
        columns.scalar(at.TRUE_VELOCITY_X, t_us, float(truth.image_velocity_px_s[0]))
        columns.scalar(at.TRUE_VELOCITY_Y, t_us, float(truth.image_velocity_px_s[1]))
        for name, pose in self._bodies.poses(self._crossing.seconds(t_us)).items():
            columns.pose(body_path(name), t_us, pose)


def recording_name(crossing: Crossing) -> str:
    """What the viewer calls a recording of a crossing, such as "day, 1.61 rad/s, right"."""
    c = crossing.config
    return f"{c.lighting}, {c.omega_rad_s:g} rad/s, {c.direction}"
