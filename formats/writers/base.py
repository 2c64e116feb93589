"""Base of all writers: checks, and a temporary file that is renamed once it is complete."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

import numpy.typing as npt

from emulator import ApsFrame
from flybench.disk_space import caused_by_full_disk, full_disk_message
from flybench.errors import EventError
from flybench.events import Events, check_events
from flybench.unfinished import UnfinishedOutput, check_new_file
from formats.columns import MAX_SIDE_PX
from formats.errors import FormatError


class EventWriter(ABC):
    """Writes one recording under a temporary name and renames it once it is complete.

    Use as a context manager.

    Attributes:
        takes_frames: True if the format supports APS frames.
        takes_samples: True if the format supports IMU samples and triggers.
        max_side_px: largest width or height of a sensor in the format [px].
        path: path of the file.
        width: sensor columns [px].
        height: sensor rows [px].
    """

    takes_frames: ClassVar[bool] = False
    takes_samples: ClassVar[bool] = False
    max_side_px: ClassVar[int] = MAX_SIDE_PX

    def __init__(self, path: Path, *, width: int, height: int, overwrite: bool = True) -> None:
        """Create the temporary file.

        Args:
            path: path of the file.
            width: sensor columns [px].
            height: sensor rows [px].
            overwrite: True to replace an existing file.

        Raises:
            FormatError: the file cannot be written, exists and may not be overwritten, or is being
                written by another process; or the format does not support the size.
            MissingLibraryError: a library is missing; the message states how to install it.
        """
        if not (0 < width <= self.max_side_px and 0 < height <= self.max_side_px):
            raise FormatError(
                f"The sensor has {width}x{height} px. Allowed in this format is 1 to "
                f"{self.max_side_px} px each way. Choose another format."
            )
        _check_place(path)
        check_new_file(path, overwrite=overwrite, error=FormatError)
        self.path, self.width, self.height = path, width, height
        self._overwrite, self._last_us = overwrite, 0
        self._output = UnfinishedOutput(path.absolute(), FormatError)
        self._work = self._output.new / path.name
        try:
            self._open(self._work)
        except BaseException as error:
            named = self._as_format_error(error)
            self._discard()
            raise named from error

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
                self._output.publish_file(overwrite=self._overwrite)
            except BaseException as failure:
                named = self._as_format_error(failure)
                self._discard()
                raise named from failure
        self._discard()

    def write(self, events: Events) -> None:
        """Append events.

        Args:
            events: events sorted by time, from 0 on and not older than those written before.

        Raises:
            FormatError: the events are not in order or not from this sensor, or the disk is full.
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
                f"{self.path} cannot be written: an event at {first_us} µs comes after one at "
                f"{self._last_us} µs. Write events in order of time, from 0 on."
            )
        self._last_us = int(events["t"][-1])
        try:
            self._write(events)
        except (OSError, RuntimeError) as error:
            raise self._as_format_error(error) from error

    def write_frame(self, frame: ApsFrame) -> None:
        """Append an APS frame; frames must come in order of time.

        Raises:
            FormatError: the format does not support frames, or the frame has another size.
        """
        if not self.takes_frames:
            raise FormatError(
                f"{self.path} has a format without frames. Write AEDAT 4 (.aedat4), or leave the "
                "frames out."
            )
        if frame.image.shape != (self.height, self.width):
            raise FormatError(
                f"{self.path}: a frame has {frame.image.shape[1]}x{frame.image.shape[0]} px. "
                f"Allowed is the size of the sensor, {self.width}x{self.height} px."
            )
        try:
            self._write_frame(frame)
        except (OSError, RuntimeError) as error:
            raise self._as_format_error(error) from error

    def write_samples(self, samples: npt.NDArray[Any]) -> None:
        """Append IMU samples or triggers.

        Args:
            samples: array of `formats.IMU_DTYPE` or `formats.TRIGGER_DTYPE`; times from 0 on.

        Raises:
            FormatError: the format does not support them, or a time is negative.
        """
        if not self.takes_samples:
            raise FormatError(
                f"{self.path} has a format without IMU samples and triggers. Write AEDAT 4 "
                "(.aedat4), or leave them out."
            )
        if not samples.size:
            return
        if int(samples["t"].min()) < 0:
            raise FormatError(
                f"{self.path} cannot be written: a sample has the time {samples['t'].min()} µs. "
                "Allowed is 0 and later. Leave out those before the first event."
            )
        try:
            self._write_samples(samples)
        except (OSError, RuntimeError) as error:
            raise self._as_format_error(error) from error

    @abstractmethod
    def _open(self, work: Path) -> None:
        """Create the temporary file `work`."""

    @abstractmethod
    def _write(self, events: Events) -> None:
        """Append events that have been checked, at least one."""

    def _write_frame(self, frame: ApsFrame) -> None:
        """Append a frame that has been checked; called only if `takes_frames`."""
        raise NotImplementedError

    def _write_samples(self, samples: npt.NDArray[Any]) -> None:
        """Append samples that have been checked; called only if `takes_samples`."""
        raise NotImplementedError

    @abstractmethod
    def _finish(self) -> None:
        """Write buffered data and close the file."""

    @abstractmethod
    def _abandon(self) -> None:
        """Close all open files; always called at the end, also after `_finish`."""

    def _discard(self) -> None:
        with suppress(Exception):
            self._abandon()
        self._output.close()

    def _as_format_error(self, error: BaseException) -> BaseException:
        if isinstance(error, FormatError) or not isinstance(error, OSError | RuntimeError):
            return error
        if caused_by_full_disk(error):
            return FormatError(full_disk_message(self.path, self._work.parent))
        why = (error.strerror if isinstance(error, OSError) else None) or str(error)
        return FormatError(f"{self.path} cannot be written ({why}). Choose another place.")


def _check_place(path: Path) -> None:
    if path.is_dir():
        raise FormatError(f"{path} is a folder. Give the name of a file in it.")
    if not path.parent.is_dir():
        raise FormatError(
            f"{path} cannot be written: the folder {path.parent} does not exist. Create it first."
        )
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise FormatError(
            f"{path} cannot be written: the folder {path.parent} is write-protected. Choose "
            "another place."
        )
