"""The key of a finished point."""

from dataclasses import replace
from pathlib import Path

import pytest

from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep import point_key as module
from scenarios.sweep.point_key import point_key


def test_another_run_or_other_code_has_another_key(monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunConfig()
    assert point_key(run) == point_key(RunConfig())
    assert point_key(replace(run, seed=1)) != point_key(run)
    before = point_key(run)
    monkeypatch.setattr(module, "code_digest", lambda: "another")
    assert point_key(run) != before


@pytest.mark.parametrize("method", ["edited_detector:Mine", "stcf+edited_detector:Mine"])
def test_an_edited_user_detector_has_another_key(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "edited_detector.py").write_text("class Mine: ...")
    run = RunConfig(method=method)
    module.method_digest.cache_clear()
    before = point_key(run)
    (tmp_path / "edited_detector.py").write_text("class Mine: pass")
    module.method_digest.cache_clear()
    assert point_key(run) != before
    module.method_digest.cache_clear()
