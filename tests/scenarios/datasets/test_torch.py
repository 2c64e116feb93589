"""The documented example of a DataLoader. It needs PyTorch, which is large, and skips without."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from scenarios.datasets.slicing import read_events

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "explanation" / "datasets.md"


def test_the_documented_loader_runs(root: Path, tmp_path: Path) -> None:
    pytest.importorskip("torch")
    (code,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    script = tmp_path / "example.py"
    script.write_text(code)
    shutil.copytree(root, tmp_path / "logs/dataset/streets")
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) >= 2
    assert lines[0].startswith("torch.Size([2, 5, 64, 96]) torch.Size([2, 2, 64, 96]) tensor([")


def test_a_batch_holds_tensors_where_samples_agree_and_lists_elsewhere(root: Path) -> None:
    torch = pytest.importorskip("torch")
    from scenarios.datasets import EventDataset, collate

    samples = EventDataset(root, window_us=20_000, labels=["depth", "boxes", "motion"])
    batch = collate([samples[1], samples[2]])
    assert batch["depth"].shape == (2, 64, 96)
    assert batch["depth"].dtype == torch.float32
    assert batch["direction"].tolist() == [samples[1]["direction"], samples[2]["direction"]]
    assert isinstance(batch["events"], list)
    assert isinstance(batch["boxes"], list)
    assert len(batch["events"][1]) == len(samples[2]["events"])
    assert batch["sequence"] == [samples[1]["sequence"], samples[2]["sequence"]]


def test_the_dataset_loads_neither_torch_nor_the_simulator() -> None:
    script = (
        "import sys, flybench; flybench.EventDataset; "
        "print(bool({'torch', 'mujoco', 'matplotlib', 'rerun'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "False\n"), done.stderr


def test_the_example_trains_a_network_that_is_a_detector(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("torch")
    weights = tmp_path / "network.pt"
    script = ROOT / "examples" / "learned_direction" / "train.py"
    done = subprocess.run(
        [sys.executable, str(script), str(root), "--weights", str(weights), "--step", "1"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert "samples to train on: right " in lines[0]
    assert lines[-2].startswith("fly  ")
    assert lines[-1].startswith("learned direction ")
    from scenarios.pipeline.user_detectors import find_method

    monkeypatch.setenv("LEARNED_DIRECTION", str(weights))
    monkeypatch.chdir(ROOT)
    method = find_method("examples.learned_direction.network:LearnedDirection")
    estimates = method.make(width=97, height=65).advance(100_000)
    assert [estimate.direction for estimate in estimates] == ["none"] * 10
    with h5py.File(root / "test/0000/events/left/events.h5") as file:
        events = read_events(file, 0, len(file["events/t"]))
    estimates = method.make(width=97, height=65).push(events)
    assert len(estimates) == events["t"][-1] // 10_000
    assert all(-1 <= estimate.hs <= 1 for estimate in estimates)
