"""Colour pictures of a crossing, and that they are kept with its light."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from sim import Crossing, CrossingConfig, LuminanceCache, preview_jpegs
from sim import preview as preview_module

TIMES_US = (0, 400_000)


def test_pictures_are_drawn_once_and_then_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    crossing = Crossing(CrossingConfig(), cache=LuminanceCache(tmp_path))
    drawn = preview_jpegs(crossing, TIMES_US)
    images = [cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) for jpeg in drawn]
    assert [image.shape for image in images if image is not None] == [(390, 519, 3)] * 2
    assert drawn[0] != drawn[1]

    def never(_: Crossing) -> None:
        raise AssertionError("drawn")

    monkeypatch.setattr(preview_module, "Preview", never)
    again = Crossing(CrossingConfig(), cache=LuminanceCache(tmp_path))
    assert preview_jpegs(again, TIMES_US) == drawn
    with pytest.raises(AssertionError, match="drawn"):
        preview_jpegs(again, TIMES_US[:1])
    with pytest.raises(AssertionError, match="drawn"):
        preview_jpegs(Crossing(CrossingConfig()), TIMES_US)
