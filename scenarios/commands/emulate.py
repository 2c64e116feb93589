"""`flybench emulate`: emulate a sensor that looks at a video, images or an array."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from emulator import EventSensor, SensorOutput, preset
from emulator.presets import PresetName
from formats import EventWriter, open_writer
from scenarios.emulate.luminance_samples import (
    ACCURATE_PX,
    STEP_PX,
    MotionStatistics,
    luminance_samples,
)
from scenarios.emulate.pictures import Pictures, open_pictures
from scenarios.errors import ScenarioError
from scenarios.output.atomic_file import check_output_file
from scenarios.output.terminal import progress_bar, run_cli

FPS_MIN, FPS_MAX = 0.1, 100_000.0
WHITE_CD_M2 = 200.0
"""Luminance of a white display (assumed)."""
LARGE_SHARE = 0.1
"""Motion between frames, as a share of the sensor's width, above which optical flow is unreliable
(assumed)."""


@dataclass
class EmulationTotals:
    """Totals of the sensor's input and output.

    Attributes:
        frames: number of pictures that the sensor has seen.
        t_us: time of the last picture [µs].
        events: number of events.
        on: number of ON events.
        aps: number of APS frames.
    """

    frames: int = 0
    t_us: int = 0
    events: int = 0
    on: int = 0
    aps: int = 0

    def add(self, output: SensorOutput) -> None:
        """Include the output of one sensor step."""
        self.events += output.events.size
        self.on += int(np.count_nonzero(output.events["p"]))
        self.aps += len(output.aps_frames)


@dataclass(frozen=True)
class Emulate:
    """Emulate a sensor that looks at a video, images or an array, and write its events."""

    input: Annotated[Path, tyro.conf.Positional]
    """Video, folder of images (in the order of the numbers in their names) or .npy array."""
    out: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """File to write: .aedat4 (events and APS frames), .h5 (DSEC), .raw (EVT3), .txt, .csv, .npz."""
    fps: Annotated[
        float | None,
        tyro.conf.arg(metavar="HZ", help_behavior_hint="(default: that of the video)"),
    ] = None
    """Frames per second, 0.1 to 100000; required for images and arrays."""
    white_cd_m2: Annotated[
        float,
        tyro.conf.arg(
            metavar="CD_M2",
            help="Luminance of the highest grey level [cd/m²], above 0: 200 for a display, 2000 in "
            "the shade, 10000 in the sun.",
        ),
    ] = WHITE_CD_M2
    transfer: Literal["srgb", "linear"] = "srgb"
    """Relation of grey levels to luminance: sRGB, as in most images and videos, or linear."""
    sensor: PresetName = "davis346"
    """Preset of the sensor. The picture is scaled and cropped to fill it."""
    seed: int = 0
    """Seed of the sensor's mismatch and noise, 0 to 2^32 - 1. Equal seeds give equal events."""
    interpolate: bool = False
    """Interpolate frames by optical flow so that nothing moves more than half a pixel at once."""

    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace an existing file of --out."""

    def execute(self) -> int:
        """Run the sensor, write the file and print a summary."""
        check_output_file(self.out, "--out", overwrite=self.overwrite)
        pictures = open_pictures(self.input)
        fps, motion, totals = self._fps(pictures), MotionStatistics(), EmulationTotals()
        config = preset(self.sensor)
        with open_writer(
            self.out, width=config.width, height=config.height, overwrite=self.overwrite
        ) as writer:
            self._emulate(pictures, fps, motion, writer, totals)
            if totals.frames < 2:
                raise ScenarioError(
                    f"{self.input} contains {totals.frames} frames. Allowed are 2 or more, because "
                    "events come from changes. Give a longer sequence."
                )
        self._warn(pictures, fps, motion, totals, takes_frames=writer.takes_frames)
        self._print(fps, motion, totals)
        return 0

    def _emulate(
        self,
        pictures: Pictures,
        fps: float,
        motion: MotionStatistics,
        writer: EventWriter,
        totals: EmulationTotals,
    ) -> None:
        config = preset(self.sensor)
        sensor = EventSensor(config, seed=self.seed)
        samples = luminance_samples(
            pictures,
            fps=fps,
            size=(config.width, config.height),
            white_cd_m2=self.white_cd_m2,
            transfer=self.transfer,
            interpolate=self.interpolate,
            motion=motion,
        )
        with progress_bar() as progress:
            advance = progress.track(self.input.name)
            for sample in samples:
                output = sensor.step(sample.t_us, sample.luminance)
                writer.write(output.events)
                if writer.takes_frames:
                    for frame in output.aps_frames:
                        writer.write_frame(frame)
                totals.add(output)
                totals.frames, totals.t_us = sample.frame + 1, sample.t_us
                advance(totals.frames, max(totals.frames, pictures.count))

    def _fps(self, pictures: Pictures) -> float:
        fps = self.fps if self.fps is not None else pictures.fps
        if fps is None:
            raise ScenarioError(
                f"{self.input} does not state its frames per second. Give them with --fps, such as "
                "--fps 1000."
            )
        if not FPS_MIN <= fps <= FPS_MAX:
            raise ScenarioError(
                f"The frame rate is {fps:g} frames per second. Allowed is {FPS_MIN:g} to "
                f"{FPS_MAX:g}. Give another with --fps."
            )
        return fps

    def _warn(
        self,
        pictures: Pictures,
        fps: float,
        motion: MotionStatistics,
        totals: EmulationTotals,
        *,
        takes_frames: bool,
    ) -> None:
        if motion.inaccurate and not self.interpolate:
            _print_note(
                f"Objects move by up to {motion.max_px:.1f} px between frames, by more than "
                f"{ACCURATE_PX:g} px in {motion.inaccurate} of {motion.pairs} steps. There, the "
                f"times of events are wrong by up to {1e3 / fps:.3g} ms, and their number is "
                f"wrong. Record {fps * motion.max_px / ACCURATE_PX:.0f} frames per second, or give "
                "--interpolate."
            )
        reliable_px = LARGE_SHARE * preset(self.sensor).width
        if self.interpolate and motion.max_px > reliable_px:
            _print_note(
                f"Objects move by up to {motion.max_px:.1f} px between frames. Optical flow is "
                f"unreliable above {reliable_px:.0f} px. Record more frames per second."
            )
        if totals.frames < pictures.count:
            _print_note(
                f"{self.input} states {pictures.count} frames, but only {totals.frames} could be "
                "read. It may be truncated."
            )
        if totals.aps and not takes_frames:
            _print_note(
                f"{totals.aps} APS frames were not written, because {self.out.suffix} files cannot "
                "contain them. Write an .aedat4 file to keep them.",
                kind="note",
            )

    def _print(self, fps: float, motion: MotionStatistics, totals: EmulationTotals) -> None:
        table = Table(title=str(self.out), title_justify="left", show_header=False)
        rate = f", {totals.events / totals.t_us * 1e3:,.0f} kev/s" if totals.t_us else ""
        share = f"{totals.on / totals.events:.1%} ON" if totals.events else "none"
        rows = {
            "frames": f"{totals.frames:,} at {fps:g} Hz, {totals.t_us * 1e-6:.3f} s",
            "luminance": f"up to {self.white_cd_m2:g} cd/m², {self.transfer}",
            "motion": f"up to {motion.max_px:.2f} px between frames",
            "interpolated": f"{motion.interpolated:,}, at most {STEP_PX:g} px apart",
            "events": f"{totals.events:,}{rate}",
            "polarity": share,
            "APS frames": f"{totals.aps:,}",
        }
        for name, value in rows.items():
            if name != "interpolated" or self.interpolate:
                table.add_row(name, value)
        Console().print(table)


def _print_note(text: str, *, kind: str = "warning") -> None:
    print(f"flybench: {kind}: {text}", file=sys.stderr)


if __name__ == "__main__":
    run_cli(Emulate)
