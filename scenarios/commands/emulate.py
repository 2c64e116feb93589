"""`flybench emulate`: a video, a folder of images or an array, as a DAVIS346 would have seen it."""

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
from scenarios.emulate.pictures import Pictures, open_pictures
from scenarios.emulate.samples import BELIEVABLE_PX, STEP_PX, Motion, samples
from scenarios.errors import ScenarioError
from scenarios.output.terminal import progress_bar, script
from scenarios.output.whole_file import check_place

FPS_MIN, FPS_MAX = 0.1, 100_000.0
WHITE_CD_M2 = 200.0
"""A display's white (assumed)."""
LARGE_SHARE = 0.1
"""Of the sensor's width: motion from frame to frame above which flow is not to be believed
(assumed)."""


@dataclass
class Seen:
    """What came out of the sensor.

    Attributes:
        frames: pictures that it was shown.
        t_us: time of the last [µs].
        events, on: how many, and of them ON.
        aps: frames of the APS.
    """

    frames: int = 0
    t_us: int = 0
    events: int = 0
    on: int = 0
    aps: int = 0

    def add(self, output: SensorOutput) -> None:
        """Count what a step brought."""
        self.events += output.events.size
        self.on += int(np.count_nonzero(output.events["p"]))
        self.aps += len(output.aps_frames)


@dataclass(frozen=True)
class Emulate:
    """Turn pictures into the events and frames of a DAVIS346: a video, a folder, an array."""

    input: Annotated[Path, tyro.conf.Positional]
    """A video, a folder of images in the order of their numbers, or a .npy array."""
    out: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """What to write: .aedat4 (events and frames), .h5 (DSEC), .raw (EVT3), .txt, .csv or .npz."""
    fps: float | None = None
    """Frames a second; a video's own where not given."""
    white_cd_m2: float = WHITE_CD_M2
    """Luminance that the highest level stands for [cd/m²]: 200 on a display, 2000 in the shade,
    10000 in the sun."""
    transfer: Literal["srgb", "linear"] = "srgb"
    """How levels stand for light: as cameras encode it, or in proportion."""
    sensor: PresetName = "davis346"
    """Preset of the sensor; the middle of the picture fills it."""
    seed: int = 0
    """Seed of everything random."""
    interpolate: bool = False
    """Put pictures between frames by optical flow, so that nothing moves farther than half a pixel
    at once."""

    def execute(self) -> int:
        """Emulate, write the file, and print what is in it."""
        check_place(self.out, "--out")
        pictures = open_pictures(self.input)
        fps, motion, seen = self._fps(pictures), Motion(), Seen()
        config = preset(self.sensor)
        with open_writer(self.out, width=config.width, height=config.height) as writer:
            self._emulate(pictures, fps, motion, writer, seen)
            if seen.frames < 2:
                raise ScenarioError(
                    f"{self.input} holds {seen.frames} frames; allowed is 2 and more, since events "
                    "come from change; give a longer one"
                )
        self._warn(pictures, fps, motion, seen, takes_frames=writer.takes_frames)
        self._print(fps, motion, seen)
        return 0

    def _emulate(
        self, pictures: Pictures, fps: float, motion: Motion, writer: EventWriter, seen: Seen
    ) -> None:
        config = preset(self.sensor)
        sensor = EventSensor(config, seed=self.seed)
        found = samples(
            pictures,
            fps=fps,
            size=(config.width, config.height),
            white_cd_m2=self.white_cd_m2,
            transfer=self.transfer,
            interpolate=self.interpolate,
            motion=motion,
        )
        with progress_bar() as progress:
            tell = progress.track(self.input.name)
            for sample in found:
                output = sensor.step(sample.t_us, sample.luminance)
                writer.write(output.events)
                if writer.takes_frames:
                    for frame in output.aps_frames:
                        writer.write_frame(frame)
                seen.add(output)
                seen.frames, seen.t_us = sample.frame + 1, sample.t_us
                tell(seen.frames, max(seen.frames, pictures.count))

    def _fps(self, pictures: Pictures) -> float:
        fps = self.fps if self.fps is not None else pictures.fps
        if fps is None:
            raise ScenarioError(
                f"{self.input} does not say how many frames a second it has; give them with --fps, "
                "such as --fps 1000"
            )
        if not FPS_MIN <= fps <= FPS_MAX:
            raise ScenarioError(
                f"the frames a second are {fps:g}; allowed is {FPS_MIN:g} to {FPS_MAX:g}; give "
                "them with --fps"
            )
        return fps

    def _warn(
        self, pictures: Pictures, fps: float, motion: Motion, seen: Seen, *, takes_frames: bool
    ) -> None:
        if motion.too_far and not self.interpolate:
            _tell(
                f"things move by up to {motion.most_px:.1f} px from frame to frame, more than "
                f"{BELIEVABLE_PX:g} px in {motion.too_far} of {motion.pairs} steps: events there "
                f"come at times that are wrong by up to {1e3 / fps:.3g} ms, and in wrong numbers; "
                f"take {fps * motion.most_px / BELIEVABLE_PX:.0f} frames a second, or give "
                "--interpolate"
            )
        widest_px = LARGE_SHARE * preset(self.sensor).width
        if self.interpolate and motion.most_px > widest_px:
            _tell(
                f"things move by up to {motion.most_px:.1f} px from frame to frame; optical flow "
                f"is seldom right above {widest_px:.0f} px; take more frames a second"
            )
        if seen.frames < pictures.count:
            _tell(
                f"{self.input} promises {pictures.count} frames, and {seen.frames} could be read; "
                "it may be cut"
            )
        if seen.aps and not takes_frames:
            _tell(
                f"{seen.aps} APS frames were left out, since {self.out.suffix} holds none; write "
                "an .aedat4 to keep them",
                kind="note",
            )

    def _print(self, fps: float, motion: Motion, seen: Seen) -> None:
        table = Table(title=str(self.out), title_justify="left", show_header=False)
        rate = f", {seen.events / seen.t_us * 1e3:,.0f} kev/s" if seen.t_us else ""
        share = f"{seen.on / seen.events:.1%} ON" if seen.events else "none"
        rows = {
            "frames": f"{seen.frames:,} at {fps:g} a second, {seen.t_us * 1e-6:.3f} s",
            "luminance": f"up to {self.white_cd_m2:g} cd/m², {self.transfer}",
            "motion": f"up to {motion.most_px:.2f} px from frame to frame",
            "put between": f"{motion.made:,}, by optical flow, {STEP_PX:g} px apart at most",
            "events": f"{seen.events:,}{rate}",
            "polarity": share,
            "APS frames": f"{seen.aps:,}",
        }
        for name, value in rows.items():
            if name != "put between" or self.interpolate:
                table.add_row(name, value)
        Console().print(table)


def _tell(what: str, *, kind: str = "warning") -> None:
    print(f"flybench: {kind}: {what}", file=sys.stderr)


if __name__ == "__main__":
    script(Emulate)
