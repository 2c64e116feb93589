"""Dense labels and boxes at regular times."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
import numpy.typing as npt

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
from sim import Crossing
from sim.raster import flow
from sim.truth.probe import TruthProbe

_FLOW_HEADER = "# from_timestamp_us, to_timestamp_us"


def write_frame_labels(
    work: Path, crossing: Crossing, labels: Sequence[Label], times_us: Sequence[int]
) -> BoxTable:
    """Write the labels that belong to instants.

    Args:
        work: folder of the sequence.
        crossing: the crossing.
        labels: labels to write.
        times_us: times of the labels [µs].

    Returns:
        The boxes, which the statistics of the dataset need even if they are not written.
    """
    probe = TruthProbe(crossing.scene, crossing.intrinsics)
    boxes, motion = BoxTable(crossing.scene.objects), MotionTable()
    for folder in _folders(labels):
        (work / folder).mkdir(parents=True)
    write_times(work / IMAGE_TIMES, times_us)
    for number, t_us in enumerate(times_us):
        t_s, name = crossing.seconds(t_us), file_name(number)
        seen = probe.geometry.visible(t_s)
        truth = probe.measure(t_us, t_s, seen.body)
        boxes.add(number, truth)
        motion.add(truth)
        if Label.DEPTH in labels:
            write_png(work / DEPTH / name, encode_depth(flow.depth_m(seen)))
        if Label.MASKS in labels:
            write_png(work / MASKS / name, (truth.target.labels + 1).astype(np.uint8))
    if Label.FLOW in labels:
        _write_flow(work, crossing, probe, times_us)
    if Label.VELOCITY in labels:
        _write_velocity(work / VELOCITY, crossing, probe, times_us)
    if Label.BOXES in labels:
        boxes.write_tracks(work)
    if Label.COCO in labels:
        boxes.write_coco(work, IMAGES, crossing.intrinsics.width, crossing.intrinsics.height)
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


def _write_flow(work: Path, crossing: Crossing, probe: TruthProbe, times_us: Sequence[int]) -> None:
    """Write the displacement from each label to the next and to the previous one."""
    numbers = range(len(times_us))
    for folder, step in ((FORWARD, 1), (BACKWARD, -1)):
        pairs = [(k, k + step) for k in numbers if k + step in numbers]
        for k, to in pairs:
            from_s, to_s = (crossing.seconds(times_us[n]) for n in (k, to))
            displacement = probe.geometry.displacement_px(from_s, to_s)
            write_png(work / folder / file_name(k), encode_flow(displacement))
        lines = [f"{times_us[k]}, {times_us[to]}" for k, to in pairs]
        path = work / f"{folder}_timestamps.txt"
        path.write_text("\n".join([_FLOW_HEADER, *lines]) + "\n", encoding="utf-8")


def _write_velocity(
    path: Path, crossing: Crossing, probe: TruthProbe, times_us: Sequence[int]
) -> None:
    """Write `velocity_px_s`, (labels, height, width, 2) float32, and `t_us`, (labels,) int64."""
    path.parent.mkdir(exist_ok=True)
    shape = crossing.intrinsics.height, crossing.intrinsics.width, 2
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
            velocity[k] = _velocity(probe, crossing.seconds(t_us))


def _velocity(probe: TruthProbe, t_s: float) -> npt.NDArray[np.float32]:
    return probe.geometry.flow_px_s(t_s)
