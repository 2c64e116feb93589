from typing import Any

import numpy as np
import pytest

from emulator import Davis346, FrameError, SensorConfigError
from tests.emulator.scenes import flat, moving_texture, noisy, quiet, run


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (np.float32("nan"), "luminance nan cd/m² at row 2, column 3"),
        (np.float32("inf"), "luminance inf cd/m² at row 2, column 3"),
        (np.float32(-1.0), r"luminance -1.0 cd/m² at row 2, column 3; allowed is 0 to 1e\+10"),
    ],
)
def test_light_that_cannot_be_is_refused(bad: np.float32, words: str) -> None:
    frame = flat(1.0, quiet())
    frame[2, 3] = bad
    with pytest.raises(FrameError, match=words):
        Davis346(quiet(), seed=1).step(0, frame)


def test_what_rounding_would_hide_is_refused() -> None:
    frame = flat(1.0, quiet()).astype(np.float64)
    frame[1, 2] = -1e-300
    with pytest.raises(FrameError, match="luminance -1e-300 cd/m² at row 1, column 2"):
        Davis346(quiet(), seed=1).step(0, frame)
    frame[1, 2] = -0.0
    Davis346(quiet(), seed=1).step(0, frame)


def test_rows_of_unlike_length_are_refused() -> None:
    with pytest.raises(FrameError, match="list that makes no array; allowed is"):
        Davis346(quiet(), seed=1).step(0, [[1.0], [1.0, 2.0]])


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ([1, 2], "hold a int that is no pair; allowed are"),
        ([(0, 1, 2)], "hold a tuple that is no pair"),
        (None, "frames are None; allowed is an iterable"),
    ],
)
def test_a_stream_of_anything_but_pairs_is_refused(frames: Any, words: str) -> None:
    with pytest.raises(FrameError, match=words):
        list(Davis346(quiet(), seed=1).stream(frames))


def test_an_error_of_the_frames_own_source_comes_through() -> None:
    def broken() -> Any:
        yield 0, flat(1.0, quiet())
        raise TypeError("the renderer's own")

    with pytest.raises(TypeError, match="the renderer's own"):
        list(Davis346(quiet(), seed=1).stream(broken()))


def test_another_shape_is_refused() -> None:
    with pytest.raises(FrameError, match=r"shape \(16, 12\); allowed is \(12, 16\)"):
        Davis346(quiet(), seed=1).step(0, np.ones((16, 12), np.float32))


def test_grey_levels_are_refused() -> None:
    with pytest.raises(FrameError, match="dtype uint8"):
        Davis346(quiet(), seed=1).step(0, np.ones((12, 16), np.uint8))


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (1000, "1000 µs after a frame at 1000 µs"),
        (999, "999 µs after"),
        (1000 + 2**30, "without gaps of minutes"),
        (1000.5, "allowed is a whole number of µs"),
        (2**63, "the time is 9223372036854775808 µs; allowed is"),
    ],
)
def test_times_that_do_not_go_on_are_refused(time: Any, words: str) -> None:
    sensor = Davis346(quiet(), seed=1)
    sensor.step(1000, flat(1.0, quiet()))
    with pytest.raises(FrameError, match=words):
        sensor.step(time, flat(1.0, quiet()))


def test_a_refused_frame_leaves_the_sensor_as_it_was() -> None:
    config = noisy()
    samples = [(t, flat(1.0 + t / 5000, config)) for t in range(0, 20_000, 1000)]
    whole, _ = run(Davis346(config, seed=4), samples)
    sensor = Davis346(config, seed=4)
    before = [o.events for o in sensor.stream(samples[:10])]
    with pytest.raises(FrameError):
        sensor.step(9500, flat(-1.0, config))
    after = [o.events for o in sensor.stream(samples[10:])]
    assert np.array_equal(np.concatenate(before + after), whole)
    assert whole.size > 0


@pytest.mark.parametrize("seed", [-1, 1.5, True])
def test_a_seed_that_is_none_is_refused(seed: Any) -> None:
    with pytest.raises(SensorConfigError, match="the seed is"):
        Davis346(quiet(), seed=seed)


@pytest.mark.parametrize("integer", [np.int32, np.int64, np.uint64])
def test_numpy_times_and_double_precision_give_the_same_events(integer: Any) -> None:
    samples = list(moving_texture(20))
    whole, _ = run(Davis346(noisy(), seed=4), samples)
    other, _ = run(
        Davis346(noisy(), seed=4), [(integer(t), frame.astype(np.float64)) for t, frame in samples]
    )
    assert other.dtype == whole.dtype
    assert other.tobytes() == whole.tobytes()
    assert whole.size > 0


@pytest.mark.parametrize("time_us", [2**63, -(2**63) - 1, 10**30])
def test_a_first_time_beyond_64_bits_is_refused(time_us: int) -> None:
    with pytest.raises(FrameError, match="in 64 bits"):
        Davis346(quiet(), seed=1).step(time_us, flat(1.0, quiet()))


@pytest.mark.parametrize("config", ["davis346", None])
def test_a_sensor_needs_a_configuration(config: Any) -> None:
    with pytest.raises(SensorConfigError, match=r"allowed is a SensorConfig.*preset\('davis346'\)"):
        Davis346(config, seed=1)
