"""Voxel grids: events as an image with several bins of time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.events import Events


def voxel_grid(
    events: Events, *, start_us: int, end_us: int, bins: int, width: int, height: int
) -> npt.NDArray[np.float32]:
    """Return a voxel grid (Zhu et al. 2019, equations 1 to 3).

    Each event adds its polarity, ±1, to the two bins that are nearest in time, in proportion. Time
    runs from the first bin at `start_us` to the last bin at `end_us`. The paper uses the first and
    the last event instead, which makes a grid depend on single events of noise.

    Args:
        events: (n,) of `EVENT_DTYPE`, all in [start_us, end_us].
        start_us: start of the window [µs].
        end_us: end of the window, after its start [µs].
        bins: number of bins, 1 or more.
        width: sensor columns [px].
        height: sensor rows [px].

    Returns:
        (bins, height, width) float32.
    """
    place = (events["t"] - start_us) * ((bins - 1) / (end_us - start_us))
    lower = np.minimum(place.astype(np.int64), bins - 1)
    share = place - lower
    polarity = np.where(events["p"], 1.0, -1.0)
    pixel = events["y"].astype(np.int64) * width + events["x"]
    size = bins * width * height
    upper = np.minimum(lower + 1, bins - 1)
    grid = np.bincount(lower * width * height + pixel, polarity * (1 - share), size)
    grid += np.bincount(upper * width * height + pixel, polarity * share, size)
    return grid.reshape(bins, height, width).astype(np.float32)
