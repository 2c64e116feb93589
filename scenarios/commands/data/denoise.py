"""`flybench denoise`: measure filters of noise, and what they do to detectors, by illuminance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import tyro
from rich.table import Table

from flybench.direction import Direction
from scenarios.denoise.figure import draw_roc, draw_steps
from scenarios.denoise.measure import (
    Row,
    measure_filters,
    measure_steps,
    record_stream,
)
from scenarios.denoise.roc import Roc
from scenarios.errors import MethodError, ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.method import MethodNames
from scenarios.options.sensor import SensorOptions, sensor_of
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say
from scenarios.output.tables import write_table
from scenarios.output.terminal import report_failures, run_cli
from scenarios.output.versions import versions
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.registry import CONTRAST, FLY, PLANE_FIT, WIDE
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import check_run_memory
from scenarios.pipeline.user_detectors import find_method
from scenarios.styles.method_style import method_style
from sim import CrossingConfig, Lighting

ROC, FILTER_TABLE, STEPS = "roc.csv", "filters.csv", "steps.csv"
NEEDED_BYTES = 2_000_000
"""Size of the output [bytes] (measured: below 1 MB)."""
NIGHT_BELOW_LUX, DUSK_BELOW_LUX = 40.0, 1000.0
"""Illuminances below which it is night, and dusk (assumed)."""


@dataclass(frozen=True)
class Denoise:
    """Measure filters of noise by illuminance."""

    lux: tuple[float, ...] = (1.0, 3.0, 10.0, 30.0, 100.0, 30000.0)
    """Illuminances [lux], 0.1 to 100000: night below 40, dusk below 1000, else day."""
    filters: tuple[Literal["baf", "stcf", "time-surface", "double-window"], ...] = (
        "baf",
        "stcf",
        "time-surface",
        "double-window",
    )
    """Names of the filters."""
    methods: MethodNames = (FLY, WIDE, CONTRAST, PLANE_FIT)
    omega_rad_s: float = CrossingConfig.omega_rad_s
    """Angular velocity of the vehicle [rad/s], 0.05 to 10."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Direction in which the vehicle moves in the image."""
    step_px: float = CrossingConfig.step_px
    """Largest motion in the image between two luminance samples, 0.05 to 8 [px]."""
    supersample: int = CrossingConfig.supersample
    """Rendered sub-pixels per pixel along each axis, 1 to 8."""
    seed: int = 0
    """Seed of the sensor, 0 to 2^32 - 1."""
    out: Path = Path("logs/denoise")
    """Output folder; an earlier result in it is replaced."""
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def execute(self) -> int:
        """Measure all illuminances, print the tables, and write the folder."""
        configs, cache = list(self._configs()), self.cache.open()
        check_output_folder(self.out, needed_bytes=NEEDED_BYTES)
        with atomic_folder(self.out) as work:
            filters: list[Row] = []
            steps: list[Row] = []
            failed: list[str] = []
            curves: dict[float, dict[str, Roc]] = {}
            with progress_bar() as bars:
                for config in configs:
                    lux = config.crossing.illuminance
                    stream = record_stream(config, cache, bars.track(f"{lux:g} lux"))
                    rows, curves[lux] = measure_filters(config, stream, self.filters)
                    filters += rows
                    rows, reasons = measure_steps(config, stream, self.filters, self.methods)
                    steps, failed = steps + rows, failed + reasons
            if not steps:
                raise MethodError(failed[0])
            self._write(work, filters, steps, curves, failed)
        print_filters(filters)
        print_steps(steps)
        say(f"wrote {self.out}")
        return report_failures(failed)

    def _configs(self) -> Iterator[RunConfig]:
        """Yield the configurations, all checked."""
        for name, values in (("--lux", self.lux), ("--filters", self.filters)):
            if not values or len(set(values)) < len(values):
                raise ScenarioError(
                    f"{name} is {' '.join(map(str, values)) or 'empty'}. Allowed is one value or "
                    "more, each once. Correct the list."
                )
        for method in self.methods:
            if "+" in method:
                raise ScenarioError(
                    f"--methods has {method}. Allowed are detectors without a filter, because the "
                    "filters of --filters come before each of them. Leave the filter out."
                )
            find_method(method)
            check_frames(self.sensor.changes()["preset"], method)
        for lux in sorted(self.lux):
            crossing = CrossingConfig(
                lighting=lighting_at(lux),
                illuminance_lux=lux,
                omega_rad_s=self.omega_rad_s,
                direction=Direction(self.direction),
                step_px=self.step_px,
                supersample=self.supersample,
            )
            config = RunConfig(crossing, sensor=sensor_of(self.sensor.changes()), seed=self.seed)
            check_run_memory(config)
            yield config

    def _write(
        self,
        work: Path,
        filters: list[Row],
        steps: list[Row],
        curves: dict[float, dict[str, Roc]],
        failed: list[str],
    ) -> None:
        write_table(work / FILTER_TABLE, tuple(filters[0]), (tuple(r.values()) for r in filters))
        write_table(work / STEPS, tuple(steps[0]), (tuple(row.values()) for row in steps))
        points = (
            (lux, name, noise, signal)
            for lux, of_filters in curves.items()
            for name, roc in of_filters.items()
            for noise, signal in zip(roc.kept_noise, roc.kept_signal, strict=True)
        )
        columns = ("illuminance_lux", "filter", "kept_noise", "kept_signal")
        write_table(work / ROC, columns, points)
        draw_roc(work / "roc", filters, curves)
        draw_steps(work / "steps", steps)
        parameters: dict[str, Any] = {
            "lux": self.lux,
            "filters": self.filters,
            "methods": self.methods,
            "omega_rad_s": self.omega_rad_s,
            "direction": self.direction,
            "step_px": self.step_px,
            "supersample": self.supersample,
            "seed": self.seed,
            "sensor": self.sensor.changes(),
        }
        facts = {"command": "denoise", "parameters": parameters, "versions": versions()}
        write_summary(work, facts | {"failed": failed})


def lighting_at(lux: float) -> Lighting:
    """Return the time of day of an illuminance."""
    if lux < NIGHT_BELOW_LUX:
        return Lighting.NIGHT
    return Lighting.DUSK if lux < DUSK_BELOW_LUX else Lighting.DAY


def print_filters(rows: Sequence[Row]) -> None:
    """Print the area, and what the default threshold keeps, of every filter."""
    table = Table("lux", "noise", "filter", "AUC", "signal\nkept", "noise\nkept", "CPU per\nevent")
    table.box = None
    for row in rows:
        table.add_row(
            f"{row['illuminance_lux']:g}",
            _percent(row["noise_share"]),
            row["filter"],
            f"{row['auc']:.3f}",
            _percent(row["kept_signal"]),
            _percent(row["kept_noise"]),
            f"{row['cpu_ns_per_event']:.0f} ns",
        )
    SafeConsole().print(table)


def print_steps(rows: Sequence[Row]) -> None:
    """Print the share of right steps of every detector, without a filter and behind each."""
    filters = list(dict.fromkeys(row["filter"] for row in rows))
    shares = {(r["illuminance_lux"], r["method"], r["filter"]): r for r in rows}
    table = Table("lux", "right steps", *filters, box=None)
    for lux, method in dict.fromkeys((row["illuminance_lux"], row["method"]) for row in rows):
        found = (shares.get((lux, method, name), {}) for name in filters)
        cells = (_percent(row.get("accuracy_after_100ms")) for row in found)
        table.add_row(f"{lux:g}", method_style(method).label, *cells)
    SafeConsole().print(table)


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.1f} %"


if __name__ == "__main__":
    run_cli(Denoise)
