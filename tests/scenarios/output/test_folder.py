import json
from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.output.folder import GENERATOR, check_output, whole_folder, write_summary


def test_a_folder_appears_whole(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with whole_folder(out) as work:
        (work / "a").write_text("1")
        assert not out.exists()
    assert (out / "a").read_text() == "1"
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_a_failure_leaves_nothing_of_it_and_what_was_there_before(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with whole_folder(out) as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))

    def fail() -> None:
        with whole_folder(out) as work:
            (work / "half").write_text("1")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert [path.name for path in out.iterdir()] == ["summary.json"]


@pytest.mark.parametrize("summary", [None, "{}", "[]", "not json", '{"generator": "other"}'])
def test_somebody_elses_folder_is_refused(tmp_path: Path, summary: str | None) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "precious").write_text("1")
    if summary is not None:
        (out / "summary.json").write_text(summary)
    with pytest.raises(OutputError, match="was not written by flybench"):
        check_output(out)


def test_an_empty_folder_may_be_used(tmp_path: Path) -> None:
    check_output(tmp_path)


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("1")
    with pytest.raises(OutputError, match="was not written by flybench"):
        check_output(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot be made"):
        check_output(tmp_path / "file" / "out")


def test_the_folder_that_one_is_in_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = tmp_path / "in"
    inside.mkdir()
    monkeypatch.chdir(inside)
    for folder in (Path(), inside, tmp_path):
        with pytest.raises(OutputError, match="you are in"):
            check_output(folder)


def test_a_link_to_a_folder_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with whole_folder(tmp_path / "link") as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "summary.json").exists()


def test_what_a_command_lists_in_its_summary_is_its_own(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with whole_folder(out) as work:
        (work / "map.png").write_text("1")
        write_summary(work, {"command": "envelope"})
    check_output(out)
    summary = json.loads((out / "summary.json").read_text())
    assert summary == {
        "generator": GENERATOR,
        "command": "envelope",
        "files": ["map.png", "summary.json"],
    }
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="was not written by flybench"):
        check_output(out)


def test_an_earlier_run_with_something_added_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with whole_folder(out) as work:
        (work / "summary.json").write_text(json.dumps({"generator": GENERATOR}))
    check_output(out)
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="was not written by flybench"):
        check_output(out)
