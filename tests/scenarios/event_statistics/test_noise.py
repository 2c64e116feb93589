import numpy as np
import pytest

from emulator import ApsFrame
from scenarios.event_statistics.noise import (
    BRIGHTNESS_EDGES,
    MeanFrame,
    brightness_label,
    noise_classes,
    spread_of_rates,
)


def frame(image: np.ndarray) -> ApsFrame:
    return ApsFrame(0, 10, image.astype(np.uint16))


@pytest.mark.parametrize("deviation", [0.0, 0.5, 1.0])
def test_the_spread_is_that_of_log_normal_rates(deviation: float) -> None:
    rng = np.random.default_rng(0)
    rates = np.exp(rng.normal(0.0, deviation, 400_000))
    assert spread_of_rates(rng.poisson(0.5 * rates)) == pytest.approx(deviation, abs=0.05)


def test_regular_events_have_no_spread_and_few_events_none() -> None:
    assert spread_of_rates(np.full(100, 3)) == 0.0
    assert spread_of_rates(np.array([0, 9, 0])) is None


def test_brightness_is_relative_to_the_mean_and_needs_frames_of_the_sensor() -> None:
    mean = MeanFrame(width=2, height=1)
    assert mean.brightness() is None
    mean.add([frame(np.array([[0, 200]])), frame(np.array([[0, 400]])), frame(np.ones((5, 5)))])
    assert mean.frames == 2
    assert mean.brightness() == pytest.approx(np.array([[0.0, 2.0]]))


def test_black_frames_give_no_brightness() -> None:
    mean = MeanFrame(width=2, height=1)
    mean.add([frame(np.zeros((1, 2)))])
    assert mean.brightness() is None


def test_rates_by_brightness_of_quiet_pixels() -> None:
    counts = np.zeros((2, 1, 4), np.int64)
    counts[:, 0] = [[6, 0, 2, 100], [8, 0, 4, 100]]
    quiet = np.array([[True, True, True, False]])
    brightness = np.array([[0.01, 0.02, 1.0, 1.0]])
    whole, dark, *_, middle, bright = noise_classes(counts, quiet, brightness, 2_000_000)
    assert (whole.pixels, whole.on, whole.off) == (3, 12, 8)
    assert (dark.on_hz, dark.off_hz, dark.rate_hz, dark.silent) == (2.0, 1.5, 3.5, 0.5)
    assert (middle.pixels, middle.on_hz, middle.off_hz) == (1, 2.0, 1.0)
    assert (bright.pixels, bright.rate_hz, bright.silent) == (0, None, None)


def test_without_frames_there_is_one_class() -> None:
    counts, quiet = np.ones((2, 1, 4), np.int64), np.ones((1, 4), np.bool_)
    assert [n.from_brightness for n in noise_classes(counts, quiet, None, 10)] == [None]


def test_labels() -> None:
    labels = [brightness_label(edge) for edge in (None, *BRIGHTNESS_EDGES)]
    assert labels[:3] == ["all quiet pixels", "< 1/32 of mean", "1/32–1/8 of mean"]
    assert labels[-1] == "≥ 2 of mean"
