"""Edge-informed contrast maximisation on a drawn rectangle that moves, with its frames."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from detector.contrast_maximisation.detector import ContrastConfig, ContrastMaximisation
from detector.contrast_maximisation.edge_informed import (
    EdgeInformedConfig,
    EdgeInformedContrast,
    EdgeRewards,
    edge_image,
    squared_differences,
)
from detector.contrast_maximisation.warped_events import Reward, WarpedEvents, centred_points
from detector.errors import DetectorConfigError, FrameError
from detector.estimate import FrameDetector, MotionEstimate
from flybench.direction import CARDINAL, Direction
from flybench.events import EVENT_DTYPE, Events

WIDTH, HEIGHT, SPAN_US = 160, 120, 200_000
SIDE_PX = 30.0
VELOCITY = {
    Direction.RIGHT: (1.0, 0.0),
    Direction.LEFT: (-1.0, 0.0),
    Direction.UP: (0.0, -1.0),
    Direction.DOWN: (0.0, 1.0),
}


def corner_px(velocity: tuple[float, float], t_us: float) -> npt.NDArray[np.float64]:
    """Upper left corner of the square, which is in the middle of the image half way."""
    middle = np.array([WIDTH, HEIGHT]) / 2 - SIDE_PX / 2
    return np.asarray(middle + np.array(velocity) * (t_us - SPAN_US / 2) * 1e-6)


def square_events(velocity: tuple[float, float], *, number: int = 12_000) -> Events:
    """Events at random points of the outline of the moving square, at random times."""
    rng = np.random.default_rng(3)
    t = np.sort(rng.integers(SPAN_US, size=number))
    along, side = rng.uniform(0, SIDE_PX, number), rng.integers(4, size=number)
    x = np.choose(side, [along, along, np.zeros(number), np.full(number, SIDE_PX)])
    y = np.choose(side, [np.zeros(number), np.full(number, SIDE_PX), along, along])
    corners = np.stack([corner_px(velocity, at) for at in t])
    x, y = x + corners[:, 0], y + corners[:, 1]
    inside = (x >= 0) & (x < WIDTH) & (y >= 0) & (y < HEIGHT)
    events = np.zeros(int(inside.sum()), EVENT_DTYPE)
    events["t"], events["x"], events["y"] = t[inside], x[inside], y[inside]
    events["p"] = rng.integers(2, size=events.size) > 0
    return events


def square_frame(velocity: tuple[float, float], t_us: float) -> npt.NDArray[np.uint16]:
    frame = np.full((HEIGHT, WIDTH), 200, np.uint16)
    x, y = np.round(corner_px(velocity, t_us)).astype(int).tolist()
    side = round(SIDE_PX)
    frame[max(y, 0) : y + side, max(x, 0) : x + side] = 700
    return frame


def answers(
    detector: EdgeInformedContrast, velocity: tuple[float, float], *, frames: bool
) -> list[MotionEstimate]:
    events = square_events(velocity)
    found: list[MotionEstimate] = []
    for start, end in pairwise(range(0, SPAN_US + 1, 20_000)):
        found += detector.push(events[(events["t"] >= start) & (events["t"] < end)])
        if frames:
            found += detector.push_frame(end, square_frame(velocity, end))
    return found + detector.advance(SPAN_US)


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [120.0, 400.0])
def test_it_finds_velocity_and_direction_of_a_square_with_frames(
    direction: Direction, speed_px_s: float
) -> None:
    x, y = VELOCITY[direction]
    truth = (speed_px_s * x, speed_px_s * y)
    detector = EdgeInformedContrast(EdgeInformedConfig(), width=WIDTH, height=HEIGHT)
    assert isinstance(detector, FrameDetector)
    full = [e for e in answers(detector, truth, frames=True) if e.t_us >= 50_000]
    assert len(full) == 16
    assert {e.direction for e in full} == {direction}
    errors = [np.hypot(*np.subtract(e.response, truth)) for e in full]
    assert np.median(errors) < 30.0  # 1.5 px in a window: edges of frames are whole pixels


def test_without_frames_it_answers_as_contrast_maximisation() -> None:
    truth = (200.0, 0.0)
    events = square_events(truth)
    informed = EdgeInformedContrast(width=WIDTH, height=HEIGHT)
    plain = ContrastMaximisation(ContrastConfig(), width=WIDTH, height=HEIGHT)
    expected = plain.push(events) + plain.advance(SPAN_US)
    assert informed.push(events) + informed.advance(SPAN_US) == expected


def test_the_edges_lower_the_reward_of_a_velocity_that_they_contradict() -> None:
    truth, config = (200.0, 0.0), EdgeInformedConfig(contrast_weight=0.0)
    events = square_events(truth)
    points = centred_points(events, most=20_000, middle_us=SPAN_US / 2, middle_px=(0.0, 0.0))
    warped = WarpedEvents(points, reward=Reward.GRADIENT, area_px=1e4)

    def best(frame_us: float) -> float:
        edges = edge_image(square_frame(truth, frame_us), config)
        rewards = EdgeRewards(warped, [(points, edges)], config)
        speeds = np.arange(-400.0, 401.0, 100.0)
        candidates = np.stack([speeds, np.zeros_like(speeds)], axis=1)
        found = rewards(candidates, 1.0)
        assert found[list(speeds).index(0.0)] == pytest.approx(-config.edge_weight)
        return float(speeds[int(found.argmax())])

    assert best(SPAN_US / 2) == 200.0


def test_edges_are_1_and_fall_exponentially() -> None:
    frame = np.full((60, 80), 100, np.uint16)
    frame[:, 40:] = 900
    edges = edge_image(frame, EdgeInformedConfig(edge_fall_px=2.0))
    line = edges[30]
    peak = int(line.argmax())
    assert abs(peak - 39.5) <= 1.5
    assert line[peak] == 1.0
    assert line[peak + 4] <= np.exp(-3 / 2) + 1e-6
    assert (edge_image(np.full((60, 80), 5, np.uint16), EdgeInformedConfig()) == 0).all()


def test_squared_differences_against_a_calculation_by_hand() -> None:
    points = np.array([[1.0, 1.0, 2.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.5]], np.float32)
    edges = np.zeros((3, 4), np.float32)
    edges[1, 1] = 1.0
    found = np.zeros(2)
    image = np.zeros((3, 4), np.float32)
    squared_differences(points, np.array([[0.0, 0.0], [2.0, -2.0]]), 1.0, edges, image, found)
    # Unwarped, two events are at (1, 1) and one at (2, 0), half as high; warped, all are at (1, 1).
    assert found == pytest.approx([0.25 / 12, 0.0])


def test_a_frame_of_another_size_or_type_is_refused() -> None:
    detector = EdgeInformedContrast(width=WIDTH, height=HEIGHT)
    for frame in (np.zeros((HEIGHT, WIDTH), np.uint8), np.zeros((WIDTH, HEIGHT), np.uint16), None):
        with pytest.raises(FrameError, match=r"Allowed is a uint16 array of shape \(120, 160\)"):
            detector.push_frame(10, frame)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["contrast_weight", "edge_weight", "canny_low", "edge_fall_px"])
def test_a_parameter_out_of_range_is_refused(name: str) -> None:
    with pytest.raises(DetectorConfigError, match=name):
        EdgeInformedConfig(**{name: -1.0})  # type: ignore[arg-type]
