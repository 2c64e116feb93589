"""Which format a file has, by what it begins with; its ending says nothing."""

from __future__ import annotations

import re
from pathlib import Path

from formats.errors import FormatError

FORMATS = {
    "aedat4": "AEDAT 4 (DV)",
    "aedat3": "AEDAT 3.1 (cAER)",
    "aedat2": "AEDAT 2 (jAER)",
    "evt2": "Prophesee RAW, EVT 2.0",
    "evt21": "Prophesee RAW, EVT 2.1",
    "evt3": "Prophesee RAW, EVT 3.0",
    "dat": "Prophesee DAT",
    "es": "Event Stream",
    "hdf5": "HDF5",
    "npz": "NumPy archive",
    "npy": "NumPy array",
    "text": "text",
}
"""Name of each format that can be read, as `format=` takes it, and what to call it."""

_BEGINNINGS = {
    b"#!AER-DAT4.": "aedat4",
    b"#!AER-DAT3.1": "aedat3",
    b"#!AER-DAT2.": "aedat2",
    b"Event Stream": "es",
    b"\x89HDF\r\n\x1a\n": "hdf5",
    b"PK\x03\x04": "npz",
    b"PK\x05\x06": "npz",
    b"\x93NUMPY": "npy",
}
_FOREIGN = {
    b"#!AER-DAT3.0": "an AEDAT 3.0 file; convert it to AEDAT 4 with DV",
    b"#!AER-DAT1.": "an AEDAT 1 file; convert it to AEDAT 4 with DV",
    b"#ROSBAG": "a ROS bag; convert it to AEDAT 4 or HDF5 with the driver's own tool",
    b"\x1f\x8b": "compressed by gzip; unpack it with gunzip first",
    b"7z\xbc\xaf": "compressed by 7-Zip; unpack it first",
    b"\xfd7zXZ": "compressed by xz; unpack it with unxz first",
}
_EVT = {"2.0": "evt2", "2": "evt2", "2.1": "evt21", "21": "evt21", "3.0": "evt3", "3": "evt3"}
_HEAD_BYTES = 1 << 14

BINARY_ENDINGS = (
    ".aedat4", ".aedat", ".raw", ".dat", ".es", ".h5", ".hdf5", ".npy", ".npz",
)  # fmt: skip
"""Endings of formats that are not text: such a file without a line of numbers has been cut."""


def check_file(path: Path) -> None:
    """Refuse what is no file with something in it.

    Raises:
        FormatError: it does not exist, is a folder, is empty, or may not be read.
    """
    try:
        if path.is_dir():
            raise FormatError(f"{path} is a folder; give the file of events in it")
        if not path.exists():
            raise FormatError(f"{path} does not exist; check its name and folder")
        if not path.is_file():
            raise FormatError(f"{path} is no ordinary file; copy the events into one first")
        if path.stat().st_size == 0:
            raise FormatError(f"{path} is empty (0 bytes); record or copy it again")
        with path.open("rb"):
            pass
    except OSError as error:
        raise FormatError(
            f"{path} cannot be read ({error.strerror}); check who may read it"
        ) from error


def format_of(path: Path) -> str:
    """Name of the format of a file, one of `FORMATS`.

    Raises:
        FormatError: it has none of them.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    for beginning, name in _BEGINNINGS.items():
        if head.startswith(beginning):
            return name
    for beginning, name in _BEGINNINGS.items():
        if beginning.startswith(head) and path.suffix.lower() not in (".txt", ".csv"):
            raise FormatError(
                f"{path} holds no more than the beginning of a header, as of {FORMATS[name]} "
                f"(bytes: {len(head)}); it is cut in its header; copy it again"
            )
    for beginning, what in _FOREIGN.items():
        if head.startswith(beginning):
            raise FormatError(f"{path} is {what}")
    name = _prophesee(head) if head.startswith(b"%") else ""
    if name:
        return name
    if _is_text(head):
        return "text"
    raise FormatError(
        f"{path} begins with {head[:8]!r}, as none of the formats that can be read does "
        f"({', '.join(FORMATS.values())}); a RAW file without its header needs --format evt2, "
        "evt21 or evt3, and --size"
    )


def percent_header(head: bytes) -> tuple[dict[str, str], int]:
    """Keywords of a Prophesee header, lower case, and where its data begin [bytes]."""
    facts: dict[str, str] = {}
    offset = 0
    while head[offset : offset + 2] in (b"% ", b"%\n", b"%\r"):
        end = head.find(b"\n", offset)
        if end < 0:
            break
        words = head[offset + 1 : end].decode("latin-1").strip().split(None, 1)
        offset = end + 1
        if words:
            facts[words[0].lower()] = words[1] if len(words) > 1 else ""
        if words == ["end"]:
            break
    return facts, offset


def _prophesee(head: bytes) -> str:
    facts, _ = percent_header(head)
    evt = re.match(r"EVT([\d.]+)", facts.get("format", ""), re.IGNORECASE)
    version = evt[1] if evt else facts.get("evt", "")
    if version in _EVT:
        return _EVT[version]
    return "dat" if "version" in facts or facts.get("data", "").startswith("file") else ""


def _is_text(head: bytes) -> bool:
    """Whether the first line is one of text; a line further down may still be damaged."""
    first = head.removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0]
    printable = re.fullmatch(rb"([\t\r\x20-\x7e]|\xc2\xb5)*", first)
    return printable is not None and b"\0" not in head
