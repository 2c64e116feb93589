import os
from pathlib import Path

import pytest

from flybench import files
from flybench.disk_space import caused_by_full_disk
from flybench.files import open_lock, open_regular, read_small_text


def test_a_regular_file_is_opened(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"content")
    with open_regular(path) as file:
        assert file.read() == b"content"


def test_what_would_block_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path / "fifo", Path("/dev/zero"), tmp_path):
        with pytest.raises(OSError, match="it is not a regular file"):
            open_regular(path)


def test_a_lock_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    for name in ("fifo", "new"):
        open_lock(tmp_path / name).close()
        assert (tmp_path / name).exists()


def test_a_text_that_is_too_long_is_no_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "TEXT_MAX_BYTES", 10)
    (tmp_path / "a").write_text("a" * 11)
    with pytest.raises(OSError, match="it has more than 10 bytes") as raised:
        read_small_text(tmp_path / "a")
    assert not caused_by_full_disk(raised.value)
