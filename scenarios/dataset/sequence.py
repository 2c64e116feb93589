"""Make one sequence of a dataset: render, emulate, and write events and labels."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from emulator import ApsFrame, EventSensor
from formats.writers.dsec import DsecWriter
from scenarios.dataset.labels.boxes import BoxTable
from scenarios.dataset.labels.camera import write_camera, write_rectify_map
from scenarios.dataset.labels.events import EventLog
from scenarios.dataset.labels.frames import write_frame_labels
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.labels.png import write_png
from scenarios.dataset.labels.shard import write_shard
from scenarios.dataset.layout import APS, EVENTS, IMAGES, file_name, label_times_us
from scenarios.dataset.scenes.labelled import LabelledScene
from scenarios.dataset.sequence_plan import SequencePlan
from scenarios.output.atomic_folder import atomic_folder, write_summary
from scenarios.output.versions import versions
from scenarios.pipeline.summary import EventTally

_OF_EVENTS = frozenset({Label.EVENT_SOURCE, Label.EVENT_FLOW})


@dataclass(frozen=True)
class Cost:
    """CPU time of a sequence [s].

    Attributes:
        events_s: to build and render the scene, to emulate the sensor and to write the events.
        labels_s: to compute and write all labels.
    """

    events_s: float
    labels_s: float


def make_sequence(plan: SequencePlan, folder: Path) -> Cost:
    """Write the folder of one sequence; an earlier one in its place is replaced.

    Args:
        plan: the sequence.
        folder: its folder, which appears when it is complete.

    Raises:
        OutputError: the folder cannot be written.
        RendererError: this machine cannot render.
        MemoryBudgetError: the sequence does not fit into the memory budget.
    """
    with atomic_folder(folder) as work:
        start_s = time.process_time()
        scene = plan.build_scene()
        (work / EVENTS).parent.mkdir(parents=True)
        log, tally, frames = _write_events(work, plan, scene)
        rendered_s = time.process_time()
        times_us = label_times_us(scene.duration_us, plan.period_us)
        boxes = _write_labels(work, plan, scene, times_us, log)
        labelled_s = time.process_time()
        facts = _facts(plan, scene, tally, boxes, len(times_us), frames)
        write_summary(work, facts | {"sha256": file_digests(work)})
    return Cost(rendered_s - start_s, labelled_s - rendered_s)


def _write_events(
    work: Path, plan: SequencePlan, scene: LabelledScene
) -> tuple[EventLog, EventTally, int]:
    """Render and emulate; write the events, and the frames if they are wanted."""
    log, tally, frames = EventLog(), EventTally(), _Frames(work, wanted=Label.APS in plan.labels)
    keep: Callable[[Any], None] = log.add if _OF_EVENTS & set(plan.labels) else lambda _: None
    sensor = EventSensor(plan.sensor, seed=plan.seed)
    width, height = plan.sensor.width, plan.sensor.height
    with DsecWriter(work / EVENTS, width=width, height=height) as writer:
        for sample in scene.samples():
            output = sensor.step(sample.t_us, sample.luminance, changed=sample.changed)
            writer.write(output.events)
            keep(output)
            tally.add(output)
            frames.write(output.aps_frames)
        writer.index_until(scene.duration_us)
    write_rectify_map(work, scene.lens)
    return log, tally, frames.close()


class _Frames:
    """Writes APS frames, and the times of their exposure."""

    def __init__(self, work: Path, *, wanted: bool) -> None:
        self._folder, self._wanted = work / APS, wanted
        self._exposures: list[tuple[int, int]] = []
        if wanted:
            self._folder.mkdir()

    def write(self, frames: tuple[ApsFrame, ...]) -> None:
        for frame in frames if self._wanted else ():
            write_png(self._folder / file_name(len(self._exposures)), frame.image)
            self._exposures.append((frame.start_us, frame.end_us))

    def close(self) -> int:
        """Write the table of exposures, and return the number of frames."""
        if self._wanted:
            lines = ["# exposure_start_us, exposure_end_us"]
            lines += [f"{start_us}, {end_us}" for start_us, end_us in self._exposures]
            path = self._folder / "exposure_timestamps.txt"
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return len(self._exposures)


def _write_labels(
    work: Path, plan: SequencePlan, scene: LabelledScene, times_us: range, log: EventLog
) -> BoxTable:
    boxes = write_frame_labels(work, scene, plan.labels, times_us)
    if _OF_EVENTS & set(plan.labels):
        log.write_labels(work, scene, plan.labels)
    if Label.CAMERA in plan.labels:
        write_camera(work, scene)
    if Label.IMAGES in plan.labels:
        (work / IMAGES).mkdir(parents=True)
        for number, image in enumerate(scene.images(times_us)):
            write_png(work / IMAGES / file_name(number), image)
    if Label.SHARD in plan.labels:
        facts = {"direction": scene.facts()["direction"], "variant": plan.variant}
        has_boxes = not {Label.BOXES, Label.COCO}.isdisjoint(plan.labels)
        write_shard(work, times_us, plan.name, facts, boxes if has_boxes else None)
    return boxes


def _facts(
    plan: SequencePlan,
    scene: LabelledScene,
    tally: EventTally,
    boxes: BoxTable,
    labels: int,
    frames: int,
) -> dict[str, Any]:
    """Return everything about the sequence that is not an array, ready for JSON."""
    return {
        "command": "dataset",
        "sequence": plan.name,
        "split": plan.split,
        "variant": plan.variant,
        "key": plan.key(),
        "parameters": {
            **plan.scene_parameters(),
            "sensor": {"preset": plan.sensor_name} | asdict(plan.sensor),
            "seed": plan.seed,
        },
        "labels": list(plan.labels),
        "period_us": plan.period_us,
        "duration_us": scene.duration_us,
        **scene.facts(),
        "label_times": labels,
        "aps_frames": frames,
        "objects": [
            {"track_id": k, "name": item.name, "kind": item.kind}
            for k, item in enumerate(scene.objects)
        ],
        "boxes": dict(sorted(boxes.kinds.items())),
        "events": tally.summary(),
        "versions": versions(),
    }


def file_digests(folder: Path) -> dict[str, str]:
    """Return the SHA-256 digest of every file in a folder, by its path relative to it."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): file_digest(path) for path in paths}


def file_digest(path: Path) -> str:
    """Return the SHA-256 digest of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
