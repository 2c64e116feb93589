"""Records what a detector makes of events from a file: no light, no scene, no truth."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scenarios.recording import entities as at
from scenarios.recording.blueprint import stream_blueprint
from scenarios.recording.stage import log_marks
from scenarios.recording.stream_recorder import StreamRecorder


class FileRecorder(StreamRecorder):
    """The recording of a stream from a sensor of any size, seen by one method."""

    def __init__(
        self,
        path: Path,
        *,
        width: int,
        height: int,
        method: str,
        has_maps: bool,
        has_frames: bool,
        name: str,
        parameters: Mapping[str, object],
        start_us: int = 0,
    ) -> None:
        """Begin the file.

        Args:
            path: the .rrd file; one that exists is replaced.
            width: sensor columns [px].
            height: sensor rows [px].
            method: whose estimates are logged.
            has_maps: whether they come with a fly's maps.
            has_frames: whether there are APS frames.
            name: what the viewer calls the recording.
            parameters: shown with it, by name; see `log_parameters`.
            start_us: from when on the event rate is shown [µs].

        Raises:
            OSError: the file cannot be written.
        """
        paths = {method: at.paths_of(method, 0)}
        super().__init__(
            path,
            view=stream_blueprint(
                width, height, paths, maps_of=method if has_maps else None, has_frames=has_frames
            ),
            name=name,
            parameters=parameters,
            methods=paths,
            start_us=start_us,
            knows_noise=False,
        )
        log_marks(self._stream, paths)
