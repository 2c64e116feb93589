"""The header of AEDAT 2 and 3.1 files: lines that begin with #."""

from __future__ import annotations

from pathlib import Path

_LINE_MAX = 1 << 20
"""Longest plausible line (assumed; jAER writes all its settings into one) [bytes]."""


def read_header(path: Path, *, last: bytes | None = None) -> tuple[str, int]:
    """Read the header.

    Args:
        path: path of the file.
        last: beginning of the last line of the header; None: it ends before the first line without
            a #.

    Returns:
        The text of the header, and the position of the data after it [bytes].
    """
    lines, offset = [], 0
    with path.open("rb") as file:
        while (line := file.readline(_LINE_MAX)).startswith(b"#"):
            lines.append(line.decode("latin-1"))
            offset += len(line)
            if last is not None and line.startswith(last):
                break
    return "".join(lines), offset
