"""Record the estimates of a detector for events from a file, without scene or ground truth."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scenarios.recording import entities as at
from scenarios.recording.blueprint import stream_blueprint
from scenarios.recording.static_content import log_styles
from scenarios.recording.stream_recorder import StreamRecorder


class FileRecorder(StreamRecorder):
    """Recording of a stream from a sensor of any size, with the estimates of one method."""

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
        """Create the file.

        Args:
            path: path of the .rrd file; an existing file is replaced.
            width: sensor columns [px].
            height: sensor rows [px].
            method: name of the method whose estimates are logged.
            has_maps: True if the method has a fly's maps.
            has_frames: True if there are APS frames.
            name: name of the recording in the viewer.
            parameters: parameters to show with the recording; see `log_parameters`.
            start_us: time from which the event rate is shown [µs].

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
        log_styles(self._stream, paths)
