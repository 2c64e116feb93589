"""Samples from keyframes.

`tests/scenarios/commands/test_converge.py` compares them with full renderings, by their events.
"""

from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from sim import (
    Crossing,
    CrossingConfig,
    Distractors,
    Lighting,
    LuminanceCache,
    RelativeDirection,
)
from sim.errors import SceneConfigError
from sim.keyframes import renderings, reprojection
from sim.keyframes.background import background_of
from sim.keyframes.background_layers import BackgroundLight, render_light


def coarse_crossing(options: dict[str, Any]) -> Crossing:
    return Crossing(CrossingConfig(**{"step_px": 4.0, "max_step_ms": 20.0} | options))


def test_a_sample_hardly_depends_on_which_others_are_rendered() -> None:
    crossing = coarse_crossing({})
    middle = crossing.duration_us // 2
    few = [s.luminance for s in crossing.samples([0, middle, crossing.duration_us])]
    more = [s.luminance for s in crossing.samples([0, middle, middle + 1000, crossing.duration_us])]
    np.testing.assert_allclose(few[0], more[0], rtol=1e-5)
    assert np.abs(np.log(few[1] / more[1])).max() < 0.2


def test_equal_sequences_have_equal_bits() -> None:
    crossing = coarse_crossing({"lighting": Lighting.NIGHT})
    times_us = [0, crossing.duration_us // 2, crossing.duration_us]
    first = [s.luminance for s in crossing.samples(times_us)]
    repeated = coarse_crossing({"lighting": Lighting.NIGHT}).samples(times_us)
    second = [s.luminance for s in repeated]
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one, other)


def test_sequences_of_a_street_share_the_rendered_background(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With another paint and speed, the background comes from the cache: the same bits."""
    rendered: list[int] = []

    def counted(*args: Any, **options: Any) -> Any:
        rendered.append(1)
        return render_light(*args, **options)

    monkeypatch.setattr(renderings, "render_light", counted)
    night, other = {"lighting": Lighting.NIGHT}, {"omega_rad_s": 3.0, "paint_reflectance": 0.1}
    images = []
    for cached in (False, True):
        for options in ({}, other):
            cache = LuminanceCache(tmp_path) if cached else None
            crossing = Crossing(coarse_crossing(night | options).config, cache=cache)
            middle_us = crossing.duration_us // 2
            images.append([s.luminance for s in crossing.samples([middle_us])])
    assert len(rendered) == 3
    np.testing.assert_array_equal(images[0], images[2])
    np.testing.assert_array_equal(images[1], images[3])


@pytest.mark.parametrize("vehicle", ["van", "motorcycle"])
def test_the_background_does_not_depend_on_the_moving_objects(vehicle: str) -> None:
    def background(options: dict[str, Any]) -> bytes:
        crossing = coarse_crossing({"lighting": Lighting.NIGHT, "supersample": 1} | options)
        made: list[BackgroundLight] = []

        def keep(light: BackgroundLight, *args: Any) -> Any:
            made.append(light)
            return background_of(light, *args)

        middle_us = [crossing.duration_us // 2]
        with (
            patch.object(reprojection, "background_of", keep),
            crossing.keyframe_renderer(middle_us),
        ):
            return made[0].to_bytes()

    everything = [(0, 0, 346, 260)]
    with patch.object(reprojection, "plan_keyframes", lambda *_, **__: ({}, everything)):
        others = Distractors(pedestrian=RelativeDirection.SAME, far_vehicle=RelativeDirection.SAME)
        changed = background({"vehicle": vehicle, "distractors": others})
        assert changed == background({})


@pytest.mark.parametrize("times_us", [[], [5, 5], [7, 3], [-1, 4]])
def test_times_that_do_not_increase_are_refused(times_us: list[int]) -> None:
    with pytest.raises(SceneConfigError, match="not strictly increasing"):
        next(coarse_crossing({}).samples(times_us))


def test_an_object_that_is_never_in_view_adds_no_samples() -> None:
    unseen = Distractors(
        far_vehicle=RelativeDirection.SAME, far_vehicle_speed_m_s=40.0, far_vehicle_lag_s=60.0
    )
    alone, with_it = coarse_crossing({}), coarse_crossing({"distractors": unseen})
    assert len(with_it.times_us()) == len(alone.times_us())


def test_lamps_that_are_off_by_day_do_not_flicker() -> None:
    crossing = coarse_crossing({"distractors": Distractors(flicker_hz=100)})
    assert len(crossing.times_us()) == len(coarse_crossing({}).times_us())
