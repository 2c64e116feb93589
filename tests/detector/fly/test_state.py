import io
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from detector.errors import StateError
from detector.estimate import MotionEstimate
from detector.fly.detector import FlyConfig, FlyDetector
from detector.fly.state import State
from flybench.direction import Direction
from flybench.events import Events
from tests.detector.stimuli import crossing, merged, noise, textured_box

PRESETS = [FlyConfig.preset(name) for name in ("paper", "wide", "robust")]


@cache
def stream() -> Events:
    events, view_us = crossing(textured_box(60, 40), speed_px_s=700, direction=Direction.UP)
    return merged(events, noise(2.0, duration_us=view_us))


def halfway() -> FlyDetector:
    fly = FlyDetector()
    fly.push(stream()[:20_000])
    return fly


@cache
def uninterrupted(config: FlyConfig) -> tuple[FlyDetector, list[MotionEstimate]]:
    """Return a fly that read the stream at once, and its estimates."""
    fly = FlyDetector(config)
    return fly, fly.push(stream()) + fly.advance(600_000)


@pytest.mark.parametrize("config", PRESETS)
@settings(max_examples=6, deadline=None)
@given(cut=st.integers(0, 40_000))
def test_a_restored_fly_returns_the_same_estimates_and_maps(config: FlyConfig, cut: int) -> None:
    events, (whole, expected) = stream(), uninterrupted(config)
    first, second = FlyDetector(config), FlyDetector(config)
    found = first.push(events[:cut])
    second.restore(first.state())
    first.push(events[cut:])
    assert found + second.push(events[cut:]) + second.advance(600_000) == expected
    np.testing.assert_array_equal(second.maps.motion, whole.maps.motion)


@pytest.mark.parametrize("config", PRESETS)
def test_a_state_survives_npz_and_pickle(config: FlyConfig) -> None:
    fly = FlyDetector(config)
    fly.push(stream()[:20_000])
    file = io.BytesIO()
    np.savez(file, **fly.state())  # type: ignore[arg-type]
    file.seek(0)
    rest = stream()[20_000:]
    expected = [FlyDetector(config) for _ in range(2)]
    with np.load(file, allow_pickle=False) as loaded:
        expected[0].restore(loaded)
    expected[1].restore(pickle.loads(pickle.dumps(fly.state())))
    following = fly.push(rest)
    assert following
    assert [e.push(rest) for e in expected] == [following, following]


def test_a_state_is_a_copy() -> None:
    fly = halfway()
    state = fly.state()
    kept = {name: array.copy() for name, array in state.items()}
    FlyDetector().restore(state)
    fly.push(stream()[20_000:])
    for name, array in state.items():
        np.testing.assert_array_equal(array, kept[name])


def test_a_new_fly_saves_and_restores_a_state() -> None:
    fly = FlyDetector()
    fly.restore(FlyDetector().state())
    assert fly.push(stream()) == FlyDetector().push(stream())


def test_order_is_checked_across_a_restore() -> None:
    fly = FlyDetector()
    fly.restore(halfway().state())
    with pytest.raises(ValueError, match="time must not go back"):
        fly.push(stream()[:10])


def test_another_configuration_or_sensor_is_refused() -> None:
    state = halfway().state()
    with pytest.raises(StateError, match=r"config of the state is .* Make a detector with"):
        FlyDetector(replace(FlyConfig(), alpha=0.25)).restore(state)
    with pytest.raises(StateError, match=r"sensor of the state is \[346, 260\]"):
        FlyDetector(width=640, height=480).restore(state)


def without(state: State, name: str) -> State:
    return {key: value for key, value in state.items() if key != name}


@pytest.mark.parametrize("name", ["format", "surfaces.totals", "centre.steered", "fly.hop"])
def test_a_state_without_one_of_its_arrays_is_refused(name: str) -> None:
    with pytest.raises(StateError, match=f"{name}"):
        FlyDetector().restore(without(halfway().state(), name))


def test_unfit_arrays_are_refused_and_change_nothing() -> None:
    state = halfway().state()
    cases = {
        "surfaces.totals": state["surfaces.totals"][:-1],
        "surfaces.times": state["surfaces.times"].astype(np.int32),
        "surfaces.pixels": state["surfaces.pixels"] + 10**6,
        "surfaces.clock": state["surfaces.clock"] * -1,
    }
    fly = FlyDetector()
    for name, array in cases.items():
        with pytest.raises(StateError, match="Pass everything that FlyDetector"):
            fly.restore(state | {name: array})
    assert fly.push(stream()) == FlyDetector().push(stream())


NOT_FINITE: dict[str, object] = {
    "centre.position": np.array([np.nan, 3.0]),
    "centre.steered": np.full((5, 2), np.inf),
    "surfaces.surfaces": np.full((6, 2, 87, 116), np.nan, np.float32),
    "fly.now_us": 7,
}


@pytest.mark.parametrize("name", NOT_FINITE)
def test_values_that_are_not_finite_arrays_are_refused(name: str) -> None:
    with pytest.raises(StateError, match=f"{name} of the state .* Allowed"):
        FlyDetector().restore(halfway().state() | {name: NOT_FINITE[name]})  # type: ignore[arg-type]


@pytest.mark.parametrize("state", [None, 3, [np.zeros(3)]])
def test_a_value_without_arrays_is_refused(state: object) -> None:
    with pytest.raises(StateError, match=r"The state is of type .*Allowed are arrays by name"):
        FlyDetector().restore(state)  # type: ignore[arg-type]


@pytest.mark.parametrize("hop", [0, -5, 1_000_000_000])
def test_a_hop_of_another_time_is_refused(hop: int) -> None:
    with pytest.raises(StateError, match=rf"The state is in hop {hop} at \d+ µs\. Allowed is"):
        FlyDetector().restore(halfway().state() | {"fly.hop": np.array(hop)})


@pytest.mark.parametrize(("entry", "value"), [(0, 10**9), (0, -1), (1, 10**9), (1, -(10**9))])
def test_a_clock_that_contradicts_the_stream_is_refused(entry: int, value: int) -> None:
    state = halfway().state()
    state["surfaces.clock"][entry] = value
    with pytest.raises(StateError, match="The last event of the state is at"):
        FlyDetector().restore(state)


def test_a_view_centre_outside_the_grid_is_refused() -> None:
    state = halfway().state() | {"centre.position": np.array([116.0, 40.0])}
    with pytest.raises(
        StateError, match=r"view centre of the state is \[116.0, 40.0\]\. Allowed are cells"
    ):
        FlyDetector().restore(state)


@pytest.mark.parametrize("until_us", [0, 9_999, 10_000, 59_000_000, 61_000_000, 10**10])
@pytest.mark.parametrize("is_fresh", [True, False])
def test_a_state_after_any_quiet_time_is_restored(until_us: int, is_fresh: bool) -> None:
    fly, later = FlyDetector(), FlyDetector()
    if not is_fresh:
        fly.push(stream()[:10])
    fly.advance(max(until_us, int(stream()["t"][10])))
    later.restore(fly.state())
    after = stream()[:100].copy()
    after["t"] += max(until_us, int(stream()["t"][10]))
    assert later.push(after) == fly.push(after)


def test_the_size_of_a_state_does_not_grow_with_the_stream() -> None:
    fly, sizes = FlyDetector(), []
    for second in range(4):
        events = noise(3.0, duration_us=1_000_000, seed=second)
        events["t"] += second * 1_000_000
        fly.push(events)
        sizes.append(sum(array.nbytes for array in fly.state().values()))
    assert sizes[1:] == sizes[:-1]
    assert sizes[-1] < 5_000_000
