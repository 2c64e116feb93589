"""From sub-pixels to pixels: even images and ramps are exact, edges get the blurred aperture."""

import math

import numpy as np
import pytest

from sim.raster.aperture import (
    BLUR_REACH_PX,
    LENS_BLUR_PX,
    aperture_weights,
    blur_before_interpolation_px,
    to_grid,
    to_pixels,
)

GRIDS = [(size, per) for size in range(1, 9) for per in range(1, size + 1) if size % per == 0]


@pytest.mark.parametrize("blur_px", [0.0, LENS_BLUR_PX, 0.5])
@pytest.mark.parametrize("supersample", range(1, 9))
def test_weights_sum_to_one_and_are_symmetric(supersample: int, blur_px: float) -> None:
    weights = aperture_weights(supersample, blur_px)
    assert weights.shape == (3 * supersample,)
    assert weights.dtype == np.float32
    assert weights.sum() == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(weights, weights[::-1], atol=1e-7)


def test_without_blur_a_pixel_is_the_mean_over_its_area() -> None:
    fine = np.random.default_rng(0).uniform(size=(12, 18)).astype(np.float32)
    means = fine.reshape(4, 3, 6, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(to_pixels(fine, 3, blur_px=0.0), means, rtol=1e-5)


@pytest.mark.parametrize(("supersample", "per_pixel"), GRIDS)
def test_a_ramp_is_reproduced_at_the_grid_points(supersample: int, per_pixel: int) -> None:
    side = 8
    fine = (np.arange(side * supersample) + 0.5) / supersample
    wanted = (np.arange(side * per_pixel) + 0.5) / per_pixel
    image = np.add.outer(2 * fine, 5 * fine).astype(np.float32)
    inner = slice((BLUR_REACH_PX + 1) * per_pixel, -(BLUR_REACH_PX + 1) * per_pixel)
    seen = to_grid(image, supersample, per_pixel=per_pixel)
    assert seen.shape == (side * per_pixel,) * 2
    np.testing.assert_allclose(
        seen[inner, inner], np.add.outer(2 * wanted, 5 * wanted)[inner, inner], atol=2e-5
    )


@pytest.mark.parametrize(("supersample", "per_pixel"), GRIDS)
def test_an_even_image_stays_even_up_to_the_border(supersample: int, per_pixel: int) -> None:
    even = np.full((3 * supersample, 4 * supersample), 7, np.float32)
    seen = to_grid(even, supersample, per_pixel=per_pixel)
    np.testing.assert_allclose(seen, 7, rtol=1e-6)


@pytest.mark.parametrize("edge_px", [3.0, 3.25, 3.5, 3.875])
@pytest.mark.parametrize("axis", [0, 1])
def test_an_edge_is_blurred_by_the_lens_and_averaged_over_the_pixel(
    axis: int, edge_px: float
) -> None:
    """The closed form is the mean of Φ((x - edge) / σ) over a pixel."""
    supersample, side = 16, 7
    bright = (np.arange(side * supersample) + 0.5) / supersample > edge_px
    image = np.broadcast_to(bright.astype(np.float32), (side * supersample,) * 2)
    seen = to_pixels(np.ascontiguousarray(image if axis else image.T), supersample)
    profile = seen[3] if axis else seen[:, 3]
    for pixel, value in enumerate(profile):
        ends = [(pixel + k - edge_px) / LENS_BLUR_PX for k in (0, 1)]
        low, high = (t * _phi(t) + math.exp(-t * t / 2) / math.sqrt(2 * math.pi) for t in ends)
        assert value == pytest.approx(LENS_BLUR_PX * (high - low), abs=0.004)


def _phi(t: float) -> float:
    return (1 + math.erf(t / math.sqrt(2))) / 2


@pytest.mark.parametrize("per_pixel", [3, 4, 6])
def test_the_reduced_blur_and_interpolation_add_up_to_the_lens_blur(per_pixel: int) -> None:
    fine = 24
    line = np.zeros((5 * fine, 7 * fine), np.float32)
    line[:, 3 * fine + fine // 2] = 1.0
    blur_px = blur_before_interpolation_px(per_pixel)
    grid = to_grid(line, fine, per_pixel=per_pixel, blur_px=blur_px)[2 * per_pixel].astype(float)
    x = np.linspace(0.5, 6.5, 1000)
    grid_points = (np.arange(len(grid)) + 0.5) / per_pixel
    interpolated = np.interp(x, grid_points, grid)
    centre = (interpolated * x).sum() / interpolated.sum()
    variance = (interpolated * (x - centre) ** 2).sum() / interpolated.sum()
    assert variance == pytest.approx(aperture_variance(fine), rel=0.03)


def aperture_variance(supersample: int) -> float:
    """Return the variance of a pixel's aperture [px²]."""
    weights = aperture_weights(supersample).astype(float)
    x = (np.arange(len(weights)) + 0.5) / supersample - 1.5
    return float((weights * x**2).sum())
