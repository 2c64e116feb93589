"""Output that is being written: in the folder `NAME.unfinished` beside its final place, locked.

The lock ends with its process, even if that is killed. A folder without a lock was therefore
abandoned; the next process that writes beside it removes it.
"""

from __future__ import annotations

import fcntl
import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, Self

from flybench.disk_space import caused_by_full_disk, full_disk_message
from flybench.errors import FlybenchError
from flybench.files import open_regular

SUFFIX, LOCK = ".unfinished", "flybench.lock"
NEW, OLD, FINISHED = "new", "old", "finished"
_NAMES = frozenset({LOCK, NEW, OLD, FINISHED})


class UnfinishedOutput:
    """The folder in which this process prepares a file or a folder. Use as a context manager.

    Attributes:
        target: final place of the output.
        new: place of the new output: an empty folder.
        old: place to which an earlier output may be moved; it is moved back if `target` is missing.
        finished: place of parts of the output; they are kept if the process fails or is killed, and
            removed when the output is complete.
    """

    def __init__(self, target: Path, error: type[FlybenchError]) -> None:
        """Create the folder, or take over an abandoned one with its finished parts.

        Args:
            target: final place of the output, in an existing folder.
            error: class to raise.

        Raises:
            FlybenchError: of class `error`, if another process is writing the same output, or if
                the folder cannot be created.
        """
        self.target, self._error = target, error
        self._lock: BinaryIO | None = None
        self._folder = folder = target.with_name(target.name + SUFFIX)
        self.new, self.old, self.finished = folder / NEW, folder / OLD, folder / FINISHED
        try:
            remove_abandoned(target.parent)
            self._lock = self._lock_folder()
            _restore(folder)
            _remove(folder, NEW, OLD)
            self.new.mkdir()
        except BlockingIOError:
            raise error(
                f"Another process is writing {target}. Allowed is one process at a time. Wait for "
                "it to end, or choose another place."
            ) from None
        except OSError as failure:
            if self._lock is not None:
                self.close(keep_finished=True)
            raise error(
                f"{target} cannot be written ({failure.strerror}). Choose another place."
            ) from failure

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Remove the folder; after an error, keep the finished parts.

        Raises:
            FlybenchError: of the class given, if the disk is full.
        """
        message = full_disk_message(self.target, self.new) if caused_by_full_disk(error) else None
        self.close(keep_finished=error is not None)
        if message is not None:
            raise self._error(message) from error

    def close(self, *, keep_finished: bool = False) -> None:
        """Remove the folder, and release its lock."""
        _restore(self._folder)
        _remove(self._folder, NEW, OLD)
        if not (keep_finished and self.finished.exists()):
            _remove(self._folder, FINISHED)
            _remove_locked(self._folder)
        if self._lock is not None:
            self._lock.close()

    def publish_file(self, *, overwrite: bool) -> None:
        """Move the new file, which has the name of the target, to its final place.

        Raises:
            FlybenchError: of the class given, if the target cannot be replaced, or was created
                meanwhile and may not be overwritten. The new file is then kept under another name.
        """
        work = self.new / self.target.name
        reason = "was created by another program meanwhile"
        if overwrite or not os.path.lexists(self.target):
            try:
                work.replace(self.target)
            except OSError as failure:
                reason = f"cannot be replaced ({failure.strerror})"
            else:
                return
        place = free_name(self.target)
        work.rename(place)
        raise self._error(
            f"{self.target} {reason}. The output is in {place.name} beside it. Rename one of them."
        )

    def _lock_folder(self) -> BinaryIO:
        while True:
            self._folder.mkdir(exist_ok=True)
            if not {path.name for path in self._folder.iterdir()} <= _NAMES:
                raise self._error(
                    f"{self._folder} was not made by flybench, which needs a folder of this name. "
                    "Rename it, or choose another place."
                )
            with suppress(FileNotFoundError):  # its process has just ended and removed it
                return lock_file(self._folder / LOCK)


def lock_file(path: Path, *, create: bool = True) -> BinaryIO:
    """Open or create a file and lock it until it is closed.

    Raises:
        BlockingIOError: another process has locked it.
        FileNotFoundError: it does not exist, or another process has just removed it.
        OSError: it cannot be opened.
    """
    file = open_regular(path, "ab" if create else "r+b")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(file.fileno()), path.stat()):
            raise FileNotFoundError(path)
    except OSError:
        file.close()
        raise
    return file


def remove_abandoned(parent: Path) -> None:
    """Remove the unfinished outputs in a folder whose process has ended, but no finished parts."""
    for folder in parent.glob(f"*{SUFFIX}"):
        with suppress(OSError):
            names = {path.name for path in folder.iterdir()}
            if LOCK in names and names <= _NAMES:
                with lock_file(folder / LOCK, create=False):
                    _restore(folder)
                    _remove(folder, NEW, OLD)
                    if FINISHED not in names:
                        _remove_locked(folder)


def check_new_file(path: Path, *, overwrite: bool, error: type[FlybenchError]) -> None:
    """Check that a file does not exist yet, or may be overwritten.

    Raises:
        FlybenchError: of class `error`, if it exists and may not be overwritten, or is a mount
            point, which cannot be replaced.
    """
    if os.path.ismount(path):
        raise error(f"{path} is a mount point, which cannot be replaced. Choose another name.")
    if not overwrite and os.path.lexists(path):
        raise error(
            f"{path} exists already. Allowed is a new file. Choose another name, or give "
            "--overwrite to replace it."
        )


def free_name(path: Path) -> Path:
    """Return the first path that does not exist: NAME_2, NAME_3, and so on."""
    number = 2
    while os.path.lexists(free := path.with_stem(f"{path.stem}_{number}")):
        number += 1
    return free


def _restore(folder: Path) -> None:
    """Move an earlier output back, if its process was killed before the new one took its place."""
    target = folder.with_name(folder.name.removesuffix(SUFFIX))
    if (folder / OLD).exists() and not os.path.lexists(target):
        (folder / OLD).rename(target)


def _remove(folder: Path, *names: str) -> None:
    for name in names:
        shutil.rmtree(folder / name, ignore_errors=True)


def _remove_locked(folder: Path) -> None:
    """Remove a folder that holds nothing but its lock, which this process has."""
    with suppress(OSError):
        (folder / LOCK).unlink()
        folder.rmdir()
