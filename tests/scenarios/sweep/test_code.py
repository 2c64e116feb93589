"""What a finished point's key stands for."""

import ast
from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.config import RunConfig
from scenarios.sweep import code
from scenarios.sweep.code import MEASURING, code_digest, point_key

ROOT = Path(__file__).parents[3]
NO_RESULT = {
    *("errors", "light_options", "output", "terminal"),
    *("sweep", "sweep.code"),
}
"""Modules of scenarios that measuring imports, and on which no result depends."""


def imported(name: str) -> set[str]:
    """Modules of scenarios that one imports, by their names below it."""
    path = ROOT / "scenarios" / name.replace(".", "/")
    tree = ast.parse(path.with_suffix(".py").read_text(encoding="utf-8"))
    froms = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {m.removeprefix("scenarios.") for m in froms if m.startswith("scenarios.")}


def test_all_that_measuring_imports_is_in_the_digest() -> None:
    found = {name for module in MEASURING for name in imported(module)}
    assert found - set(MEASURING) - NO_RESULT == set()
    assert all((ROOT / "scenarios" / f"{m.replace('.', '/')}.py").is_file() for m in MEASURING)


def test_a_key_tells_runs_and_code_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunConfig()
    assert point_key(run) == point_key(RunConfig())
    assert point_key(replace(run, seed=1)) != point_key(run)
    before = point_key(run)
    monkeypatch.setattr(code, "code_digest", lambda: "another")
    assert point_key(run) != before


def test_an_edited_file_is_other_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(code, "_ROOT", tmp_path)
    for name in MEASURING:
        path = tmp_path / "scenarios" / f"{name.replace('.', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    fresh = code_digest.__wrapped__
    before = fresh()
    (tmp_path / "sim" / "assets").mkdir(parents=True)
    (tmp_path / "sim" / "assets" / "sedan.xml").write_text("<mujoco/>")
    with_asset = fresh()
    (tmp_path / "sim" / "notes.md").write_text("words")
    assert before != with_asset == fresh()
    (tmp_path / "scenarios" / "judgement.py").write_text("# edited")
    assert fresh() != with_asset


def test_an_edited_detector_of_ones_own_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "own_bee.py").write_text("class Bee: ...")
    run = RunConfig(method="own_bee:Bee")
    code._method_digest.cache_clear()
    before = point_key(run)
    (tmp_path / "own_bee.py").write_text("class Bee: pass")
    code._method_digest.cache_clear()
    assert point_key(run) != before
