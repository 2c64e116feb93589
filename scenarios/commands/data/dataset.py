"""`flybench dataset`: make a labelled dataset from a TOML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import tyro
from rich.table import Table

from flybench.disk_space import megabytes
from scenarios.dataset.folder import CHECKSUMS, check_folder, finished_sequences
from scenarios.dataset.plan import DatasetPlan, read_plan
from scenarios.dataset.run import DatasetResult, Runner, needed_bytes, run_dataset
from scenarios.dataset.sequence_plan import SequencePlan
from scenarios.dataset.size import duration_s, estimated_bytes
from scenarios.errors import ScenarioError
from scenarios.output.numbers import counted
from scenarios.output.progress import progress_bar
from scenarios.output.streams import SafeConsole, say, table_width
from scenarios.output.terminal import run_cli
from scenarios.pipeline.cluster import run_on_cluster
from scenarios.pipeline.parallel import ONE_PER_CORE, check_jobs, run_locally

DATASETS = Path("logs/dataset")
_SPEED_OVER_S = 3600.0
"""Time over which the progress display averages the speed [s]; a sequence may take minutes."""


@dataclass(frozen=True)
class Dataset:
    """Make a labelled dataset of random sequences (layout of DSEC)."""

    file: Annotated[
        tyro.conf.Positional[Path],
        tyro.conf.arg(metavar="SPEC.toml", help_behavior_hint=""),
    ]
    """File that describes the dataset. An example is in scenarios/dataset/examples."""
    out: Annotated[
        Path | None,
        tyro.conf.arg(
            metavar="DIR", help_behavior_hint="(default: logs/dataset/ and the name of the file)"
        ),
    ] = None
    """Output folder; an interrupted dataset in it is resumed."""
    jobs: int = ONE_PER_CORE
    """Number of processes, 1 or more; -1: one per core."""
    dask: Annotated[
        str | None,
        tyro.conf.arg(metavar="ADDRESS", help_behavior_hint="(default: no cluster)"),
    ] = None
    """Run on a Dask cluster whose workers see the output folder: address of its scheduler."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check the file and print its sequences and their size, but render and write nothing."""

    def execute(self) -> int:
        """Check the file, make the sequences that are not finished, and describe the dataset."""
        run, plan = self._runner(), read_plan(self.file)
        folder = self.out or DATASETS / self.file.stem
        check_folder(folder, plan, needed_bytes(folder, plan))
        if self.dry_run:
            print_plan(plan, len(finished_sequences(folder, plan.sequences)))
            return 0
        with progress_bar(_SPEED_OVER_S) as bar:
            advance = bar.track(f"{self.file.stem}, {counted(len(plan.sequences), 'sequence')}")
            result = run_dataset(
                plan,
                folder,
                run,
                use_all_cores=self.jobs == 1,
                progress=lambda done, total, size: advance(done, total, note=megabytes(size)),
            )
        print_result(result, folder)
        return 0

    def _runner(self) -> Runner:
        check_jobs(self.jobs)
        if self.dask is None:
            return partial(run_locally, jobs=self.jobs)
        if self.jobs != ONE_PER_CORE:
            raise ScenarioError(
                f"--jobs is {self.jobs} and --dask is {self.dask}. Allowed is only one of them, "
                "because a cluster has its own workers. Leave the other out."
            )
        return partial(run_on_cluster, address=self.dask)


def print_plan(plan: DatasetPlan, finished: int) -> None:
    """Print what is drawn for each sequence, and the size of the dataset."""
    names = list(dict.fromkeys(name for s in plan.sequences for name in s.drawn))
    table = Table("sequence", "variant", *names, box=None)
    for sequence in plan.sequences:
        parameters = sequence.parameters()
        cells = (_format(parameters.get(name, "")) for name in names)
        table.add_row(sequence.name, sequence.variant, *cells)
    console = SafeConsole(width=table_width())
    console.print(table)
    size = sum(map(estimated_bytes, plan.sequences))
    console.print(
        f"{counted(len(plan.sequences), 'sequence')}, together about "
        f"{_seconds(plan.sequences):.0f} s and {megabytes(size)}; {finished} finished"
    )


def print_result(result: DatasetResult, folder: Path) -> None:
    """Print what was made, and what the labels cost."""
    made, all_of_them = len(result.costs), len(result.summaries)
    say(
        f"wrote {folder} and {CHECKSUMS} in it: {counted(all_of_them, 'sequence')}, "
        f"{megabytes(result.size_bytes)}; {all_of_them - made} finished before"
    )
    if made:
        events_s = sum(cost.events_s for cost in result.costs)
        labels_s = sum(cost.labels_s for cost in result.costs)
        say(
            f"CPU time of a sequence: {events_s / made:.1f} s for its events and "
            f"{labels_s / made:.1f} s for its labels ({100 * labels_s / events_s:.0f} %)"
        )


def _seconds(sequences: Sequence[SequencePlan]) -> float:
    return sum(map(duration_s, sequences))


def _format(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    run_cli(Dataset)
