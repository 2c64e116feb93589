"""Atomic output folders."""

import json
from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.output.atomic_folder import (
    GENERATOR,
    atomic_folder,
    check_output_folder,
    write_summary,
)


def test_the_folder_appears_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with atomic_folder(out) as work:
        (work / "a").write_text("1")
        assert not out.exists()
    assert (out / "a").read_text() == "1"
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_an_error_keeps_the_old_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))

    def fail() -> None:
        with atomic_folder(out) as work:
            (work / "half").write_text("1")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert [path.name for path in out.iterdir()] == ["summary.json"]


@pytest.mark.parametrize("summary", [None, "{}", "[]", "not json", '{"generator": "other"}'])
def test_a_folder_of_other_programs_is_refused(tmp_path: Path, summary: str | None) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "precious").write_text("1")
    if summary is not None:
        (out / "summary.json").write_text(summary)
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(out)


def test_an_empty_folder_may_be_used(tmp_path: Path) -> None:
    check_output_folder(tmp_path)


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("1")
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot be created"):
        check_output_folder(tmp_path / "file" / "out")


def test_the_current_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inside = tmp_path / "in"
    inside.mkdir()
    monkeypatch.chdir(inside)
    for folder in (Path(), inside, tmp_path):
        with pytest.raises(OutputError, match="contains the current folder"):
            check_output_folder(folder)


def test_a_link_to_a_folder_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with atomic_folder(tmp_path / "link") as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "summary.json").exists()


def test_files_listed_in_the_summary_may_be_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        (work / "map.png").write_text("1")
        write_summary(work, {"command": "envelope"})
    check_output_folder(out)
    summary = json.loads((out / "summary.json").read_text())
    assert summary == {
        "generator": GENERATOR,
        "command": "envelope",
        "files": ["map.png", "summary.json"],
    }
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(out)


def test_an_earlier_run_with_added_files_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))
    check_output_folder(out)
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(out)
