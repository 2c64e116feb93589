import numpy as np
import pytest

from emulator.noise.random_numbers import draw_gaussians, exponential, gaussian, uniform

SEED = np.uint64(12345)


def test_random_numbers_are_uniform_and_independent() -> None:
    grid = np.array([[uniform(SEED, i, k) for k in range(60)] for i in range(200)])
    assert grid.min() > 0.0
    assert grid.max() < 1.0
    assert np.histogram(grid, 10, (0, 1))[0].std() < 120
    assert abs(np.corrcoef(grid[:-1].ravel(), grid[1:].ravel())[0, 1]) < 0.04
    assert abs(np.corrcoef(grid[:, :-1].ravel(), grid[:, 1:].ravel())[0, 1]) < 0.04
    assert uniform(SEED, 3, 4) != uniform(np.uint64(12346), 3, 4)
    drawn = [exponential(SEED, i, 7) for i in range(10_000)]
    assert np.mean(drawn) == pytest.approx(1.0, abs=0.04)
    assert np.std(drawn) == pytest.approx(1.0, abs=0.06)


def test_gaussians_are_gaussian_and_independent() -> None:
    drawn = np.empty(400_001, np.float32)
    draw_gaussians(SEED, np.uint64(0), drawn)
    wide = drawn.astype(np.float64)
    assert abs(wide.mean()) < 0.006
    assert wide.std() == pytest.approx(1.0, abs=0.004)
    assert abs(np.mean(wide**3)) < 0.02
    assert np.mean(wide**4) == pytest.approx(3.0, abs=0.06)
    for sigmas, share in ((1.0, 0.31731), (2.0, 0.0455), (3.0, 0.0027)):
        assert np.mean(np.abs(wide) > sigmas) == pytest.approx(share, rel=0.1)
    for lag in (1, 2, 346, 200_000):
        assert abs(np.mean(wide[lag:] * wide[:-lag])) < 0.01
    other, later = np.empty(1000, np.float32), np.empty(1000, np.float32)
    draw_gaussians(np.uint64(7), np.uint64(0), other)
    draw_gaussians(SEED, np.uint64(10**6), later)
    assert abs(np.corrcoef(wide[:1000], other)[0, 1]) < 0.15
    assert abs(np.corrcoef(wide[:1000], later)[0, 1]) < 0.15


def test_single_gaussians_are_gaussian_and_independent() -> None:
    drawn = np.array([[gaussian(SEED, i, k) for k in range(50)] for i in range(2000)])
    assert abs(drawn.mean()) < 0.015
    assert drawn.std() == pytest.approx(1.0, abs=0.01)
    assert np.mean(drawn**4) == pytest.approx(3.0, abs=0.1)
    assert np.mean(np.abs(drawn) > 2.0) == pytest.approx(0.0455, rel=0.1)
    assert abs(np.corrcoef(drawn[:, 1:].ravel(), drawn[:, :-1].ravel())[0, 1]) < 0.015
    assert abs(np.corrcoef(drawn[1:].ravel(), drawn[:-1].ravel())[0, 1]) < 0.015
