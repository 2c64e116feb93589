"""The passes over batches of noisy pixels, against the same pixels taken through a step singly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import emulator.sensor
from emulator import SensorConfig
from emulator.pixel import fields as at
from emulator.pixel.active_pixels import ActiveMasks, ThreadShare
from emulator.pixel.batch import OTHER, Batch, gather, rounded_up
from emulator.pixel.noisy.batch import follow_quiet
from emulator.pixel.noisy.step import step_noisy
from emulator.pixel.state import PixelModel, PixelState, StepTimes
from emulator.pixel.step import fill_batch, update_block_wake
from emulator.readout.config import UNLIMITED
from emulator.readout.event_keys import Keys
from flybench.events import Cause, Events
from tests.emulator.stimuli import HEIGHT, WIDTH, moving_texture, run_sensor

CONFIG = SensorConfig(width=WIDTH, height=HEIGHT, readout=UNLIMITED)


def step_singly(
    state: PixelState,
    model: PixelModel,
    luminance: npt.NDArray[np.float32],
    times: StepTimes,
    masks: ActiveMasks,
    share: ThreadShare,
    batch: Batch,
    keys: Keys,
    most: int,
) -> tuple[Keys, int]:
    """Take the pixels through a step as `step_pixels` does, but all of them one by one."""
    span_us = np.float64(times.to_us - times.from_us)
    used = block = 0
    while block < masks.changed.size:
        block, count = fill_batch(masks, block, share.parts, batch)
        gather(state, model, luminance, times.from_us, batch, count)
        follow_quiet(batch, model, rounded_up(count), span_us)
        batch.fields[at.OUTCOME : at.OUTCOME + count] = OTHER
        done, used = step_noisy(state, model, luminance, times, batch, 0, count, keys, used)
        assert done == count
    update_block_wake(state, masks, np.int32(times.to_us), share)
    return keys, used


def first_us(events: Events) -> npt.NDArray[np.int64]:
    """Return the time of the first event of each pixel, −1 for pixels without one [µs]."""
    pixel = events["y"].astype(np.int64) * WIDTH + events["x"]
    times = np.full(WIDTH * HEIGHT, -1)
    found, index = np.unique(pixel, return_index=True)
    times[found] = events["t"][index]
    return times


@pytest.mark.parametrize(
    ("level", "changes", "median_us"),
    [
        (300.0, {}, 5),
        (1.0, {}, 5),
        (0.1, {"noise_sigma": 0.12}, 100),
        (1.0, {"follower_hz": 0.0, "bandwidth_hz_per_lux": 300.0}, 5),
        (300.0, {"refractory_us": 2500, "noise_sigma": 0.15}, 5),
    ],
    ids=["day", "night", "dark", "no follower", "long reset"],
)
def test_batches_give_the_events_that_single_pixels_give(
    level: float, changes: dict[str, Any], median_us: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The random numbers are equal, so that the same events come at almost the same times.

    In the dark the time constants are 10 to 100 times those of the others.
    """
    config = replace(CONFIG, **changes)
    samples = list(moving_texture(400, level=level))
    batches, causes = run_sensor(config, samples)
    monkeypatch.setattr(emulator.sensor, "step_pixels", step_singly)
    single, single_causes = run_sensor(config, samples)
    assert single.size > 500
    assert batches.size == pytest.approx(single.size, rel=0.01)
    assert np.mean(batches["p"]) == pytest.approx(np.mean(single["p"]), abs=0.01)
    for cause in Cause:
        expected = np.count_nonzero(single_causes == cause)
        assert np.count_nonzero(causes == cause) == pytest.approx(expected, rel=0.05, abs=30)
    apart_us = np.abs(first_us(batches) - first_us(single))
    assert np.median(apart_us) <= median_us
