import math
import tracemalloc
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from detector.errors import DetectorConfigError, DetectorError
from detector.estimate import MotionEstimate
from detector.fly.detector import FlyConfig, FlyDetector
from detector.fly.model_variants import (
    Attention,
    Averaging,
    LocalMotion,
    Normalisation,
    Offsets,
    PairLocation,
    RegionActivity,
    SurfaceEvents,
)
from detector.metrics import accuracy, intersection_over_union, onset_latency_us, verdict
from flybench.direction import CARDINAL, Direction
from flybench.errors import EventError
from flybench.events import EVENT_DTYPE, Events, empty_events
from tests.detector.stimuli import (
    asphalt,
    car,
    crossing,
    hot_pixels,
    merged,
    noise,
    plain_box,
    slide,
    textured_box,
)


def estimates_of(events: Events, end_us: int) -> list[MotionEstimate]:
    fly = FlyDetector()
    return fly.push(events) + fly.advance(end_us)


def one_event(t_us: int, x: int = 100, y: int = 100) -> Events:
    return np.array([(t_us, x, y, True)], EVENT_DTYPE)


@cache
def busy_stream() -> Events:
    events, view_us = crossing(textured_box(60, 40), speed_px_s=700, direction=Direction.DOWN)
    return merged(events, noise(2.0, duration_us=view_us))


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("speed_px_s", [350, 518, 790])
@pytest.mark.parametrize("noise_hz", [0.0, 10.0])
def test_the_direction_of_a_car_is_right_from_100_ms_until_it_leaves(
    direction: Direction, speed_px_s: float, noise_hz: float
) -> None:
    events, view_us = crossing(car(), speed_px_s=speed_px_s, direction=direction)
    background = merged(
        noise(noise_hz, duration_us=view_us), hot_pixels(20, 50, duration_us=view_us)
    )
    found = estimates_of(merged(events, background), view_us)
    leaves_us = view_us - int(30 / speed_px_s * 1e6)
    assert accuracy(found, direction, crossing_us=(99_999, leaves_us)) == 1.0
    assert verdict(found, crossing_us=(0, view_us)) is direction


@pytest.mark.parametrize("direction", CARDINAL)
@pytest.mark.parametrize("contrast", [0.5, 1.0])
def test_the_direction_of_a_car_that_fills_the_view_is_right(
    direction: Direction, contrast: float
) -> None:
    pattern = car(300, 90, contrast=contrast)
    events, view_us = crossing(pattern, speed_px_s=450, direction=direction)
    found = estimates_of(merged(events, noise(3.0, duration_us=view_us)), view_us)
    leaves_us = view_us - int(30 / 450 * 1e6)
    assert accuracy(found, direction, crossing_us=(99_999, leaves_us)) == 1.0


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_direction_of_a_shape_without_texture_is_right(direction: Direction) -> None:
    events, view_us = crossing(
        plain_box(), speed_px_s=518, direction=direction, plain_background=True
    )
    found = estimates_of(merged(events, noise(5.0, duration_us=view_us)), view_us)
    share = accuracy(found, direction, crossing_us=(99_999, view_us))
    assert share is not None
    assert share > 0.98
    latency_us = onset_latency_us(found, direction, crossing_us=(0, view_us))
    assert latency_us is not None
    assert latency_us <= 100_000


def small_target(*, noise_hz: float, start_px: float = 40.0) -> Events:
    """Return a target of 24×24 px at 500 px/s from row 50 for 0.4 s, then 0.4 s of noise alone."""
    moving = slide(
        textured_box(24, 24),
        speed_px_s=500,
        start_px=start_px,
        top_px=50,
        duration_us=400_000,
        background=asphalt(260, 346),
    )
    return merged(moving, noise(noise_hz, duration_us=800_000))


def distance_px(e: MotionEstimate) -> float:
    """Return the distance from the view centre to the middle of the small target."""
    return math.dist(e.view_centre_px, (40 + 12 + 500e-6 * e.t_us, 62))


