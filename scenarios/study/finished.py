"""Finished sequences of a study that is not complete, so that it can be resumed."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from flybench.sources import SWEEP_POINT_SOURCES, sources_digest
from scenarios.output.streams import complain
from scenarios.output.versions import versions
from scenarios.study.one_sequence import SequenceTask
from scenarios.study.result_json import result_from_json, result_to_json
from scenarios.study.results import SequenceResult
from scenarios.sweep.point_key import method_digest

_SOURCES = (*SWEEP_POINT_SOURCES, "scenarios/recording", "scenarios/study")
RESULT, RECORDING = ".json", ".rrd"


@dataclass(frozen=True)
class FinishedSequences:
    """A folder with the result and the recording of each finished sequence, named by its key.

    A recording counts only if its result exists, which is written later.

    Attributes:
        folder: the folder; it exists.
    """

    folder: Path

    def recorded(self, task: SequenceTask) -> SequenceTask:
        """Return the task with its recording in this folder."""
        task = replace(task, recording=self.folder)
        return replace(task, recording=self.folder / (sequence_key(task) + RECORDING))

    def load(self, task: SequenceTask) -> SequenceResult | None:
        """Return the result of a task; None if it is not finished."""
        key = sequence_key(task)
        if task.recording is not None and not task.recording.is_file():
            return None
        try:
            text = (self.folder / (key + RESULT)).read_text(encoding="utf-8")
            return result_from_json(text)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def store(self, task: SequenceTask, result: SequenceResult) -> None:
        """Write the result of a task; when this returns, it is on the disk.

        Raises:
            OSError: it cannot be written.
        """
        path = self.folder / (sequence_key(task) + RESULT)
        part = path.with_suffix(".part")
        with part.open("w", encoding="utf-8") as file:
            file.write(result_to_json(result))
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)

    def count(self) -> int:
        """Return the number of results in the folder."""
        return len(list(self.folder.glob(f"*{RESULT}")))

    def remove_incomplete(self) -> None:
        """Remove everything without a result, and the folder if there is none."""
        for path in self.folder.iterdir():
            if not path.with_suffix(RESULT).is_file() or path.suffix not in (RESULT, RECORDING):
                path.unlink()
        if not self.count():
            self.folder.rmdir()


@contextmanager
def finished_sequences(folder: Path) -> Iterator[FinishedSequences]:
    """Create or reopen the folder; after an error, keep and name what is finished."""
    folder.mkdir(exist_ok=True)
    finished = FinishedSequences(folder)
    try:
        yield finished
    except BaseException:
        with suppress(OSError):  # a worker may still be writing
            finished.remove_incomplete()
        if folder.exists() and finished.count():
            complain(
                f"Finished sequences are kept in {folder} ({finished.count()}). To go on, start "
                "the same command again."
            )
        raise


def sequence_key(task: SequenceTask) -> str:
    """Return a digest of everything that determines the result of a task, except the machine."""
    inputs: Mapping[str, object] = {
        "parameters": task.config().parameters(),
        "methods": [(method, method_digest(method)) for method in task.methods],
        "seeds": task.seeds,
        "background": task.background,
        "high_threshold_seeds": task.high_threshold_seeds,
        "contrast_hop_us": task.contrast_hop_us,
        "is_recorded": task.recording is not None,
        "sources": sources_digest(*_SOURCES),
        "versions": versions(),
    }
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def link_or_copy(source: Path, target: Path) -> None:
    """Give a file a second name, or copy it where the disk cannot.

    Raises:
        OSError: the file cannot be copied.
    """
    try:
        target.hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)
