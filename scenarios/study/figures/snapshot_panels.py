"""What the sensor and the fly saw at one moment: the APS frame and the saliency map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from detector.metrics import Box
from scenarios.study import results
from scenarios.study.results import Snapshot

TRUTH_BOX: Any = {"color": "#4DD0E1", "linestyle": (0, (3, 1.5)), "linewidth": 1.3}
REGION: Any = {"color": "#FFFFFF", "linestyle": "-", "linewidth": 1.3}
OUTLINE = [withStroke(linewidth=2.6, foreground="#1d2733")]
"""Dark beside light, so that a line shows on any picture."""
_WHITE_PERCENTILE = 99.5
"""Of a light's frames, shown as white: a lamp or two may be brighter (assumed)."""


def sample_snapshot(sequence: results.Sequence) -> Snapshot | None:
    """The moment that stands for a sequence: the middle one; None where there is none."""
    shots = sequence.snapshots
    return shots[len(shots) // 2] if shots else None


def white_dn(sequences: Sequence[results.Sequence]) -> float:
    """What to show as white, the same for all frames of a light [DN]."""
    shots = [shot for one in sequences if (shot := sample_snapshot(one)) is not None]
    frames = [np.percentile(shot.aps, _WHITE_PERCENTILE) for shot in shots if shot.aps.size]
    return max([float(value) for value in frames], default=0.0) or 1.0


def draw_aps(axes: Axes, sequence: results.Sequence, *, white: float) -> None:
    """The last APS frame of the sample moment, with the vehicle's true box.

    Args:
        axes: to draw on.
        sequence: whose.
        white: what is shown as white [DN].
    """
    _blank(axes)
    shot = sample_snapshot(sequence)
    if shot is None:
        return
    axes.imshow(shot.aps, cmap="gray", vmin=0, vmax=white, interpolation="none")
    _draw_box(axes, shot.box_px, TRUTH_BOX)


def draw_saliency(axes: Axes, sequence: results.Sequence) -> None:
    """The fly's saliency at the sample moment, its region of interest and the true box."""
    _blank(axes)
    shot = sample_snapshot(sequence)
    if shot is None:
        return
    rows, columns = shot.saliency.shape
    extent = (-0.5, columns * shot.cell_px - 0.5, rows * shot.cell_px - 0.5, -0.5)
    axes.imshow(shot.saliency, cmap="inferno", vmin=0, extent=extent, interpolation="none")
    height, width = shot.aps.shape
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    _draw_box(axes, shot.box_px, TRUTH_BOX)
    _draw_box(axes, shot.roi_px, REGION)


def truth_box_handle() -> Line2D:
    """What the dashed box means."""
    return Line2D([], [], label="true box", path_effects=OUTLINE, **TRUTH_BOX)


def region_handle() -> Line2D:
    """What the other box means."""
    return Line2D([], [], label="region of interest", path_effects=OUTLINE, **REGION)


def _blank(axes: Axes) -> None:
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def _draw_box(axes: Axes, box: Box | None, line: Any) -> None:
    if box is None:
        return
    x0, y0, x1, y1 = box
    corner = (x0 - 0.5, y0 - 0.5)
    axes.add_patch(
        Rectangle(corner, x1 - x0, y1 - y0, fill=False, path_effects=OUTLINE, clip_on=False, **line)
    )
