"""Dense labels and boxes at regular times."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from scenarios.dataset.labels.boxes import BoxTable
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.labels.motion import MotionTable
from scenarios.dataset.labels.png import encode_depth, encode_flow, write_png
from scenarios.dataset.layout import (
    BACKWARD,
    DEPTH,
    FORWARD,
    IMAGE_TIMES,
    IMAGES,
    MASKS,
    MOTION,
    VELOCITY,
    file_name,
)
from scenarios.dataset.scenes.labelled import LabelledScene

_FLOW_HEADER = "# from_timestamp_us, to_timestamp_us"


def write_frame_labels(
    work: Path, scene: LabelledScene, labels: Sequence[Label], times_us: Sequence[int]
) -> BoxTable:
    """Write the labels that belong to instants.

    Args:
        work: folder of the sequence.
        scene: the scene.
        labels: labels to write.
        times_us: times of the labels [µs].

    Returns:
        The boxes, which the statistics of the dataset need even if they are not written.
    """
    boxes, motion = BoxTable(scene.objects), MotionTable()
    for folder in _folders(labels):
        (work / folder).mkdir(parents=True)
    write_times(work / IMAGE_TIMES, times_us)
    for number, t_us in enumerate(times_us):
        frame, name = scene.frame(t_us), file_name(number)
        boxes.add(number, frame)
        if frame.motion is not None:
            motion.add(frame.motion)
        if Label.DEPTH in labels:
            write_png(work / DEPTH / name, encode_depth(frame.depth_m))
        if Label.MASKS in labels:
            write_png(work / MASKS / name, (frame.labels + 1).astype(np.uint8))
    if Label.FLOW in labels:
        _write_flow(work, scene, times_us)
    if Label.VELOCITY in labels:
        _write_velocity(work / VELOCITY, scene, times_us)
    if Label.BOXES in labels:
        boxes.write_tracks(work)
    if Label.COCO in labels:
        boxes.write_coco(work, IMAGES, scene.lens.width, scene.lens.height)
    if Label.MOTION in labels:
        motion.write(work / MOTION)
    return boxes


def write_times(path: Path, times_us: Sequence[int]) -> None:
    """Write one time per line [µs]."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{t_us}\n" for t_us in times_us), encoding="utf-8")


def _folders(labels: Sequence[Label]) -> list[str]:
    folders = {
        Label.FLOW: [FORWARD, BACKWARD],
        Label.DEPTH: [DEPTH],
        Label.MASKS: [MASKS],
    }
    return [folder for label in labels for folder in folders.get(label, [])]


def _write_flow(work: Path, scene: LabelledScene, times_us: Sequence[int]) -> None:
    """Write the displacement from each label to the next and to the previous one."""
    numbers = range(len(times_us))
    for folder, step in ((FORWARD, 1), (BACKWARD, -1)):
        pairs = [(k, k + step) for k in numbers if k + step in numbers]
        for k, to in pairs:
            displacement = scene.displacement_px(times_us[k], times_us[to])
            write_png(work / folder / file_name(k), encode_flow(displacement))
        lines = [f"{times_us[k]}, {times_us[to]}" for k, to in pairs]
        path = work / f"{folder}_timestamps.txt"
        path.write_text("\n".join([_FLOW_HEADER, *lines]) + "\n", encoding="utf-8")


def _write_velocity(path: Path, scene: LabelledScene, times_us: Sequence[int]) -> None:
    """Write `velocity_px_s`, (labels, height, width, 2) float32, and `t_us`, (labels,) int64."""
    path.parent.mkdir(exist_ok=True)
    shape = scene.lens.height, scene.lens.width, 2
    with h5py.File(path, "w") as file:
        file["t_us"] = np.array(times_us, np.int64)
        velocity = file.create_dataset(
            "velocity_px_s",
            (len(times_us), *shape),
            np.float32,
            chunks=(1, *shape),
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )
        for k, t_us in enumerate(times_us):
            velocity[k] = scene.velocity_px_s(t_us)
