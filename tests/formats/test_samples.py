"""IMU samples and triggers beside the events of a file."""

from pathlib import Path

import dv_processing as dv
import numpy as np
import pytest

from formats import Chunk, TriggerKind, open_events
from formats.held_back import HeldBack
from formats.samples import IMU_DTYPE
from tests.formats.sample_files import SIZE

START_US = 1_700_000_000_000_000
"""A wall-clock time, as DV writes it [µs]."""


def write_with_dv(path: Path, *, imu: int = 40, events: int = 200) -> None:
    config = dv.io.MonoCameraWriter.Config("test")
    config.addEventStream(SIZE)
    config.addImuStream()
    config.addTriggerStream()
    writer = dv.io.MonoCameraWriter(str(path), config)
    for k in range(imu):  # from 3 ms before the first event
        t = START_US + 1000 * (k - 3)
        writer.writeImu(dv.IMU(t, 25.5, 0.1 * k, -1, 0.5, 10, 20, 30 + k, 1, 2, 3))
    writer.writeTrigger(dv.Trigger(START_US + 500, dv.TriggerType.EXTERNAL_SIGNAL_RISING_EDGE))
    writer.writeTrigger(dv.Trigger(START_US + 9500, dv.TriggerType.APS_EXPOSURE_END))
    store = dv.EventStore()
    for k in range(events):
        store.push_back(START_US + 100 * k, k % 346, k % 260, k % 3 == 0)
    writer.writeEvents(store)
    del writer


def test_imu_samples_and_triggers_of_aedat4(tmp_path: Path) -> None:
    write_with_dv(tmp_path / "a.aedat4")
    with open_events(tmp_path / "a.aedat4") as file:
        chunks = list(file)
    assert (file.statistics.events, file.statistics.imu, file.statistics.triggers) == (200, 40, 2)
    assert file.origin_us == START_US
    imu = np.concatenate([chunk.imu for chunk in chunks])
    assert imu["t"].tolist() == list(range(-3000, 37_000, 1000))
    assert imu["acceleration_g"][7] == pytest.approx([0.7, -1, 0.5])
    assert imu["rotation_deg_s"][7] == pytest.approx([10, 20, 37])
    assert imu["magnetic_ut"][7] == pytest.approx([1, 2, 3])
    assert imu["temperature_c"][7] == 25.5
    triggers = np.concatenate([chunk.triggers for chunk in chunks])
    assert triggers["t"].tolist() == [500, 9500]
    kinds = [TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXPOSURE_END]
    assert triggers["kind"].tolist() == kinds


def test_samples_without_events_after_them_are_not_held_back_for_ever() -> None:
    held, sample = HeldBack(), np.zeros(1 << 15, IMU_DTYPE)
    released = 0
    for _ in range(5):
        held.add(b"I", bytearray(sample.tobytes()))
        if held.is_full:
            released += Chunk(np.empty(0), *held.release_some()).imu.size
    assert released == 3 << 15
    assert held.release()[1].size == 2 << 15
