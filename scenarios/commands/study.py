"""`flybench study`: the paper's evaluation, with what truth can tell beyond it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.table import Table

from scenarios.errors import ScenarioError
from scenarios.options.cache import CacheOptions
from scenarios.output.folder import check_output, whole_folder, write_summary
from scenarios.output.tables import write_table
from scenarios.output.terminal import progress_bar, script
from scenarios.pipeline.parallel import ONE_PER_CORE, check_jobs
from scenarios.pipeline.registry import DETECTORS
from scenarios.pipeline.summary import versions
from scenarios.runs.run_table import format_number
from scenarios.study.claims.all_claims import hold_claims
from scenarios.study.claims.claim import Claim, told
from scenarios.study.figures.all_figures import draw_figures
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.report.page import write_report
from scenarios.study.results import Sequence as Result
from scenarios.study.rows import COLUMNS, Row, study_rows
from scenarios.study.runner import run_all
from scenarios.study.statistics import Interval, by_method_and_light
from scenarios.study.watcher import CONTRAST_HOP_US
from sim import CrossingConfig, Lighting
from sim.config import PAPER_OMEGA_RAD_S

METHODS = tuple(entry.name for entry in DETECTORS.values() if entry.in_study)
SEEDS, MOST_SEEDS = 5, 100
TABLE, REPORT, RECORDINGS, FIGURES = "results.csv", "report.html", "recordings", "figures"
_SPEED_OVER_S = 600.0
"""Light is drawn much more slowly than it is read, so the time left needs a long memory."""


@dataclass(frozen=True)
class Study:
    """Run the paper's crossings with every method, and hold the paper's claims against them."""

    lighting: Literal["day", "night", "both"] = "both"
    """Sun and sky, or street lamps and headlights, or one after the other."""
    omegas: tuple[float, ...] = ()
    """Angular velocities [rad/s]; the paper's four by each light where not given."""
    methods: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME ...")] = METHODS
    """Detectors by name, or classes of your own as package.module:Class."""
    seeds: int = SEEDS
    """How many sensors see each crossing, with seeds from 0 on."""
    contrast_hop_ms: float = CONTRAST_HOP_US / 1e3
    """Step between windows of contrast maximisation [ms]; 10 is the fly's, at four times the
    cost."""
    recordings: bool = True
    """Whether to write a Rerun recording of each crossing, with the first seed."""
    step_px: float = CrossingConfig.step_px
    """The farthest that anything may move in the image between two samples [px]."""
    supersample: int = CrossingConfig.supersample
    """Drawn points per pixel along each axis."""
    jobs: int = ONE_PER_CORE
    """How many processes; -1: one a core."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("logs/study")
    """Folder to write; takes the place of what flybench wrote there before."""
    light: tyro.conf.OmitArgPrefixes[CacheOptions] = field(default_factory=CacheOptions)

    def tasks(self) -> list[SequenceTask]:
        """The crossings that the arguments ask for, without recordings.

        Raises:
            ScenarioError: no seed or too many, no method or one twice, or a velocity twice.
            MethodError: there is no such method, or it does not obey the protocol.
            SceneConfigError: a velocity is out of range.
            DetectorConfigError: the hop of contrast maximisation does not divide its window.
        """
        self._check()
        tasks = [
            SequenceTask(
                crossing,
                methods=self.methods,
                seeds=tuple(range(self.seeds)),
                light=self.light,
                contrast_hop_us=round(self.contrast_hop_ms * 1e3),
            )
            for crossing in self._crossings()
        ]
        tasks[0].watchers(0)
        return tasks

    def execute(self) -> int:
        """Run, write the folder, and print what was found."""
        start_s = time.perf_counter()
        tasks = self.tasks()
        self.light.open()
        check_output(self.out)
        with whole_folder(self.out) as work:
            with progress_bar(_SPEED_OVER_S) as progress:
                advance = progress.track("study")
                tasks = self._recorded(tasks, work)
                sequences = run_all(tasks, jobs=self.jobs, progress=advance)
            rows = study_rows(sequences)
            claims = hold_claims(rows)
            self._write(work, tasks, sequences, rows, claims, start_s)
        print_study(rows, claims)
        print(f"wrote {self.out}; read {self.out / REPORT}")
        return 0

    def _check(self) -> None:
        if not 1 <= self.seeds <= MOST_SEEDS:
            raise ScenarioError(
                f"--seeds is {self.seeds}; allowed is 1 to {MOST_SEEDS}; five are the least that "
                "tell how much noise matters"
            )
        for name, values in (("methods", self.methods), ("omegas", self.omegas)):
            if len(set(values)) < len(values):
                raise ScenarioError(
                    f"--{name} is {' '.join(map(str, values))}; allowed is each once; leave out "
                    "what is there twice"
                )
        if not self.methods:
            raise ScenarioError("--methods names none; allowed is one or more, such as fly")
        check_jobs(self.jobs)

    def _crossings(self) -> list[CrossingConfig]:
        lights = ("day", "night") if self.lighting == "both" else (self.lighting,)
        return [
            CrossingConfig(
                lighting=Lighting(light),
                omega_rad_s=omega,
                step_px=self.step_px,
                supersample=self.supersample,
            )
            for light in lights
            for omega in self.omegas or PAPER_OMEGA_RAD_S[Lighting(light)]
        ]

    def _recorded(self, tasks: Sequence[SequenceTask], work: Path) -> list[SequenceTask]:
        if not self.recordings:
            return list(tasks)
        folder = work / RECORDINGS
        folder.mkdir()
        return [replace(task, recording=folder / f"{task.name}.rrd") for task in tasks]

    def _write(
        self,
        work: Path,
        tasks: Sequence[SequenceTask],
        sequences: Sequence[Result],
        rows: list[Row],
        claims: Sequence[Claim],
        start_s: float,
    ) -> None:
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
        )
        write_summary(work, self._summary(rows, claims, time.perf_counter() - start_s))

    def _parameters(self, tasks: Sequence[SequenceTask]) -> dict[str, Any]:
        """What the report tells: the arguments, and what a single run would have as parameters."""
        first = tasks[0]
        return {
            "command": self._command(),
            "study": self._arguments(),
            "scene": first.crossing,
            "sensor": first.sensor,
            "methods": {w.method: c for w in first.watchers(0) if (c := w.config) is not None},
        }

    def _arguments(self) -> dict[str, Any]:
        arguments = asdict(self) | {"out": str(self.out)}
        for name in ("light", "jobs"):  # the result does not depend on them
            del arguments[name]
        return arguments

    def _command(self) -> str:
        """What to type to run this again."""
        usual, parts = asdict(Study()), ["flybench study"]
        for name, value in self._arguments().items():
            option = name.replace("_", "-")
            if name == "out" or value == usual[name]:
                continue
            if isinstance(value, bool):
                parts.append(f"--{option}" if value else f"--no-{option}")
            else:
                words = value if isinstance(value, tuple) else (value,)
                parts.append(" ".join([f"--{option}", *map(str, words)]))
        return " ".join(parts)

    def _summary(
        self, rows: Sequence[Row], claims: Sequence[Claim], wall_s: float
    ) -> dict[str, Any]:
        return {
            "command": "study",
            "parameters": self._arguments(),
            "versions": versions(),
            "statistics": {
                method: {
                    light: {name: _plain(value) for name, value in found.items()}
                    for light, found in by_light.items()
                }
                for method, by_light in by_method_and_light(rows).items()
            },
            "claims": [asdict(claim) for claim in claims],
            "wall_s": round(wall_s, 1),
        }


def _plain(interval: Interval | None) -> dict[str, float] | None:
    return None if interval is None else asdict(interval)


def _mean(interval: Interval | None) -> float | None:
    return None if interval is None else interval.mean


def print_study(rows: Sequence[Row], claims: Sequence[Claim]) -> None:
    """Print what each method reached by each light, and which claims hold."""
    columns = ("method", "light", "right after 100 ms", "latency", "ms each", "ns/event")
    table = Table(*columns, title="study", title_justify="left")
    table.columns[0].no_wrap = True
    for method, by_light in by_method_and_light(rows).items():
        for light, found in by_light.items():
            latency = found["latency_ms"]
            table.add_row(
                method,
                light,
                told(found["accuracy_after_100ms"], "%"),
                "never" if latency is None else f"{latency.mean:.0f} ms",
                *(
                    format_number(_mean(found[name]))
                    for name in ("ms_per_estimate", "ns_per_event")
                ),
            )
    console = Console()
    console.print(table)
    for claim in claims:
        console.print(f"{claim.holds}: {claim.statement}", soft_wrap=True, highlight=False)


if __name__ == "__main__":
    script(Study)
