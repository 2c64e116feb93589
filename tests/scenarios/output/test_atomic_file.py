"""Atomic files."""

from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.output.atomic_file import atomic_file, check_output_file


def test_the_file_appears_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with atomic_file(path) as work:
        assert work.suffix == ".png"
        work.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with pytest.raises(FileNotFoundError), atomic_file(path) as work:
        (work.parent / "no" / "half").touch()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_invalid_paths_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"--plot .* is a folder. Give the name of a file"):
        check_output_file(tmp_path, "--plot")
    with pytest.raises(OutputError, match=r"--rrd .*a\.rrd cannot be written: .*no does not exist"):
        check_output_file(tmp_path / "no" / "a.rrd", "--rrd")
    with pytest.raises(OutputError, match="cannot be written"), atomic_file(tmp_path / "no" / "a"):
        pass
