"""Which sources determine a result."""

import ast
from pathlib import Path

import pytest

from flybench import sources
from flybench.sources import LUMINANCE_SOURCES, ROOT, SWEEP_POINT_SOURCES, sources_digest

PACKAGES = {"flybench", "sim", "emulator", "detector", "formats", "scenarios"}
NO_RESULT = ("scenarios/errors.py", "scenarios/output", "scenarios/sweep/point_key.py")
"""What measuring imports, and no result depends on."""


def imported_files(start: Path) -> set[Path]:
    """Every file of the project that a file imports, however indirectly."""
    found: set[Path] = set()
    waiting = [start]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found.add(path)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
                waiting += [p for name in names for p in files_of(name)]
    return found


def files_of(module: str) -> list[Path]:
    if module.split(".")[0] not in PACKAGES:
        return []
    path = ROOT / module.replace(".", "/")
    return [p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file()]


def covered(path: Path, parts: tuple[str, ...]) -> bool:
    return any(path.is_relative_to(ROOT / part) for part in parts)


@pytest.mark.parametrize(
    ("start", "parts"),
    [
        ("sim/crossing.py", LUMINANCE_SOURCES),
        ("scenarios/sweep/measure.py", (*SWEEP_POINT_SOURCES, *NO_RESULT)),
    ],
)
def test_the_parts_cover_every_import(start: str, parts: tuple[str, ...]) -> None:
    files = imported_files(ROOT / start)
    files = {path for path in files if path.name != "__init__.py"}
    assert len(files) > 30
    assert [path for path in files if not covered(path, parts)] == []


def test_any_edit_at_any_depth_changes_the_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    deep, asset = tmp_path / "room" / "a" / "b", tmp_path / "room" / "assets"
    deep.mkdir(parents=True)
    asset.mkdir()
    digests = []

    def note() -> None:
        sources_digest.cache_clear()
        digests.append(sources_digest("room"))

    (deep / "one.py").write_text("a = 1")
    note()
    (deep / "one.py").write_text("a = 2")
    note()
    (deep / "one.py").rename(deep / "two.py")
    note()
    (asset / "sedan.xml").write_text("<mujoco/>")
    note()
    assert len(set(digests)) == 4
    (deep / "notes.md").write_text("words")
    note()
    assert digests[-1] == digests[-2]
    sources_digest.cache_clear()
