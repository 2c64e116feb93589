"""The noise of single pixels: counts, intervals and order of their events."""

from dataclasses import replace

import numpy as np
import pytest

from emulator import SensorConfig
from emulator.characterisation.bench import Recording
from emulator.characterisation.experiments.background import record_static
from emulator.characterisation.experiments.noise_spread import (
    WINDOW_US,
    interval_shares,
    measure,
    measure_pixel_noise,
)
from flybench.events import EVENT_DTYPE
from tests.emulator.characterisation.plain_sensor import PLAIN


def recording_of(events: list[tuple[int, int, int, int]], *, windows: int) -> Recording:
    array = np.array(events, EVENT_DTYPE)
    return Recording(array, np.zeros(array.size, np.uint8), (), (1, 2), windows * WINDOW_US)


def test_the_order_and_the_windows_of_single_pixels_are_counted() -> None:
    times = [(1, 0, 0, 1), (2, 1, 0, 1), (3, 0, 0, 0), (4, 1, 0, 1), (WINDOW_US, 0, 0, 0)]
    found = measure_pixel_noise(recording_of(times, windows=2))
    assert found.alternating == pytest.approx(1 / 3)  # of three pairs in one pixel, one alternates
    assert found.silent == 1 / 4
    assert found.fano == pytest.approx(np.var([2, 2, 1, 0]) / 1.25)
    assert found.variation == (None, None)
    assert found.ln_rates.shape == (2, 0)


def test_a_poisson_process_has_the_figures_of_one() -> None:
    rng = np.random.default_rng(3)
    number = 60_000
    events = np.zeros(number, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 40 * WINDOW_US, number))
    events["x"], events["y"] = rng.integers(0, 20, (2, number))
    events["p"] = rng.random(number) < 0.5
    found = measure_pixel_noise(
        Recording(events, np.zeros(number, np.uint8), (), (20, 20), 40 * WINDOW_US)
    )
    assert found.alternating == pytest.approx(0.5, abs=0.01)
    assert found.fano == pytest.approx(1.0, abs=0.06)
    assert found.silent == pytest.approx(np.exp(-number / 400 / 40), abs=0.005)
    assert found.variation == pytest.approx((1.0, 1.0), abs=0.03)


def test_pixels_that_reset_to_what_they_see_alternate() -> None:
    config = replace(
        PLAIN, noise_sigma=0.07, theta_mismatch=0.015, leak_hz=0.0, leak_hz_per_lux=0.0
    )
    found = measure_pixel_noise(record_static(config, chip_lux=0.1, seed=1))
    on, off = found.ln_rates
    assert (on - off).mean() == pytest.approx(np.log(0.22 / 0.18), abs=0.02)
    assert (on - off).std() == pytest.approx(0.015 * np.hypot(1 / 0.18, 1 / 0.22), rel=0.2)
    assert found.alternating is not None
    assert found.alternating > 0.7


def test_intervals_between_on_events_are_counted_in_whole_windows() -> None:
    times = [(1, 0, 0, 1), (2, 0, 0, 0), (3, 0, 0, 1), (4, 0, 0, 1), (5, 1, 0, 1)]
    later = [(WINDOW_US + 1, 1, 0, 1), (WINDOW_US + 2, 1, 0, 1), (2 * WINDOW_US + 1, 0, 0, 1)]
    shares = interval_shares(recording_of(times + later, windows=2), window_us=WINDOW_US, most=3)
    assert shares.tolist() == [2 / 4, 1 / 4, 1 / 4, 0]


def test_section_of_the_default_sensor() -> None:
    section = measure(SensorConfig(), seed=1)
    assert len(section.quantities) == 12 + 5 + 5
    for row in section.quantities:
        assert row.published is not None
        assert row.measured is not None or row.note
    figures = section.figures
    silent = figures["silent pixels in 0.51 s of dark"].measured
    assert silent == pytest.approx(88.0, abs=12.0)
    for lux in ("17.5 s at 161 lux", "20 s at 3 klux"):
        shares = [x.measured or 0.0 for name, x in figures.items() if name.endswith(lux)]
        assert len(shares) == 5
        assert 90.0 < sum(shares) < 100.0
    low, median, high = (row.measured or 0.0 for row in section.quantities[:3])
    assert low < median < high
