"""A file is whole or absent."""

from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.output.whole_file import check_place, whole_file


def test_it_is_there_when_nothing_failed(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with whole_file(path) as work:
        assert work.suffix == ".png"
        work.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_what_was_there_stays_when_something_failed(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("old")
    with pytest.raises(FileNotFoundError), whole_file(path) as work:
        (work.parent / "no" / "half").touch()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_places_where_nothing_can_be_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"--plot .* is a folder; give the name of a file"):
        check_place(tmp_path, "--plot")
    with pytest.raises(OutputError, match=r"--rrd .*a\.rrd has no folder to lie in; make .*no"):
        check_place(tmp_path / "no" / "a.rrd", "--rrd")
    with pytest.raises(OutputError, match="cannot be written"), whole_file(tmp_path / "no" / "a"):
        pass
