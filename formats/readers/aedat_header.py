"""The header of AEDAT 2 and 3.1: lines that begin with a #."""

from __future__ import annotations

from pathlib import Path

_LINE_MAX = 1 << 20
"""Longest line that is believed; jAER writes its settings into one (assumed) [bytes]."""


def read_header(path: Path, *, last: bytes | None = None) -> tuple[str, int]:
    """The header's text, and where what comes after it begins [bytes].

    Args:
        path: of the file.
        last: how the header's last line begins; None: it ends where a line has no #.
    """
    lines, offset = [], 0
    with path.open("rb") as file:
        while (line := file.readline(_LINE_MAX)).startswith(b"#"):
            lines.append(line.decode("latin-1"))
            offset += len(line)
            if last is not None and line.startswith(last):
                break
    return "".join(lines), offset
