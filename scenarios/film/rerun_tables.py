"""The tables of a Rerun recording that flybench wrote, read back."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
import rerun as rr

from flybench.memory import check_memory
from scenarios.errors import ScenarioError
from scenarios.film.track import Track
from scenarios.recording.entities import APS, CAMERA, DIRECTION, EVENTS, METHODS, RESPONSE, TRUTH

T = TypeVar("T")
_SHOWN = (EVENTS, APS, TRUTH, METHODS, DIRECTION, RESPONSE)
_EVENT_BYTES = 60
"""Memory per event while a recording is read [bytes]: its columns, the array and its parts
(assumed)."""


class RerunTables:
    """Tables of the entities that a film shows.

    Attributes:
        path: the recording.
        properties: values that do not change, by name, such as "Pinhole:resolution".
    """

    def __init__(self, path: Path) -> None:
        """Read a recording.

        Raises:
            ScenarioError: the file is damaged.
            MemoryBudgetError: its events need more memory than the budget allows.
        """
        self.path = path
        self.properties: dict[str, Any] = {}
        self._tables: defaultdict[str, list[Any]] = defaultdict(list)
        try:
            with warnings.catch_warnings(action="ignore"):  # of a file that was cut off
                for chunk in rr.chunk.RrdReader(path).stream():
                    self._add(chunk.entity_path.removeprefix("/"), chunk)
        except (RuntimeError, ValueError, OSError) as error:
            raise ScenarioError(
                f"{path} cannot be read as a Rerun recording ({error}). Allowed is a complete "
                "recording of flybench. Write it again."
            ) from error

    def _add(self, entity: str, chunk: Any) -> None:
        table = chunk.to_record_batch()
        if chunk.is_static:
            if entity == CAMERA or entity.startswith("__properties"):
                row = table.to_pylist()[-1]
                self.properties |= {name: value for name, value in row.items() if value is not None}
        elif entity.startswith(_SHOWN):
            self._tables[entity].append(table)
            if entity == EVENTS:
                number = sum(len(part[-1].flatten()) for part in self._tables[EVENTS])
                check_memory(f"The list of {number} events of {self.path}", number * _EVENT_BYTES)

    def entities(self, parent: str) -> list[str]:
        """Return the names of the entities below a path."""
        start = f"{parent}/"
        return [name.removeprefix(start) for name in self._tables if name.startswith(start)]

    def columns(self, entity: str, *names: str) -> list[tuple[npt.NDArray[np.int64], list[Any]]]:
        """Return the times [µs] and the columns of each table of an entity, in order of time."""
        found = []
        for table in self._tables.get(entity, ()):
            if set(names) <= set(table.schema.names):
                times_ns = table["time"].cast("int64").to_numpy()
                found.append((times_ns // 1000, [table[name] for name in names]))
        return sorted(found, key=lambda columns: int(columns[0][0]))

    def track(self, entity: str, value: Callable[..., T], *names: str) -> Track[T]:
        """Return the values of an entity over time.

        Args:
            entity: its path.
            value: function that returns a value from the cells of a row, which are lists.
            names: names of the columns.
        """
        times: list[int] = []
        values: list[T] = []
        for t_us, columns in self.columns(entity, *names):
            times += t_us.tolist()
            cells: Sequence[Any] = [column.to_pylist() for column in columns]
            values += [value(*row) for row in zip(*cells, strict=True)]
        order = sorted(range(len(times)), key=times.__getitem__)
        return Track([times[k] for k in order], [values[k] for k in order])
