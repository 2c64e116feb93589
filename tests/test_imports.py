"""The structure: sim → emulator → detector → scenarios, formats beside; one owner a library."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ROOMS = ("sim", "emulator", "detector", "formats", "scenarios")
SHARED = {"emulator.events", "emulator.errors"}
"""What a detector may take from the emulator: the events, and what is wrong with them."""


def imports(room: str) -> Iterator[tuple[Path, str]]:
    for path in sorted((ROOT / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                yield from ((path, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                yield path, node.module


@pytest.mark.parametrize(("library", "owner"), [("mujoco", "sim"), ("rerun", "scenarios")])
def test_only_one_room_imports_a_heavy_library(library: str, owner: str) -> None:
    users = {room for room in ROOMS for _, name in imports(room) if name.split(".")[0] == library}
    assert users == {owner}


@pytest.mark.parametrize(
    ("room", "others"),
    [
        ("kernels", {"sim", "emulator", "detector", "formats", "scenarios"}),
        ("sim", {"emulator", "detector", "formats", "scenarios"}),
        ("emulator", {"sim", "detector", "formats", "scenarios"}),
        ("detector", {"sim", "formats", "scenarios"}),
        ("formats", {"sim", "detector", "scenarios"}),
    ],
)
def test_arrows_point_one_way(room: str, others: set[str]) -> None:
    wrong = [(path.name, name) for path, name in imports(room) if name.split(".")[0] in others]
    assert wrong == []


def test_the_detector_knows_events_and_nothing_else_of_the_emulator() -> None:
    used = {name for _, name in imports("detector") if name.split(".")[0] == "emulator"}
    assert used <= SHARED


def test_files_know_events_and_frames_and_nothing_else_of_the_emulator() -> None:
    used = {name for _, name in imports("formats") if name.split(".")[0] == "emulator"}
    assert used <= SHARED | {"emulator"}  # ApsFrame is what the package itself gives


def test_what_parses_files_imports_nothing_of_the_bench() -> None:
    parsers = {ROOT / "formats" / f"{name}.py" for name in ("errors", "magic", "raw", "worker")}
    parsers |= set((ROOT / "formats" / "readers").glob("*.py"))
    used = {name.split(".")[0] for path, name in imports("formats") if path in parsers}
    assert not used & {"emulator", "detector", "sim", "scenarios"}
