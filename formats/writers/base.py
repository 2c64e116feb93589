"""What all writers share: the checks, and a file that is whole or absent."""

from __future__ import annotations

import os
import secrets
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import ClassVar, Self

from emulator import ApsFrame
from flybench.errors import EventError
from flybench.events import Events, check_events
from formats.columns import SIDE_MAX
from formats.errors import FormatError


class EventWriter(ABC):
    """Writes one recording, under another name until it is whole. Use as a context manager.

    Attributes:
        takes_frames: whether the format holds APS frames beside events.
    """

    takes_frames: ClassVar[bool] = False
    side_max: ClassVar[int] = SIDE_MAX

    def __init__(self, path: Path, *, width: int, height: int) -> None:
        """Begin a file.

        Args:
            path: where it will be.
            width: sensor columns [px].
            height: sensor rows [px].

        Raises:
            FormatError: nothing can be written there, or no sensor of this size in this format.
            MissingLibraryError: a library is missing, with the command that installs it.
        """
        if not (0 < width <= self.side_max and 0 < height <= self.side_max):
            raise FormatError(
                f"the sensor has {width}x{height} px; this format allows 1 to {self.side_max} each "
                "way; choose another format"
            )
        _check_place(path)
        self.path, self.width, self.height = path, width, height
        self._work = path.with_name(f".{path.name}.{secrets.token_hex(4)}{path.suffix}")
        self._last_us = 0
        try:
            self._open(self._work)
        except BaseException as error:
            self._discard()
            raise self._told(error) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            try:
                self._finish()
                self._work.replace(self.path)
            except BaseException as failure:
                self._discard()
                raise self._told(failure) from failure
        self._discard()

    def write(self, events: Events) -> None:
        """Append events, sorted by t, from 0 on, and not older than the last.

        Raises:
            FormatError: they are not, or are no events of this sensor, or the disk is full.
        """
        try:
            check_events(events, width=self.width, height=self.height)
        except EventError as error:
            raise FormatError(f"{self.path} cannot be written: {error}") from error
        if not events.size:
            return
        first_us = int(events["t"][0])
        if first_us < self._last_us:
            raise FormatError(
                f"{self.path} cannot be written: an event at {first_us} µs comes after "
                f"{self._last_us} µs; write them in order of time, from 0 on"
            )
        self._last_us = int(events["t"][-1])
        try:
            self._write(events)
        except (OSError, RuntimeError) as error:
            raise self._told(error) from error

    def write_frame(self, frame: ApsFrame) -> None:
        """Add an APS frame, in order of time among the frames.

        Raises:
            FormatError: the format takes none, or the frame is of another size.
        """
        if not self.takes_frames:
            raise FormatError(
                f"{self.path} cannot hold frames; write AEDAT 4 (.aedat4), or leave them out"
            )
        if frame.image.shape != (self.height, self.width):
            raise FormatError(
                f"{self.path}: a frame has {frame.image.shape[1]}x{frame.image.shape[0]} px; "
                f"allowed is the sensor's {self.width}x{self.height}"
            )
        try:
            self._write_frame(frame)
        except (OSError, RuntimeError) as error:
            raise self._told(error) from error

    @abstractmethod
    def _open(self, work: Path) -> None:
        """Begin the file under its temporary name."""

    @abstractmethod
    def _write(self, events: Events) -> None:
        """Append checked events, at least one."""

    def _write_frame(self, frame: ApsFrame) -> None:
        """Add a checked frame; only where `takes_frames`."""
        raise NotImplementedError

    @abstractmethod
    def _finish(self) -> None:
        """Write what is left, and close."""

    @abstractmethod
    def _abandon(self) -> None:
        """Close whatever is open; called at the end in any case."""

    def _discard(self) -> None:
        with suppress(Exception):
            self._abandon()
        with suppress(OSError):
            self._work.unlink(missing_ok=True)

    def _told(self, error: BaseException) -> BaseException:
        if isinstance(error, FormatError) or not isinstance(error, OSError | RuntimeError):
            return error
        why = (error.strerror if isinstance(error, OSError) else None) or str(error)
        return FormatError(
            f"{self.path} cannot be written ({why}); make room there, or choose another place"
        )


def _check_place(path: Path) -> None:
    if path.is_dir():
        raise FormatError(f"{path} is a folder; give the name of a file in it")
    if not path.parent.is_dir():
        raise FormatError(f"{path} cannot be written: there is no folder {path.parent}; make it")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise FormatError(
            f"{path} cannot be written: the folder {path.parent} allows it not; choose "
            "another place"
        )
