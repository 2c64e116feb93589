from typing import Any

import numpy as np
import pytest

from emulator import EventSensor, FrameError, SensorConfigError
from tests.emulator.stimuli import (
    moving_texture,
    noise_free_config,
    noisy_config,
    run_sensor,
    uniform_frame,
)


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (np.float32("nan"), "luminance nan cd/m² at row 2, column 3"),
        (np.float32("inf"), "luminance inf cd/m² at row 2, column 3"),
        (np.float32(-1.0), r"luminance -1.0 cd/m² at row 2, column 3. Allowed is 0 to 1e\+10"),
    ],
)
def test_invalid_luminance_is_refused(bad: np.float32, words: str) -> None:
    frame = uniform_frame(1.0, noise_free_config())
    frame[2, 3] = bad
    with pytest.raises(FrameError, match=words):
        EventSensor(noise_free_config(), seed=1).step(0, frame)


def test_negative_values_that_float32_rounds_to_zero_are_refused() -> None:
    frame = uniform_frame(1.0, noise_free_config()).astype(np.float64)
    frame[1, 2] = -1e-300
    with pytest.raises(FrameError, match="luminance -1e-300 cd/m² at row 1, column 2"):
        EventSensor(noise_free_config(), seed=1).step(0, frame)
    frame[1, 2] = -0.0
    EventSensor(noise_free_config(), seed=1).step(0, frame)


def test_rows_of_different_length_are_refused() -> None:
    with pytest.raises(FrameError, match=r"list that cannot become an array\. Allowed"):
        EventSensor(noise_free_config(), seed=1).step(0, [[1.0], [1.0, 2.0]])


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ([1, 2], "is not a pair but a int. Allowed are"),
        ([(0, 1, 2)], "is not a pair but a tuple"),
        (None, "frames are None. Allowed is an iterable"),
    ],
)
def test_a_stream_of_other_items_than_pairs_is_refused(frames: Any, words: str) -> None:
    with pytest.raises(FrameError, match=words):
        list(EventSensor(noise_free_config(), seed=1).stream(frames))


def test_an_error_in_the_source_of_the_frames_is_raised() -> None:
    def broken() -> Any:
        yield 0, uniform_frame(1.0, noise_free_config())
        raise TypeError("the renderer's own")

    with pytest.raises(TypeError, match="the renderer's own"):
        list(EventSensor(noise_free_config(), seed=1).stream(broken()))


def test_a_wrong_shape_is_refused() -> None:
    with pytest.raises(FrameError, match=r"shape \(16, 12\). Allowed is \(12, 16\)"):
        EventSensor(noise_free_config(), seed=1).step(0, np.ones((16, 12), np.float32))


def test_grey_levels_are_refused() -> None:
    with pytest.raises(FrameError, match="dtype uint8"):
        EventSensor(noise_free_config(), seed=1).step(0, np.ones((12, 16), np.uint8))


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (1000, "1000 µs after a frame at 1000 µs"),
        (999, "999 µs after"),
        (1000 + 2**30, "without gaps of minutes"),
        (1000.5, "Allowed is a whole number of µs"),
        (2**63, "the time is 9223372036854775808 µs. Allowed is"),
    ],
)
def test_times_out_of_order_are_refused(time: Any, words: str) -> None:
    sensor = EventSensor(noise_free_config(), seed=1)
    sensor.step(1000, uniform_frame(1.0, noise_free_config()))
    with pytest.raises(FrameError, match=words):
        sensor.step(time, uniform_frame(1.0, noise_free_config()))


def test_a_refused_frame_leaves_the_sensor_unchanged() -> None:
    config = noisy_config()
    samples = [(t, uniform_frame(1.0 + t / 5000, config)) for t in range(0, 20_000, 1000)]
    whole, _ = run_sensor(config, samples, seed=4)
    sensor = EventSensor(config, seed=4)
    before = [o.events for o in sensor.stream(samples[:10])]
    with pytest.raises(FrameError):
        sensor.step(9500, uniform_frame(-1.0, config))
    after = [o.events for o in sensor.stream(samples[10:])]
    assert np.array_equal(np.concatenate(before + after), whole)
    assert whole.size > 0


@pytest.mark.parametrize("seed", [-1, 1.5, True])
def test_an_invalid_seed_is_refused(seed: Any) -> None:
    with pytest.raises(SensorConfigError, match="the seed is"):
        EventSensor(noise_free_config(), seed=seed)


@pytest.mark.parametrize("integer", [np.int32, np.int64, np.uint64])
def test_numpy_times_and_double_precision_give_the_same_events(integer: Any) -> None:
    samples = list(moving_texture(20))
    whole, _ = run_sensor(noisy_config(), samples, seed=4)
    other, _ = run_sensor(
        noisy_config(), [(integer(t), frame.astype(np.float64)) for t, frame in samples], seed=4
    )
    assert other.dtype == whole.dtype
    assert other.tobytes() == whole.tobytes()
    assert whole.size > 0


@pytest.mark.parametrize("time_us", [2**63, -(2**63) - 1, 10**30])
def test_a_first_time_beyond_64_bits_is_refused(time_us: int) -> None:
    with pytest.raises(FrameError, match="in 64 bits"):
        EventSensor(noise_free_config(), seed=1).step(
            time_us, uniform_frame(1.0, noise_free_config())
        )


@pytest.mark.parametrize("config", ["davis346", None])
def test_a_sensor_needs_a_configuration(config: Any) -> None:
    with pytest.raises(SensorConfigError, match=r"Allowed is a SensorConfig.*preset\('davis346'\)"):
        EventSensor(config, seed=1)
