"""Colour previews of a crossing, which are cached beside its luminance."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from sim import Crossing, CrossingConfig, LuminanceCache, preview_jpegs
from sim import preview as preview_module

TIMES_US = (0, 400_000)


def test_previews_are_rendered_once_and_then_read_from_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    crossing = Crossing(CrossingConfig(), cache=LuminanceCache(tmp_path))
    jpegs = preview_jpegs(crossing, TIMES_US)
    images = [cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) for jpeg in jpegs]
    assert [image.shape for image in images if image is not None] == [(390, 519, 3)] * 2
    assert jpegs[0] != jpegs[1]

    def refuse(_: Crossing) -> None:
        raise AssertionError("rendered")

    monkeypatch.setattr(preview_module, "Preview", refuse)
    again = Crossing(CrossingConfig(), cache=LuminanceCache(tmp_path))
    assert preview_jpegs(again, TIMES_US) == jpegs
    with pytest.raises(AssertionError, match="rendered"):
        preview_jpegs(again, TIMES_US[:1])
    with pytest.raises(AssertionError, match="rendered"):
        preview_jpegs(Crossing(CrossingConfig()), TIMES_US)
