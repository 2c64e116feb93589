"""The files that describe a dataset as a whole: table, annotations, figure, card, checksums."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from flybench.files import open_regular
from scenarios.dataset.card import card_text
from scenarios.dataset.figure import draw_overview
from scenarios.dataset.folder import (
    CARD,
    CHECKSUMS,
    COPY,
    FIGURES,
    TABLE,
    annotations_file,
)
from scenarios.dataset.labels.boxes import write_json
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.layout import COCO
from scenarios.dataset.plan import DatasetPlan
from scenarios.dataset.sequence import file_digest
from scenarios.dataset.sequence_plan import SequencePlan, code_digest
from scenarios.output.atomic_folder import GENERATOR, SUMMARY
from scenarios.output.tables import write_table
from scenarios.output.versions import versions
from scenarios.pipeline.run_config import flatten
from scenarios.sweep.folder import durable_file

Summaries = Sequence[Mapping[str, Any]]
_FACTS = ("split", "sequence", "variant", "duration_us", "label_times", "aps_frames", "direction")


def write_description(folder: Path, plan: DatasetPlan, summaries: Summaries) -> None:
    """Write the table of sequences, the COCO files, the figure, the card and the checksums.

    The checksums come last: their presence shows that the dataset is complete.

    Args:
        folder: folder of the dataset.
        plan: the dataset.
        summaries: summary of each sequence, in the order of the plan.

    Raises:
        OutputError: a file cannot be written.
    """
    with durable_file(folder / TABLE) as part:
        _write_table(part, summaries)
    for split in plan.spec.counts if Label.COCO in plan.spec.labels else ():
        with durable_file(folder / annotations_file(split)) as part:
            _write_annotations(part, folder, [s for s in plan.sequences if s.split == split])
    draw_overview(folder / Path(FIGURES[0]).stem, folder, plan, summaries)
    with durable_file(folder / CARD) as part:
        part.write_text(card_text(plan, summaries), encoding="utf-8")
    with durable_file(folder / SUMMARY) as part:
        part.write_text(_summary_text(plan, summaries), encoding="utf-8")
    with durable_file(folder / CHECKSUMS) as part:
        part.write_text("".join(_checksums(folder, plan, summaries)), encoding="utf-8")


def _write_table(path: Path, summaries: Summaries) -> None:
    rows = [_row(summary) for summary in summaries]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    write_table(path, columns, ([row.get(name, "") for name in columns] for row in rows))


def _row(summary: Mapping[str, Any]) -> dict[str, Any]:
    facts = {name: summary[name] for name in _FACTS}
    boxes = {"boxes": sum(summary["boxes"].values())}
    events = {f"events.{name}": value for name, value in flatten(summary["events"])}
    return facts | boxes | events | dict(flatten(summary["parameters"]))


def _write_annotations(path: Path, folder: Path, sequences: Iterable[SequencePlan]) -> None:
    """Join the COCO files of sequences; file names are relative to the dataset's folder.

    Track numbers are unique in a sequence, so each annotation also names its sequence.
    """
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    categories: set[tuple[int, str]] = set()
    for sequence in sequences:
        with open_regular(folder / sequence.name / COCO) as file:
            document = json.load(file)
        first = len(images)
        categories |= {(entry["id"], entry["name"]) for entry in document["categories"]}
        images += [
            image
            | {"id": first + image["id"], "file_name": f"{sequence.name}/{image['file_name']}"}
            for image in document["images"]
        ]
        for entry in document["annotations"]:
            number = {"id": len(annotations) + 1, "image_id": first + entry["image_id"]}
            annotations.append(entry | number | {"sequence": sequence.name})
    write_json(path, images, annotations, categories)


def _summary_text(plan: DatasetPlan, summaries: Summaries) -> str:
    spec = plan.spec
    summary = {
        "generator": GENERATOR,
        "command": "dataset",
        "title": spec.title,
        "license": spec.license,
        "seed": spec.seed,
        "splits": dict(spec.counts),
        "labels": list(spec.labels),
        "period_us": spec.period_us,
        "events": sum(s["events"]["count"] for s in summaries),
        "versions": versions(),
        "code": code_digest(),
    }
    return json.dumps(summary, indent=2) + "\n"


def _checksums(folder: Path, plan: DatasetPlan, summaries: Summaries) -> Iterator[str]:
    """Yield the lines of the file, in the format of `sha256sum`."""
    own = [CARD, COPY, TABLE, SUMMARY, *FIGURES]
    if Label.COCO in plan.spec.labels:
        own += [annotations_file(split) for split in plan.spec.counts]
    for name in sorted(own):
        yield f"{file_digest(folder / name)}  {name}\n"
    for sequence, summary in zip(plan.sequences, summaries, strict=True):
        for name, digest in summary["sha256"].items():
            yield f"{digest}  {sequence.name}/{name}\n"
        name = f"{sequence.name}/{SUMMARY}"
        yield f"{file_digest(folder / name)}  {name}\n"
