"""Times of keyframes."""

import numpy as np
import numpy.typing as npt
import pytest

from sim import Crossing, CrossingConfig, Lighting, VehicleKind
from sim.keyframes.plan import keyframe_times

F64 = npt.NDArray[np.float64]

TIMES_US = list(range(0, 1000, 10))


def crossing_box(px_per_step: float) -> tuple[F64, npt.NDArray[np.bool_]]:
    """Return the corners of a box that crosses at constant speed, in view from step 20 to 79.

    One corner is twice as fast as the others.
    """
    corners = np.zeros((100, 8, 2))
    corners[..., 0] = px_per_step * np.arange(100)[:, None]
    corners[:, 5] *= 2
    step = np.arange(100)
    return corners, (step >= 20) & (step < 80)


@pytest.mark.parametrize("spacing_px", [1.0, 7.0, 32.0, 1e6])
def test_the_fastest_corner_moves_by_the_spacing_between_keyframes(spacing_px: float) -> None:
    corners, in_view = crossing_box(1.5)
    times = keyframe_times(TIMES_US, corners, in_view, spacing_px)
    assert (times[0], times[-1]) == (200, 790)
    steps = np.array(times) // 10
    gaps = np.diff(corners[steps, 5, 0])
    assert (gaps > 0).all()
    assert (gaps < spacing_px + 3.0).all()  # it is noticed one step late
    assert (gaps[:-1] >= spacing_px).all()


def test_keyframes_span_the_time_in_view() -> None:
    corners, in_view = crossing_box(1.5)
    assert keyframe_times(TIMES_US, corners, np.zeros_like(in_view), 8.0) == []
    assert keyframe_times(TIMES_US, corners, np.arange(100) == 33, 8.0) == [330]
    assert keyframe_times(TIMES_US, corners * 0, in_view, 8.0) == [200, 790]


def test_both_sides_of_a_gap_have_keyframes() -> None:
    corners, in_view = crossing_box(1.5)
    kept = np.r_[20:41, 70:80]
    times = keyframe_times(np.array(TIMES_US)[kept].tolist(), corners[kept], in_view[kept], 32.0)
    assert times == [200, 310, 400, 700, 790]


def test_samples_before_a_gap_are_those_without_it() -> None:
    config = CrossingConfig(vehicle=VehicleKind.VAN, supersample=1)
    crossing, times_us = Crossing(config), list(range(250_000, 300_001, 5_000))
    alone = [s.luminance for s in crossing.samples(times_us)]
    with_gap = [s.luminance for s in crossing.samples([*times_us, 1_200_000])]
    for one, other in zip(alone[:-1], with_gap[:-2], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-4)
    assert min(image.min() for image in with_gap) > 0


@pytest.mark.parametrize("lighting", [Lighting.DAY, Lighting.NIGHT])
def test_samples_far_apart_are_those_of_a_dense_sequence(lighting: Lighting) -> None:
    """Shadows, too: the areas that they reach are found at every sample."""
    crossing = Crossing(CrossingConfig(lighting=lighting, supersample=1))
    dense_us = list(range(200_000, 600_001, 4_000))
    sparse_us = dense_us[::25]
    dense = {s.t_us: s.luminance for s in crossing.samples(dense_us)}
    for sample in crossing.samples(sparse_us):
        error = np.abs(sample.luminance / dense[sample.t_us] - 1)
        assert (error > 0.2).mean() < 0.006
