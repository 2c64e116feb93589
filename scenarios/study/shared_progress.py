"""How far each of several processes has come, told to the one that started them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread

import numpy as np

PERIOD_S = 0.5
"""How often the sum is told (assumed)."""
_PARTS = 1000


@dataclass(frozen=True)
class SharedProgress:
    """A small file with a number for each task, which any process may write its own of.

    Attributes:
        path: of the file.
        tasks: how many there are.
    """

    path: Path
    tasks: int

    @classmethod
    def begin(cls, path: Path, tasks: int) -> SharedProgress:
        """Make the file, with no task begun."""
        np.zeros(tasks, np.int64).tofile(path)
        return cls(path, tasks)

    def tell(self, task: int, done: int, total: int) -> None:
        """Note that of a task so much is done."""
        part = np.int64(done * _PARTS // max(total, 1))
        with self.path.open("r+b") as file:
            file.seek(task * part.itemsize)
            file.write(part.tobytes())

    @contextmanager
    def watched(self, progress: Callable[[int, int], None]) -> Iterator[None]:
        """Tell the sum over all tasks, and that of the whole, while the block runs."""
        ended = Event()

        def tell_sum() -> None:
            parts = np.memmap(self.path, np.int64, "r", shape=self.tasks)
            progress(int(parts.sum()), _PARTS * self.tasks)

        def keep_telling() -> None:
            while not ended.wait(PERIOD_S):
                tell_sum()

        thread = Thread(target=keep_telling, daemon=True)
        tell_sum()
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            tell_sum()
