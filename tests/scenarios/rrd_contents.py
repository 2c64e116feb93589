"""The contents of a Rerun recording, read back for tests."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import rerun as rr


class RrdContents:
    """Contents of an .rrd file, by entity and component."""

    def __init__(self, path: Path) -> None:
        self.chunks = list(rr.chunk.RrdReader(path).stream())

    def rows(self, entity: str, component: str) -> list[tuple[float, Any]]:
        """Return (time [s], values) of a component that changes, in order of time."""
        found: list[tuple[float, Any]] = []
        for table in self._tables(entity, component, static=False):
            seconds = [t.total_seconds() for t in table["time"]]
            found += zip(seconds, table[component], strict=True)
        return sorted(found, key=lambda row: row[0])

    def values(self, entity: str, component: str) -> list[Any]:
        """Return the values of a component that changes, in order of time."""
        return [values for _, values in self.rows(entity, component)]

    def static(self, entity: str, component: str) -> Any:
        """Return the values of a component that is constant."""
        ((values,),) = (t[component] for t in self._tables(entity, component, static=True))
        return values

    def _tables(self, entity: str, component: str, *, static: bool) -> Iterator[dict[str, Any]]:
        for chunk in self.chunks:
            if chunk.entity_path == entity and chunk.is_static == static:
                table = chunk.to_record_batch().to_pydict()
                if component in table:
                    yield table
