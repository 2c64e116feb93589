"""Train a small network to name the direction of motion, and compare it with the fly.

    flybench dataset examples/learned_direction/dataset.toml --out logs/dataset/directions
    python examples/learned_direction/train.py logs/dataset/directions

The network is trained on the split "train" and tested on "test", whose streets it has not seen.
"""

import argparse
import json
import os
import sys
import time
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import torch

sys.path.append(str(Path(__file__).parents[2]))

from examples.learned_direction.network import (
    BINS,
    CLASSES,
    DEFAULT_WEIGHTS,
    WEIGHTS,
    WINDOW_US,
    DirectionNetwork,
    LearnedDirection,
    network_input,
)
from flybench import Direction, EventDataset, FlyDetector
from scenarios.dataset.layout import label_times_us
from scenarios.datasets.label_reading import SequenceLabels
from scenarios.datasets.slicing import read_events

STILL = CLASSES.index(Direction.NONE)
VISIBLE = 0.1
"""A sample has a direction if the image shows this share of the vehicle (assumed)."""
EPOCHS, BATCH, RATE = 10, 32, 2e-3
"""Usual values; they were not tuned on the test split or on recordings."""


def has_walker(summary: dict) -> bool:
    """Return True if a pedestrian walks, so that something moves without a vehicle."""
    return summary["parameters"]["crossing"]["distractors"]["pedestrian"] != "none"


def read_summary(folder: Path) -> dict:
    """Return the summary of a sequence."""
    return json.loads((folder / "summary.json").read_text())


def read_samples(root: Path, split: str, step: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Return inputs, (n, bins, rows, columns) float16, and classes, (n,), of every step-th sample.

    Samples in which a small part of the vehicle is in view, or only a pedestrian, are left out.
    """
    samples = EventDataset(
        root,
        split,
        window_us=WINDOW_US,
        representation="voxel_grid",
        bins=BINS,
        labels=["motion"],
    )
    walkers: dict[str, bool] = {}
    inputs, classes = [], []
    for k in range(0, len(samples), step):
        sample = samples[k]
        name, seen = sample["sequence"], float(sample["visibility"])
        if name not in walkers:
            walkers[name] = has_walker(read_summary(root / name))
        if 0 < seen < VISIBLE or (seen == 0 and walkers[name]):
            continue
        inputs.append(network_input(sample["events"][None]).half())
        classes.append(sample["direction"] if seen else STILL)
    return torch.cat(inputs), torch.tensor(classes)


def turned(x: torch.Tensor, y: torch.Tensor, random: np.random.Generator):
    """Mirror or turn a batch, and change its directions accordingly."""
    for axis, swapped in ((3, (1, 0, 2, 3, 4)), (2, (0, 1, 3, 2, 4))):
        if random.random() < 0.5:
            x, y = x.flip(axis), torch.tensor(swapped)[y]
    if random.random() < 0.5:
        x, y = x.transpose(2, 3), torch.tensor((3, 2, 1, 0, 4))[y]
    return x, y


def train(x: torch.Tensor, y: torch.Tensor, seed: int) -> DirectionNetwork:
    """Train a network; all five classes have the same weight."""
    torch.manual_seed(seed)
    random, network = np.random.default_rng(seed), DirectionNetwork()
    counts = torch.bincount(y, minlength=len(CLASSES)).float()
    loss_of = torch.nn.CrossEntropyLoss(weight=counts.sum() / counts.clamp(min=1) / len(CLASSES))
    steps = EPOCHS * -(-len(y) // BATCH)
    optimizer = torch.optim.Adam(network.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=steps)
    for epoch in range(EPOCHS):
        losses = []
        for part in torch.from_numpy(random.permutation(len(y))).split(BATCH):
            inputs, classes = turned(x[part].float(), y[part], random)
            loss = loss_of(network(inputs), classes)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            losses.append(loss.item())
        print(f"epoch {epoch + 1} of {EPOCHS}: loss {np.mean(losses):.3f}")
    return network


def true_classes(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the times of the labels of a sequence [µs], and their classes; -1: not to score."""
    summary = read_summary(folder)
    times_us = label_times_us(summary["duration_us"], summary["period_us"])
    labels, still = SequenceLabels(folder, times_us), -1 if has_walker(summary) else STILL
    classes = np.full(len(times_us), still)
    for k in range(len(times_us)):
        motion = labels.read("motion", k)
        if motion["visibility"] > 0:
            classes[k] = motion["direction"] if motion["visibility"] >= VISIBLE else -1
    return np.array(times_us), classes


def score(root: Path, split: str, make) -> Counter[str]:
    """Return how many steps of a detector are right, wrong and without a direction.

    A step counts if the whole window has the same truth: a direction, or nothing that moves.
    """
    counts: Counter[str] = Counter()
    for folder in sorted((root / split).iterdir()):
        times_us, classes = true_classes(folder)
        with h5py.File(folder / "events/left/events.h5") as file:
            width, height = int(file.attrs["width"]), int(file.attrs["height"])
            events = read_events(file, 0, len(file["events/t"]))
        for estimate in make(width=width, height=height).push(events):
            within = (times_us >= estimate.t_us - WINDOW_US) & (times_us <= estimate.t_us)
            truth = set(classes[within])
            if len(truth) != 1 or estimate.t_us < times_us[0] + WINDOW_US:
                continue
            (number,) = truth
            if number < 0:
                continue
            named = estimate.direction is not Direction.NONE
            if number == STILL:
                counts["false alarm" if named else "still"] += 1
            else:
                is_right = estimate.direction is CLASSES[number]
                counts["right" if is_right else "wrong" if named else "none"] += 1
    return counts


def row(name: str, counts: Counter[str]) -> str:
    """Return a line of the table."""
    moving = counts["right"] + counts["wrong"] + counts["none"]
    still = counts["still"] + counts["false alarm"]
    shares = [counts[word] / max(moving, 1) for word in ("right", "wrong", "none")]
    shares.append(counts["false alarm"] / max(still, 1))
    return f"{name:18}" + "".join(f"{share:>10.0%}" for share in shares) + f"{moving:>8}{still:>7}"


def main() -> None:
    """Train, test, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path, help="folder that `flybench dataset` has finished")
    parser.add_argument("--weights", type=Path, default=DEFAULT_WEIGHTS, help="file to write")
    parser.add_argument("--step", type=int, default=2, help="use every n-th label (default: 2)")
    parser.add_argument("--seed", type=int, default=0, help="seed (default: 0)")
    arguments = parser.parse_args()
    x, y = read_samples(arguments.dataset, "train", arguments.step)
    shares = ", ".join(f"{word} {int((y == k).sum())}" for k, word in enumerate(CLASSES))
    print(f"{len(y)} samples to train on: {shares}")
    wall_s, cpu_s = time.monotonic(), time.process_time()
    network = train(x, y, arguments.seed)
    wall_s, cpu_s = time.monotonic() - wall_s, time.process_time() - cpu_s
    print(f"trained in {wall_s:.0f} s, {cpu_s:.0f} s of CPU time")
    arguments.weights.parent.mkdir(parents=True, exist_ok=True)
    torch.save(network.state_dict(), arguments.weights)
    os.environ[WEIGHTS] = str(arguments.weights)
    print(f"wrote {arguments.weights}\n\nsteps of the split test:")
    print(f"{'':18}     right     wrong      none    alarms  moving  still")
    print(row("fly", score(arguments.dataset, "test", FlyDetector)))
    print(row("learned direction", score(arguments.dataset, "test", LearnedDirection)))


if __name__ == "__main__":
    main()
