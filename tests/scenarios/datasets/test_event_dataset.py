"""Samples of a dataset: which events and which labels they hold."""

import json
import multiprocessing
import pickle
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from detector.fly.detector import FlyDetector
from flybench.events import EVENT_DTYPE, Events
from scenarios.dataset.labels.png import decode_flow, read_png
from scenarios.datasets import EventDataset, Slicing, voxel_grid
from scenarios.datasets.slicing import first_event_at, read_events
from scenarios.errors import ScenarioError

NAMES = ["flow", "flow_backward", "velocity", "depth", "masks", "images", "boxes", "motion"]
PERIOD_US = 50_000


def all_events(root: Path, name: str) -> Events:
    with h5py.File(root / name / "events/left/events.h5") as file:
        return read_events(file, 0, len(file["events/t"]))


@pytest.mark.parametrize("after", [False, True])
def test_slices_of_equal_time_hold_exactly_the_events_of_their_window(
    root: Path, after: bool
) -> None:
    samples = EventDataset(root, window_us=33_333, after=after)
    every = [samples[k] for k in range(len(samples))]
    assert {sample["sequence"] for sample in every} == {"train/0000", "train/0001", "test/0000"}
    for sample in every:
        t = all_events(root, sample["sequence"])["t"]
        start_us = sample["t_us"] - (0 if after else 33_333)
        inside = np.count_nonzero((t >= start_us) & (t < start_us + 33_333))
        assert len(sample["events"]) == inside
        assert start_us <= sample["events"]["t"].min()
        assert sample["events"]["t"].max() < start_us + 33_333
    if not after:
        assert min(sample["t_us"] for sample in every) == PERIOD_US


@pytest.mark.parametrize("after", [False, True])
def test_slices_of_equal_number_touch_their_label(root: Path, after: bool) -> None:
    samples = EventDataset(root, "train", count=2000, after=after)
    assert len(samples) > 4
    for k in range(len(samples)):
        sample = samples[k]
        events, whole = sample["events"], all_events(root, sample["sequence"])
        at = int(np.searchsorted(whole["t"], sample["t_us"]))
        expected = whole[at : at + 2000] if after else whole[at - 2000 : at]
        assert (events == expected).all()
        assert len(events) == 2000


def test_labels_belong_to_the_time_of_the_sample(root: Path) -> None:
    samples = EventDataset(root, "train", window_us=10_000, labels=NAMES)
    summary = json.loads((root / "train/0000/summary.json").read_text())
    of_first = [k for k in range(len(samples)) if samples[k]["sequence"] == "train/0000"]
    assert len(of_first) == summary["label_times"] - 2  # flow forward and backward
    for k in of_first:
        sample = samples[k]
        folder, number = root / sample["sequence"], sample["t_us"] // PERIOD_US
        name = f"{number:06d}.png"
        flow, valid = decode_flow(read_png(folder / "flow/forward" / name))
        assert (sample["flow"] == np.moveaxis(flow, -1, 0)).all()
        assert (sample["flow_valid"] == valid).all()
        assert (sample["masks"] == read_png(folder / "masks" / name)).all()
        assert sample["images"].shape == (3, 64, 96)
        assert sample["velocity"].shape == sample["flow_backward"].shape == (2, 64, 96)
        assert sample["depth"].min() > 1
        assert set(sample["boxes"]["t"]) <= {sample["t_us"]}
        assert sample["direction"] == ["right", "left", "up", "down"].index(summary["direction"])
        moving = np.abs(sample["velocity"]).max() > 100  # too fast for the pedestrian
        assert moving == (sample["masks"] == 1).any()


def test_time_surfaces_are_those_of_the_fly(root: Path) -> None:
    samples = EventDataset(root, "test", representation="time_surface")
    assert len(samples) >= 4
    for k in range(len(samples)):
        sample = samples[k]
        fly = FlyDetector(width=96, height=64)
        events = all_events(root, sample["sequence"])
        fly.push(events[events["t"] < sample["t_us"]])
        fly.advance(sample["t_us"])
        assert sample["events"] == pytest.approx(np.stack([fly.maps.off, fly.maps.on]), abs=1e-6)
        assert sample["events"].max() > 0


