"""The folder of a dataset: used by one process at a time, and resumable."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flybench.files import read_small_text
from flybench.unfinished import SUFFIX, remove_abandoned
from scenarios.dataset.plan import DatasetPlan
from scenarios.dataset.sequence_plan import SequencePlan
from scenarios.errors import OutputError
from scenarios.output.atomic_folder import GENERATOR, SUMMARY, check_output_folder
from scenarios.output.locked_folder import locked_folder

LOCK, COPY = "flybench-dataset.lock", "dataset.toml"
CARD, CHECKSUMS, TABLE = "README.md", "checksums.sha256", "sequences.csv"
FIGURES = ("overview.png", "overview.svg")
ANNOTATIONS = "annotations"


def results_of(splits: Collection[str]) -> list[str]:
    """Return the names of the files that describe a dataset as a whole."""
    annotations = [annotations_file(split) for split in splits]
    return [CARD, CHECKSUMS, TABLE, SUMMARY, *FIGURES, *annotations]


def annotations_file(split: str) -> str:
    """Return the name of the COCO file of a split."""
    return f"{ANNOTATIONS}_{split}.json"


def check_folder(folder: Path, plan: DatasetPlan, needed_bytes: int) -> None:
    """Check that a folder can hold the dataset.

    Args:
        folder: output folder.
        plan: the dataset.
        needed_bytes: estimated size of the sequences that are not finished [bytes].

    Raises:
        OutputError: the folder holds anything but sequences of this dataset, cannot be created, or
            its disk has too little free space.
    """
    if leftover := _leftover(folder, plan):
        raise OutputError(
            f"The output folder {folder} holds {len(leftover)} sequences of another dataset, such "
            f"as {leftover[0]}. Allowed are those that the file describes. Remove them, or choose "
            "another folder with --out."
        )
    check_output_folder(
        folder, needed_bytes=needed_bytes, other_files=lambda place: _other_files(place, plan)
    )


def _other_files(folder: Path, plan: DatasetPlan) -> list[str]:
    if not folder.is_dir():
        return [folder.name]
    names = {path.name for path in folder.iterdir()}
    if LOCK not in names:
        return sorted(names)
    own = {LOCK, COPY, *results_of(plan.spec.counts)}
    own |= {f".{name}.part" for name in own} | set(plan.spec.counts)
    wanted = {sequence.name for sequence in plan.sequences}
    found = {name.removesuffix(SUFFIX) for name in _in_splits(folder, plan)}
    return sorted(names - own) + sorted(found - wanted)


def _leftover(folder: Path, plan: DatasetPlan) -> list[str]:
    """Return the finished sequences in the folder that the dataset does not have."""
    wanted = {sequence.name for sequence in plan.sequences}
    others = (name for name in _in_splits(folder, plan) if name not in wanted)
    return sorted(name for name in others if _summary(folder / name).get("command") == "dataset")


def _in_splits(folder: Path, plan: DatasetPlan) -> list[str]:
    """Return the paths of everything in the folders of the splits, relative to the folder."""
    places = [folder / split for split in plan.spec.counts if (folder / split).is_dir()]
    return [f"{place.name}/{path.name}" for place in places for path in place.iterdir()]


@contextmanager
def dataset_folder(folder: Path, plan: DatasetPlan, needed_bytes: int) -> Iterator[Path]:
    """Create or reopen the folder and lock it for this process.

    Raises:
        OutputError: the folder fails `check_folder`, or another process uses it.
    """
    check_folder(folder, plan, needed_bytes)
    with locked_folder(folder, LOCK, "making the dataset"):
        for split in plan.spec.counts:
            (folder / split).mkdir(exist_ok=True)
            remove_abandoned(folder / split)
        yield folder


def finished_sequences(
    folder: Path, sequences: Sequence[SequencePlan]
) -> dict[str, Mapping[str, Any]]:
    """Return the summaries of the sequences in a folder that have all their files, by name."""
    found = {s.name: (_summary(folder / s.name), s) for s in sequences}
    return {
        name: summary
        for name, (summary, s) in found.items()
        if summary.get("key") == s.key()
        and all((folder / name / file).is_file() for file in summary["files"])
    }


def _summary(folder: Path) -> Mapping[str, Any]:
    """Return the summary of a sequence; empty if there is none."""
    try:
        summary = json.loads(read_small_text(folder / SUMMARY))
    except (OSError, ValueError, RecursionError):
        return {}
    is_own = isinstance(summary, dict) and summary.get("generator") == GENERATOR
    return summary if is_own else {}


def drop_results(folder: Path, splits: Collection[str]) -> None:
    """Remove the files that describe an earlier dataset as a whole."""
    for name in results_of(splits):
        (folder / name).unlink(missing_ok=True)
