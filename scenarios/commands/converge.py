"""`flybench converge`: how finely a scene must be drawn for its events to be right.

A short piece of a crossing is drawn in full at several supersamplings and steps, and from
keyframes at several spacings; a sensor without noise turns each into events, which are held against
those of the finest drawing. The defaults of `CrossingConfig` come from this table.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from emulator import EventSensor, SensorConfig
from flybench.direction import Direction
from flybench.events import Events
from scenarios.convergence.matching import WITHIN_US, match
from scenarios.errors import ScenarioError
from scenarios.options.distractors import DistractorOptions
from scenarios.output.folder import check_output, whole_folder, write_summary
from scenarios.output.tables import write_table
from scenarios.output.terminal import progress_bar, script
from scenarios.pipeline.summary import versions
from sim import Crossing, CrossingConfig, Lighting, VehicleKind
from sim.render.filament import Luminance

SENSOR = replace(SensorConfig.ideal(), theta_on=0.2, theta_off=0.2, theta_mismatch=0.035)
"""No noise, no bandwidth limit, and the same thresholds for every drawing: what differs is the
drawing's. The pixels' thresholds differ as those of a DAVIS do (Brandli 2014), since a long even
edge would otherwise cross one and the same threshold everywhere or nowhere."""


class Drawing(NamedTuple):
    """A way to draw a piece.

    Attributes:
        kind: "full" or "keyframes".
        supersample: rendered pixels per sensor pixel and axis.
        step_px: motion of the vehicle from one sample to the next [px].
        spacing_px: and from one keyframe to the next [px]; 0 in full.
    """

    kind: str
    supersample: int
    step_px: float
    spacing_px: float = 0.0


FINEST = Drawing("full", 6, 0.1)
"""Finer than anything that it is compared with."""
FULL = tuple(Drawing("full", size, step) for size in (1, 2, 4) for step in (1.0, 0.5, 0.25, 0.1))
KEYED = tuple(
    Drawing("keyframes", size, step, spacing)
    for size in (2, 3, 4)
    for step in (1.0, 0.5, 0.25)
    for spacing in (8.0, 16.0, 32.0, 64.0)
    if step == 0.5 or spacing == 32.0
)
BEFORE_MIDDLE_S = 0.06
"""The piece begins this long before closest approach, so that it is not symmetric."""
COLUMNS = (
    "lighting",
    "drawing",
    "supersampling",
    "step_px",
    "keyframe_px",
    "cpu_ms_a_sample",
    "events",
    *(f"found_within_{limit}us" for limit in WITHIN_US),
    *(f"real_within_{limit}us" for limit in WITHIN_US),
    "median_us",
)


@dataclass(frozen=True)
class Converge:
    """Draw a short piece at many finenesses, and say how its events approach the finest's."""

    lighting: Literal["day", "dusk", "night", "both"] = "both"
    """Sun and sky, or street lamps and headlights, or dusk; both: day, then night."""
    vehicle: Literal["sedan", "van", "motorcycle"] = "sedan"
    """What drives."""
    direction: Literal["right", "left", "up", "down"] = "right"
    """Where it goes in the image."""
    distractors: tyro.conf.EnumChoicesFromValues[DistractorOptions] = field(
        default_factory=DistractorOptions
    )
    """What else moves or flickers."""
    piece_px: float = 3.0
    """Length of the piece, in motion of the vehicle [px]."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder for the table as CSV, in place of what flybench wrote there; nothing without."""

    def execute(self) -> int:
        """Draw, compare, print, and write the table if asked to."""
        if not 1 <= self.piece_px <= 64:
            raise ScenarioError(
                f"--piece-px is {self.piece_px:g}; allowed is 1 to 64; 3 takes some minutes"
            )
        if self.out is not None:
            check_output(self.out)
        lightings = ("day", "night") if self.lighting == "both" else (self.lighting,)
        rows = []
        with progress_bar() as progress:
            for lighting in lightings:
                advance = progress.track(lighting)
                ways = (FINEST, *FULL, *KEYED)
                config = self._config(Lighting(lighting))
                for k, row in enumerate(converge(config, self.piece_px, ways)):
                    rows.append((lighting, *row))
                    advance(k + 1, len(ways))
        print_rows(rows)
        if self.out is not None:
            with whole_folder(self.out) as work:
                write_table(work / "convergence.csv", COLUMNS, rows)
                parameters = asdict(self) | {"out": str(self.out)}
                write_summary(
                    work,
                    {"command": "converge", "parameters": parameters, "versions": versions()},
                )
            print(f"wrote {self.out}")
        return 0

    def _config(self, lighting: Lighting) -> CrossingConfig:
        return CrossingConfig(
            lighting=lighting,
            vehicle=VehicleKind(self.vehicle),
            direction=Direction(self.direction),
            distractors=self.distractors.checked(),
        )


