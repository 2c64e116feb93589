"""The object that each pixel shows, and the pixels of each object."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.rectangles import Rectangle

F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]

AREA = 4
"""Column of the counts that holds the number of pixels."""


@compiled
def label_objects(body: I32, object_of_body: I8, objects: int) -> tuple[I8, I64]:
    """Label each pixel with its object, and sum up the pixels of each object.

    Args:
        body: (height, width) body that each pixel shows, -1 for the sky.
        object_of_body: (bodies,) number of the object that each body belongs to, -1 for none.
        objects: number of objects.

    Returns:
        (height, width) int8 labels, the number of the object, -1 for none; and (objects, 7) int64
        counts: lowest column and row, highest column and row (half-open), number of pixels, sum of
        their columns and sum of their rows.
    """
    height, width = body.shape
    labels = np.full((height, width), -1, np.int8)
    counts = np.zeros((objects, 7), np.int64)
    counts[:, 0], counts[:, 1] = width, height
    for row in range(height):
        highest = np.int32(0)
        for column in range(width):
            highest = max(highest, body[row, column])
        if highest == 0:
            continue
        end = 0
        while end < width:  # whole runs of equal pixels are faster than single ones
            start, shown = end, body[row, end]
            while end < width and body[row, end] == shown:
                end += 1
            k = object_of_body[shown] if shown > 0 else np.int8(-1)
            if k < 0:
                continue
            labels[row, start:end] = k
            counts[k, 0] = min(counts[k, 0], start)
            counts[k, 1] = min(counts[k, 1], row)
            counts[k, 2] = max(counts[k, 2], end)
            counts[k, 3] = max(counts[k, 3], row + 1)
            counts[k, 4] += end - start
            counts[k, 5] += (start + end - 1) * (end - start) // 2
            counts[k, 6] += row * (end - start)
    return labels, counts


def box_of(count: I64) -> Rectangle:
    """Return the half-open bounding box of a row of counts [px]."""
    return int(count[0]), int(count[1]), int(count[2]), int(count[3])


def centroid_of(count: I64) -> F64:
    """Return the (2,) centroid of a row of counts [px]."""
    return np.asarray(count[5:] / count[AREA] + 0.5)
