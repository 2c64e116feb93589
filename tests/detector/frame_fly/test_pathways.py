import math

import numpy as np
import pytest

from detector.frame_fly.pathways import (
    Adaptation,
    blurred,
    gaussian_kernel,
    grey_levels,
    luminance_change,
    on_off,
    spatial_difference,
    weight_of_present,
)


def test_the_weight_of_the_present_grows_with_the_interval() -> None:
    assert weight_of_present(25_000, 100_000) == pytest.approx(0.2)
    assert weight_of_present(100_000, 100_000) == pytest.approx(0.5)


def test_grey_levels_have_8_bits_and_are_averaged_over_cells() -> None:
    frame = np.array([[0, 1023, 9], [1023, 0, 9]], np.uint16)
    assert grey_levels(frame, full_scale_dn=1023.0, cell_px=1)[0, 1] == pytest.approx(255.0)
    coarse = grey_levels(frame, full_scale_dn=1023.0, cell_px=2)
    assert coarse.shape == (1, 1)
    assert coarse[0, 0] == pytest.approx(127.5)


def test_the_retina_responds_to_change_only() -> None:
    now, before = np.full((2, 2), 5, np.float32), np.full((2, 2), 8, np.float32)
    assert (luminance_change(now, before) == -3.0).all()


def test_the_kernel_is_the_gaussian_as_printed() -> None:
    kernel = gaussian_kernel(5, 2.0)
    u, v = 1, -2
    printed = math.exp(-(u**2 + v**2) / 8.0) / (2 * math.pi * 4.0)
    assert kernel[2 + u] * kernel[2 + v] == pytest.approx(printed, rel=1e-6)


def test_blurring_a_point_gives_the_kernel() -> None:
    point = np.zeros((9, 9), np.float32)
    point[4, 4] = 1.0
    kernel = gaussian_kernel(5, 2.0)
    image = blurred(point, kernel)
    np.testing.assert_allclose(image[2:7, 2:7], np.outer(kernel, kernel), rtol=1e-5)
    assert image[0].sum() == 0.0


def test_the_difference_of_gaussians_follows_the_sign_rule() -> None:
    centre = np.array([3.0, 1.0, -3.0, -1.0, 2.0, -2.0, 0.0], np.float32)
    surround = np.array([1.0, 3.0, -1.0, -3.0, -1.0, 1.0, 0.0], np.float32)
    difference = spatial_difference(centre[None], surround[None])[0]
    np.testing.assert_allclose(difference, [2.0, 2.0, -2.0, -2.0, 0.0, 0.0, 0.0])


def test_brightening_is_on_and_darkening_is_off() -> None:
    on, off = on_off(np.array([[2.0, -3.0, 0.0]], np.float32))
    np.testing.assert_array_equal(on, [[2.0, 0.0, 0.0]])
    np.testing.assert_array_equal(off, [[0.0, 3.0, 0.0]])


def step(adaptation: Adaptation, value: float) -> float:
    signal = np.full((1,), value, np.float32)
    return float(adaptation.step(signal, interval_us=25_000)[0])


def test_adaptation_follows_a_rise_fast_and_a_fall_slowly() -> None:
    adaptation = Adaptation((1,), rising_us=1_000, falling_us=100_000)
    assert step(adaptation, 26.0) == pytest.approx(1.0, rel=1e-5)  # 26·(1 − 25/26)
    assert step(adaptation, 0.0) == 0.0
    # The low-pass fell from 25 to 20: a rise to 26 leaves (26 − 20)/26.
    assert step(adaptation, 26.0) == pytest.approx(6.0 / 26.0, rel=1e-4)


def test_adaptation_suppresses_flicker() -> None:
    adaptation = Adaptation((1,), rising_us=1_000, falling_us=100_000)
    responses = [step(adaptation, 10.0 * (n % 2 == 0)) for n in range(9)]
    assert responses[0] > 3 * max(responses[1:])
