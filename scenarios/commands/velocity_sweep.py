"""`flybench velocity-sweep`: compare estimates with the truth at several angular velocities.

The command renders one sequence per velocity, shows it to one sensor per seed, and prints one row
per velocity. With `--out` it also draws GRMS against velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import tyro

from flybench.direction import Direction
from scenarios.errors import MethodError, ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.method import MethodName
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import say
from scenarios.output.tables import write_table
from scenarios.output.terminal import report_failures, run_cli
from scenarios.output.versions import versions
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_detector
from scenarios.velocity_sweep.grms import draw_grms, spearman_by_seed
from scenarios.velocity_sweep.rows import Row, measure_velocity
from scenarios.velocity_sweep.table import print_rows
from sim import CrossingConfig, Lighting, LuminanceCache
from sim.config import PAPER_OMEGA_RAD_S
from sim.render.kept_renderer import kept_renderer

MAX_SEEDS = 100
NEEDED_BYTES = 60_000
"""Size of the output [bytes] (measured)."""
TABLE = "velocities.csv"


@dataclass(frozen=True)
class VelocitySweep:
    """Run several angular velocities; compare with the truth."""

    GROUPS: ClassVar = {
        "sensor": ("seed", "seeds"),
        "rendering": ("step_px", "supersample"),
        "cache": (),
    }

    lighting: Literal["day", "night", "both"] = "day"
    """day: sun and sky. night: street lamps and headlights. both: day, then night."""
    omegas: Annotated[
        tuple[float, ...], tyro.conf.arg(help_behavior_hint="(default: the paper's four)")
    ] = ()
    """Angular velocities [rad/s], 0.05 to 10."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Direction in which the vehicle moves in the image."""
    method: MethodName = FLY
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    seed: int = 0
    """Seed of the first sensor, 0 to 2^32 - 1. Equal seeds give equal events."""
    seeds: int = 1
    """Number of sensors per velocity, 1 to 100. Their seeds start at --seed."""
    step_px: float = CrossingConfig.step_px
    """Largest motion in the image between two luminance samples, 0.05 to 8 [px]."""
    supersample: int = CrossingConfig.supersample
    """Rendered sub-pixels per pixel along each axis, 1 to 8."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(metavar="DIR", help_behavior_hint="(default: nothing is written)"),
    ] = None
    """Folder for the table and the figure; an earlier result in it is replaced."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def execute(self) -> int:
        """Measure all velocities, print the table, and write the folder if `--out` is given."""
        configs, cache = list(self._configs()), self.cache.open()
        check_frames(self.sensor.preset, self.method)
        make_detector(configs[0])
        if self.out is None:
            rows, failed = self._measure(configs, cache)
            print_rows(rows)
            return report_failures(failed)
        check_output_folder(self.out, needed_bytes=NEEDED_BYTES)
        with atomic_folder(self.out) as work:
            rows, failed = self._measure(configs, cache)
            print_rows(rows)
            self._write(work, rows, failed)
        say(f"wrote {self.out}")
        return report_failures(failed)

    def _measure(
        self, configs: list[RunConfig], cache: LuminanceCache | None
    ) -> tuple[list[Row], list[str]]:
        """Return the rows of all velocities, and why the detector failed at some of them."""
        rows: list[Row] = []
        failed: list[str] = []
        with progress_bar() as progress, kept_renderer():
            for config in configs:
                try:
                    rows += measure_velocity(config, self.seeds, progress, cache=cache)
                except MethodError as error:
                    failed.append(f"{error} (sequence {config.name})")
        if not rows:
            raise MethodError(failed[0])
        return rows, failed

    def _configs(self) -> Iterator[RunConfig]:
        if not 1 <= self.seeds <= MAX_SEEDS:
            raise ScenarioError(
                f"--seeds is {self.seeds}. Allowed is a whole number from 1 to {MAX_SEEDS}. "
                "Use about ten to see the effect of the noise."
            )
        sensor = self.sensor.config()
        names = ("day", "night") if self.lighting == "both" else (self.lighting,)
        for lighting in map(Lighting, names):
            for omega in self.omegas or PAPER_OMEGA_RAD_S[lighting]:
                crossing = CrossingConfig(
                    lighting=lighting,
                    omega_rad_s=omega,
                    direction=Direction(self.direction),
                    step_px=self.step_px,
                    supersample=self.supersample,
                )
                yield RunConfig(crossing, sensor, method=self.method, seed=self.seed)

    def _write(self, work: Path, rows: list[Row], failed: list[str]) -> None:
        write_table(work / TABLE, tuple(rows[0]), (tuple(row.values()) for row in rows))
        draw_grms(work / "grms", rows, method=self.method)
        arguments = asdict(self) | {"out": str(self.out)}
        del arguments["cache"]  # the result does not depend on it
        write_summary(
            work,
            {
                "command": "velocity-sweep",
                "parameters": arguments,
                "versions": versions(),
                "spearman": spearman_by_seed(rows),
                "failed": failed,
            },
        )


if __name__ == "__main__":
    run_cli(VelocitySweep)
