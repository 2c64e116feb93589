"""Colour previews of a crossing, which are cached beside its luminance."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from sim import (
    Crossing,
    CrossingConfig,
    Distractors,
    Lighting,
    LuminanceCache,
    RelativeDirection,
    preview_jpegs,
)
from sim import preview as preview_module
from sim.distractors import Pavement
from sim.geometry.pinhole import Pose
from sim.geometry.rectangles import Rectangle
from sim.preview import Preview
from sim.render.filament import FilamentRenderer

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


OTHERS = Distractors(
    wind_grade=6,
    far_vehicle=RelativeDirection.OPPOSITE,
    pedestrian=RelativeDirection.SAME,
    pedestrian_pavement=Pavement.NEAR,
)


@pytest.mark.parametrize(
    ("lighting", "distractors"),
    [
        (Lighting.DAY, Distractors()),
        (Lighting.NIGHT, Distractors()),
        (Lighting.NIGHT, Distractors(shake_rms_deg=0.5)),
        (Lighting.DUSK, OTHERS),
    ],
)
def test_an_image_does_not_depend_on_those_before(
    lighting: Lighting, distractors: Distractors
) -> None:
    crossing = Crossing(CrossingConfig(lighting=lighting, distractors=distractors))
    times_us = [0, 600_000, 900_000, 0]
    with Preview(crossing) as preview:
        images = [preview.render(t_us) for t_us in times_us]
    for t_us, image in zip(times_us, images, strict=True):
        with Preview(crossing) as preview:
            alone = preview.render(t_us)
        # The renderer dithers, and jitters edges by a fraction of a pixel.
        differs = np.abs(image.astype(int) - alone).max(axis=2) > 3
        assert differs.mean() < 0.02
        assert cv2.boxFilter(differs.astype(np.float32), -1, (15, 15)).max() < 0.6


def test_only_what_moves_is_rendered_again(monkeypatch: pytest.MonkeyPatch) -> None:
    areas = []
    whole = FilamentRenderer.preview

    def noting(self: FilamentRenderer, pose: Pose, area: Rectangle, scale: float) -> Any:
        areas.append(area)
        return whole(self, pose, area, scale)

    monkeypatch.setattr(FilamentRenderer, "preview", noting)
    crossing = Crossing(CrossingConfig())
    middle_us = crossing.duration_us // 2
    with Preview(crossing) as preview:
        for t_us in (0, middle_us, crossing.duration_us, crossing.duration_us):
            preview.render(t_us)
        preview.render(middle_us, scale=1.0)
    assert areas[0] == (0, 0, 519, 390)
    x0, y0, x1, y1 = areas[1]
    assert 0 < x0 < x1 < 519
    assert 150 < y0 < y1 < 300
    assert areas[2] == areas[1]  # the vehicle is gone
    assert areas[3:] == [(0, 0, 346, 260)]  # another size; before it, nothing had moved
