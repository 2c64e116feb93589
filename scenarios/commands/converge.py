"""`flybench converge`: how finely a scene must be rendered for its events to be correct."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.table import Table

from emulator import SensorConfig
from flybench.direction import Direction
from scenarios.convergence.matching import WITHIN_US
from scenarios.convergence.measure import (
    COLUMNS,
    RENDERINGS,
    measure_convergence,
    noise_free_sensor,
)
from scenarios.errors import ScenarioError
from scenarios.options.distractors import DistractorOptions
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say
from scenarios.output.tables import write_table
from scenarios.output.terminal import run_cli
from scenarios.output.versions import versions
from sim import CrossingConfig, Lighting, VehicleKind

NEEDED_BYTES = 12_000
"""Size of the output [bytes] (measured)."""
TABLE = "convergence.csv"


@dataclass(frozen=True)
class Converge:
    """Measure how events converge as rendering gets finer."""

    lighting: Literal["day", "dusk", "night", "both"] = "both"
    """day: sun, sky. dusk: sky, street lamps. night: street lamps, headlights. both: day, night."""
    vehicle: Literal["sedan", "van", "motorcycle"] = "sedan"
    """Kind of vehicle."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Direction in which the vehicle moves in the image."""
    distractors: tyro.conf.EnumChoicesFromValues[DistractorOptions] = field(
        default_factory=DistractorOptions
    )
    """Other things that move or flicker."""
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    piece_px: float = 3.0
    """Length of the rendered piece: distance that the vehicle moves in the image, 1 to 64 [px]."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(metavar="DIR", help_behavior_hint="(default: nothing is written)"),
    ] = None
    """Folder for the table as CSV; an earlier result in it is replaced."""

    def execute(self) -> int:
        """Render, compare, print, and write the table if `--out` is given."""
        if not 1 <= self.piece_px <= 64:
            raise ScenarioError(
                f"--piece-px is {self.piece_px:g}. Allowed is a number from 1 to 64. The default "
                "is 3, which takes some minutes."
            )
        sensor = noise_free_sensor(None if self.sensor.is_default else self.sensor.config())
        if self.out is None:
            print_rows(self._measure(sensor))
            return 0
        check_output_folder(self.out, needed_bytes=NEEDED_BYTES)
        with atomic_folder(self.out) as work:
            rows = self._measure(sensor)
            print_rows(rows)
            write_table(work / TABLE, ("lighting", *COLUMNS), rows)
            parameters = asdict(self) | {"out": str(self.out)}
            write_summary(
                work, {"command": "converge", "parameters": parameters, "versions": versions()}
            )
        say(f"wrote {self.out}")
        return 0

    def _measure(self, sensor: SensorConfig) -> list[tuple[Any, ...]]:
        rows = []
        with progress_bar() as progress:
            for lighting in ("day", "night") if self.lighting == "both" else (self.lighting,):
                advance = progress.track(lighting)
                config = self._config(Lighting(lighting))
                found = measure_convergence(config, self.piece_px, RENDERINGS, sensor)
                for k, row in enumerate(found):
                    rows.append((lighting, *row))
                    advance(k + 1, len(RENDERINGS))
        return rows

    def _config(self, lighting: Lighting) -> CrossingConfig:
        return CrossingConfig(
            lighting=lighting,
            vehicle=VehicleKind(self.vehicle),
            direction=Direction(self.direction),
            distractors=self.distractors.checked(),
        )


def print_rows(rows: list[tuple[Any, ...]]) -> None:
    """Print one line per rendering; "matched" is the lower of recall and precision."""
    limits = " / ".join(f"{limit / 1000:g}" for limit in WITHIN_US)
    table = Table(title="Events compared with the first row of each lighting, the finest rendering")
    table.add_column("lighting, rendering", no_wrap=True)
    for heading in ("step", "CPU", "events", f"matched in {limits} ms", "median"):
        table.add_column(heading, justify="right", no_wrap=True)
    for lighting, kind, size, step, spacing, cpu_ms, excess, *rest in rows:
        recall, precision, median = rest[:4], rest[4:8], rest[8]
        matched = [min(pair) for pair in zip(recall, precision, strict=True)]
        table.add_row(
            f"{lighting} {kind} {size}×{size}" + (f" / {spacing:g} px" if spacing else ""),
            f"{step:g} px",
            f"{cpu_ms:.0f} ms" if cpu_ms >= 10 else f"{cpu_ms:.1f} ms",
            f"{excess:+.1%}",
            " / ".join(f"{100 * share:.0f}" for share in matched) + " %",
            f"{median:.0f} µs",
        )
    SafeConsole().print(table)


if __name__ == "__main__":
    run_cli(Converge)