def test_every_event_adds_its_polarity_to_a_voxel_grid() -> None:
    events = np.zeros(3, EVENT_DTYPE)
    events["t"], events["x"], events["y"] = (0, 25, 100), (0, 1, 2), (0, 0, 1)
    events["p"] = (True, False, True)
    grid = voxel_grid(events, start_us=0, end_us=100, bins=3, width=3, height=2)
    assert grid.shape == (3, 2, 3)
    assert grid[:, 0, 0].tolist() == [1, 0, 0]
    assert grid[:, 0, 1].tolist() == [-0.5, -0.5, 0]
    assert grid[:, 1, 2].tolist() == [0, 0, 1]
    assert np.count_nonzero(grid) == 4
    one = voxel_grid(events, start_us=0, end_us=100, bins=1, width=3, height=2)
    assert one.sum() == 1


def test_voxel_grids_have_the_sum_of_the_polarities(root: Path) -> None:
    grids = EventDataset(root, "train", window_us=50_000, representation="voxel_grid", bins=5)
    plain = EventDataset(root, "train", window_us=50_000)
    assert len(grids) == len(plain)
    for k in range(len(grids)):
        signs = np.where(plain[k]["events"]["p"], 1, -1)
        assert grids[k]["events"].shape == (5, 64, 96)
        assert grids[k]["events"].sum() == pytest.approx(signs.sum(), abs=0.1)
    counted = EventDataset(root, "train", count=500, representation="voxel_grid", bins=5)
    assert counted[0]["events"].shape == (5, 64, 96)


@given(st.lists(st.integers(0, 4999), max_size=30), st.integers(0, 5000))
def test_the_first_event_at_a_time_is_found(times: list[int], t_us: int) -> None:
    t = np.sort(np.array(times, np.int64))
    file = {"events/t": t, "ms_to_idx": np.searchsorted(t, np.arange(6) * 1000)}
    assert first_event_at(file, t_us) == np.searchsorted(t, t_us)


def read_sample(samples: EventDataset, k: int) -> Any:
    return samples[k]["events"]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # fork in a process with threads
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_workers_that_share_a_dataset_read_the_same_samples(root: Path, method: str) -> None:
    samples = EventDataset(root, window_us=20_000)
    here = [samples[k]["events"] for k in range(len(samples))]  # files are open before the fork
    with multiprocessing.get_context(method).Pool(2) as pool:
        there = pool.starmap(read_sample, [(samples, k) for k in range(len(samples))])
    assert all((a == b).all() for a, b in zip(here, there, strict=True))
    assert (samples[0]["events"] == here[0]).all()
    assert (pickle.loads(pickle.dumps(samples))[0]["events"] == here[0]).all()


def test_few_files_are_open_at_once(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenarios.datasets.event_dataset._OPEN_FILES", 1)
    samples = EventDataset(root, window_us=20_000)
    first, last = samples[0]["events"], samples[len(samples) - 1]["events"]
    assert (samples[0]["events"] == first).all()
    assert not np.array_equal(first, last)


def test_a_transform_of_tonic_takes_the_events(root: Path) -> None:
    tonic = pytest.importorskip("tonic")
    size = (96, 64, 2)
    to_frame = tonic.transforms.ToFrame(sensor_size=size, n_time_bins=4)
    frames = EventDataset(root, "train", window_us=50_000, transform=to_frame)
    plain = EventDataset(root, "train", window_us=50_000)
    assert frames[3]["events"].shape == (4, 2, 64, 96)
    assert 0.95 * len(plain[3]["events"]) <= frames[3]["events"].sum() <= len(plain[3]["events"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, r"window_us is None and count is None\. Allowed is one of them"),
        ({"window_us": 10, "count": 10}, r"window_us is 10 and count is 10\."),
        ({"window_us": 0}, r"window_us is 0 and"),
        ({"count": 5, "split": "val"}, r"split is 'val'\. Allowed .* one of train, test\. Leave"),
        ({"count": 5, "labels": ["flows"]}, r"labels holds 'flows'\. Allowed .* is flow, "),
        ({"count": 5, "representation": "cube"}, r"representation is 'cube'\. Allowed is one of"),
        ({"count": 5, "representation": "time_surface"}, r"count is 5 for time surfaces\. Their"),
        ({"count": 5, "bins": 0}, r"bins is 0\. Allowed is 1 or more\."),
        (
            {"count": 5, "representation": "voxel_grid", "transform": len},
            r"representation is 'voxel_grid' and a transform is given\.",
        ),
    ],
)
def test_bad_arguments_are_refused(root: Path, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        EventDataset(root, **arguments)


def test_a_folder_without_a_finished_dataset_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"holds no complete dataset: .*summary\.json is mis"):
        EventDataset(tmp_path, count=5)
    with pytest.raises(ScenarioError, match="Allowed is one of them"):
        Slicing()
