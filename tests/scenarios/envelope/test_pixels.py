"""Event pixels against a calculation by hand."""

import numpy as np
import pytest

from emulator import SensorConfig
from flybench.events import Events
from scenarios.envelope.pixels import EDGE_CONTRAST, PixelArray, threshold_scale

WHOLE = (0, 0, 8, 6)
THETA = 0.2
STILL = np.zeros(2)
SENSOR = SensorConfig(theta_on=THETA, theta_off=THETA, theta_mismatch=0.0)


def array_of(
    texture: float, *, opacity: float = 1.0, background: float = 0.0, theta: float = THETA
) -> PixelArray:
    block = np.full((2, 3), texture, np.float32)
    made = PixelArray(
        np.full((10, 12), background, np.float32),
        [block],
        [np.full((2, 3), opacity, np.float32)],
        margin_px=2,
        sensor=SENSOR,
        scale=theta / THETA,
        rng=np.random.default_rng(0),
    )
    made.adapt(STILL, np.array([[-10.0, 1.0]]))
    return made


def show(array: PixelArray, x: float, y: float = 1.0, *, start_us: float = 0.0) -> Events:
    return array.step(STILL, np.array([[x, y]]), WHOLE, start_us=start_us, step_us=1000.0)


def test_a_brighter_layer_causes_one_on_event_per_threshold() -> None:
    events = show(array_of(1.01), 2.0)
    crossings = THETA * np.arange(1, 6)
    assert set(zip(events["x"].tolist(), events["y"].tolist(), strict=True)) == {
        (x, y) for x in (2, 3, 4) for y in (1, 2)
    }
    assert events["p"].all()
    one = events[(events["x"] == 3) & (events["y"] == 2)]
    np.testing.assert_allclose(one["t"], crossings / 1.01 * 1000, atol=1)


def test_a_darker_layer_causes_off_events() -> None:
    events = show(array_of(-0.5), 2.0)
    assert not events["p"].any()
    assert events.size == 6 * int(0.5 / THETA)


def test_changes_below_a_threshold_add_up() -> None:
    array = array_of(0.1)  # less than a threshold
    assert show(array, 2.0).size == 0
    assert show(array, 2.0).size == 0
    other = array_of(2.2 * THETA)
    assert show(other, 2.0).size == 2 * 6
    gone = show(other, -10.0, start_us=1000.0)  # 2 thresholds up, and 2 down
    assert gone.size == 2 * 6
    assert not gone["p"].any()
    assert (gone["t"] > 1000).all()


def test_a_layer_is_weighted_by_the_area_that_it_covers() -> None:
    array = array_of(1.0)
    show(array, 2.25)
    row = array._present[1]
    np.testing.assert_allclose(row[:7], [0, 0, 0.75, 1, 1, 0.25, 0], atol=1e-6)


def test_a_transparent_layer_shows_the_background() -> None:
    array = array_of(1.0, opacity=0.0, background=0.5)
    assert show(array, 2.0).size == 0
    np.testing.assert_allclose(array._present, 0.5)


def test_only_the_given_region_changes() -> None:
    events = array_of(1.0).step(
        STILL, np.array([[2.0, 1.0]]), (3, 1, 4, 2), start_us=0.0, step_us=1000.0
    )
    assert set(events["x"]) == {3}
    assert set(events["y"]) == {1}


def test_a_shifted_background_shifts_in_every_pixel() -> None:
    background = np.tile(np.arange(12, dtype=np.float32), (10, 1))
    array = PixelArray(background, [np.zeros((1, 1), np.float32)], [np.zeros((1, 1), np.float32)],
                    margin_px=2, sensor=SENSOR, rng=np.random.default_rng(0))  # fmt: skip
    array.adapt(STILL, np.array([[0.0, 0.0]]))
    np.testing.assert_allclose(array._present[0], np.arange(2, 10))
    array.step(np.array([-1.5, 0.0]), np.array([[0.0, 0.0]]), WHOLE, start_us=0, step_us=1000.0)
    np.testing.assert_allclose(array._present[3], np.arange(2, 10) + 1.5)


@pytest.mark.parametrize("number", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_edge_causes_the_given_number_of_events(number: int, sign: int) -> None:
    default = (SensorConfig().theta_on + SensorConfig().theta_off) / 2.0
    array = array_of(sign * EDGE_CONTRAST, theta=default * threshold_scale(number))
    assert show(array, 2.0).size == 6 * number