@pytest.mark.parametrize("noise_hz", [0.0, 1.0, 5.0])
def test_the_view_centre_converges_to_a_small_target_and_follows_it(noise_hz: float) -> None:
    fly = FlyDetector()
    events = small_target(noise_hz=noise_hz)
    events["t"] += 50_000
    at_rest, *found = fly.push(events)[4:]
    assert at_rest.view_centre_px == (173.0, 130.0)
    found = [replace(e, t_us=e.t_us - 50_000) for e in found]
    settled = found[15:40]
    # The saliency covers the last 50 ms, in which the target moves 25 px.
    assert max(map(distance_px, settled)) < 40.0
    for e in settled:
        assert e.direction is Direction.RIGHT
    travelled = settled[-1].view_centre_px[0] - settled[0].view_centre_px[0]
    assert travelled == pytest.approx(500 * 0.24, abs=25)


def test_the_region_contains_the_small_target() -> None:
    for e in FlyDetector().push(small_target(noise_hz=1.0))[20:40]:
        right_px = 40 + 24 + 500e-6 * e.t_us
        truth = int(right_px) - 24, 50, int(right_px), 74
        assert e.roi_px is not None
        assert e.roi_px[0] <= truth[0]
        assert e.roi_px[2] >= truth[2] - 5
        assert intersection_over_union(e.roi_px, truth) > 0.1


@pytest.mark.parametrize("far", [(300, 220), (20, 20), (330, 62)])
def test_hot_pixels_do_not_attract_the_view_centre(far: tuple[int, int]) -> None:
    # Four hot pixels close together, each firing more often than any pixel of the target.
    rows, columns = np.mgrid[far[1] : far[1] + 2, far[0] : far[0] + 2]
    burst = np.zeros((4, 80), EVENT_DTYPE)
    burst["t"] = np.arange(80) * 5_000
    burst["x"], burst["y"], burst["p"] = columns.reshape(4, 1), rows.reshape(4, 1), True
    isolated = np.sort(burst.ravel(), order="t", kind="stable")
    found = FlyDetector().push(merged(small_target(noise_hz=1.0), isolated))
    assert max(map(distance_px, found[15:40])) < 40.0


@pytest.mark.parametrize("noise_hz", [0.0, 1.0, 5.0])
def test_attention_returns_to_the_image_centre_when_the_target_is_gone(noise_hz: float) -> None:
    fly = FlyDetector()
    events = small_target(noise_hz=noise_hz)
    found = fly.push(events) + fly.advance(800_000)
    for e in found[50:]:
        assert e.view_centre_px == (173.0, 130.0)
        assert e.roi_px is None
        assert e.direction is Direction.NONE


@pytest.mark.parametrize("attention", [Attention.MAXIMUM, Attention.EVERYWHERE])
def test_other_variants_of_attention(attention: Attention) -> None:
    found = FlyDetector(FlyConfig(attention=attention)).push(small_target(noise_hz=0.0))
    for e in found[15:40]:
        assert e.direction is Direction.RIGHT
        if attention is Attention.EVERYWHERE:
            assert e.view_centre_px == (173.0, 130.0)
            assert e.roi_px == (0, 0, 346, 260)
        else:
            assert distance_px(e) < 40.0


@pytest.mark.parametrize(
    "variant",
    [
        {"time_surface": SurfaceEvents.ITSELF},
        {"averaging": Averaging.BOTH},
        {"averaging": Averaging.AREA},
        {"averaging": Averaging.NONE},
        {"offsets": Offsets.DOUBLING},
        {"pair_location": PairLocation.DELAYED},
        {"local_motion": LocalMotion.CELL},
        {"roi_activity": RegionActivity.PRESENT},
        {"normalisation": Normalisation.TOTAL},
    ],
)
def test_every_model_variant_can_be_selected_and_changes_estimates(variant: dict[str, Any]) -> None:
    events, view_us = crossing(car(), speed_px_s=518, direction=Direction.RIGHT)
    usual, other = FlyDetector(), FlyDetector(FlyConfig(**variant))
    found = [fly.push(events) + fly.advance(view_us) for fly in (usual, other)]
    assert found[0] != found[1]
    assert all(-1.0 < e.hs < 1.0 and -1.0 < e.vs < 1.0 for e in found[1])
    assert verdict(found[1], crossing_us=(0, view_us)) is Direction.RIGHT


