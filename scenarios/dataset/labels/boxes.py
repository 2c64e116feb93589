"""Boxes and tracks in the layouts of DSEC-Detection and COCO."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.dataset.layout import COCO, TRACKS, file_name
from scenarios.dataset.scenes.labelled import FrameTruth, SceneObject

TRACK_DTYPE = np.dtype(
    [
        ("t", "<u8"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("h", "<f8"),
        ("w", "<f8"),
        ("class_id", "u1"),
        ("class_confidence", "<f8"),
        ("track_id", "<u8"),
    ]
)
"""Fields as the documentation of DSEC-Detection (Gehrig and Scaramuzza 2024) gives them."""

CLASSES = ("pedestrian", "rider", "car", "bus", "truck", "bicycle", "motorcycle", "train")
"""Classes of DSEC-Detection; `class_id` is the index."""
CLASS_OF_KIND = {"pedestrian": 0, "sedan": 2, "van": 2, "motorcycle": 6}
"""Class of each kind of object. A van is a car, as in Cityscapes."""
COCO_CATEGORIES = {
    "pedestrian": (1, "person"),
    "sedan": (3, "car"),
    "van": (3, "car"),
    "motorcycle": (4, "motorcycle"),
}
"""Number and name of the category of each kind of object in COCO."""
_OWN_CLASSES, _OWN_CATEGORIES = len(CLASSES), 101
"""First class and category of the objects of a model, above those of DSEC-Detection and COCO."""
WITHOUT_BOX = ("tree",)
"""Kinds of objects that have masks and no boxes."""


class BoxTable:
    """Boxes of all labels of a sequence.

    A box encloses the visible part of an object: the pixels of its mask.

    Attributes:
        kinds: number of boxes of each kind of object.
    """

    def __init__(self, objects: Sequence[SceneObject]) -> None:
        self._objects = objects
        self._tracked = [k for k, item in enumerate(objects) if item.kind not in WITHOUT_BOX]
        self._times: list[int] = []
        self._rows: list[tuple[Any, ...]] = []
        self._annotations: list[dict[str, Any]] = []
        self.kinds: Counter[str] = Counter()

    def add(self, number: int, frame: FrameTruth) -> None:
        """Add the boxes of one label.

        Args:
            number: number of the label.
            frame: what the camera sees at its time.
        """
        self._times.append(frame.t_us)
        for k in self._tracked:
            box, kind = frame.boxes_px[k], self._objects[k].kind
            if box is None:
                continue
            x0, y0, x1, y1 = box
            mask = frame.labels == k
            self.kinds[kind] += 1
            row = frame.t_us, x0, y0, y1 - y0, x1 - x0, class_of(kind, k), 1.0, k
            self._rows.append(row)
            self._annotations.append(
                {
                    "id": len(self._annotations) + 1,
                    "image_id": number + 1,
                    "category_id": category_of(kind, k)[0],
                    "bbox": [x0, y0, x1 - x0, y1 - y0],
                    "area": int(np.count_nonzero(mask)),
                    "segmentation": run_lengths(mask),
                    "iscrowd": 0,
                    "track_id": k,
                }
            )

    def boxes_at(self, t_us: int) -> list[dict[str, Any]]:
        """Return the boxes of one label, with the names of the fields of `TRACK_DTYPE`."""
        names = TRACK_DTYPE.names or ()
        return [dict(zip(names, row, strict=True)) for row in self._rows if row[0] == t_us]

    def write_tracks(self, work: Path) -> None:
        """Write `tracks.npy` of DSEC-Detection."""
        (work / TRACKS).parent.mkdir(parents=True, exist_ok=True)
        np.save(work / TRACKS, np.array(self._rows, TRACK_DTYPE))

    def write_coco(self, work: Path, images: str, width: int, height: int) -> None:
        """Write the boxes and masks as COCO JSON.

        Args:
            work: folder of the sequence.
            images: folder of the images in it.
            width: width of the images [px].
            height: height of the images [px].
        """
        described = [
            {
                "id": n + 1,
                "file_name": f"{images}/{file_name(n)}",
                "width": width,
                "height": height,
                "t_us": t_us,
            }
            for n, t_us in enumerate(self._times)
        ]
        (work / COCO).parent.mkdir(parents=True, exist_ok=True)
        own = (category_of(self._objects[k].kind, k) for k in self._tracked)
        categories = {*own} | {*COCO_CATEGORIES.values()}
        write_json(work / COCO, described, self._annotations, categories)


def class_of(kind: str, number: int) -> int:
    """Return the class of an object; that of a model's object is its own: 8 + its number."""
    return CLASS_OF_KIND.get(kind, _OWN_CLASSES + number)


def category_of(kind: str, number: int) -> tuple[int, str]:
    """Return number and name of an object's category; 101 + its number for a model's object."""
    return COCO_CATEGORIES.get(kind, (_OWN_CATEGORIES + number, kind))


def write_json(
    path: Path,
    images: Sequence[dict[str, Any]],
    annotations: Sequence[dict[str, Any]],
    categories: Iterable[tuple[int, str]],
) -> None:
    """Write a COCO file."""
    named = [{"id": k, "name": name} for k, name in sorted(set(categories))]
    document = {"images": images, "annotations": annotations, "categories": named}
    path.write_text(json.dumps(document) + "\n", encoding="utf-8")


def run_lengths(mask: npt.NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask as COCO's uncompressed run lengths.

    Args:
        mask: (height, width).

    Returns:
        "size", height and width; and "counts", the lengths of runs of equal pixels down the
        columns, one column after another, the first of them of pixels that are False.
    """
    pixels = mask.ravel(order="F")
    edges = np.flatnonzero(np.diff(pixels)) + 1
    counts = np.diff([0, *edges, pixels.size]).tolist()
    return {"size": list(mask.shape), "counts": [0, *counts] if pixels[0] else counts}
