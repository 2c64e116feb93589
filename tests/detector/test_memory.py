"""The detectors' memory: computed before it is allocated, and bounded for any events."""

import tracemalloc
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from detector import ContrastMaximisation, Detector, FlyConfig, FlyDetector, FrameFly, PlaneFit
from detector.fly.event_histogram import COUNT_BITS, merge_equal
from flybench.events import EVENT_DTYPE, Events
from flybench.memory import VARIABLE, MemoryBudgetError

WIDTH, HEIGHT = 640, 480
DETECTORS = [ContrastMaximisation, FlyDetector, FrameFly, PlaneFit]


@pytest.fixture
def _small_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv(VARIABLE, "0.02")


def at_once(number: int, *, t_us: int = 100, side: int = 40) -> Events:
    events = np.zeros(number, EVENT_DTYPE)
    rng = np.random.default_rng(0)
    events["t"], events["p"] = t_us, rng.random(number) < 0.5
    events["x"], events["y"] = rng.integers(0, side, number), rng.integers(0, side, number)
    return events


@pytest.mark.parametrize("make", DETECTORS)
def test_a_huge_sensor_is_refused(make: Any) -> None:
    with pytest.raises(MemoryBudgetError, match=r"30000×30000 px needs .* Allowed is 4 GB"):
        make(width=30_000, height=30_000)


@pytest.mark.parametrize("make", DETECTORS)
def test_memory_stays_within_what_was_counted(make: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    counted: dict[int, int] = {}
    monkeypatch.setattr("flybench.memory._counted", counted)
    use(make)  # compiles the kernels
    tracemalloc.start()
    keep = use(make)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert keep is not None
    assert peak <= sum(counted.values()) + 1_000_000
    if make is not ContrastMaximisation:  # its image is smaller without moving events
        assert peak >= 0.5 * sum(counted.values())


def use(make: Any) -> Detector:
    detector: Detector = make(width=WIDTH, height=HEIGHT)
    detector.push(at_once(100))
    detector.advance(200_000)
    if isinstance(detector, FrameFly):
        for t_us in (300_000, 400_000):
            detector.push_frame(t_us, np.full((HEIGHT, WIDTH), t_us // 1000, np.uint16))
    return detector


@pytest.mark.usefixtures("_small_budget")
def test_events_of_one_time_take_bounded_memory() -> None:
    fly = FlyDetector(width=40, height=40)
    for _ in range(100):
        fly.push(at_once(10_000))
    assert fly.state()["surfaces.pixels"].size <= 1 << 13  # of a million events


def test_merged_events_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    chunks = [at_once(3000, t_us=t) for t in (100, 100, 7000, 15_000, 15_001, 40_000, 66_000)]

    def run() -> FlyDetector:
        fly = FlyDetector(width=40, height=40)
        for chunk in chunks:
            fly.push(chunk)
        fly.advance(150_000)
        return fly

    merged = run()
    monkeypatch.setattr("detector.fly.time_surface.merge_equal", lambda *ring: ring)
    plain = run()
    assert merged.state()["surfaces.pixels"].size < plain.state()["surfaces.pixels"].size
    for name in ("surfaces.totals", "surfaces.tallies", "surfaces.surfaces"):
        assert np.array_equal(merged.state()[name], plain.state()[name])


def test_equal_entries_are_counted() -> None:
    def packed(*entries: tuple[int, int]) -> npt.NDArray[np.int64]:
        return np.array([pixel | count << COUNT_BITS for pixel, count in entries], np.int64)

    times, pixels, merged = merge_equal(
        np.array([1, 1, 1, 1, 2, 2]),
        np.array([5, -1, 5, 3, 3, 4], np.int32),
        packed((3, 3)),
    )
    assert times.tolist() == [1, 1, 2, 2]
    assert pixels.tolist() == [-1, -2, 3, 4]
    assert merged.tolist() == packed((3, 4), (5, 2)).tolist()


@pytest.mark.usefixtures("_small_budget")
@pytest.mark.parametrize("make", [ContrastMaximisation, PlaneFit])
def test_too_many_events_in_a_window_are_refused(make: Any) -> None:
    detector = make(width=40, height=40)
    detector.push(at_once(10_000))
    with pytest.raises(MemoryBudgetError, match="A window of 310000 events needs 0"):
        detector.push(at_once(300_000))


@pytest.mark.usefixtures("_small_budget")
def test_too_many_different_events_in_a_window_are_refused() -> None:
    fly = FlyDetector(width=40, height=40)
    events = at_once(500_000)
    events["t"] = np.arange(events.size) // 50
    with pytest.raises(MemoryBudgetError, match="A window with 262144 events of different time"):
        fly.push(events)


@pytest.mark.usefixtures("_small_budget")
@pytest.mark.parametrize("make", [ContrastMaximisation, FlyDetector, PlaneFit])
def test_a_chunk_with_too_many_pauses_is_refused(make: Any) -> None:
    detector = make(width=40, height=40)
    events = at_once(100)
    events["t"] = np.arange(events.size) * 59_000_000
    with pytest.raises(MemoryBudgetError, match="A chunk of 100 events with 584100 estimates"):
        detector.push(events)
    assert len(detector.push(events[:1])) == 0


def test_a_hop_with_too_many_estimates_in_a_pause_is_refused() -> None:
    with pytest.raises(MemoryBudgetError, match=r"quiet_limit_us = 60000000 µs .* every 1 µs"):
        FlyDetector(FlyConfig(hop_us=1, window_us=100, delay_us=100))
