"""IMU samples and triggers beside the events of a file."""

from dataclasses import replace
from pathlib import Path

import dv_processing as dv
import numpy as np
import pytest

from formats import Chunk, FormatError, TriggerKind, open_events, open_writer, write_events
from formats.held_back import HeldBack
from formats.samples import IMU_DTYPE
from tests.formats.sample_files import SIZE, random_frames

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


def test_a_stated_unit_of_time_holds_for_samples_too(tmp_path: Path) -> None:
    write_with_dv(tmp_path / "a.aedat4")
    with open_events(tmp_path / "a.aedat4", time_unit="ns") as file:
        chunks = list(file)
    start_us = START_US // 1000
    assert chunks[0].events["t"][0] == start_us
    imu = np.concatenate([chunk.imu for chunk in chunks])
    assert imu["t"].tolist() == list(range(start_us - 3, start_us + 37))
    triggers = np.concatenate([chunk.triggers for chunk in chunks])
    assert triggers["t"].tolist() == [start_us, start_us + 9]


def test_triggers_of_prophesee_raw(tmp_path: Path) -> None:
    words = np.array([0x8000, 0x6005, 0x0003, 0x2007, 0xA101, 0x6009, 0xA100, 0x2808], "<u2")
    header = b"% evt 3.0\n% format EVT3;height=260;width=346\n% end\n"
    (tmp_path / "a.raw").write_bytes(header + words.tobytes())
    with open_events(tmp_path / "a.raw") as file:
        (chunk,) = file
    assert chunk.events.tolist() == [(5, 7, 3, False), (9, 8, 3, True)]
    rises, falls = TriggerKind.EXTERNAL_RISING_EDGE, TriggerKind.EXTERNAL_FALLING_EDGE
    assert chunk.triggers.tolist() == [(5, rises, 1), (9, falls, 1)]


def test_samples_without_events_after_them_are_not_held_back_for_ever() -> None:
    held, sample = HeldBack(), np.zeros(1 << 15, IMU_DTYPE)
    released = 0
    for _ in range(5):
        held.add(b"I", bytearray(sample.tobytes()))
        if held.is_full:
            released += Chunk(np.empty(0), *held.release_some()).imu.size
    assert released == 3 << 15
    assert held.release()[1].size == 2 << 15


def test_samples_are_written_to_aedat4_in_order_of_time(tmp_path: Path) -> None:
    write_with_dv(tmp_path / "a.aedat4")
    frame = random_frames(1)[0]
    with open_events(tmp_path / "a.aedat4") as file:
        chunks = list(file)
        chunks[-1] = replace(chunks[-1], frames=(frame,))
        write_events(tmp_path / "b.aedat4", chunks, width=346, height=260)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.aedat4", "b.aedat4"]
    with open_events(tmp_path / "b.aedat4") as file:
        written = list(file)
    for name in ("events", "imu", "triggers"):
        before, after = (
            np.concatenate([getattr(chunk, name) for chunk in part]) for part in (chunks, written)
        )
        assert np.array_equal(before[before["t"] >= 0], after)
    assert file.statistics.frames == 1
    recording = dv.io.MonoCameraRecording(str(tmp_path / "b.aedat4"))
    imu, triggers = recording.getNextImuBatch(), recording.getNextTriggerBatch()
    assert imu is not None
    assert triggers is not None
    assert imu[4].getAccelerations() == pytest.approx([6.867, -9.81, 4.905], rel=1e-4)  # m/s²
    assert triggers[1].type == dv.TriggerType.APS_EXPOSURE_END


def test_formats_without_samples_refuse_them(tmp_path: Path) -> None:
    sample = np.zeros(1, IMU_DTYPE)
    with (
        open_writer(tmp_path / "a.npz", width=9, height=9) as writer,
        pytest.raises(FormatError, match="without IMU samples"),
    ):
        writer.write_samples(sample)
    sample["t"] = -5
    with (
        open_writer(tmp_path / "a.aedat4", width=9, height=9) as writer,
        pytest.raises(FormatError, match="a sample has the time -5 µs"),
    ):
        writer.write_samples(sample)
