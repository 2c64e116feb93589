"""Output that is being written."""

import errno
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from flybench.errors import FlybenchError
from flybench.unfinished import (
    LOCK,
    UnfinishedOutput,
    check_new_file,
    free_name,
    remove_abandoned,
)

KILLED = """
import os, signal, sys
from pathlib import Path
from typing import Any
from flybench.errors import FlybenchError
from flybench.unfinished import UnfinishedOutput
output = UnfinishedOutput(Path(sys.argv[1]), FlybenchError)
(output.new / "half").write_text("half")
for action in sys.argv[2:]:
    if action == "aside":
        output.target.rename(output.old)
    if action == "part":
        output.finished.mkdir()
        (output.finished / "part").write_text("whole")
os.kill(os.getpid(), signal.SIGKILL)
"""


def killed(target: Path, *actions: str) -> None:
    """Let a process be killed while it writes an output."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(target), *actions], check=False)
    assert done.returncode == -signal.SIGKILL
    assert target.with_name(f"{target.name}.unfinished").is_dir()


def test_what_a_killed_process_left_is_removed_by_the_next_one(tmp_path: Path) -> None:
    killed(tmp_path / "a")
    with UnfinishedOutput(tmp_path / "b", FlybenchError):
        assert [path.name for path in tmp_path.iterdir()] == ["b.unfinished"]
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_was_moved_aside_is_restored(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "precious").touch()
    killed(tmp_path / "a", "aside")
    remove_abandoned(tmp_path)
    assert (tmp_path / "a" / "precious").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_finished_parts_stay_until_the_output_is_complete(tmp_path: Path) -> None:
    killed(tmp_path / "a", "part")
    remove_abandoned(tmp_path)

    def fail() -> None:
        with UnfinishedOutput(tmp_path / "a", FlybenchError) as output:
            assert list(output.new.iterdir()) == []
            assert (output.finished / "part").read_text() == "whole"
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    with UnfinishedOutput(tmp_path / "a", FlybenchError) as output:
        assert (output.finished / "part").read_text() == "whole"
    assert list(tmp_path.iterdir()) == []


def test_the_output_of_a_living_process_is_left_alone(tmp_path: Path) -> None:
    with UnfinishedOutput(tmp_path / "a", FlybenchError) as output:
        remove_abandoned(tmp_path)
        assert output.new.is_dir()
        with pytest.raises(FlybenchError, match=r"Another process is writing .*a\. Allowed"):
            UnfinishedOutput(tmp_path / "a", FlybenchError)


def test_a_folder_of_the_user_is_neither_used_nor_removed(tmp_path: Path) -> None:
    mine = tmp_path / "a.unfinished"
    mine.mkdir()
    for name in (LOCK, "notes.txt"):
        (mine / name).touch()
    remove_abandoned(tmp_path)
    with pytest.raises(FlybenchError, match="was not made by flybench"):
        UnfinishedOutput(tmp_path / "a", FlybenchError)
    assert (mine / "notes.txt").exists()


def test_a_place_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FlybenchError, match=r"cannot be written \(No such file or directory\)"):
        UnfinishedOutput(tmp_path / "no" / "a", FlybenchError)
    with pytest.raises(FlybenchError, match="File name too long"):
        UnfinishedOutput(tmp_path / ("a" * 250), FlybenchError)


def test_nothing_is_left_if_the_folder_cannot_be_prepared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Path.mkdir

    def mkdir(path: Path, **options: Any) -> None:
        if path.name == "new":
            raise OSError(errno.ENOSPC, "No space left on device")
        make(path, **options)

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with pytest.raises(FlybenchError, match="No space left on device"):
        UnfinishedOutput(tmp_path / "a", FlybenchError)
    assert list(tmp_path.iterdir()) == []


def test_a_free_name_is_numbered(tmp_path: Path) -> None:
    (tmp_path / "a_2.csv").touch()
    (tmp_path / "a_3.csv").symlink_to("nowhere")
    assert free_name(tmp_path / "a.csv") == tmp_path / "a_4.csv"


def test_a_mount_point_is_no_output_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.path.ismount", lambda path: path == tmp_path / "a")
    with pytest.raises(FlybenchError, match="is a mount point, which cannot be replaced"):
        check_new_file(tmp_path / "a", overwrite=True, error=FlybenchError)
    check_new_file(tmp_path / "b", overwrite=True, error=FlybenchError)


def test_a_file_that_cannot_take_its_place_is_kept_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def replace(_: Path, target: Path) -> None:
        raise OSError(errno.EBUSY, "Device or resource busy", target)

    monkeypatch.setattr(Path, "replace", replace)
    (tmp_path / "a.csv").write_text("old")

    def write() -> None:
        with UnfinishedOutput(tmp_path / "a.csv", FlybenchError) as output:
            (output.new / "a.csv").write_text("new")
            output.publish_file(overwrite=True)

    with pytest.raises(FlybenchError, match=r"replaced \(Device .* is in a_2\.csv beside it"):
        write()
    assert (tmp_path / "a.csv").read_text() == "old"
    assert (tmp_path / "a_2.csv").read_text() == "new"
