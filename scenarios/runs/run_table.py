"""The closing table of one or more runs."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from scenarios.output.atomic_folder import GENERATOR, RECORDING
from scenarios.output.terminal import has_display
from scenarios.pipeline.running import TOTAL

Summaries = Sequence[tuple[Path, dict[str, Any]]]


def print_runs(runs: Summaries) -> None:
    """Print what happened in each run, side by side, and how to open its recording."""
    console = Console()
    table = Table(title="flybench", title_justify="left")
    table.add_column("")
    for folder, _ in runs:
        table.add_column(folder.name, justify="right")
    rows = [_rows(summary) for _, summary in runs]
    for name in rows[0]:
        table.add_row(name, *(row[name] for row in rows))
        if name in _SECTION_ENDS:
            table.add_section()
    console.print(table)
    for folder, _ in runs:
        line = f"{folder / RECORDING}   open it with: {view_command(folder)}"
        console.print(line, soft_wrap=True, markup=False)


_SECTION_ENDS = ("image speed", "hot pixels", "GRMS [1/s]")


def view_command(folder: Path) -> str:
    """What to type to look at a run: the command as it can be called from here."""
    installed = Path(sys.executable).with_name(GENERATOR)
    name = GENERATOR if shutil.which(GENERATOR) else os.path.relpath(installed)
    way = "" if has_display() else " --web"
    return f"{shlex.quote(name)} view {shlex.quote(str(folder))}{way}"


def _rows(summary: dict[str, Any]) -> dict[str, str]:
    own, *rivals = summary.get("detectors", [summary["detector"]])
    parts = _truth(summary["truth"]), _events(summary), _detector(own), _rivals(rivals)
    light = {"light": summary.get("light", "rendered")}
    return dict(row for part in (*parts, light, _wall(summary["wall_s"])) for row in part.items())


def _truth(truth: dict[str, Any]) -> dict[str, str]:
    return {
        "true direction": truth["direction"],
        "true speed": f"{truth['omega_rad_s']:.2f} rad/s, {truth['speed_km_h']:.1f} km/h",
        "image speed": f"{truth['image_speed_px_s']:.0f} px/s",
    }


def _events(summary: dict[str, Any]) -> dict[str, str]:
    events, seconds = summary["events"], summary["truth"]["duration_us"] / 1e6
    cause = events["by_cause"]
    return {
        "events": f"{events['count']:,} in {seconds:.2f} s",
        "ON / OFF": f"{events['on']:,} / {events['off']:,}",
        "from the scene": f"{cause['signal']:,}",
        "leak": f"{cause['leak']:,}",
        "shot noise": f"{cause['shot']:,}",
        "hot pixels": f"{cause['hot']:,}",
    }


def _detector(found: dict[str, Any]) -> dict[str, str]:
    latency = found["latency_ms"]
    return {
        "method": found["method"],
        "its verdict": found["direction"],
        "right steps in view": f"{percent(found['accuracy'])} of {found['steps_in_view']}",
        "after 100 ms in view": percent(found["accuracy_after_100ms"]),
        "first right step": "never" if latency is None else f"{latency:.0f} ms after entering",
        "ROI's overlap (IoU)": overlap(found["roi_iou"]),
        "view centre off by": pixels(found["centroid_error_px"]),
        "GRMS [1/s]": number(found["grms"]),
    }


def _rivals(found: Sequence[dict[str, Any]]) -> dict[str, str]:
    """A line a method that ran beside the run's own."""
    return {
        f"beside it: {rival['method']}": f"{rival['direction']}, {percent(rival['accuracy'])} right"
        for rival in found
    }


def _wall(wall_s: dict[str, float]) -> dict[str, str]:
    stages = {name: seconds for name, seconds in wall_s.items() if name != TOTAL}
    rows = {f"time to {name}": f"{seconds:.1f} s" for name, seconds in stages.items()}
    return rows | {"in all": f"{wall_s[TOTAL]:.1f} s"}


def percent(share: float | None) -> str:
    """A share as a percentage; None is a share of nothing."""
    return "no step" if share is None else f"{100 * share:.0f} %"


def overlap(share: float | None) -> str:
    """An overlap as a percentage; None is of a method without a region, or of no step."""
    return "–" if share is None else percent(share)


def pixels(value: float | None) -> str:
    """A distance in whole pixels; None is a figure of no step."""
    return "no step" if value is None else f"{value:.0f} px"


def number(value: float | None) -> str:
    """Three digits; None is a figure that needs more steps than there were."""
    return "no step" if value is None else f"{value:.3g}"
