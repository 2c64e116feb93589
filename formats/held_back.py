"""Frames, IMU samples and triggers that wait for the events of their time."""

from __future__ import annotations

from itertools import takewhile
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from emulator import ApsFrame
from flybench.memory import check_memory
from formats.parser_process import FRAME
from formats.samples import IMU_DTYPE, TRIGGER_DTYPE

_FRAMES_MAX = 32
"""Most frames that wait (assumed)."""

_FRAMES_KEPT = 2 * _FRAMES_MAX
"""Frames that exist at once: those that wait, and those in use after them (estimated)."""

_SAMPLES_MAX = 1 << 16
"""Most IMU samples, or triggers, that wait (assumed)."""

Released: TypeAlias = tuple[tuple[ApsFrame, ...], npt.NDArray[Any], npt.NDArray[Any]]
"""Frames, IMU samples and triggers, as the last fields of `formats.Chunk`."""


class HeldBack:
    """Queue of what is not events; a frame waits for events that reach the end of its exposure."""

    def __init__(self) -> None:
        self._frames: list[ApsFrame] = []
        self._samples: dict[bytes, list[npt.NDArray[Any]]] = {b"I": [], b"T": []}

    def add(self, kind: bytes, content: bytearray) -> None:
        """Append the content of a message of the parser, of kind `F`, `I` or `T`."""
        if kind == b"F":
            self._frames.append(_frame(content))
        else:
            dtype = IMU_DTYPE if kind == b"I" else TRIGGER_DTYPE
            self._samples[kind].append(np.frombuffer(content, dtype))

    @property
    def is_full(self) -> bool:
        """True if some must be released before more is added."""
        waiting = (sum(part.size for part in parts) for parts in self._samples.values())
        return len(self._frames) > _FRAMES_MAX or any(count > _SAMPLES_MAX for count in waiting)

    def release(self, until_us: int | None = None) -> Released:
        """Return all samples, and the frames whose exposure ends by `until_us`; None: all."""
        frames = tuple(self._frames)
        if until_us is not None:
            frames = tuple(takewhile(lambda frame: frame.end_us <= until_us, frames))
        del self._frames[: len(frames)]
        return frames, self._taken(b"I", IMU_DTYPE), self._taken(b"T", TRIGGER_DTYPE)

    def release_some(self) -> Released:
        """Return all samples, and the oldest frame if too many wait."""
        oldest = self._frames[0].end_us if len(self._frames) > _FRAMES_MAX else -1
        return self.release(oldest)

    def _taken(self, kind: bytes, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
        parts, self._samples[kind] = self._samples[kind], []
        return np.concatenate([np.empty(0, dtype), *parts])


def _frame(content: bytearray) -> ApsFrame:
    start_us, end_us, width, height = FRAME.unpack_from(content)
    check_memory(f"A recording with APS frames of {width}×{height} px", _FRAMES_KEPT * len(content))
    image = np.frombuffer(content, "<u2", offset=FRAME.size).reshape(height, width)
    return ApsFrame(start_us=start_us, end_us=end_us, image=image)
