"""Progress of several processes, forwarded to the process that started them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread

import numpy as np

PERIOD_S = 0.5
"""Period at which the sum is forwarded (assumed) [s]."""
_PARTS = 1000


@dataclass(frozen=True)
class SharedProgress:
    """A small file with one number for each task; each process writes the number of its task.

    Attributes:
        path: path of the file.
        tasks: number of tasks.
    """

    path: Path
    tasks: int

    @classmethod
    def create(cls, path: Path, tasks: int) -> SharedProgress:
        """Create the file, with every task at 0."""
        np.zeros(tasks, np.int64).tofile(path)
        return cls(path, tasks)

    def report(self, task: int, done: int, total: int) -> None:
        """Write the progress of one task."""
        part = np.int64(done * _PARTS // max(total, 1))
        with self.path.open("r+b") as file:
            file.seek(task * part.itemsize)
            file.write(part.tobytes())

    @contextmanager
    def forwarded_to(self, progress: Callable[[int, int], None]) -> Iterator[None]:
        """Call `progress` with the sum over all tasks and its maximum while the block runs."""
        ended = Event()

        def forward() -> None:
            parts = np.memmap(self.path, np.int64, "r", shape=self.tasks)
            progress(int(parts.sum()), _PARTS * self.tasks)

        def keep_forwarding() -> None:
            while not ended.wait(PERIOD_S):
                forward()

        thread = Thread(target=keep_forwarding, daemon=True)
        forward()
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            forward()
