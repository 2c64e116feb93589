"""`flybench velocity-sweep`: several angular velocities, truth against what the fly said.

The seed of a study: it renders, emulates and detects, prints one row a velocity, and writes
nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from rich.console import Console
from rich.table import Table

from scenarios.config import RunConfig
from scenarios.pipeline import Stopwatch, ViewSpan, make_crossing, make_fly, run_steps
from scenarios.report import number, percent
from scenarios.summary import judge
from scenarios.terminal import Bar, progress_bar, script
from sim import CrossingConfig, Direction, Lighting
from sim.config import PAPER_OMEGA_RAD_S

COLUMNS = ("rad/s", "px/s", "truth", "verdict", "right steps", "first right", "GRMS [1/s]")


@dataclass(frozen=True)
class VelocitySweep:
    """Run a list of angular velocities and print truth against estimate."""

    lighting: Literal["day", "night"] = "day"
    """Sun and sky, or street lamps and headlights."""
    omegas: tuple[float, ...] = ()
    """Angular velocities [rad/s]; the paper's four where not given."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Where the vehicle goes in the image."""
    seed: int = 0
    """Seed of everything random; the same gives the same events."""
    step_px: float = 0.5
    """The farthest that anything may move in the image between two samples [px]."""

    def execute(self) -> int:
        """Run the list, and print the table."""
        configs = list(self._configs())
        table = Table(*COLUMNS)
        with progress_bar() as progress:
            for config in configs:
                table.add_row(*sweep_row(config, progress))
        Console().print(table)
        return 0

    def _configs(self) -> Iterator[RunConfig]:
        lighting = Lighting(self.lighting)
        for omega in self.omegas or PAPER_OMEGA_RAD_S[lighting]:
            crossing = CrossingConfig(
                lighting=lighting,
                omega_rad_s=omega,
                direction=Direction(self.direction),
                step_px=self.step_px,
            )
            yield RunConfig(crossing, seed=self.seed)


def sweep_row(config: RunConfig, progress: Bar) -> tuple[str, ...]:
    """Run one sequence without recording it; its row of the table."""
    crossing, fly = make_crossing(config), make_fly(config)
    advance = progress.track(config.name)
    view = ViewSpan()
    estimates = []
    for step in run_steps(config, crossing, fly, Stopwatch()):
        estimates += step.estimates
        view.add(step.sample.truth)
        advance(step.sample.t_us, crossing.duration_us)
    found: dict[str, Any] = judge(estimates, config.crossing.direction, view.span_us)
    speed = crossing.intrinsics.focal_px * config.crossing.omega_rad_s
    latency = found["latency_ms"]
    return (
        f"{config.crossing.omega_rad_s:.2f}",
        f"{speed:.0f}",
        config.crossing.direction.value,
        found["direction"],
        percent(found["accuracy"]),
        "never" if latency is None else f"{latency:.0f} ms",
        number(found["grms"]),
    )


if __name__ == "__main__":
    script(VelocitySweep)
