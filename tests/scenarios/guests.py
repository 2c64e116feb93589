"""A user's detectors for tests: one that prints in every way, and one that fails.

Import this module in other processes only, since it prints when it is imported.
"""

import atexit
import ctypes
import os
import subprocess
import sys

from detector.estimate import MotionEstimate
from flybench.direction import Direction
from flybench.events import Events

HOP_US = 10_000
WORDS = "a guest was here"
_STDOUT = sys.stdout

print(WORDS, "at import")
subprocess.run(["echo", WORDS, "as a child"], check=True)
atexit.register(print, WORDS, "at exit")


class Noisy:
    """A detector that prints whenever it is called, and finds motion to the right."""

    def __init__(self, *, width: int, height: int) -> None:
        print(WORDS, "at creation", width, height, flush=True)
        self._hops = 0

    def push(self, events: Events) -> list[MotionEstimate]:
        c = ctypes.CDLL(None)
        c.puts(f"{WORDS} in C".encode())
        c.fflush(None)
        os.write(1, f"{WORDS} on descriptor 1\n".encode())
        print(WORDS, "with", events.size, "events", file=_STDOUT)
        return []

    def advance(self, t_us: int) -> list[MotionEstimate]:
        print(WORDS, "until", t_us, file=sys.__stdout__)
        before, self._hops = self._hops, t_us // HOP_US
        times_us = [hop * HOP_US for hop in range(before + 1, self._hops + 1)]
        centre = (5.0, 5.0)
        return [
            MotionEstimate(t, 0.5, 0.0, Direction.RIGHT, 0.5, (1.0, 0.0), centre, None)
            for t in times_us
        ]


class Failing(Noisy):
    """A detector that raises an error after 0.1 s of the stream."""

    def advance(self, t_us: int) -> list[MotionEstimate]:
        if t_us > 100_000:
            raise KeyError("wings")
        return super().advance(t_us)
