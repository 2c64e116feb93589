"""Atomic output folders."""

import errno
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
        write_summary(work, {})

    def fail() -> None:
        with atomic_folder(out) as work:
            (work / "half").write_text("1")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert [path.name for path in out.iterdir()] == ["summary.json"]


@pytest.mark.parametrize(
    "summary", [None, "{}", "[]", "not json", "[" * 100_000, '{"generator": "other"}']
)
def test_a_folder_of_other_programs_is_refused(tmp_path: Path, summary: str | None) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "precious").write_text("1")
    if summary is not None:
        (out / "summary.json").write_text(summary)
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(out, needed_bytes=0)


def test_an_empty_folder_may_be_used(tmp_path: Path) -> None:
    check_output_folder(tmp_path, needed_bytes=0)


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("1")
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(tmp_path / "file", needed_bytes=0)
    with pytest.raises(OutputError, match="cannot be created"):
        check_output_folder(tmp_path / "file" / "out", needed_bytes=0)


def test_the_current_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inside = tmp_path / "in"
    inside.mkdir()
    monkeypatch.chdir(inside)
    for folder in (Path(), inside, tmp_path):
        with pytest.raises(OutputError, match="contains the current folder"):
            check_output_folder(folder, needed_bytes=0)


def test_a_link_to_a_folder_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with atomic_folder(tmp_path / "link") as work:
        write_summary(work, {})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "summary.json").exists()


def test_files_listed_in_the_summary_may_be_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        (work / "map.png").write_text("1")
        write_summary(work, {"command": "envelope"})
    check_output_folder(out, needed_bytes=0)
    summary = json.loads((out / "summary.json").read_text())
    assert summary == {
        "generator": GENERATOR,
        "command": "envelope",
        "files": ["map.png", "summary.json"],
    }
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="were not written by flybench"):
        check_output_folder(out, needed_bytes=0)


@pytest.mark.parametrize("added", ["notes.txt", "figures/thesis_fig.py", "figures/deep/link"])
def test_files_of_others_are_refused_at_any_depth(tmp_path: Path, added: str) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        (work / "figures").mkdir()
        (work / "figures" / "ours.svg").touch()
        write_summary(work, {"command": "study"})
    check_output_folder(out, needed_bytes=0)
    (out / added).parent.mkdir(exist_ok=True)
    (out / added).symlink_to(tmp_path)
    with pytest.raises(OutputError, match=f"were not written by flybench: {added}. Allowed"):
        check_output_folder(out, needed_bytes=0)
    with pytest.raises(OutputError, match=added), atomic_folder(out):
        pass
    assert (out / added).is_symlink()


def test_files_that_come_meanwhile_are_kept_and_so_is_the_output(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        write_summary(work, {"number": 1})

    def again() -> None:
        with atomic_folder(out) as work:
            write_summary(work, {"number": 2})
            (out / "mine.txt").write_text("mine")

    with pytest.raises(OutputError, match=r"got files meanwhile .*: mine\.txt\. .* in .*out_2\."):
        again()
    assert (out / "mine.txt").read_text() == "mine"
    assert json.loads((tmp_path / "out_2" / "summary.json").read_text())["number"] == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "out_2"]


def test_a_mount_point_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.path.ismount", lambda path: path == tmp_path)
    with pytest.raises(OutputError, match="is a mount point, which cannot be replaced"):
        check_output_folder(tmp_path, needed_bytes=0)
    check_output_folder(tmp_path / "in", needed_bytes=0)
    check_output_folder(tmp_path, needed_bytes=0, other_files=lambda _: [])  # written in place


@pytest.mark.parametrize("busy", ["out", "new"])
def test_the_output_is_kept_if_the_folder_cannot_be_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, busy: str
) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        write_summary(work, {"number": 1})
    rename = Path.rename

    def busy_rename(path: Path, target: Path) -> Path:
        if path.name == busy and target.name in ("out", "old"):
            raise OSError(errno.EBUSY, "Device or resource busy")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", busy_rename)

    def again() -> None:
        with atomic_folder(out) as work:
            write_summary(work, {"number": 2})

    with pytest.raises(OutputError, match=r"cannot be replaced \(Device .* in .*out_2\."):
        again()
    for name, number in (("out", 1), ("out_2", 2)):
        assert json.loads((tmp_path / name / "summary.json").read_text())["number"] == number
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "out_2"]


def test_a_second_writer_of_the_same_folder_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        with pytest.raises(OutputError, match="Another process is writing"), atomic_folder(out):
            pass
        write_summary(work, {})
    assert [path.name for path in out.iterdir()] == ["summary.json"]
    assert list(tmp_path.iterdir()) == [out]


def test_a_disk_without_room_is_refused_before_work(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"has .* MB free\. The output needs about 1,000,.* MB"):
        check_output_folder(tmp_path / "out", needed_bytes=10**18)


def test_a_full_disk_keeps_the_old_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with atomic_folder(out) as work:
        write_summary(work, {})

    def fill() -> None:
        with atomic_folder(out) as work:
            (work / "half").write_bytes(bytes(3_000_000))
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OutputError, match=rf"The disk of {out} is full\. 3\.0 MB were written"):
        fill()
    assert [path.name for path in out.iterdir()] == ["summary.json"]
    assert list(tmp_path.iterdir()) == [out]
