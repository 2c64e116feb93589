"""The journal of finished points."""

import os
import resource
import signal
from pathlib import Path

import pytest

from scenarios.errors import OutputError
from scenarios.sweep.journal import Journal

POINTS = {f"key {n}": {"detector.accuracy": n / 7, "detector.latency_ms": None} for n in range(3)}


def test_a_journal_truncated_anywhere_holds_the_points_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "fsync", lambda _descriptor: None)  # a thousand calls would be slow
    path = tmp_path / "points.jsonl"
    with Journal(path) as journal:
        for item in POINTS.items():
            journal.add([item])
    content = path.read_bytes()
    for end in range(len(content) + 1):
        path.write_bytes(content[:end])
        known = dict(list(POINTS.items())[: content[:end].count(b"\n")])
        with Journal(path) as journal:
            assert journal.done == known
            journal.add(POINTS.items())
        assert path.read_bytes() == content


def test_a_damaged_line_is_ignored(tmp_path: Path) -> None:
    path = tmp_path / "points.jsonl"
    with Journal(path) as journal:
        journal.add(POINTS.items())
    content = path.read_bytes()
    for at in range(content.index(b"\n")):
        path.write_bytes(content[:at] + b"#" + content[at + 1 :])
        if path.read_bytes() != content:
            assert Journal.read(path) == {k: v for k, v in POINTS.items() if k != "key 0"}


def test_a_point_is_written_once(tmp_path: Path) -> None:
    with Journal(tmp_path / "points.jsonl") as journal:
        journal.add(POINTS.items())
        journal.add(POINTS.items())
    assert (tmp_path / "points.jsonl").read_bytes().count(b"\n") == 3


def test_a_file_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"cannot be written .*choose another folder with --out"):
        Journal(tmp_path)


def test_a_full_disk_keeps_the_points_before(tmp_path: Path) -> None:
    path = tmp_path / "points.jsonl"
    with Journal(path) as journal:
        journal.add([("a", {"value": 1})])
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size + 10, hard))

    def add() -> None:
        with Journal(path) as journal:
            journal.add([("b", {"value": 2})])

    try:
        with pytest.raises(OutputError, match=r"points\.jsonl cannot be written \(File too large"):
            add()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    with Journal(path) as journal:
        assert journal.done == {"a": {"value": 1}}
