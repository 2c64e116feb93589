"""Files that Rerun writes through a pipe."""

import errno
import fcntl
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from scenarios.recording.piped_file import PipedFile

BLOCK = bytes(range(256)) * 1000


@contextmanager
def no_file_beyond(size: int) -> Iterator[None]:
    """Make writing fail, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


def write(file: PipedFile, times: int) -> None:
    with file.entry.open("wb") as entry:
        file.opened()
        for _ in range(times):
            entry.write(BLOCK)


def test_everything_arrives_in_the_file(tmp_path: Path) -> None:
    file = PipedFile(tmp_path / "a.rrd")
    write(file, 20)
    file.close()
    file.check()
    assert (tmp_path / "a.rrd").read_bytes() == BLOCK * 20


def test_the_writer_never_fails_and_the_error_comes_at_the_end(tmp_path: Path) -> None:
    with no_file_beyond(300_000):
        file = PipedFile(tmp_path / "a.rrd")
        write(file, 20)
        with pytest.raises(OSError, match="File too large") as raised:
            file.close()
    assert raised.value.errno == errno.EFBIG
    with pytest.raises(OSError, match="File too large"):
        file.check()


@pytest.mark.parametrize("limit", ["refused", "missing"])
def test_a_pipe_of_the_usual_size_will_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    if limit == "refused":
        monkeypatch.setattr(fcntl, "fcntl", refuse)
    else:
        monkeypatch.delattr(fcntl, "F_SETPIPE_SZ")
    file = PipedFile(tmp_path / "a")
    write(file, times=3)
    file.close()
    assert (tmp_path / "a").read_bytes() == BLOCK * 3