def converge(
    config: CrossingConfig, piece_px: float, ways: Iterable[Drawing]
) -> Iterator[tuple[Any, ...]]:
    """Draw a piece of a crossing in several ways; the first is the reference.

    Yields:
        Values of `COLUMNS` from the second on.
    """
    reference: Events | None = None
    for way in ways:
        kind, supersample, step_px, spacing_px = way
        events, cpu_ms = piece_events(config, piece_px, way)
        reference = events if reference is None else reference
        compared = match(events, reference)
        yield (
            kind,
            supersample,
            step_px,
            spacing_px or "",
            cpu_ms,
            compared.count,
            *compared.found,
            *compared.real,
            compared.median_us,
        )


def piece_events(config: CrossingConfig, piece_px: float, way: Drawing) -> tuple[Events, float]:
    """Events of a piece around closest approach drawn in one way, and its cost.

    Args:
        config: the crossing; its supersampling and spacing are replaced.
        piece_px: how far the vehicle moves.
        way: how to draw it.

    Returns:
        The events, and CPU time a sample without what is drawn once [ms].
    """
    kind, supersample, step_px, spacing_px = way
    crossing = Crossing(
        replace(config, supersample=supersample, keyframe_px=spacing_px or config.keyframe_px)
    )
    times_us = piece_times_us(crossing, piece_px, step_px)
    frames = full_frames(crossing, times_us) if kind == "full" else keyed_frames(crossing, times_us)
    clock = Clock(frames)
    events = events_of(clock)
    return events, 1e3 * clock.spent_s / max(len(times_us) - 1, 1)


class Clock:
    """Frames as they come, and the CPU time that they take but for the first.

    Attributes:
        spent_s: so far [s].
    """

    def __init__(self, frames: Iterator[tuple[int, Luminance]]) -> None:
        self._frames = frames
        self.spent_s = 0.0

    def __iter__(self) -> Iterator[tuple[int, Luminance]]:
        """Hand the frames on."""
        yield next(self._frames)
        while True:
            start_s = time.process_time()
            frame = next(self._frames, None)
            if frame is None:
                return
            self.spent_s += time.process_time() - start_s
            yield frame


def events_of(frames: Iterable[tuple[int, Luminance]]) -> Events:
    """Events of a sensor that has adapted to the first of the frames."""
    sensor = EventSensor(SENSOR, seed=0)
    found = [sensor.step(t_us, luminance).events for t_us, luminance in frames]
    return np.concatenate(found[1:])


def piece_times_us(crossing: Crossing, piece_px: float, step_px: float) -> list[int]:
    """Times of samples `step_px` apart, in motion of the target's flank [µs]."""
    px_s = target_px_s(crossing)
    first_us = crossing.duration_us // 2 - round(BEFORE_MIDDLE_S * 1e6)
    steps = round(piece_px / step_px)
    return [first_us + round(1e6 * k * step_px / px_s) for k in range(steps + 1)]


def target_px_s(crossing: Crossing) -> float:
    """Image speed of the target's flank at closest approach [px/s]."""
    speed_m_s = crossing.scene.trajectory.speed_m_s(0.0)
    return crossing.intrinsics.focal_px * speed_m_s / crossing.config.distance


def full_frames(crossing: Crossing, times_us: list[int]) -> Iterator[tuple[int, Luminance]]:
    """Each sample drawn in full."""
    with crossing.full_frames() as draw:
        for t_us in times_us:
            yield t_us, draw(t_us)


def keyed_frames(crossing: Crossing, times_us: list[int]) -> Iterator[tuple[int, Luminance]]:
    """The same times from keyframes, half way between two: where they are worst."""
    with crossing.from_keyframes(between_keyframes_us(crossing, times_us)) as draw:
        for t_us in times_us:
            yield t_us, draw(t_us).luminance


def between_keyframes_us(crossing: Crossing, times_us: list[int]) -> list[int]:
    """Times, with one before and one after that are keyframes' and as far away from the middle."""
    middle_us = (times_us[0] + times_us[-1]) / 2
    off_us = 1e6 * crossing.config.keyframe_px / 2 / target_px_s(crossing)
    first, last = (round(middle_us + side * off_us) for side in (-1, 1))
    return [min(first, times_us[0] - 1), *times_us, max(last, times_us[-1] + 1)]


def print_rows(rows: list[tuple[Any, ...]]) -> None:
    """Print the table, a line a drawing; matched is the lesser share of the two directions."""
    limits = " / ".join(f"{limit / 1000:g}" for limit in WITHIN_US)
    table = Table(title="How events approach those of the finest drawing, each light's first")
    table.add_column("light, drawing", no_wrap=True)
    for heading in ("step", "CPU", "events", f"matched in {limits} ms", "median"):
        table.add_column(heading, justify="right", no_wrap=True)
    for lighting, kind, size, step, spacing, cpu_ms, count, *rest in rows:
        found, real, median = rest[:4], rest[4:8], rest[8]
        matched = [min(pair) for pair in zip(found, real, strict=True)]
        table.add_row(
            f"{lighting} {kind} {size}×{size}" + (f" / {spacing:g} px" if spacing else ""),
            f"{step:g} px",
            f"{cpu_ms:.0f} ms" if cpu_ms >= 10 else f"{cpu_ms:.1f} ms",
            f"{count:+.1%}",
            " / ".join(f"{100 * share:.0f}" for share in matched) + " %",
            f"{median:.0f} µs",
        )
    Console().print(table)


if __name__ == "__main__":
    script(Converge)
