"""Find the file of a recording, or fetch it into the user's cache, and check its content."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flybench.errors import first_line
from scenarios.options.cache import VARIABLE, default_folder
from scenarios.validate.keys import ManifestError
from scenarios.validate.manifest import Manifest, Recording

CACHE_FOLDER = "recordings"
"""Folder inside flybench's cache."""

Progress = Callable[[int, int], None]
"""Function of the bytes done and their total."""


def find_file(
    manifest: Manifest,
    recording: Recording,
    folder: Path | None,
    progress: Callable[[str], Progress],
) -> Path:
    """Return the path of a recording's file, whose SHA-256 is that of the manifest.

    Args:
        manifest: the manifest, whose folder relative paths begin at.
        recording: one of its recordings.
        folder: folder that holds all files; None: fetch files that have a URL.
        progress: function that adds a progress bar with a label.

    Raises:
        ManifestError: the file does not exist, cannot be fetched, or has another SHA-256.
    """
    if folder is not None:
        path = folder / Path(recording.file).name
    elif recording.url is not None:
        path = _fetched(recording, recording.url, progress)
    else:
        path = manifest.path.absolute().parent / recording.file
    if not path.is_file():
        where = recording.url or recording.source
        raise ManifestError(
            f"The file of {recording.name}, {path}, does not exist. Get it from "
            f"{where}, or leave the recording out with --recording."
        )
    _check_content(recording, path)
    return path


def _check_content(recording: Recording, path: Path) -> None:
    try:
        with path.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise ManifestError(
            f"The file of {recording.name}, {path}, cannot be read ({error.strerror}). Change its "
            "permissions."
        ) from error
    if found != recording.sha256:
        raise ManifestError(
            f"sha256 of {recording.name} is {recording.sha256}, and {path} has "
            f"{found}. Get the right file from {recording.url or recording.source}, or correct "
            "the manifest if the windows are true for this file."
        )


def _fetched(recording: Recording, url: str, progress: Callable[[str], Progress]) -> Path:
    import pooch  # takes 80 ms, as does requests; most runs do not need them
    from requests import exceptions

    base = default_folder()
    if base is None:
        raise ManifestError(
            f"{recording.name} has to be fetched, and there is no cache: {VARIABLE} is off, or "
            "there is no home folder. Set it to a folder, or give the files with --folder DIR."
        )
    pooch.get_logger().setLevel("WARNING")
    folder = base / CACHE_FOLDER / recording.sha256[:16]
    bar: Any = _Bar(progress, f"fetching {recording.name}")
    try:
        pooch.retrieve(
            url,
            known_hash=f"sha256:{recording.sha256}",
            fname=recording.file,
            path=folder,
            downloader=pooch.downloaders.choose_downloader(url, progressbar=bar),
        )
    except (OSError, ValueError) as error:  # OSError includes every error of requests
        unreachable = isinstance(error, exceptions.ConnectionError | exceptions.Timeout)
        reason = "the server does not answer" if unreachable else first_line(error)
        raise ManifestError(
            f"{recording.name} cannot be fetched from {url}: {reason}. Check the address and the "
            f"connection, or put the file into a folder as {recording.file} and give --folder DIR."
        ) from error
    return folder / recording.file


class _Bar:
    """A progress bar in the form that pooch expects."""

    def __init__(self, progress: Callable[[str], Progress], label: str) -> None:
        self.total = 0
        self._start, self._label = progress, label
        self._done = 0
        self._advance: Progress | None = None

    def update(self, size: int) -> None:
        """Count bytes."""
        self._advance = self._advance or self._start(self._label)
        self._done += size
        self._advance(self._done, max(self.total, self._done))

    def reset(self) -> None:
        """Count from 0 again."""
        self._done = 0

    def close(self) -> None:
        """Do nothing: the display closes the bar."""
