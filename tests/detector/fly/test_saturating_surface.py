"""Saturating surfaces, against the same maths event by event."""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from detector.errors import DetectorConfigError
from detector.fly.config import FlyConfig
from detector.fly.model_variants import SurfaceEvents
from detector.fly.saturating_surface import SaturatingSurfaces, inhibited, smooth
from flybench.events import EVENT_DTYPE, Events

WIDTH, HEIGHT, END_US = 20, 14, 100_000
CONFIG = replace(FlyConfig.preset("robust"), mains_notch=False, inhibition=0.0)


def random_events(seed: int = 3, number: int = 400) -> Events:
    rng = np.random.default_rng(seed)
    events = np.zeros(number, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, END_US, number))
    events["x"], events["y"] = rng.integers(5, 12, number), rng.integers(4, 9, number)
    events["p"] = rng.random(number) < 0.5
    return events


def surfaces_of(events: Events, config: FlyConfig) -> SaturatingSurfaces:
    surfaces = SaturatingSurfaces(config, width=WIDTH, height=HEIGHT)
    assert surfaces.accumulate(events, 0, until_us=END_US) == events.size
    return surfaces


def average(surfaces: SaturatingSurfaces) -> npt.NDArray[np.float32]:
    return surfaces.average(hop=END_US // CONFIG.hop_us - 1)


def test_agrees_with_the_sum_over_events() -> None:
    c, events = CONFIG, random_events()
    pixels = np.zeros((2, HEIGHT, WIDTH))
    times = np.full((2, HEIGHT, WIDTH), -math.inf)
    for t, x, y, p in events.tolist():
        at = int(p), y, x
        age = t - times[at]
        level = pixels[at] * math.exp(-age / c.tau_us) if age <= c.window_us else 0.0
        pixels[at], times[at] = level + c.event_gain * (1 - level), t
    ages = END_US - times
    pixels = np.where(ages <= c.window_us, pixels * np.exp(-ages / c.tau_us), 0.0)
    # 14 rows are 6 cells with 2 px to spare on each side, 20 columns are 8 cells, likewise
    cells = np.pad(pixels, ((0, 0), (2, 2), (2, 2))).reshape(2, 6, 3, 8, 3).mean(axis=(2, 4))
    expected = [inhibited(smooth(c.astype(np.float32)), 0.0) for c in cells]
    np.testing.assert_allclose(average(surfaces_of(events, c)), expected, atol=2e-4)


def test_an_event_counts_itself_and_a_pixel_saturates() -> None:
    def highest(number: int) -> float:
        events = np.zeros(number, EVENT_DTYPE)
        events["t"], events["x"], events["y"], events["p"] = END_US - 1, 10, 7, True
        return float(average(surfaces_of(events, CONFIG)).max())

    one, hundred = highest(1), highest(100)
    assert one > 0.0
    assert hundred < one / CONFIG.event_gain * 1.01


@pytest.mark.parametrize(("interval_us", "counts"), [(10_000, 1), (8_400, 1), (13_000, 2)])
def test_the_notch_leaves_out_intervals_of_the_mains(interval_us: int, counts: int) -> None:
    config = replace(CONFIG, mains_notch=True)
    events = np.zeros(2, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = (END_US - 1 - interval_us, END_US - 1), 10, 7
    both = average(surfaces_of(events, config)).max()
    first = average(surfaces_of(events[:1], config)).max()
    assert both == pytest.approx(first) if counts == 1 else both > 1.5 * first


def test_inhibition_leaves_what_stands_out() -> None:
    surface = np.random.default_rng(0).uniform(0.1, 0.2, (30, 40)).astype(np.float32)
    surface[10, 20] = 0.9
    left = inhibited(surface, 2.0)
    assert left[10, 20] > 0.5
    assert (left > 0).mean() < 0.05


def test_parameters_that_have_no_effect_are_refused() -> None:
    with pytest.raises(DetectorConfigError, match="averaging is 'events'"):
        FlyConfig(time_surface=SurfaceEvents.SATURATING)
    with pytest.raises(DetectorConfigError, match=r"inhibition is 2\.0"):
        FlyConfig(inhibition=2.0)
