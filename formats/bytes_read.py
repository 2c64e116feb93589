"""How much a process has read, as a measure of progress that is the same for every format."""

from __future__ import annotations

from pathlib import Path


def bytes_read(process: int | str = "self") -> int | None:
    """Return how much a process has read from files and pipes [bytes]; None if it is not known.

    Args:
        process: its number; "self": this one.
    """
    try:
        counters = Path(f"/proc/{process}/io").read_text(encoding="ascii")
    except OSError:  # not on Linux, or the process has ended
        return None
    return int(counters.split("rchar: ", 1)[1].split(None, 1)[0])
