"""Labels of single events: object, cause and true image velocity."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from emulator import SensorOutput
from flybench.events import Events, concatenate_events
from flybench.memory import count_memory
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.layout import EVENT_LABELS
from scenarios.dataset.scenes.labelled import LabelledScene

_CHUNK = 1 << 16
_BYTES_PER_EVENT = 60
"""Memory per event: the event and its cause, their joined copies, and the arrays of the truth
[bytes] (estimated)."""


class EventLog:
    """Events of a sequence, kept in memory until their labels are computed."""

    def __init__(self) -> None:
        self._events: list[Events] = []
        self._causes: list[npt.NDArray[np.uint8]] = []
        self._count = 0

    def add(self, output: SensorOutput) -> None:
        """Append the events of one sensor step.

        Raises:
            MemoryBudgetError: they do not fit into the memory budget.
        """
        if not output.events.size:
            return
        self._count += output.events.size
        what = f"A sequence of {self._count} events and their labels"
        count_memory(self, what, self._count * _BYTES_PER_EVENT)
        self._events.append(output.events)
        self._causes.append(output.causes)

    def write_labels(self, work: Path, scene: LabelledScene, labels: Sequence[Label]) -> None:
        """Write `source`, `cause` and `flow_px_s`, one entry for each event of `events.h5`.

        Args:
            work: folder of the sequence.
            scene: scene that the sensor saw.
            labels: labels to write.
        """
        causes = np.concatenate([np.empty(0, np.uint8), *self._causes])
        truth = scene.event_truth(concatenate_events(self._events), causes)
        with h5py.File(work / EVENT_LABELS, "w") as file:
            if Label.EVENT_SOURCE in labels:
                _write(file, "source", truth.source)
                _write(file, "cause", causes)
            if Label.EVENT_FLOW in labels:
                _write(file, "flow_px_s", truth.flow_px_s)


def _write(file: Any, name: str, values: npt.NDArray[Any]) -> None:
    if not len(values):
        file.create_dataset(name, data=values)
        return
    file.create_dataset(
        name,
        data=values,
        chunks=(min(_CHUNK, len(values)), *values.shape[1:]),
        compression="gzip",
        compression_opts=1,
        shuffle=True,
    )
