import numpy as np
import pytest

from detector.contrast_maximisation.warped_events import Reward, WarpedEvents, centred_points
from detector.contrast_maximisation.warped_image import SUPPRESSION
from flybench.events import EVENT_DTYPE

F32 = np.float32


def random_points(number: int = 200, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.stack(
        [rng.integers(0, 30, number), rng.integers(0, 20, number), rng.uniform(-0.02, 0.02, number)]
    ).astype(F32)


def rewards(
    points: np.ndarray,
    velocities: np.ndarray,
    *,
    scale_px: float = 1.0,
    reward: Reward = Reward.GRADIENT,
    area_px: float = 90_000.0,
) -> np.ndarray:
    return WarpedEvents(points, reward=reward, area_px=area_px).rewards(velocities, scale_px)


def warped_image(
    points: np.ndarray, velocity: tuple[float, float], *, scale_px: float = 1.0
) -> np.ndarray:
    return WarpedEvents(points, reward=Reward.GRADIENT, area_px=1.0).image(velocity, scale_px)


def reference_image(points: np.ndarray, velocity: tuple[float, float]) -> np.ndarray:
    """Compute the image of warped events in plain NumPy, with a rim of zeros."""
    canvas = np.zeros((80, 80))
    for x, y, t in points.T.astype(float):
        px, py = x - velocity[0] * t + 20, y - velocity[1] * t + 20
        column, row = int(px + 0.5), int(py + 0.5)
        fx, fy = px - column, py - row
        across = np.array([(0.5 - fx) ** 2 / 2, 0.75 - fx**2, (0.5 + fx) ** 2 / 2])
        down = np.array([(0.5 - fy) ** 2 / 2, 0.75 - fy**2, (0.5 + fy) ** 2 / 2])
        canvas[row - 1 : row + 2, column - 1 : column + 2] += np.outer(down, across)
    for axis in (0, 1):
        canvas = 0.5 * canvas + 0.25 * (np.roll(canvas, 1, axis) + np.roll(canvas, -1, axis))
    return canvas


def test_the_image_equals_the_reference() -> None:
    points, velocity = random_points(), (130.0, -70.0)
    image, canvas = warped_image(points, velocity), reference_image(points, velocity)
    rows, columns = np.nonzero(canvas.sum(axis=1))[0], np.nonzero(canvas.sum(axis=0))[0]
    expected = canvas[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    rows, columns = np.nonzero(image.sum(axis=1))[0], np.nonzero(image.sum(axis=0))[0]
    found = image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    np.testing.assert_allclose(found, expected, atol=1e-3)


@pytest.mark.parametrize("reward", Reward)
def test_the_rewards_equal_the_reference(reward: Reward) -> None:
    points, velocity, area = random_points(), (130.0, -70.0), 6400.0
    h = reference_image(points, velocity)
    energy, empty = (h**2).mean(), np.exp(-SUPPRESSION * h).mean()
    expected = {
        Reward.VARIANCE: h.var(),
        Reward.GRADIENT: (np.diff(h, axis=1) ** 2).sum() / area
        + (np.diff(h, axis=0) ** 2).sum() / area,
        Reward.SUPPRESSED: empty,
        Reward.COMBINED: energy * empty,
    }[reward]
    (found,) = rewards(points, np.array([velocity]), scale_px=1.0, reward=reward, area_px=area)
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (900.0, -1400.0), (-37.0, 3.0)])
def test_no_event_is_lost(velocity: tuple[float, float]) -> None:
    points = random_points()
    assert warped_image(points, velocity).sum() == pytest.approx(points.shape[1], rel=1e-4)
    assert warped_image(points, velocity, scale_px=4.0).sum() == pytest.approx(200, rel=1e-4)


@pytest.mark.parametrize("reward", Reward)
def test_every_reward_prefers_the_true_velocity(reward: Reward) -> None:
    rng = np.random.default_rng(1)
    t = rng.uniform(-0.025, 0.025, 4000)
    x = np.repeat(rng.uniform(50, 100, 200), 20) + 300 * t
    y = np.repeat(rng.uniform(50, 100, 200), 20) - 120 * t
    points = np.stack([np.floor(x), np.floor(y), t]).astype(F32)
    candidates = np.array([(300.0, -120.0), (330.0, -120.0), (300.0, -90.0), (0.0, 0.0)])
    found = rewards(points, candidates, scale_px=1.0, reward=reward, area_px=90_000.0)
    assert found.argmax() == 0


def test_the_pixel_grid_does_not_favour_a_velocity_of_zero() -> None:
    # Bilinear votes would give a velocity of 0, with events in the middle of pixels, 1.5 times the
    # reward.
    rng = np.random.default_rng(0)
    t = rng.uniform(-0.025, 0.025, 3000)
    points = np.stack([rng.integers(0, 300, 3000), rng.integers(0, 200, 3000), t]).astype(F32)
    candidates = np.array([(0.0, 0.0), (40.0, 0.0), (0.0, 40.0), (-40.0, 40.0)])
    found = rewards(points, candidates, scale_px=1.0, reward=Reward.GRADIENT, area_px=60_000.0)
    assert np.ptp(found) < 0.1 * found.mean()


def test_the_reward_of_no_events_is_zero() -> None:
    none = np.zeros((3, 0), F32)
    assert not rewards(
        none, np.zeros((2, 2)), scale_px=1.0, reward=Reward.VARIANCE, area_px=10.0
    ).any()


@pytest.mark.parametrize("reward", Reward)
def test_candidates_do_not_affect_later_ones(reward: Reward) -> None:
    velocities = np.array([(900.0, -1400.0), (0.0, 0.0), (130.0, -70.0)])
    warped = WarpedEvents(random_points(), reward=reward, area_px=6400.0)
    together = warped.rewards(velocities, 1.0)
    warped.image((-37.0, 3.0))
    alone = [float(warped.rewards(v[None], 1.0)[0]) for v in velocities]
    assert together.tolist() == alone


def test_the_order_of_the_events_does_not_matter() -> None:
    points, velocities = random_points(), np.array([(900.0, -1400.0), (130.0, -70.0)])
    in_time = points[:, np.argsort(points[2])]
    np.testing.assert_allclose(rewards(in_time, velocities), rewards(points, velocities), rtol=1e-5)


def test_rewards_by_chance_exchange_the_times() -> None:
    points, velocity = random_points(), (130.0, -70.0)
    points[0], points[1] = np.arange(200) % 20 * 5, np.arange(200) // 20 * 5  # one event a pixel
    points[2].sort()
    orders = np.random.default_rng(1).permuted(np.tile(np.arange(200), (3, 1)), axis=1)
    exchanged = [np.stack([points[0], points[1], points[2, order]]) for order in orders]
    warped = WarpedEvents(points, reward=Reward.GRADIENT, area_px=90_000.0)
    found = warped.rewards_by_chance(velocity, 1.0, orders.astype(np.int32))
    expected = [float(rewards(p, np.array([velocity]))[0]) for p in exchanged]
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_points_are_centred_and_thinned_evenly() -> None:
    events = np.zeros(5, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = np.arange(5) * 1000, np.arange(5), 7
    points = centred_points(events, most=3, middle_us=2000.0, middle_px=(2.0, 3.5))
    expected = np.array([[-2.0, -1.0, 1.0], [3.5, 3.5, 3.5], [-0.002, -0.001, 0.001]])
    np.testing.assert_allclose(points, expected, rtol=1e-6)
    assert points.dtype == np.float32
    points = centred_points(events, most=9, middle_us=0.0, middle_px=(0.0, 0.0))
    assert points[0].tolist() == [0, 1, 2, 3, 4]
