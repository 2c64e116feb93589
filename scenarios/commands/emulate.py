"""`flybench emulate`: emulate a sensor that looks at a video, images or an array."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tyro
from rich.table import Table

from emulator import EventSensor, SensorConfig, SensorOutput
from formats import EventWriter, open_writer, unit_us
from scenarios.emulate.frame_times import TimeOptions
from scenarios.emulate.luminance_samples import (
    ACCURATE_PX,
    STEP_PX,
    MotionStatistics,
    luminance_samples,
)
from scenarios.emulate.picture_source import Pictures
from scenarios.emulate.pictures import open_pictures
from scenarios.emulate.time_unit import Unit
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_file import check_output_file
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, complain
from scenarios.output.terminal import run_cli

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
        max_cd_m2: highest luminance on the sensor [cd/m²].
    """

    frames: int = 0
    t_us: int = 0
    events: int = 0
    on: int = 0
    aps: int = 0
    max_cd_m2: float = 0.0

    def add(self, output: SensorOutput) -> None:
        """Include the output of one sensor step."""
        self.events += output.events.size
        self.on += int(np.count_nonzero(output.events["p"]))
        self.aps += len(output.aps_frames)


@dataclass(frozen=True)
class Emulate:
    """Turn a video, images or an array into events."""

    input: Annotated[Path, tyro.conf.Positional]
    """Video, folder of images (in the order of their times or numbers) or .npy array."""
    out: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """File to write: .aedat4 (events and APS frames), .h5 (DSEC), .raw (EVT3), .txt, .csv, .npz."""
    fps: Annotated[
        float | None,
        tyro.conf.arg(
            metavar="HZ",
            help="Frames per second at a constant rate, 0.1 to 100000; required for arrays, and "
            "for images without times.",
            help_behavior_hint="(default: each frame's own time)",
        ),
    ] = None
    times: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="FILE",
            help="Text file with the time of each frame, one a line, alone or with the name of an "
            "image.",
            help_behavior_hint="(default: timestamps.txt, images.txt and others near the images, "
            "or the times in their names)",
        ),
    ] = None
    time_unit: Annotated[
        Unit | None,
        tyro.conf.arg(
            metavar="s|ms|us|ns",
            help="Unit of the times in a text file or in the names of images; 1/30s for frame "
            "numbers at 30 Hz.",
            help_behavior_hint="(default: decided by the values, and shown)",
        ),
    ] = None
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
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    seed: int = 0
    """Seed of the sensor's mismatch and noise, 0 to 2^32 - 1. Equal seeds give equal events."""
    interpolate: bool = False
    """Interpolate frames by optical flow so that nothing moves more than half a pixel at once."""

    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace an existing file of --out."""

    def execute(self) -> int:
        """Run the sensor, write the file and print a summary."""
        self._check_out(self.input, self.times)
        config = self.sensor.config()
        if self.time_unit is not None:
            unit_us(self.time_unit)
        options = TimeOptions(self.fps, self.times, self.time_unit)
        pictures = open_pictures(self.input, options)
        self._check_out(pictures.times.file)
        for warning in pictures.times.warnings:
            _print_note(warning)
        if pictures.times.t_us.size < 2:
            raise ScenarioError(
                f"{self.input} contains {pictures.times.t_us.size} frames. Allowed are 2 or more, "
                "because events come from changes. Give a longer sequence."
            )
        motion, totals = MotionStatistics(), EmulationTotals()
        with open_writer(
            self.out, width=config.width, height=config.height, overwrite=self.overwrite
        ) as writer:
            self._emulate(config, pictures, motion, writer, totals)
        self._warn(config, pictures, motion, totals, takes_frames=writer.takes_frames)
        self._print(pictures, motion, totals)
        return 0

    def _check_out(self, *sources: Path | None) -> None:
        known = [source for source in sources if source is not None]
        check_output_file(self.out, "--out", overwrite=self.overwrite, sources=known)

    def _emulate(
        self,
        config: SensorConfig,
        pictures: Pictures,
        motion: MotionStatistics,
        writer: EventWriter,
        totals: EmulationTotals,
    ) -> None:
        sensor = EventSensor(config, seed=self.seed)
        samples = luminance_samples(
            pictures,
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
                totals.max_cd_m2 = max(totals.max_cd_m2, float(sample.luminance.max()))
                advance(totals.frames, pictures.times.t_us.size)

    def _warn(
        self,
        config: SensorConfig,
        pictures: Pictures,
        motion: MotionStatistics,
        totals: EmulationTotals,
        *,
        takes_frames: bool,
    ) -> None:
        if motion.inaccurate and not self.interpolate:
            _print_note(
                f"Objects move by up to {motion.max_px:.1f} px between frames, by more than "
                f"{ACCURATE_PX:g} px in {motion.inaccurate} of {motion.pairs} steps. There, the "
                f"times of events are wrong by up to {motion.max_error_us / 1e3:.3g} ms, and their "
                f"number is wrong. Record {motion.max_px_s / ACCURATE_PX:.0f} frames per second, "
                "or give --interpolate."
            )
        reliable_px = LARGE_SHARE * config.width
        if self.interpolate and motion.max_px > reliable_px:
            _print_note(
                f"Objects move by up to {motion.max_px:.1f} px between frames. Optical flow is "
                f"unreliable above {reliable_px:.0f} px. Record more frames per second."
            )
        if totals.frames < pictures.times.t_us.size:
            _print_note(
                f"{self.input} has {pictures.times.t_us.size} frames, but only {totals.frames} "
                "could be decoded. It may be damaged."
            )
        if totals.aps and not takes_frames:
            _print_note(
                f"{totals.aps} APS frames were not written, because {self.out.suffix} files cannot "
                "contain them. Write an .aedat4 file to keep them.",
                kind="note",
            )

    def _print(self, pictures: Pictures, motion: MotionStatistics, totals: EmulationTotals) -> None:
        table = Table(title=str(self.out), title_justify="left", show_header=False)
        rate = f", {totals.events / totals.t_us * 1e3:,.0f} kev/s" if totals.t_us else ""
        share = f"{100 * totals.on / totals.events:.1f} % ON" if totals.events else "none"
        luminance = (
            f"up to {totals.max_cd_m2:.4g} cd/m², from the array"
            if pictures.are_luminance
            else f"up to {self.white_cd_m2:g} cd/m², {self.transfer}"
        )
        rows = {
            "frames": f"{totals.frames:,} at {pictures.times.rate()}, {totals.t_us * 1e-6:.3f} s",
            "times": pictures.times.source,
            "luminance": luminance,
            "motion": f"up to {motion.max_px:.2f} px between frames",
            "interpolated": f"{motion.interpolated:,}, at most {STEP_PX:g} px apart",
            "events": f"{totals.events:,}{rate}",
            "polarity": share,
            "APS frames": f"{totals.aps:,}",
        }
        for name, value in rows.items():
            if name != "interpolated" or self.interpolate:
                table.add_row(name, value)
        SafeConsole().print(table)


def _print_note(text: str, *, kind: str = "warning") -> None:
    complain(f"{kind}: {text}")


if __name__ == "__main__":
    run_cli(Emulate)
