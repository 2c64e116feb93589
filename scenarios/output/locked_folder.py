"""A folder that one process at a time works in, and that keeps what was finished."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from flybench.unfinished import lock_file
from scenarios.errors import OutputError


@contextmanager
def locked_folder(folder: Path, lock_name: str, work: str) -> Iterator[Path]:
    """Create or reopen a folder, and lock it for this process.

    Args:
        folder: the folder; the caller has checked what is in it.
        lock_name: name of the lock file in it.
        work: what a process does in it, for the message, such as "running the sweep".

    Yields:
        The folder.

    Raises:
        OutputError: another process uses the folder, or it cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = lock_file(folder / lock_name)
    except BlockingIOError:
        raise OutputError(
            f"Another process is {work} in {folder}. Allowed is one process at a time. Wait for it "
            "to end, or choose another folder with --out."
        ) from None
    except OSError as error:
        raise OutputError(
            f"The output folder {folder} cannot be created ({error.strerror}). Choose another "
            "folder with --out."
        ) from error
    with lock:
        yield folder
