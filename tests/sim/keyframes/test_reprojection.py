"""Light from keyframes; how near it is to light drawn in full, `test_converge` tells by events."""

from typing import Any

import numpy as np
import pytest

from sim import Crossing, CrossingConfig, Distractors, Lighting, RelativeDirection
from sim.errors import SceneConfigError


def crossing(options: dict[str, Any]) -> Crossing:
    return Crossing(CrossingConfig(**{"step_px": 4.0, "max_step_ms": 20.0} | options))


def test_samples_do_not_depend_on_which_others_are_drawn() -> None:
    it = crossing({})
    middle = it.duration_us // 2
    alone = [s.luminance for s in it.samples([0, middle, it.duration_us])]
    among = [s.luminance for s in it.samples([0, middle, middle + 1000, it.duration_us])]
    np.testing.assert_allclose(alone[0], among[0], rtol=1e-5)
    assert np.abs(np.log(alone[1] / among[1])).max() < 0.2


def test_the_same_sequence_gives_the_same_bits() -> None:
    it = crossing({"lighting": Lighting.NIGHT})
    times_us = [0, it.duration_us // 2, it.duration_us]
    first = [s.luminance for s in it.samples(times_us)]
    second = [s.luminance for s in crossing({"lighting": Lighting.NIGHT}).samples(times_us)]
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("times_us", [[], [5, 5], [7, 3], [-1, 4]])
def test_times_that_do_not_rise_are_refused(times_us: list[int]) -> None:
    with pytest.raises(SceneConfigError, match="do not rise"):
        next(crossing({}).samples(times_us))


def test_what_is_never_seen_costs_no_samples() -> None:
    unseen = Distractors(
        far_vehicle=RelativeDirection.SAME, far_vehicle_speed_m_s=40.0, far_vehicle_lag_s=60.0
    )
    alone, with_it = crossing({}), crossing({"distractors": unseen})
    assert len(with_it.times_us()) == len(alone.times_us())


def test_lamps_that_are_off_by_day_do_not_flicker() -> None:
    it = crossing({"distractors": Distractors(flicker_hz=100)})
    assert len(it.times_us()) == len(crossing({}).times_us())
