import numpy as np
import pytest

from detector.errors import DetectorConfigError, EventOrderError, FrameError
from detector.estimate import FrameDetector, MotionEstimate
from detector.frame_fly.detector import FrameFly, FrameFlyConfig
from flybench.direction import CARDINAL, Direction
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE
from tests.detector.synthetic_frames import (
    HEIGHT,
    WIDTH,
    Profile,
    bar,
    frames,
    grating,
    run_on_frames,
)

DAY_INTERVAL_US, NIGHT_INTERVAL_US = 25_000, 120_000  # 40 and 8.3 frames per second


def estimates_of(
    profile: Profile,
    step_px: float,
    *,
    direction: Direction = Direction.RIGHT,
    interval_us: int = DAY_INTERVAL_US,
    preset: str = "published",
) -> list[MotionEstimate]:
    """Return the estimates from the fourth frame; earlier ones respond to the onset."""
    upright = direction in (Direction.RIGHT, Direction.LEFT)
    width, height = (WIDTH, HEIGHT) if upright else (HEIGHT, WIDTH)
    fly = FrameFly(FrameFlyConfig.preset(preset), width=width, height=height)
    number = min(12, 1 + int(110 / step_px))  # the bar stays in view
    images = frames(profile, step_px=step_px, number=number, direction=direction)
    return run_on_frames(fly, images, interval_us=interval_us)[2:]


@pytest.mark.parametrize("interval_us", [DAY_INTERVAL_US, NIGHT_INTERVAL_US])
@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("step_px", [2, 3, 5, 6])
@pytest.mark.parametrize("profile", [grating(30), grating(47), bar(12), bar(31, level_dn=120)])
def test_the_direction_is_right_within_the_operating_range(
    profile: Profile, step_px: float, direction: Direction, interval_us: int
) -> None:
    found = estimates_of(profile, step_px, direction=direction, interval_us=interval_us)
    assert {e.direction for e in found} == {direction}


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("step_px", [6, 9, 12, 18])
def test_cells_of_3_px_triple_the_speeds(step_px: float, direction: Direction) -> None:
    for profile in (grating(75), bar(30)):
        found = estimates_of(profile, step_px, direction=direction, preset="coarse")
        assert {e.direction for e in found} == {direction}


def test_steps_beyond_half_a_period_give_the_opposite_direction() -> None:
    found = estimates_of(grating(30), 24)
    assert {e.direction for e in found} == {Direction.LEFT}


def test_noise_alone_gives_none() -> None:
    fly = FrameFly(width=WIDTH, height=HEIGHT)
    found = run_on_frames(
        fly, frames(grating(30), step_px=0, number=60), interval_us=DAY_INTERVAL_US
    )
    assert sum(e.direction is Direction.NONE for e in found) >= 58


def test_a_flash_gives_none() -> None:
    fly = FrameFly(width=WIDTH, height=HEIGHT)
    images = [np.full((HEIGHT, WIDTH), level, np.uint16) for level in (300, 600, 300, 300)]
    found = run_on_frames(fly, iter(images), interval_us=DAY_INTERVAL_US)
    assert {e.direction for e in found} == {Direction.NONE}


def test_the_response_is_weaker_at_the_night_frame_rate() -> None:
    day = max(e.strength for e in estimates_of(bar(12), 4))
    night = max(e.strength for e in estimates_of(bar(12), 4, interval_us=NIGHT_INTERVAL_US))
    assert day > 10 * night > 0.0


def test_mirrored_frames_mirror_the_response() -> None:
    fly, mirrored = (FrameFly(width=WIDTH, height=HEIGHT) for _ in range(2))
    for n, image in enumerate(frames(bar(12), step_px=4, number=6)):
        one = fly.push_frame(n * DAY_INTERVAL_US, image)
        other = mirrored.push_frame(n * DAY_INTERVAL_US, np.ascontiguousarray(image[:, ::-1]))
        for a, b in zip(one, other, strict=True):
            assert a.hs == pytest.approx(-b.hs, rel=1e-3, abs=1e-6)
            assert a.vs == pytest.approx(b.vs, rel=1e-3, abs=1e-6)


def test_there_is_an_estimate_at_every_frame_but_the_first_and_none_for_events() -> None:
    fly = FrameFly(width=8, height=8)
    assert isinstance(fly, FrameDetector)
    events = np.zeros(2, EVENT_DTYPE)
    events["t"] = [5, 10]
    frame = np.zeros((8, 8), np.uint16)
    assert fly.push(events) == []
    assert fly.push_frame(10, frame) == []
    assert fly.advance(40) == []
    (estimate,) = fly.push_frame(50, frame)
    assert (estimate.t_us, estimate.direction) == (50, Direction.NONE)


def test_time_that_goes_back_is_refused_and_changes_nothing() -> None:
    fly = FrameFly(width=8, height=8)
    frame = np.zeros((8, 8), np.uint16)
    fly.push_frame(100, frame)
    with pytest.raises(EventOrderError, match="99"):
        fly.push_frame(99, frame)
    with pytest.raises(EventOrderError, match="99"):
        fly.advance(99)
    with pytest.raises(EventError):
        fly.push(np.zeros(1, EVENT_DTYPE))
    assert [e.t_us for e in fly.push_frame(100, frame)] == [100]


@pytest.mark.parametrize(
    "frame",
    [np.zeros((8, 9), np.uint16), np.zeros((8, 8), np.uint8), np.zeros((8, 8)), None],
)
def test_a_value_that_is_not_a_frame_is_refused(frame: np.ndarray) -> None:
    with pytest.raises(FrameError, match=r"uint16 array of shape \(8, 8\)"):
        FrameFly(width=8, height=8).push_frame(0, frame)


def test_a_sensor_smaller_than_a_correlation_distance_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="cells of 3 px"):
        FrameFly(FrameFlyConfig.preset("coarse"), width=8, height=100)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"smoothing": 0.0}, "smoothing is 0.0. Allowed is a number from 0.01 to 1"),
        ({"cell_px": 1.5}, "cell_px is 1.5. Allowed is a whole number"),
        ({"offsets_cells": (2, 4)}, "one delay for each distance"),
        ({"offsets_cells": (0, 2, 4)}, "offsets_cells is"),
        ({"kernel_centre_cells": 4}, "odd"),
    ],
)
def test_parameters_out_of_range_are_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(DetectorConfigError, match=words):
        FrameFlyConfig(**values)  # type: ignore[arg-type]


def test_an_unknown_preset_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="'published', 'coarse'"):
        FrameFlyConfig.preset("fine")
