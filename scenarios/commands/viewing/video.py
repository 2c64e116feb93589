"""`flybench video`: make a film of a run, a study or a recording of any event camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar

import tyro

from flybench.checks import Range
from scenarios.commands.view import RECORDINGS, find_recordings, is_recording
from scenarios.errors import ScenarioError
from scenarios.film.film import Chapter, FilmOptions
from scenarios.film.film_file import GIF, MP4, FilmFile
from scenarios.film.from_events import events_material
from scenarios.film.from_rerun import rerun_material
from scenarios.film.material import Material
from scenarios.options.recording import RecordingOptions, events_file
from scenarios.output.atomic_file import atomic_file, check_output_file
from scenarios.output.atomic_folder import RECORDING
from scenarios.output.progress import ProgressBars, progress_bar
from scenarios.output.streams import say
from scenarios.output.terminal import run_cli
from scenarios.pipeline.registry import ROBUST

SPEED, FPS, WINDOW_MS = 0.1, 25, 10.0
"""Tenth of the speed, as in the viewer; frames per second of film (PAL); time from which a frame
shows events, one hop of the fly."""
_SPEED = Range(0.001, 1000.0)
_FPS = {MP4: Range(1, 120), GIF: Range(1, 50)}
"""A GIF counts time in hundredths of a second, and browsers slow down below two of them."""
_SCALE = Range(1, 16)
_WINDOW_MS = Range(0.001, 10_000.0)
_LONGEST_S = 1e9


@dataclass(frozen=True)
class Video:
    """Make a film of a run, a study or a recording."""

    GROUPS: ClassVar = {
        "section": ("from_s", "to_s", "recording"),
        "picture": ("fps", "window_ms", "scale"),
        "input": (),
    }

    paths: Annotated[
        tuple[Path, ...],
        tyro.conf.Positional,
        tyro.conf.arg(
            metavar="PATH ...",
            help="Folder of a run or a study, Rerun recording, or recording of any event camera. "
            "Several are shown side by side.",
            help_behavior_hint="",
        ),
    ]
    out: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """File to write: .mp4 (H.264) or .gif."""
    speed: float = SPEED
    """Speed of the film, 0.001 to 1000: 0.1 is slow motion, a tenth of the real speed."""
    from_s: Annotated[
        float | None,
        tyro.conf.arg(name="from", metavar="S", help_behavior_hint="(default: the start)"),
    ] = None
    """Time in the recording at which the film begins [s]."""
    to_s: Annotated[
        float | None, tyro.conf.arg(name="to", metavar="S", help_behavior_hint="(default: the end)")
    ] = None
    """Time in the recording at which the film ends [s]."""
    method: Annotated[
        str | None,
        tyro.conf.arg(
            metavar="NAME",
            help="Detector whose estimates are shown: one of those in a Rerun recording, or any "
            "that runs on a recording of events; see flybench detect --help.",
            help_behavior_hint=f"(default: the first in the recording, or {ROBUST})",
        ),
    ] = None
    recording: Annotated[
        str | None,
        tyro.conf.arg(metavar="NAME", help_behavior_hint="(default: all, one after another)"),
    ] = None
    """Show only this recording of a study, such as day_1.61."""
    fps: int = FPS
    """Frames per second of the film, 1 to 120, in a GIF to 50."""
    window_ms: Annotated[
        float | None,
        tyro.conf.arg(
            metavar="MS",
            help_behavior_hint=f"(default: {WINDOW_MS:g}, or the time of a frame if it is longer)",
        ),
    ] = None
    """Time from which each frame shows events [ms]."""
    scale: Annotated[
        int | None,
        tyro.conf.arg(metavar="N", help_behavior_hint="(default: about 640 pixels wide)"),
    ] = None
    """Pixels of the film per pixel of the sensor along each axis, 1 to 16."""
    overwrite: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Replace an existing file of --out."""
    input: tyro.conf.OmitArgPrefixes[RecordingOptions] = field(default_factory=RecordingOptions)

    def execute(self) -> int:
        """Read the recordings, and write the film."""
        options = self._options()
        chapters = self._chapters()
        out, frames = self.out.absolute(), 0  # a detector may change the current folder
        with (
            progress_bar() as bars,
            atomic_file(out, overwrite=self.overwrite) as work,
            FilmFile(work, fps=self.fps) as film,
        ):
            for paths in chapters:
                materials = [self._material(path, bars) for path in paths]
                chapter = Chapter(materials, options)
                advance = bars.track(f"drawing {', '.join(m.name for m in materials)}")
                for k, image in enumerate(chapter.images(), 1):
                    film.add(image)
                    advance(k, chapter.number)
                frames += chapter.number
        say(
            f"wrote {self.out}: {frames} frames, {frames / self.fps:.1f} s, "
            f"{out.stat().st_size / 1e6:.1f} MB"
        )
        return 0

    def _options(self) -> FilmOptions:
        ending = self.out.suffix.lower()
        if ending not in _FPS:
            raise ScenarioError(
                f"--out is {self.out}. Allowed is a name that ends in {MP4} or {GIF}. Change the "
                "ending."
            )
        _SPEED.check("--speed", self.speed, ScenarioError, default=SPEED)
        _FPS[ending].check("--fps", self.fps, ScenarioError, default=FPS)
        if self.scale is not None:
            _SCALE.check("--scale", self.scale, ScenarioError)
        if self.window_ms is not None:
            _WINDOW_MS.check("--window-ms", self.window_ms, ScenarioError, default=WINDOW_MS)
        window_ms = self.window_ms or max(WINDOW_MS, 1e3 * self.speed / self.fps)
        return FilmOptions(
            speed=self.speed,
            fps=self.fps,
            window_us=math.ceil(1e3 * window_ms),
            scale=self.scale,
            from_us=self._time_us("--from", self.from_s),
            to_us=self._time_us("--to", self.to_s),
        )

    def _time_us(self, option: str, time_s: float | None) -> int | None:
        if time_s is None:
            return None
        if not 0 <= time_s <= _LONGEST_S:
            raise ScenarioError(
                f"{option} is {time_s:g}. Allowed is 0 to {_LONGEST_S:.0f} s. Give a time in the "
                "recording."
            )
        return round(time_s * 1e6)

    def _chapters(self) -> list[list[Path]]:
        """Return the recordings of each chapter, from left to right."""
        if not self.paths:
            raise ScenarioError(
                "No recording is given. Allowed is the folder of a run or a study, or a "
                "recording. Give its path before --out."
            )
        found = [self._recordings(path) for path in self.paths]
        if len(found) > 1 and any(len(recordings) > 1 for recordings in found):
            raise ScenarioError(
                "Several paths are given, and one of them is a study. Allowed side by side are "
                "single recordings. Choose one of each study by its .rrd file."
            )
        check_output_file(
            self.out, "--out", overwrite=self.overwrite, sources=[p for f in found for p in f]
        )
        if len(found) > 1:
            return [[recordings[0] for recordings in found]]
        return [[recording] for recording in found[0]]

    def _recordings(self, path: Path) -> list[Path]:
        """Return the recordings that a path stands for."""
        is_study = (path / RECORDINGS).is_dir()
        if self.recording is not None or is_study:
            return find_recordings(path, self.recording)
        inside = path / RECORDING
        return [inside if is_recording(inside) else events_file(path)]

    def _material(self, path: Path, bars: ProgressBars) -> Material:
        if is_recording(path):
            return rerun_material(path, self.method)
        return events_material(
            partial(self.input.open, path), self.method or ROBUST, bars.track(path.name)
        )


if __name__ == "__main__":
    run_cli(Video)
