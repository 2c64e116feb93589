"""The samples of a sequence as one tar file, for WebDataset and other streaming readers."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flybench.events import EVENT_DTYPE
from scenarios.dataset.labels.boxes import BoxTable
from scenarios.dataset.layout import (
    BACKWARD,
    DEPTH,
    EVENTS,
    FORWARD,
    IMAGES,
    MASKS,
    SHARD,
    file_name,
)

_IMAGES = {
    "flow.png": FORWARD,
    "flow_backward.png": BACKWARD,
    "depth.png": DEPTH,
    "masks.png": MASKS,
    "image.png": IMAGES,
}
"""Ending of each image in the shard, and its folder in the sequence."""


def write_shard(
    work: Path,
    times_us: Sequence[int],
    name: str,
    facts: dict[str, Any],
    boxes: BoxTable | None,
) -> None:
    """Write one sample for each label but the last.

    Files of one sample follow each other and have one name before the first dot. A sample holds the
    events until the next label (`events.npy`, of `EVENT_DTYPE`), the images of the label that the
    sequence has, `boxes.json`: its boxes, with the names of the fields of `TRACK_DTYPE`, and
    `json`: the times of both labels [µs], and facts of the sequence. Two runs write equal bytes,
    because entries have no time and no owner.

    Args:
        work: folder of the sequence, with all other labels.
        times_us: times of the labels [µs].
        name: name of the sequence, such as "train/0000".
        facts: what is the same for all samples of the sequence.
        boxes: boxes of the sequence; None: without boxes.
    """
    key = name.replace("/", "_")
    with h5py.File(work / EVENTS) as file, tarfile.open(work / SHARD, "w") as tar:
        for number in range(len(times_us) - 1):
            start_us, end_us = times_us[number], times_us[number + 1]
            document = {"sequence": name, "t_us": start_us, "next_t_us": end_us} | facts
            members = {
                "events.npy": _events(file, start_us, end_us),
                "json": json.dumps(document).encode(),
                **dict(_images(work, number)),
            }
            if boxes is not None:
                members["boxes.json"] = json.dumps(boxes.boxes_at(start_us)).encode()
            for ending, content in members.items():
                entry = tarfile.TarInfo(f"{key}_{number:06d}.{ending}")
                entry.size = len(content)
                tar.addfile(entry, io.BytesIO(content))


def _events(file: Any, start_us: int, end_us: int) -> bytes:
    """Return the events of a window as an NPY file; both times are whole milliseconds."""
    part = slice(*(int(file["ms_to_idx"][t_us // 1000]) for t_us in (start_us, end_us)))
    events = np.empty(part.stop - part.start, EVENT_DTYPE)
    for column in "txyp":
        events[column] = file[f"events/{column}"][part]
    buffer = io.BytesIO()
    np.save(buffer, events)
    return buffer.getvalue()


def _images(work: Path, number: int) -> Iterator[tuple[str, bytes]]:
    for ending, folder in _IMAGES.items():
        path = work / folder / file_name(number)
        if path.exists():
            yield ending, path.read_bytes()
