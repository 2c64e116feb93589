"""Panels of one snapshot: the APS frame and the saliency map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from detector.metrics import Box
from scenarios.pipeline.registry import FLY
from scenarios.study.results import SequenceResult, Snapshot
from scenarios.styles.method_style import method_style

TRUTH_BOX: Any = {"color": "#4DD0E1", "linestyle": (0, (3, 1.5)), "linewidth": 1.3}
REGION: Any = {"color": method_style(FLY).colour, "linestyle": "-", "linewidth": 1.5}
OUTLINE = [withStroke(linewidth=2.8, foreground="#06281F")]
"""A dark outline makes a bright line visible on any image. A page does not take it for a grey,
which would change with its colour scheme."""
_WHITE_PERCENTILE = 99.5
"""Percentile of a frame that is shown as white; a few lamps may be brighter (assumed)."""


def middle_snapshot(sequence: SequenceResult) -> Snapshot | None:
    """Return the middle snapshot of a sequence, which represents it; None without snapshots."""
    shots = sequence.snapshots
    return shots[len(shots) // 2] if shots else None


def white_level_dn(sequences: Sequence[SequenceResult]) -> float:
    """Return the level to show as white in the frames of all sequences [DN]."""
    shots = [shot for one in sequences if (shot := middle_snapshot(one)) is not None]
    frames = [np.percentile(shot.aps, _WHITE_PERCENTILE) for shot in shots if shot.aps.size]
    return max([float(value) for value in frames], default=0.0) or 1.0


def draw_aps(axes: Axes, sequence: SequenceResult, *, white_dn: float) -> None:
    """Draw the APS frame of the middle snapshot, with the true box of the vehicle.

    Args:
        axes: axes to draw on.
        sequence: result of the sequence.
        white_dn: level that is shown as white [DN].
    """
    _blank(axes)
    shot = middle_snapshot(sequence)
    if shot is None:
        return
    axes.imshow(shot.aps, cmap="gray", vmin=0, vmax=white_dn, interpolation="none")
    _draw_box(axes, shot.box_px, TRUTH_BOX)


def draw_saliency(axes: Axes, sequence: SequenceResult) -> None:
    """Draw the saliency of the middle snapshot, with region of interest and true box."""
    _blank(axes)
    shot = middle_snapshot(sequence)
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
    """Return the legend entry for the true box."""
    return Line2D([], [], label="true box", path_effects=OUTLINE, **TRUTH_BOX)


def region_handle() -> Line2D:
    """Return the legend entry for the region of interest."""
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
