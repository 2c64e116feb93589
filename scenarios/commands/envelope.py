"""`flybench envelope`: where a detector is correct, by speed, noise and other factors."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import tyro

from detector.estimate import FrameDetector
from scenarios.envelope.grid import BASE, LEVELS, NOISES_HZ, SPEEDS_PX_S, Grid
from scenarios.envelope.measure import measure_all
from scenarios.envelope.report import print_envelope, write_envelope
from scenarios.errors import ScenarioError
from scenarios.options.method import RepeatedMethod
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder
from scenarios.output.progress import progress_bar
from scenarios.output.streams import say
from scenarios.output.terminal import report_failures, run_cli
from scenarios.pipeline.registry import FLY
from scenarios.pipeline.user_detectors import find_method

SEEDS, SEEDS_IN_FULL = 2, 10
NEEDED_BYTES = 300_000
"""Size of the output for one method [bytes] (measured)."""
Factor = Literal[
    "contrast", "direction", "length_px", "surface", "background", "tilt_deg", "events_per_edge"
]


@dataclass(frozen=True)
class Envelope:
    """Measure on synthetic stimuli where a detector is correct."""

    REPEATABLE: ClassVar = frozenset({"--method"})
    method: RepeatedMethod = ()
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    full: bool = False
    """Measure every point ten times instead of twice, with different seeds."""
    seeds: Annotated[
        int | None, tyro.conf.arg(metavar="INT", help_behavior_hint="(default: 2)")
    ] = None
    """Number of repetitions of every point, 1 or more; overrides --full."""
    speeds: tuple[float, ...] = SPEEDS_PX_S
    """Image speeds [px/s], 1 to 20000."""
    noises: tuple[float, ...] = NOISES_HZ
    """Noise rates per pixel [Hz], 0 to 1000."""
    cross: tuple[Factor, ...] = ("direction",)
    """Factors to measure at every speed and noise; others are measured at every speed."""
    only: Annotated[
        tuple[Factor, ...] | None,
        tyro.conf.arg(metavar="FACTOR ...", help_behavior_hint="(default: all factors)"),
    ] = None
    """Factors to vary, besides those of --cross."""
    jobs: int = -1
    """Number of processes, 1 or more; -1: one per core."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("logs/envelope")
    """Output folder; an earlier result in it is replaced."""

    @property
    def methods(self) -> tuple[str, ...]:
        """Names of the methods, each once."""
        return tuple(dict.fromkeys(self.method)) or (FLY,)

    def grid(self) -> Grid:
        """Return the grid that the arguments describe.

        Raises:
            ScenarioError: a value is invalid for a stimulus, or a factor has no level.
        """
        names = LEVELS if self.only is None else {*self.only, *self.cross}
        seeds = self.seeds if self.seeds is not None else SEEDS_IN_FULL if self.full else SEEDS
        speeds, noises = tuple(sorted(set(self.speeds))), tuple(sorted(set(self.noises)))
        kept = {name: levels for name, levels in LEVELS.items() if name in names}
        return Grid(speeds, noises, kept, self.cross, seeds)

    def execute(self) -> int:
        """Measure all points, write the folder, and print the operating ranges."""
        grid, sensor = self.grid(), self.sensor.config()
        for name in self.methods:
            _check_method(name)
        check_output_folder(self.out, needed_bytes=NEEDED_BYTES * len(self.methods))
        with atomic_folder(self.out) as work:
            with progress_bar() as progress:
                advance = progress.track(f"envelope of {', '.join(self.methods)}")
                points = grid.points()
                rows, failed = measure_all(
                    points, self.methods, jobs=self.jobs, sensor=sensor, progress=advance
                )
            arguments = asdict(replace(self, method=self.methods))
            write_envelope(work, rows, grid, arguments, failed)
        print_envelope(rows, grid)
        say(f"wrote {self.out}")
        return report_failures(failed.values())


def _check_method(name: str) -> None:
    detector = find_method(name).make(width=BASE.width, height=BASE.height)
    if isinstance(detector, FrameDetector):
        raise ScenarioError(
            f"The method {name} looks at frames, but the stimuli of an envelope are events only. "
            "Allowed are methods without push_frame. Measure this one with flybench velocity-sweep."
        )


if __name__ == "__main__":
    run_cli(Envelope)
