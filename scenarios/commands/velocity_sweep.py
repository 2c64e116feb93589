"""`flybench velocity-sweep`: several angular velocities, truth against what a detector said.

It renders each velocity once, shows that to a sensor a seed, and prints one row a velocity; with
`--out` it also draws the GRMS against the velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.table import Table

from flybench.direction import Direction
from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.method import MethodName
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.tables import write_table
from scenarios.output.terminal import ProgressBars, progress_bar, run_cli
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.repeats import run_repeats
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing, make_detector
from scenarios.pipeline.scoring import judge
from scenarios.pipeline.summary import versions
from scenarios.runs.run_table import number, overlap, percent, pixels
from scenarios.sweep.grms import draw_grms, spearman_by_seed
from sim import CrossingConfig, Lighting, LuminanceCache
from sim.config import PAPER_OMEGA_RAD_S

COLUMNS = (
    "rad/s",
    "px/s",
    "verdict",
    "right steps",
    "after 100 ms",
    "first right",
    "IoU",
    "centre off",
    "GRMS\n[1/s]",
)
MOST_SEEDS = 100
TABLE = "velocities.csv"
Row = dict[str, Any]


@dataclass(frozen=True)
class VelocitySweep:
    """Run a list of angular velocities and print truth against estimate."""

    lighting: Literal["day", "night", "both"] = "day"
    """Sun and sky, or street lamps and headlights, or one after the other."""
    omegas: tuple[float, ...] = ()
    """Angular velocities [rad/s]; the paper's four where not given."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Where the vehicle goes in the image."""
    method: MethodName = FLY
    seed: int = 0
    """Seed of everything random; the same gives the same events."""
    seeds: int = 1
    """How many sensors see each rendering, with seeds from --seed on."""
    step_px: float = CrossingConfig.step_px
    """The farthest that anything may move in the image between two samples [px]."""
    supersample: int = CrossingConfig.supersample
    """Drawn points per pixel along each axis."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder for table and figure, in place of what flybench wrote there; nothing without."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def execute(self) -> int:
        """Run the list, print the table, and write the folder if one was asked for."""
        configs, cache = list(self._configs()), self.cache.open()
        make_detector(configs[0])
        if self.out is not None:
            check_output_folder(self.out)
        with progress_bar() as progress:
            rows = [
                row
                for config in configs
                for row in sweep_rows(config, self.seeds, progress, cache=cache)
            ]
        print_rows(rows)
        if self.out is not None:
            with atomic_folder(self.out) as work:
                self._write(work, rows)
            print(f"wrote {self.out}")
        return 0

    def _configs(self) -> Iterator[RunConfig]:
        if not 1 <= self.seeds <= MOST_SEEDS:
            raise ScenarioError(
                f"--seeds is {self.seeds}; allowed is 1 to {MOST_SEEDS}; ten show how much noise "
                "matters"
            )
        for light in ("day", "night") if self.lighting == "both" else (self.lighting,):
            lighting = Lighting(light)
            for omega in self.omegas or PAPER_OMEGA_RAD_S[lighting]:
                crossing = CrossingConfig(
                    lighting=lighting,
                    omega_rad_s=omega,
                    direction=Direction(self.direction),
                    step_px=self.step_px,
                    supersample=self.supersample,
                )
                yield RunConfig(crossing, method=self.method, seed=self.seed)

    def _write(self, work: Path, rows: list[Row]) -> None:
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
            },
        )


def sweep_rows(
    config: RunConfig, seeds: int, progress: ProgressBars, *, cache: LuminanceCache | None = None
) -> list[Row]:
    """Render one sequence, or have it from the cache, and show it to sensors; a row each."""
    crossing = make_crossing(config, cache)
    advance = progress.track(config.name)
    used = range(config.seed, config.seed + seeds)
    by_seed, track = run_repeats(
        config, crossing.samples(), used, lambda t_us: advance(t_us, crossing.duration_us)
    )
    direction, omega = config.crossing.direction, config.crossing.omega_rad_s
    known = {
        "lighting": config.crossing.lighting.value,
        "omega_rad_s": omega,
        "image_speed_px_s": crossing.intrinsics.focal_px * omega,
        "truth": direction.value,
        "method": config.method,
    }
    return [
        known | {"seed": seed} | judge(said, direction, track.in_view_us, track)
        for seed, said in zip(used, by_seed, strict=True)
    ]


def print_rows(rows: list[Row]) -> None:
    """Print truth against estimate: a table a light, a row a velocity, the mean over the seeds."""
    seeds = len({row["seed"] for row in rows})
    for light in dict.fromkeys(row["lighting"] for row in rows):
        own = [row for row in rows if row["lighting"] == light]
        title = f"{light}, moving {own[0]['truth']}, method {own[0]['method']}, seeds: {seeds}"
        table = Table(title=title, title_justify="left")
        for name in COLUMNS:
            table.add_column(name, no_wrap=" " not in name)
        for omega in dict.fromkeys(row["omega_rad_s"] for row in own):
            table.add_row(*_line([row for row in own if row["omega_rad_s"] == omega]))
        Console().print(table)


def _line(rows: list[Row]) -> tuple[str, ...]:
    def mean(name: str) -> float | None:
        values = [row[name] for row in rows if row[name] is not None]
        return fmean(values) if values else None

    first, latency = rows[0], mean("latency_ms")
    verdicts = sorted({row["direction"] for row in rows})
    return (
        f"{first['omega_rad_s']:.2f}",
        f"{first['image_speed_px_s']:.0f}",
        " or ".join(verdicts),
        percent(mean("accuracy")),
        percent(mean("accuracy_after_100ms")),
        "never" if latency is None else f"{latency:.0f} ms",
        overlap(mean("roi_iou")),
        pixels(mean("centroid_error_px")),
        number(mean("grms")),
    )


if __name__ == "__main__":
    run_cli(VelocitySweep)
