"""What a finished point's key stands for."""

from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep import code
from scenarios.sweep.code import point_key


def test_a_key_tells_runs_and_code_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunConfig()
    assert point_key(run) == point_key(RunConfig())
    assert point_key(replace(run, seed=1)) != point_key(run)
    before = point_key(run)
    monkeypatch.setattr(code, "code_digest", lambda: "another")
    assert point_key(run) != before


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