def test_the_region_lies_on_the_car() -> None:
    events, view_us = crossing(car(), speed_px_s=518, direction=Direction.RIGHT)
    for e in estimates_of(events, view_us)[20:60]:
        assert e.roi_px is not None
        x0, y0, x1, y1 = e.roi_px
        front_px = 518e-6 * e.t_us
        assert front_px - 200 - 50 < (x0 + x1) / 2 < front_px
        assert 97 - 10 < (y0 + y1) / 2 < 163 + 10
        assert x1 - x0 <= 102
        assert y1 - y0 <= 102


cuts = st.lists(st.integers(0, 10**6), max_size=12)


@cache
def uncut(preset: str) -> tuple[FlyDetector, list[MotionEstimate]]:
    """Return a fly that read the busy stream at once, and its estimates."""
    fly, events = FlyDetector(FlyConfig.preset(preset)), busy_stream()
    return fly, fly.push(events) + fly.advance(int(events["t"][-1]) + 200_000)


@pytest.mark.parametrize("preset", ["paper", "wide"])
@settings(max_examples=12, deadline=None)
@given(cuts=cuts, with_advance=st.booleans())
def test_the_cuts_between_chunks_change_no_bit(
    preset: str, cuts: list[int], with_advance: bool
) -> None:
    events, (whole, expected) = busy_stream(), uncut(preset)
    fly, found, start = FlyDetector(whole.config), list[MotionEstimate](), 0
    for cut in [*sorted(c % events.size for c in cuts), events.size]:
        found += fly.push(events[start:cut])
        if with_advance and cut < events.size:
            found += fly.advance(int(events["t"][cut]))
        start = cut
    found += fly.advance(int(events["t"][-1]) + 200_000)
    assert found == expected
    np.testing.assert_array_equal(fly.maps.motion, whole.maps.motion)


@settings(max_examples=5, deadline=None)
@given(start=st.integers(0, 20_000), size=st.integers(50, 400))
def test_event_by_event_gives_the_same_estimates_as_at_once(start: int, size: int) -> None:
    events = busy_stream()[start : start + size]
    fly = FlyDetector()
    found = [e for n in range(size) for e in fly.push(events[n : n + 1])]
    assert found == FlyDetector().push(events)


def test_an_estimate_is_returned_with_the_first_event_at_or_after_its_end() -> None:
    fly = FlyDetector()
    assert fly.push(one_event(9_999)) == []
    assert [e.t_us for e in fly.push(one_event(10_000))] == [10_000]
    assert [e.t_us for e in fly.push(one_event(35_000))] == [20_000, 30_000]


def test_advance_returns_every_due_estimate_once() -> None:
    fly = FlyDetector()
    assert [e.t_us for e in fly.advance(30_000)] == [10_000, 20_000, 30_000]
    assert fly.advance(30_000) == []
    assert fly.advance(39_999) == []


def test_an_empty_stream_and_a_single_event_give_none() -> None:
    fly = FlyDetector()
    assert fly.push(empty_events()) == []
    fly.push(one_event(5_000))
    found = fly.advance(200_000)
    assert len(found) == 20
    for e in found:
        assert e.direction is Direction.NONE
        assert (e.hs, e.vs, e.strength, e.roi_px) == (0.0, 0.0, 0.0, None)
        assert e.view_centre_px == (173.0, 130.0)


