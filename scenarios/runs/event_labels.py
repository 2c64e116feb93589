"""Cause and source of each event of a run, written beside the events: the option --event-labels."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import numpy.typing as npt

from emulator import SensorOutput
from flybench.events import Cause, Events, concatenate_events
from flybench.memory import count_memory
from sim import Crossing
from sim.event_truth import NOISE, event_truth
from sim.truth.dense_truth import BACKGROUND

_BYTES_PER_EVENT = 60
"""Memory per event: the event and its cause, their joined copies, and the arrays of the truth
[bytes] (assumed, as for datasets)."""


class EventLabels:
    """Events and causes of a run, kept in memory until the sources are computed."""

    def __init__(self) -> None:
        self._events: list[Events] = []
        self._causes = [np.empty(0, np.uint8)]
        self._count = 0

    def add(self, output: SensorOutput) -> None:
        """Add the events of one sensor step.

        Raises:
            MemoryBudgetError: they do not fit into the memory budget.
        """
        self._count += output.events.size
        what = f"A list of {self._count} events with their labels"
        count_memory(self, what, self._count * _BYTES_PER_EVENT)
        self._events.append(output.events)
        self._causes.append(output.causes)

    def write(self, path: Path, crossing: Crossing) -> None:
        """Add `events/cause` and `events/source` to a complete events.h5, one value for each event.

        The attributes of both state what the numbers mean.

        Args:
            path: the file.
            crossing: crossing that the sensor saw.
        """
        causes: npt.NDArray[np.uint8] = np.concatenate(self._causes)
        truth = event_truth(concatenate_events(self._events), causes, crossing)
        names = {number: obj.name for number, obj in enumerate(crossing.scene.objects)}
        names |= {BACKGROUND: "background", NOISE: "noise"}
        meanings = {"cause": {int(cause): cause.name.lower() for cause in Cause}, "source": names}
        with h5py.File(path, "r+") as file:
            for name, values in (("cause", causes), ("source", truth.source)):
                column = file["events"].create_dataset(
                    name, data=values, compression="gzip", compression_opts=1, shuffle=True
                )
                for number, meaning in meanings[name].items():
                    column.attrs[str(number)] = meaning
