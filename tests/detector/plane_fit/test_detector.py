import numpy as np
import pytest

from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector, MotionEstimate
from detector.plane_fit.detector import PlaneFit, PlaneFitConfig, common_velocity
from flybench.direction import CARDINAL, Direction
from flybench.events import Events
from tests.detector.stimuli import crossing, hot_pixels, merged, noise, plain_box
from tests.detector.test_operating_range import passing, share_with


def slopes_of(v: tuple[float, float], number: int = 200, seed: int = 0) -> np.ndarray:
    """Return the slopes of edges of all directions of an object with velocity v."""
    angle = np.random.default_rng(seed).uniform(-np.pi, np.pi, number)
    normals = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = normals @ v
    ahead = across > 30.0
    return np.asarray(normals[ahead] / across[ahead, None])


def test_edges_of_several_directions_give_the_whole_velocity() -> None:
    v, ratio = common_velocity(slopes_of((300.0, -120.0)))
    assert v == pytest.approx((300.0, -120.0), rel=2e-2)
    assert ratio > 100.0


def test_edges_of_one_direction_give_the_velocity_across_them() -> None:
    slopes = np.tile((1 / 250.0, 0.0), (50, 1))
    v, _ = common_velocity(slopes)
    assert v == pytest.approx((250.0, 0.0), rel=1e-2)


def test_outliers_do_not_change_the_velocity() -> None:
    wrong = np.random.default_rng(1).normal(0.0, 5e-3, (60, 2))
    v, _ = common_velocity(np.concatenate([slopes_of((300.0, -120.0), 400), wrong]))
    assert v == pytest.approx((300.0, -120.0), rel=0.1)


def estimates_after_100_ms(events: Events, until_us: int) -> list[MotionEstimate]:
    detector = PlaneFit()
    return [e for e in detector.push(events) + detector.advance(until_us) if e.t_us > 100_000]


@pytest.mark.parametrize(
    ("direction", "noise_hz"), [(Direction.RIGHT, 0.0), *((d, 10.0) for d in CARDINAL)]
)
@pytest.mark.parametrize("speed_px_s", [60, 300, 1000])
def test_the_direction_is_right_from_60_to_1000_px_s(
    speed_px_s: int, direction: Direction, noise_hz: float
) -> None:
    events, until_us = passing(speed_px_s, direction, noise_hz=noise_hz)
    found = estimates_after_100_ms(events, until_us)
    assert share_with(found, direction) >= 0.99
    speed = np.median([np.hypot(*e.response) for e in found])
    assert speed == pytest.approx(speed_px_s, rel=0.15)


def test_the_direction_of_a_plain_box_is_right() -> None:
    events, view_us = crossing(
        plain_box(), speed_px_s=400, direction=Direction.LEFT, plain_background=True
    )
    assert share_with(estimates_after_100_ms(events, view_us), Direction.LEFT) >= 0.9


@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 5.0, 20.0])
def test_noise_and_hot_pixels_give_none(rate_hz: float) -> None:
    until_us = 600_000
    events = merged(
        noise(rate_hz, duration_us=until_us, seed=7),
        hot_pixels(20, 50, duration_us=until_us, seed=8),
    )
    found = estimates_after_100_ms(events, until_us)
    assert share_with(found, Direction.NONE) >= 0.99


def test_cuts_and_calls_of_advance_change_no_estimate() -> None:
    events, until_us = passing(620, Direction.RIGHT, noise_hz=3.0)
    one, many = PlaneFit(), PlaneFit()
    whole = one.push(events) + one.advance(until_us)
    pieces = []
    for start in range(0, events.size, 701):
        piece = events[start : start + 701]
        pieces += many.push(piece) + many.advance(int(piece["t"][-1]))
    assert pieces + many.advance(until_us) == whole


def test_it_is_not_a_frame_detector() -> None:
    assert not isinstance(PlaneFit(), FrameDetector)


@pytest.mark.parametrize("values", [{"radius_px": 0}, {"tolerance_px": float("nan")}])
def test_parameters_out_of_range_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(DetectorConfigError, match=next(iter(values))):
        PlaneFitConfig(**values)  # type: ignore[arg-type]


def test_a_window_must_be_a_multiple_of_the_hop() -> None:
    with pytest.raises(DetectorConfigError, match="Allowed is a multiple of hop_us"):
        PlaneFitConfig(hop_us=20_000)