@pytest.mark.parametrize(
    "bad",
    [
        np.array([(30_000, 1, 1, 1), (20_000, 1, 1, 1)], EVENT_DTYPE),
        one_event(30_000, x=346),
        one_event(30_000, y=-1),
        one_event(11_000),
        np.zeros(4),
    ],
)
def test_a_refused_chunk_changes_nothing(bad: Events) -> None:
    fly, other = FlyDetector(), FlyDetector()
    for detector in (fly, other):
        detector.push(one_event(12_000))
    with pytest.raises(EventError):
        fly.push(bad)
    assert fly.push(busy_stream()[5_000:]) == other.push(busy_stream()[5_000:])


def test_time_that_goes_back_is_refused() -> None:
    fly = FlyDetector()
    fly.advance(50_000)
    with pytest.raises(EventError, match="Time 40000 µs comes after time 50000 µs"):
        fly.advance(40_000)
    with pytest.raises(EventError):
        fly.push(one_event(49_999))
    assert fly.push(one_event(50_000)) == []


def test_after_a_refused_nan_the_order_is_still_checked() -> None:
    fly = FlyDetector()
    fly.advance(50_000)
    with pytest.raises(EventError, match=r"time is nan\. Allowed is a whole number"):
        fly.advance(float("nan"))  # type: ignore[arg-type]
    with pytest.raises(EventError, match="Time 40000 µs comes after time 50000 µs"):
        fly.advance(40_000)


@pytest.mark.parametrize("with_advance", [False, True])
def test_a_gap_of_hours_costs_no_more_than_the_quiet_limit(with_advance: bool) -> None:
    fly = FlyDetector(FlyConfig(quiet_limit_us=1_000_000))
    hours_us = 5 * 3600 * 10**6
    fly.push(one_event(5_000))
    found = fly.advance(hours_us // 2) if with_advance else []
    found += fly.push(one_event(hours_us + 12_345))
    assert [found[0].t_us, found[-1].t_us] == [10_000, 1_000_000]
    assert len(found) == 100
    assert [e.t_us for e in fly.advance(hours_us + 30_000)] == [
        hours_us + 20_000,
        hours_us + 30_000,
    ]


def test_after_a_gap_the_fly_decides_like_a_new_one() -> None:
    config = FlyConfig(quiet_limit_us=1_000_000)
    later = busy_stream().copy()
    later["t"] += 3600 * 10**6
    fly = FlyDetector(config)
    fly.push(busy_stream())
    after = [e for e in fly.push(later) if e.t_us >= 3600 * 10**6]
    fresh = FlyDetector(config).push(later)
    assert [e.direction for e in after] == [e.direction for e in fresh]
    np.testing.assert_allclose([e.hs for e in after], [e.hs for e in fresh], rtol=1e-6)


def test_after_a_quiet_gap_estimates_equal_those_of_a_new_fly() -> None:
    config = FlyConfig(quiet_limit_us=100_000)
    before, view_us = crossing(
        textured_box(), speed_px_s=1000, direction=Direction.RIGHT, lead_us=1_000
    )
    before = before[before["t"] < 200_000]
    later = before.copy()
    later["t"] += 3600 * 10**6
    end_us = 3600 * 10**6 + 200_000
    fly, fresh = FlyDetector(config), FlyDetector(config)
    assert view_us > 200_000
    assert fly.push(before)
    expected = fresh.push(later) + fresh.advance(end_us)
    assert Direction.RIGHT in {e.direction for e in expected}
    found = fly.push(later) + fly.advance(end_us)
    assert [e for e in found if e.t_us > 3600 * 10**6] == expected


@pytest.mark.parametrize("early_us", [10 * 3600 * 10**6, 61_000_000, 10 * 3600 * 10**6 - 12_345])
def test_an_advance_before_a_late_first_event_changes_no_estimate(early_us: int) -> None:
    later = busy_stream().copy()
    later["t"] += 10 * 3600 * 10**6
    fly = FlyDetector()
    assert fly.advance(early_us) == []
    found = fly.push(later)
    assert found
    assert found == FlyDetector().push(later)


def test_memory_beyond_the_input_stays_under_100_mb() -> None:
    rng = np.random.default_rng(0)
    events = np.zeros(1_000_000, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 100_000, events.size))
    events["x"], events["y"] = rng.integers(0, 346, events.size), rng.integers(0, 260, events.size)
    FlyDetector().push(events[:200_000])  # Memory for compilation does not count.
    tracemalloc.start()
    try:
        fly = FlyDetector()
        found = fly.push(events)
        peak_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found
    assert 1e6 < peak_bytes < 100e6


