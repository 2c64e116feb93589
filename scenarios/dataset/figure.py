"""The overview of a dataset: one sequence of each split, read back, and statistics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.labels.png import decode_flow, read_png
from scenarios.dataset.layout import EVENTS, FORWARD, IMAGES, TRACKS, file_name
from scenarios.dataset.plan import DatasetPlan
from scenarios.output.colours import OFF, ON
from scenarios.output.figures import figure_file, literal

Summaries = Sequence[Mapping[str, Any]]
_WINDOW_US = 10_000
"""Events of this time are shown [µs] (assumed)."""
_COLUMN_IN, _ROW_IN = 3.2, 2.3
_MAX_SPLITS = 4
_BOX = "#CC79A7"


def draw_overview(path: Path, folder: Path, plan: DatasetPlan, summaries: Summaries) -> None:
    """Write the figure as PNG and SVG.

    Args:
        path: path of the files, without a suffix.
        folder: folder of the dataset.
        plan: the dataset.
        summaries: summary of each sequence.
    """
    splits = list(plan.spec.counts)[:_MAX_SPLITS]
    panels = [label for label in (Label.IMAGES, Label.FLOW) if label in plan.spec.labels]
    columns, rows = max(3, 1 + len(panels)), len(splits) + 1
    with figure_file(path, (_COLUMN_IN * columns, _ROW_IN * rows)) as figure:
        axes = figure.subplots(rows, columns, squeeze=False)
        for row, split in zip(axes, splits, strict=False):
            first = next(s for s in summaries if s["split"] == split)
            _draw_sequence(row, folder, first, panels)
        _draw_statistics(axes[-1], summaries)
        for axis in axes.ravel():
            axis.set_visible(axis.has_data() or bool(axis.images))


def _draw_sequence(
    axes: Any, folder: Path, summary: Mapping[str, Any], panels: Sequence[Label]
) -> None:
    """Draw events, and image and flow where there are any, at the middle label."""
    place, middle = folder / summary["sequence"], summary["label_times"] // 2
    t_us = middle * summary["period_us"]
    axes[0].imshow(_event_image(place / EVENTS, t_us), interpolation="nearest")
    axes[0].set_title(
        f"{literal(summary['sequence'])}: {_WINDOW_US / 1000:g} ms, ON blue, OFF orange"
    )
    _draw_boxes(axes[0], place / TRACKS, t_us, [item["kind"] for item in summary["objects"]])
    for axis, label in zip(axes[1:], panels, strict=False):
        if label is Label.IMAGES:
            axis.imshow(read_png(place / IMAGES / file_name(middle)))
            axis.set_title("preview")
        elif (place / FORWARD / file_name(middle)).exists():
            flow, _ = decode_flow(read_png(place / FORWARD / file_name(middle)))
            shown = axis.imshow(np.hypot(flow[..., 0], flow[..., 1]), cmap="viridis")
            axis.figure.colorbar(shown, ax=axis, label="px")
            axis.set_title("displacement to the next label")
    for axis in axes:
        axis.set_xticks([])
        axis.set_yticks([])


def _event_image(path: Path, end_us: int) -> npt.NDArray[np.float32]:
    """(height, width, 3) white image with the events of a short window in colour."""
    with h5py.File(path) as file:
        image = np.ones((file.attrs["height"], file.attrs["width"], 3), np.float32)
        index, last = file["ms_to_idx"], len(file["ms_to_idx"]) - 1
        start, end = (
            int(index[min(max(t_us, 0) // 1000, last)]) for t_us in (end_us - _WINDOW_US, end_us)
        )
        x, y, p = (file[f"events/{name}"][start:end] for name in "xyp")
    image[y, x] = np.where(p[:, None] > 0, ON, OFF) / 255
    return image


def _draw_boxes(axis: Any, path: Path, t_us: int, names: Sequence[str]) -> None:
    if not path.exists():
        return
    tracks = np.load(path)
    for box in tracks[tracks["t"] == t_us]:
        x, y, w, h = (float(box[name]) for name in "xywh")
        xs, ys = [x, x + w, x + w, x, x], [y, y, y + h, y + h, y]
        axis.plot(xs, ys, color=_BOX, linewidth=1.2)
        axis.text(x, y - 3, literal(names[int(box["track_id"])]), color=_BOX, fontsize=7)


def _draw_statistics(axes: Any, summaries: Summaries) -> None:
    """Draw events and noise against illuminance, or against image speed if it is not known."""
    speed = np.array([s["image_speed_px_s"] for s in summaries])
    count = np.array([s["events"]["count"] for s in summaries])
    signal = np.array([s["events"]["by_cause"]["signal"] for s in summaries])
    lux = [s["illuminance_lux"] for s in summaries]
    known = None not in lux
    across = lux if known else speed
    words = "illuminance [lux]" if known else "highest image speed [px/s]"
    scale = "log" if known else "linear"
    axes[0].hist(speed, bins=20)
    axes[0].set(xlabel="image speed [px/s]", ylabel="sequences")
    axes[1].scatter(across, count / 1e6, s=8)
    axes[1].set(xlabel=words, ylabel="events [million]", xscale=scale)
    axes[2].scatter(across, 100 * (count - signal) / np.maximum(count, 1), s=8)
    axes[2].set(xlabel=words, ylabel="noise [% of events]", xscale=scale)
