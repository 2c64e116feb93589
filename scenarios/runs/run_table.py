"""The table that a command prints after one or more runs."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from scenarios.output.atomic_folder import GENERATOR, RECORDING
from scenarios.output.numbers import plain_number
from scenarios.output.streams import SafeConsole
from scenarios.output.terminal import has_display
from scenarios.pipeline.running import TOTAL
from scenarios.styles.method_style import method_style

FAILED = "failed"
Summaries = Sequence[tuple[Path, dict[str, Any]]]


def print_runs(runs: Summaries) -> None:
    """Print the results of runs side by side, and the commands that open their recordings."""
    console = SafeConsole()
    table = Table(title="flybench", title_justify="left")
    table.add_column("")
    for folder, _ in runs:
        table.add_column(folder.name, justify="right")
    rows = [run_rows(summary) for _, summary in runs]
    for name in max(rows, key=len):  # a failed method has fewer
        table.add_row(name, *(row.get(name, "–") for row in rows))
        if name in _SECTION_ENDS:
            table.add_section()
    console.print(table)
    for folder, summary in runs:
        line = f"wrote {folder}"
        if summary.get("recording", True):
            line = f"{folder / RECORDING}   open it with: {view_command(folder)}"
        console.print(line, soft_wrap=True)


_SECTION_ENDS = ("image speed", "hot pixels", "GRMS [1/s]")


def view_command(folder: Path) -> str:
    """Return the command that shows a run, as it can be called from the current folder."""
    installed = Path(sys.executable).with_name(GENERATOR)
    name = GENERATOR if shutil.which(GENERATOR) else os.path.relpath(installed)
    option = "" if has_display() else " --web"
    return f"{shlex.quote(name)} view {shlex.quote(str(folder))}{option}"


def run_rows(summary: dict[str, Any]) -> dict[str, str]:
    """Return the results of a run as text, by name."""
    main, *others = summary.get("detectors", [summary["detector"]])
    parts = (
        _truth(summary["truth"]),
        _events(summary),
        _detector(main),
        _other_detectors(others),
        {"luminance": summary.get("luminance", "rendered")},
        _wall_times(summary["wall_s"]),
    )
    return {name: value for part in parts for name, value in part.items()}


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


def _detector(scores: dict[str, Any]) -> dict[str, str]:
    if "failed" in scores:
        return {"method": method_style(scores["method"]).label, "verdict": FAILED}
    latency = scores["latency_ms"]
    return {
        "method": method_style(scores["method"]).label,
        "verdict": scores["direction"],
        "correct steps in view": (
            f"{format_percent(scores['accuracy'])} of {scores['steps_in_view']}"
        ),
        "after 100 ms in view": format_percent(scores["accuracy_after_100ms"]),
        "first correct step": "never" if latency is None else f"{latency:.0f} ms after entry",
        "overlap of the ROI (IoU)": format_overlap(scores["roi_iou"]),
        "error of the view centre": format_pixels(scores["centroid_error_px"]),
        "GRMS [1/s]": format_three_digits(scores["grms"]),
    }


def _other_detectors(all_scores: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return one line per method of `--also`."""
    return {
        f"also: {method_style(scores['method']).label}": (
            FAILED
            if "failed" in scores
            else f"{scores['direction']}, {format_percent(scores['accuracy'])} correct"
        )
        for scores in all_scores
    }


def _wall_times(wall_s: dict[str, float]) -> dict[str, str]:
    stages = {name: seconds for name, seconds in wall_s.items() if name != TOTAL}
    rows = {f"time to {name}": f"{seconds:.1f} s" for name, seconds in stages.items()}
    return rows | {"total time": f"{wall_s[TOTAL]:.1f} s"}


def format_percent(share: float | None) -> str:
    """Format a share as a percentage; None means that there was no step."""
    return "no step" if share is None else f"{100 * share:.0f} %"


def format_overlap(share: float | None) -> str:
    """Format an overlap as a percentage; None means that there was no region or no step."""
    return "–" if share is None else format_percent(share)


def format_pixels(value: float | None) -> str:
    """Format a distance in whole pixels; None means that there was no step."""
    return "no step" if value is None else f"{value:.0f} px"


def format_three_digits(value: float | None) -> str:
    """Format a number with three digits; None means that there were too few steps."""
    return "no step" if value is None else plain_number(value)
