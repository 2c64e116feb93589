"""Light from keyframes against light drawn in full, near keyframes; events tell of all else."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from sim import Crossing, CrossingConfig, Direction, Distractors, Lighting, VehicleKind, Way
from sim.distractors import Pavement
from sim.errors import SceneConfigError

SCENES: dict[str, dict[str, Any]] = {
    "day": {},
    "dusk": {"lighting": Lighting.DUSK, "vehicle": VehicleKind.VAN},
    "night": {"lighting": Lighting.NIGHT},
    "night_left_motorcycle": {
        "lighting": Lighting.NIGHT,
        "direction": Direction.LEFT,
        "vehicle": VehicleKind.MOTORCYCLE,
    },
    "up": {"direction": Direction.UP},
    "far_vehicle_and_pedestrian": {
        "distractors": Distractors(
            far_vehicle=Way.OPPOSITE, pedestrian=Way.SAME, pedestrian_pavement=Pavement.NEAR
        )
    },
    "wind": {"distractors": Distractors(wind_grade=5)},
    "shake": {"distractors": Distractors(shake_rms_deg=0.2)},
    "wind_at_night": {"lighting": Lighting.NIGHT, "distractors": Distractors(wind_grade=5)},
    "flicker": {
        "lighting": Lighting.NIGHT,
        "distractors": Distractors(flicker_hz=100, flicker_depth=0.5),
    },
}
TIMES = (0.35, 0.503)
"""Of the sequence's length."""


def crossing(options: dict[str, Any]) -> Crossing:
    return Crossing(CrossingConfig(**{"step_px": 4.0, "max_step_ms": 20.0} | options))


def drawn_in_full(
    it: Crossing, times_us: list[int], supersample: int
) -> list[npt.NDArray[np.float32]]:
    with it.full_frames(supersample) as draw:
        return [draw(t_us) for t_us in times_us]


def error(light: npt.NDArray[np.float32], reference: npt.NDArray[np.float32]) -> float:
    """Root mean square difference of ln(light), over the pixels that any scene changes most."""
    floor = np.float32(1e-3 * np.median(reference))
    difference = np.log(light + floor) - np.log(reference + floor)
    return float(np.sqrt((difference**2).mean()))


@pytest.mark.parametrize("name", SCENES)
def test_samples_are_nearer_to_fine_drawings_than_2x2_drawings_are(name: str) -> None:
    it = crossing(SCENES[name])
    times_us = [int(share * it.duration_us) for share in TIMES]
    fine = drawn_in_full(it, times_us, 4)
    coarse = drawn_in_full(it, times_us, 2)
    samples = [s.luminance for s in it.samples(times_us)]
    for light, rough, reference in zip(samples, coarse, fine, strict=True):
        assert error(light, reference) < 0.85 * error(rough, reference)


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
    unseen = Distractors(far_vehicle=Way.SAME, far_vehicle_speed_m_s=40.0, far_vehicle_lag_s=60.0)
    alone, with_it = crossing({}), crossing({"distractors": unseen})
    assert len(with_it.times_us()) == len(alone.times_us())


def test_lamps_that_are_off_by_day_do_not_flicker() -> None:
    it = crossing({"distractors": Distractors(flicker_hz=100)})
    assert len(it.times_us()) == len(crossing({}).times_us())
