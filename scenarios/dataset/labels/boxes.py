"""Boxes and tracks in the layouts of DSEC-Detection and COCO."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.dataset.layout import COCO, TRACKS, file_name
from sim import GroundTruth
from sim.scene.moving_objects import MovingObject

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
"""Class of each kind of object. A van is a car, as in Cityscapes. Trees have none, and no boxes."""
COCO_CATEGORIES = {
    "pedestrian": (1, "person"),
    "sedan": (3, "car"),
    "van": (3, "car"),
    "motorcycle": (4, "motorcycle"),
}
"""Number and name of the category of each kind of object in COCO."""


class BoxTable:
    """Boxes of all labels of a sequence.

    A box encloses the visible part of an object: the pixels of its mask.

    Attributes:
        kinds: number of boxes of each kind of object.
    """

    def __init__(self, objects: Sequence[MovingObject]) -> None:
        self._tracked = [k for k, item in enumerate(objects) if item.kind in CLASS_OF_KIND]
        self._times: list[int] = []
        self._rows: list[tuple[Any, ...]] = []
        self._annotations: list[dict[str, Any]] = []
        self.kinds: Counter[str] = Counter()

    def add(self, number: int, truth: GroundTruth) -> None:
        """Add the boxes of one label.

        Args:
            number: number of the label.
            truth: ground truth at its time.
        """
        self._times.append(truth.t_us)
        for k in self._tracked:
            item = truth.objects[k]
            if item.bounding_box_px is None:
                continue
            x0, y0, x1, y1 = item.bounding_box_px
            self.kinds[item.kind] += 1
            self._rows.append(
                (truth.t_us, x0, y0, y1 - y0, x1 - x0, CLASS_OF_KIND[item.kind], 1.0, item.number)
            )
            self._annotations.append(
                {
                    "id": len(self._annotations) + 1,
                    "image_id": number + 1,
                    "category_id": COCO_CATEGORIES[item.kind][0],
                    "bbox": [x0, y0, x1 - x0, y1 - y0],
                    "area": int(np.count_nonzero(item.mask)),
                    "segmentation": run_lengths(item.mask),
                    "iscrowd": 0,
                    "track_id": item.number,
                }
            )

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
        write_json(work / COCO, described, self._annotations)


def write_json(
    path: Path, images: Sequence[dict[str, Any]], annotations: Sequence[dict[str, Any]]
) -> None:
    """Write a COCO file."""
    categories = [{"id": k, "name": name} for k, name in sorted(set(COCO_CATEGORIES.values()))]
    document = {"images": images, "annotations": annotations, "categories": categories}
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
