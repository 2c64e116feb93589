"""Tiny datasets for tests, and sequences that take no time to make."""

import hashlib
import time
from functools import partial
from pathlib import Path

import numpy as np

from flybench.events import EVENT_DTYPE
from formats.writers.dsec import DsecWriter
from scenarios.dataset.layout import EVENTS
from scenarios.dataset.plan import read_plan
from scenarios.dataset.run import DatasetResult, Task, run_dataset
from scenarios.dataset.sequence import Cost, file_digests
from scenarios.dataset.sequence_plan import SequencePlan
from scenarios.output.atomic_folder import SUMMARY, atomic_folder, write_summary
from scenarios.pipeline.parallel import run_locally

TINY = """
title = "Tiny crossings"
license = "CC-BY-4.0"

[splits]
train = 2
test = 1
disjoint = ["street", "vehicle"]

[labels]
wanted = [
    "flow", "velocity", "depth", "masks", "boxes", "coco", "event_source", "event_flow", "motion",
    "camera", "aps", "images", "shard",
]

[sensor]
width = 96
height = 64

[crossing]
omega_rad_s = {uniform = [2.5, 3.5]}
vehicle = {choice = ["sedan", "van"]}
direction = {choice = ["right", "up"]}
street_seed = {uniform = [0, 9]}
distractors.pedestrian = "opposite"
step_px = 8
supersample = 1
lead_s = 0.05

[[variants]]
name = "day"
crossing.lighting = "day"

[[variants]]
name = "night"
crossing.lighting = "night"
"""

QUICK = """
title = "Quick"
license = "CC0-1.0"
[splits]
train = 9
test = 3
[labels]
wanted = ["motion"]
[sensor]
width = 8
height = 6
"""
MADE_S = 0.03


def write_spec(path: Path, text: str = TINY) -> Path:
    path.write_text(text)
    return path


def quick_sequence(plan: SequencePlan, folder: Path) -> None:
    """Write a made-up sequence that depends on the seed of the plan and nothing else."""
    digest = hashlib.sha256(str(plan.seed).encode()).digest()
    events = np.zeros(len(digest), EVENT_DTYPE)
    events["t"], events["x"] = np.arange(len(digest)) * 100, np.frombuffer(digest, np.uint8) % 8
    with atomic_folder(folder) as work:
        (work / EVENTS).parent.mkdir(parents=True)
        with DsecWriter(work / EVENTS, width=8, height=6) as writer:
            writer.write(events)
        time.sleep(MADE_S)
        causes = {"signal": len(events), "leak": 0, "shot": 0, "hot": 0}
        count = {"count": len(events), "on": 0, "off": len(events), "by_cause": causes}
        facts = {
            "command": "dataset",
            "sequence": plan.name,
            "split": plan.split,
            "variant": plan.variant,
            "key": plan.key(),
            "duration_us": 4000,
            "period_us": plan.period_us,
            "label_times": 1,
            "aps_frames": 0,
            "direction": plan.crossing.direction.value,
            "image_speed_px_s": 100.0,
            "illuminance_lux": plan.crossing.illuminance,
            "objects": [],
            "boxes": {},
            "events": count,
            "parameters": {"crossing": plan.crossing.resolved(), "seed": plan.seed},
        }
        write_summary(work, facts | {"sha256": file_digests(work)})


def quick_make(task: Task) -> Cost:
    quick_sequence(task.sequence, task.folder / task.sequence.name)
    return Cost(1.0, 0.5)


def must_not_run(task: Task) -> Cost:
    raise AssertionError("a sequence was made")


def make_quickly(spec: Path, folder: Path) -> DatasetResult:
    """Make a dataset of made-up sequences in this process."""
    return run_dataset(read_plan(spec), folder, partial(run_locally, jobs=1), make=quick_make)


def finished(folder: Path) -> int:
    """Return the number of finished sequences."""
    return len(list(folder.glob(f"*/*/{SUMMARY}")))
