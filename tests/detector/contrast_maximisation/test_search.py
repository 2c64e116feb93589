import numpy as np
import pytest

from detector.contrast_maximisation.search import (
    disc,
    parabola_peak,
    search_cold,
    search_warm,
    square,
)

WINDOW_S = 0.05


class TwoPeaks:
    """A reward with a high and a lower peak that counts the candidates it evaluates."""

    def __init__(self, high: tuple[float, float], low: tuple[float, float]) -> None:
        self.high, self.low, self.evaluations = np.array(high), np.array(low), 0

    def __call__(self, velocities: np.ndarray, scale_px: float) -> np.ndarray:
        self.evaluations += len(velocities)
        width = scale_px / WINDOW_S
        found = np.zeros(len(velocities))
        for peak, height in ((self.high, 1.0), (self.low, 0.7)):
            away = np.hypot(*(velocities - peak).T) / width
            found += height * np.exp(-(away**2) / 2)
        return found


@pytest.mark.parametrize("high", [(733.0, -411.0), (-3.0, 2.0), (0.0, 1499.0)])
def test_the_cold_search_finds_the_higher_of_two_peaks(high: tuple[float, float]) -> None:
    rewards = TwoPeaks(high, (-300.0, 500.0))
    found = search_cold(rewards, window_s=WINDOW_S, limit_px_s=1500.0)
    assert np.hypot(*(np.array(found) - high)) < 0.5


def test_a_cold_search_scans_with_the_survey_and_decides_with_the_reward() -> None:
    peaks = (733.0, -411.0), (-300.0, 500.0)
    rewards, survey = TwoPeaks(*peaks), TwoPeaks(peaks[1], peaks[0])  # exchanges the two peaks
    found = search_cold(rewards, window_s=WINDOW_S, limit_px_s=1500.0, cold_scan_at=survey)
    assert np.hypot(*np.subtract(found, peaks[0])) < 0.5
    assert rewards.evaluations < survey.evaluations


def warm(rewards: TwoPeaks, glance: TwoPeaks, start: tuple[float, float]) -> tuple[float, float]:
    return search_warm(rewards, glance, start, window_s=WINDOW_S, limit_px_s=1500.0)


def test_the_warm_search_needs_far_fewer_evaluations() -> None:
    peaks = (733.0, -411.0), (-300.0, 500.0)
    cold, own, glance = TwoPeaks(*peaks), TwoPeaks(*peaks), TwoPeaks(*peaks)
    search_cold(cold, window_s=WINDOW_S, limit_px_s=1500.0)
    found = warm(own, glance, (700.0, -380.0))
    assert np.hypot(*np.subtract(found, peaks[0])) < 0.5
    assert own.evaluations < cold.evaluations / 8


def test_the_warm_search_leaves_a_lower_peak_for_a_higher_one() -> None:
    peaks = (733.0, -411.0), (-300.0, 500.0)
    found = warm(TwoPeaks(*peaks), TwoPeaks(*peaks), (-340.0, 540.0))
    assert np.hypot(*np.subtract(found, peaks[0])) < 0.5


def test_the_warm_search_ignores_a_wrong_glance() -> None:
    peaks = (733.0, -411.0), (-300.0, 500.0)
    found = warm(TwoPeaks(*peaks), TwoPeaks(peaks[1], peaks[0]), (700.0, -380.0))
    assert np.hypot(*np.subtract(found, peaks[0])) < 0.5


def test_square_and_disc_grids() -> None:
    assert len(square(2, 1.0)) == 25
    grid = disc(3.0, 1.0)
    assert len(grid) == 29  # lattice points in a circle of radius 3
    assert [0.0, 0.0] in grid.tolist()


def test_the_peak_of_a_paraboloid_is_found() -> None:
    offsets = square(2, 2.5)
    values = -3 * (offsets[:, 0] - 1.2) ** 2 - (offsets[:, 1] + 0.7) ** 2 + 40
    assert parabola_peak(offsets, values) == pytest.approx((1.2, -0.7))


@pytest.mark.parametrize("curvature", [1.0, 0.0])
def test_a_bowl_or_a_plane_has_no_peak(curvature: float) -> None:
    offsets = square(2, 2.5)
    assert parabola_peak(offsets, curvature * (offsets**2).sum(axis=1)) == (0.0, 0.0)


def test_a_peak_is_found_among_rewards_that_are_all_negative() -> None:
    peaks = TwoPeaks((733.0, -411.0), (-300.0, 500.0))

    def negative(velocities: np.ndarray, scale_px: float) -> np.ndarray:
        return peaks(velocities, scale_px) - 2.0

    found = search_cold(negative, window_s=WINDOW_S, limit_px_s=1500.0)
    assert np.hypot(*np.subtract(found, peaks.high)) < 0.5
