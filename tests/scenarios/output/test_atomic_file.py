"""Atomic files."""

from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.output.atomic_file import atomic_file, check_output_file


def test_the_file_appears_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with atomic_file(path, overwrite=True) as work:
        assert work.suffix == ".png"
        work.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with pytest.raises(FileNotFoundError), atomic_file(path, overwrite=True) as work:
        (work.parent / "no" / "half").touch()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_invalid_paths_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"--plot .* is a folder. Give the name of a file"):
        check_output_file(tmp_path, "--plot", overwrite=True)
    with pytest.raises(OutputError, match=r"--rrd .*a\.rrd cannot be written: .*no does not exist"):
        check_output_file(tmp_path / "no" / "a.rrd", "--rrd", overwrite=True)
    with (
        pytest.raises(OutputError, match="cannot be written"),
        atomic_file(tmp_path / "no" / "a", overwrite=True),
    ):
        pass


def test_an_existing_file_is_kept_unless_it_may_be_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "mine.png"
    path.write_text("mine")
    check_output_file(path, "--plot", overwrite=True)
    with pytest.raises(OutputError, match=r"mine\.png exists already\. .* or give --overwrite"):
        check_output_file(path, "--plot", overwrite=False)


def test_a_file_that_comes_meanwhile_is_kept_and_so_is_the_output(tmp_path: Path) -> None:
    path = tmp_path / "a.png"

    def write() -> None:
        with atomic_file(path, overwrite=False) as work:
            work.write_text("ours")
            path.write_text("mine")

    with pytest.raises(OutputError, match=r"created by another program .* in a_2\.png beside it"):
        write()
    assert path.read_text() == "mine"
    assert (tmp_path / "a_2.png").read_text() == "ours"
    assert len(list(tmp_path.iterdir())) == 2


def test_a_file_to_read_is_no_output_under_any_name(tmp_path: Path) -> None:
    source, folder = tmp_path / "a.png", tmp_path / "in"
    source.touch()
    folder.mkdir()
    (tmp_path / "link.png").symlink_to(source)
    for path in (source, folder / ".." / "a.png", tmp_path / "link.png"):
        with pytest.raises(OutputError, match="which is a file to read"):
            check_output_file(path, "--plot", overwrite=True, sources=(source,))
    check_output_file(tmp_path / "b.png", "--plot", overwrite=True, sources=(source,))