def test_a_stream_that_begins_late_starts_with_its_first_event() -> None:
    unix_us = 1_700_000_000_000_000
    fly = FlyDetector()
    assert fly.push(one_event(unix_us)) == []
    assert [e.t_us for e in fly.advance(unix_us + 20_000)] == [unix_us + 10_000, unix_us + 20_000]


def test_maps_are_those_of_the_last_estimate_and_do_not_change_later() -> None:
    events = busy_stream()
    half = events.size // 2
    fly = FlyDetector()
    fly.push(events[:half])
    maps = fly.maps
    kept = maps.motion.copy()
    fly.push(events[half:])
    np.testing.assert_array_equal(maps.motion, kept)
    assert maps.on.shape == maps.off.shape == maps.saliency.shape == (87, 116)
    assert maps.motion.shape == (4, 87, 116)
    assert maps.attended.dtype == np.bool_
    assert maps.motion[:, maps.attended].sum() > 0.0


@pytest.mark.parametrize("direction", [Direction.RIGHT, Direction.DOWN])
@pytest.mark.parametrize(("field", "system"), [("x", 0), ("y", 1)])
def test_a_mirrored_stream_gives_the_opposite_response(
    direction: Direction, field: str, system: int
) -> None:
    # The sensor has whole cells only, so that its grid is symmetric.
    side_px = {"x": 345, "y": 258}
    events, view_us = crossing(car(150, 45), speed_px_s=518, direction=direction)
    events = events[(events["x"] < side_px["x"]) & (events["y"] < side_px["y"])]
    mirrored = events.copy()
    mirrored[field] = side_px[field] - 1 - events[field]
    responses = []
    for stream in (events, mirrored):
        fly = FlyDetector(width=side_px["x"], height=side_px["y"])
        found = fly.push(stream) + fly.advance(view_us)
        responses.append(np.array([e.response for e in found]))
    responses[1][:, system] *= -1.0
    assert np.abs(responses[0]).max() > 1000.0
    np.testing.assert_allclose(responses[1], responses[0], rtol=1e-5, atol=0.01)


def test_a_search_square_may_contain_no_cell() -> None:
    fly = FlyDetector(FlyConfig(roi_radius_px=1), width=348)
    found = fly.push(busy_stream())
    assert found


@pytest.mark.parametrize("bad", [346.0, "346", None, True])
@pytest.mark.parametrize("side", ["width", "height"])
def test_a_side_that_is_not_a_whole_number_is_refused(side: str, bad: object) -> None:
    with pytest.raises(
        DetectorConfigError, match=rf"{side} is {bad!r}\. Allowed is a whole number"
    ):
        FlyDetector(**{side: bad})  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", ["wide", {}, 0])
def test_a_value_that_is_not_a_configuration_is_refused(bad: object) -> None:
    with pytest.raises(DetectorConfigError, match=r"configuration is .*FlyConfig\.preset"):
        FlyDetector(bad)  # type: ignore[arg-type]


def test_times_before_0_and_too_late_times_are_refused() -> None:
    fly = FlyDetector()
    with pytest.raises(DetectorError, match=rf"time is {2**63} µs\. Allowed is up to"):
        fly.advance(2**63)
    with pytest.raises(DetectorError, match=r"times start at 0\. Subtract the first time"):
        fly.push(one_event(-5))
    with pytest.raises(DetectorError, match=r"times start at 0\. Subtract the first time"):
        fly.advance(-5)
    assert [e.t_us for e in fly.push(one_event(10_000))] == [10_000]


def test_a_sensor_smaller_than_a_correlation_distance_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match=r"sensor is 346×14 px\. Allowed is 15 to 32767"):
        FlyDetector(height=14)
