"""A crossing as rendered: truth against the camera's own projection, light against full frames."""

import itertools

import numpy as np
import pytest

from sim import Crossing, CrossingConfig, Direction, Lighting, Preview, project
from sim.influence import influence_window

COARSE = {"step_px": 40.0 / 5, "supersample": 1, "max_step_ms": 20.0}


def crossing(lighting: str = "day", direction: str = "right", **options: float) -> Crossing:
    return Crossing(
        CrossingConfig(
            lighting=Lighting(lighting),
            direction=Direction(direction),
            **(COARSE | options),  # type: ignore[arg-type]
        )
    )


@pytest.mark.parametrize("direction", list(Direction))
def test_truth_agrees_with_the_projected_trajectory(direction: str) -> None:
    it = crossing(direction=direction)
    truths = [s.truth for s in itertools.islice(it.samples(), 0, None, 3)]
    start = it.scene.flank_m(it.position_m(0)).mean(axis=0)
    for truth in truths:
        moved = (it.position_m(truth.t_us) - it.position_m(0)) * it.scene.heading
        place = start + np.array([moved, 0, 0])
        where, _ = project(place[None], it.scene.pose, it.intrinsics)
        assert truth.reference_px == pytest.approx(where[0], abs=1e-6)
    first, last = truths[0], truths[-1]
    mean_velocity = (last.reference_px - first.reference_px) / (last.t_us - first.t_us) * 1e6
    assert mean_velocity == pytest.approx(first.image_velocity_px_s, abs=1e-3)
    assert np.linalg.norm(mean_velocity) == pytest.approx(it.intrinsics.focal_px * 1.61)
    assert truths[0].direction == direction


@pytest.mark.parametrize(("lighting", "direction"), [("day", "right"), ("night", "up")])
def test_the_mask_lies_where_the_vehicle_is_projected(lighting: str, direction: str) -> None:
    it = crossing(lighting, direction)
    seen = 0
    for sample in itertools.islice(it.samples(), 0, None, 5):
        truth = sample.truth
        corners, _ = project(
            it.scene.body_corners_m(truth.position_m), it.scene.pose, it.intrinsics
        )
        low, high = np.clip([corners.min(axis=0), corners.max(axis=0)], 0, [346, 260])
        assert truth.mask.shape == (260, 346)
        if truth.bounding_box_px is None or truth.centroid_px is None:
            assert not truth.in_view
            assert truth.visibility < 0.1
            continue
        seen += 1
        x0, y0, x1, y1 = truth.bounding_box_px
        assert (np.array([x0, y0]) >= low - 1).all()
        assert (np.array([x1, y1]) <= high + 1).all()
        assert (np.array([x0, y0]) <= truth.centroid_px).all()
        assert (truth.centroid_px <= np.array([x1, y1])).all()
        if truth.visibility == 1:
            assert truth.mask.sum() > 0.5 * (x1 - x0) * (y1 - y0)
    assert seen > 5


@pytest.mark.parametrize(
    ("lighting", "direction"),
    [("day", "right"), ("day", "down"), ("night", "right"), ("night", "left"), ("night", "up")],
)
def test_outside_the_window_nothing_changes(lighting: str, direction: str) -> None:
    it = crossing(lighting, direction)
    with it.full_frames() as draw:
        for share in (0.05, 0.3, 0.5, 0.7, 0.95):
            t_us = int(share * it.duration_us)
            before, after = draw(0), draw(t_us)
            changed = np.abs(after / before - 1) > 0.05
            for at_us in (0, t_us):
                window = influence_window(it.scene, it.position_m(at_us), it.intrinsics)
                if window is not None:
                    x0, y0, x1, y1 = window
                    changed[y0:y1, x0:x1] = False
            # What is left are shadows' edges, which the renderer shifts with the vehicle.
            assert changed.mean() < 0.002


def test_samples_are_the_full_frames() -> None:
    it = crossing("night")
    with it.full_frames() as draw:
        for sample in itertools.islice(it.samples(), 10, 60, 20):
            error = np.abs(sample.luminance / draw(sample.t_us) - 1)
            assert error.max() < 0.02


def test_another_renderer_draws_the_same_bits() -> None:
    it = crossing()
    times_us = [0, it.duration_us // 3, it.duration_us // 2]
    frames = []
    for _ in range(3):
        with it.full_frames() as draw:
            frames.append([draw(t_us) for t_us in times_us])
    assert np.array_equal(frames[0], frames[1])
    assert np.array_equal(frames[0], frames[2])


def test_where_nothing_moves_not_a_bit_changes() -> None:
    it = crossing()
    samples = list(itertools.islice(it.samples(), 0, None, 10))
    for sample in samples[1:]:
        assert np.array_equal(sample.luminance[:100], samples[0].luminance[:100])


def test_the_road_gets_the_illuminance_asked_for() -> None:
    bright, dim = (crossing(illuminance_lux=lux) for lux in (40_000.0, 4_000.0))
    with bright.full_frames() as draw:
        light = draw(0)
    with dim.full_frames() as draw:
        assert light / draw(0) == pytest.approx(10, rel=1e-3)


@pytest.mark.parametrize("lighting", list(Lighting))
def test_the_sequence_begins_and_ends_with_the_vehicle_out_of_view(lighting: str) -> None:
    it = crossing(lighting)
    lead_us = it.config.lead_s * 1e6
    seen_us = [s.t_us for s in it.samples() if s.truth.in_view]
    assert lead_us <= min(seen_us) < lead_us + 100_000
    assert lead_us <= it.duration_us - max(seen_us) < lead_us + 100_000


def test_the_preview_is_a_colour_picture() -> None:
    it = crossing()
    with Preview(it) as preview:
        picture = preview.draw(it.duration_us // 2, scale=1)
    assert picture.shape == (260, 346, 3)
    assert picture.dtype == np.uint8
    assert 40 < picture.mean() < 220
    assert np.abs(picture[..., 0].astype(int) - picture[..., 2]).max() > 40
