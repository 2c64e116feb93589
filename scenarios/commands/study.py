"""`flybench study`: repeat the paper's evaluation, and compare with exact ground truth."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import tyro

from flybench.checks import Range
from flybench.unfinished import FINISHED
from scenarios.errors import MethodError, ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.options.method import MethodNames
from scenarios.options.sensor import SensorOptions
from scenarios.output.atomic_folder import atomic_folder, check_output_folder, write_summary
from scenarios.output.progress import progress_bar
from scenarios.output.streams import say
from scenarios.output.tables import write_table
from scenarios.output.terminal import report_failures, run_cli
from scenarios.output.versions import versions
from scenarios.pipeline.frame_check import check_frames
from scenarios.pipeline.parallel import ONE_PER_CORE, check_jobs
from scenarios.pipeline.registry import DETECTORS
from scenarios.runs.sequence import estimated_bytes
from scenarios.study.claims.all_claims import evaluate_claims
from scenarios.study.claims.claim import Claim
from scenarios.study.conditions import (
    DISTRACTORS,
    FURTHER_SEEDS,
    high_thresholds,
    paper_rows,
)
from scenarios.study.figures.all_figures import draw_figures
from scenarios.study.finished import finished_sequences, link_or_copy
from scenarios.study.moving_backgrounds import in_front_of_moving_backgrounds
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.report.page import write_report
from scenarios.study.report.terminal import print_study
from scenarios.study.results import STILL, SequenceResult, without_failed
from scenarios.study.rows import COLUMNS, Row, study_rows
from scenarios.study.runner import run_sequences
from scenarios.study.summary import summarise
from scenarios.study.timed_detector import CONTRAST_HOP_US
from sim import CrossingConfig, Lighting
from sim.config import PAPER_OMEGA_RAD_S

METHODS = tuple(entry.name for entry in DETECTORS.values() if entry.in_study)
SEEDS, MOST_SEEDS = 5, 100
TABLE, REPORT, RECORDINGS, FIGURES = "results.csv", "report.html", "recordings", "figures"
REPORT_BYTES = 4_000_000
"""Room for the report, the figures and the table [bytes] (assumed)."""
_SPEED_OVER_S = 600.0
"""Time over which the progress bar averages the speed: rendering is much slower than reading from
the cache, so a short average would give a wrong remaining time [s]."""
_HOP_HELP = (
    "Time between the windows of contrast maximisation [ms]. It must divide their length. 10 ms, "
    "the step of the fly, costs four times as much CPU time."
)
_SEEDS = Range(1, MOST_SEEDS, remedy="Use at least five to estimate the variability.")


@dataclass(frozen=True)
class Study:
    """Run the paper's crossings with all methods; test its claims."""

    GROUPS: ClassVar = {
        "conditions": ("moving_backgrounds", "second_sensor"),
        "sensor": ("seeds",),
        "output": ("recordings",),
        "quality": ("contrast_hop_ms", "step_px", "supersample"),
        "cache": (),
    }

    lighting: Literal["day", "night", "both"] = "both"
    """Lighting: day (sun and sky), night (street lamps and headlights), or both in turn."""
    omegas: Annotated[
        tuple[float, ...],
        tyro.conf.arg(help_behavior_hint="(default: the paper's four of each lighting)"),
    ] = ()
    """Angular velocities at closest approach, 0.05 to 10 [rad/s]."""
    methods: MethodNames = METHODS
    sensor: tyro.conf.OmitArgPrefixes[SensorOptions] = field(default_factory=SensorOptions)
    seeds: int = SEEDS
    """Number of simulated sensors that see each crossing, 1 to 100, with seeds from 0."""
    contrast_hop_ms: Annotated[float, tyro.conf.arg(help=_HOP_HELP)] = CONTRAST_HOP_US / 1e3
    recordings: bool = True
    """Write a Rerun recording of each crossing, with the sensor of the first seed."""
    moving_backgrounds: bool = True
    """Also draw one crossing of each lighting in front of four moving backgrounds."""
    second_sensor: bool = True
    """Also show the crossings to sensors with high thresholds, which give few events an edge."""
    step_px: float = CrossingConfig.step_px
    """Largest motion in the image between two luminance samples, 0.05 to 8 [px]."""
    supersample: int = CrossingConfig.supersample
    """Sub-pixels per pixel along each axis that are rendered, 1 to 8."""
    jobs: int = ONE_PER_CORE
    """Number of parallel processes; -1: one for each core."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("logs/study")
    """Folder to write; an earlier result in it is replaced."""
    cache: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def tasks(self) -> list[SequenceTask]:
        """Return the sequences to run, without recordings; those of the paper come first.

        Raises:
            ScenarioError: the number of seeds is out of range, no method is given, or a method or a
                velocity is given twice.
            MethodError: there is no such method, or it does not implement the protocol.
            SceneConfigError: a velocity is out of range.
            DetectorConfigError: the hop of contrast maximisation does not divide its window.
        """
        self._check()
        seeds = tuple(range(self.seeds))
        sensor = self.sensor.config()
        for method in self.methods:
            check_frames(self.sensor.preset, method)
        tasks = [
            SequenceTask(
                crossing,
                methods=self.methods,
                sensor=sensor,
                seeds=seeds,
                cache=self.cache,
                contrast_hop_us=round(self.contrast_hop_ms * 1e3),
                high_threshold_seeds=seeds[:FURTHER_SEEDS] if self.second_sensor else (),
            )
            for crossing in self._crossings()
        ]
        tasks[0].detectors(0)
        moving = in_front_of_moving_backgrounds(tasks) if self.moving_backgrounds else ()
        return [*tasks, *moving]

    def execute(self) -> int:
        """Run the study, write the folder and print the results."""
        start_s = time.perf_counter()
        tasks = self.tasks()
        self.cache.open()
        check_output_folder(self.out, needed_bytes=self._estimated_bytes(tasks))
        with atomic_folder(self.out) as work, finished_sequences(work.parent / FINISHED) as done:
            if self.recordings:
                tasks = [
                    done.recorded(task) if task.background == STILL else task for task in tasks
                ]
            with progress_bar(_SPEED_OVER_S) as progress:
                advance = progress.track("study")
                sequences = run_sequences(tasks, jobs=self.jobs, finished=done, progress=advance)
            sequences, failed = without_failed(sequences)
            if len(failed) == len(self.methods):
                raise MethodError(next(iter(failed.values())))
            rows = study_rows(sequences)
            claims = evaluate_claims(rows)
            self._write(work, tasks, sequences, rows, claims, failed, start_s)
        print_study(paper_rows(rows), claims)
        say(f"Wrote {self.out}. Open {self.out / REPORT} to read the report.")
        return report_failures(failed.values())

    def _check(self) -> None:
        _SEEDS.check("--seeds", self.seeds, ScenarioError)
        for name, values in (("methods", self.methods), ("omegas", self.omegas)):
            if len(set(values)) < len(values):
                raise ScenarioError(
                    f"--{name} is {' '.join(map(str, values))}. Allowed is each value once. Leave "
                    "out the duplicates."
                )
        if not self.methods:
            raise ScenarioError(
                "--methods is empty. Allowed is one method or more. Name one, such as fly."
            )
        check_jobs(self.jobs)

    def _crossings(self) -> list[CrossingConfig]:
        lightings = ("day", "night") if self.lighting == "both" else (self.lighting,)
        return [
            CrossingConfig(
                lighting=Lighting(lighting),
                omega_rad_s=omega,
                step_px=self.step_px,
                supersample=self.supersample,
            )
            for lighting in lightings
            for omega in self.omegas or PAPER_OMEGA_RAD_S[Lighting(lighting)]
        ]

    def _estimated_bytes(self, tasks: Sequence[SequenceTask]) -> int:
        if not self.recordings:
            return REPORT_BYTES
        recorded = [task for task in tasks if task.background == STILL]
        return REPORT_BYTES + sum(estimated_bytes(task.config()) for task in recorded)

    def _write(
        self,
        work: Path,
        tasks: Sequence[SequenceTask],
        sequences: Sequence[SequenceResult],
        rows: list[Row],
        claims: Sequence[Claim],
        failed: Mapping[str, str],
        start_s: float,
    ) -> None:
        if self.recordings:
            (work / RECORDINGS).mkdir()
        for task in tasks:
            if task.recording is not None:
                link_or_copy(task.recording, work / RECORDINGS / f"{task.name}.rrd")
        write_table(work / TABLE, COLUMNS, (tuple(row.values()) for row in rows))
        (work / FIGURES).mkdir()
        figures = draw_figures(work / FIGURES, sequences)
        write_report(
            work / REPORT,
            sequences=sequences,
            rows=rows,
            claims=claims,
            parameters=self._parameters(tasks),
            figures=figures,
            failed=failed,
        )
        about = {
            "command": "study",
            "parameters": self._arguments(),
            "versions": versions(),
            "wall_s": round(time.perf_counter() - start_s, 1),
            "failed": failed,
        }
        write_summary(work, about | summarise(rows, claims))

    def _parameters(self, tasks: Sequence[SequenceTask]) -> dict[str, Any]:
        """Return the parameters for the report: arguments, scene, sensor and methods."""
        first = tasks[0]
        return {
            "command": self._command(),
            "study": self._arguments(),
            "scene": first.crossing,
            "sensor": first.sensor,
            "second sensor": high_thresholds(first.sensor) if self.second_sensor else "none",
            "moving backgrounds": dict(DISTRACTORS) if self.moving_backgrounds else "none",
            "methods": {w.method: c for w in tasks[-1].detectors(0) if (c := w.config) is not None},
        }

    def _arguments(self) -> dict[str, Any]:
        arguments = asdict(self) | {"out": str(self.out)}
        for name in ("cache", "jobs"):  # the result does not depend on them
            del arguments[name]
        return arguments

    def _command(self) -> str:
        """Return the command that repeats this study."""
        defaults, parts = asdict(Study()), ["flybench study"]
        for name, value in self._arguments().items():
            option = name.replace("_", "-")
            if name in ("out", "sensor") or value == defaults[name]:
                continue
            if isinstance(value, bool):
                parts.append(f"--{option}" if value else f"--no-{option}")
            else:
                words = value if isinstance(value, tuple) else (value,)
                parts.append(" ".join([f"--{option}", *map(str, words)]))
        return " ".join([*parts, *self.sensor.arguments()])


if __name__ == "__main__":
    run_cli(Study)
