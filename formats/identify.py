"""Recognise the format of a file by its first bytes; the ending of its name is not used."""

from __future__ import annotations

import re
from collections.abc import Mapping
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
"""Formats that can be read: name, as `open_events(format=...)` takes it, and description."""

TABLES = ("hdf5", "npz", "npy", "text")
"""Formats in which the order of columns may be unknown."""

_MAGIC = {
    b"#!AER-DAT4.": "aedat4",
    b"#!AER-DAT3.1": "aedat3",
    b"#!AER-DAT2.": "aedat2",
    b"Event Stream": "es",
    b"\x89HDF\r\n\x1a\n": "hdf5",
    b"PK\x03\x04": "npz",
    b"PK\x05\x06": "npz",
    b"\x93NUMPY": "npy",
}
"""Format of a file by its first bytes (magic number)."""

_CONVERT_WITH_DV = "Convert it to AEDAT 4 with DV."
_UNSUPPORTED = {
    b"#!AER-DAT3.0": ("an AEDAT 3.0 file", _CONVERT_WITH_DV),
    b"#!AER-DAT1.": ("an AEDAT 1 file", _CONVERT_WITH_DV),
    b"#ROSBAG": ("a ROS bag", "Convert it to AEDAT 4 or HDF5 with the tool of the camera driver."),
    b"\x1f\x8b": ("compressed by gzip", "Unpack it with gunzip first."),
    b"7z\xbc\xaf": ("compressed by 7-Zip", "Unpack it first."),
    b"\xfd7zXZ": ("compressed by xz", "Unpack it with unxz first."),
}
"""Known files that cannot be read: description and remedy, by first bytes."""

_PICTURES = {
    rb"....ftyp": "a video (MP4 or MOV)",
    rb"RIFF....AVI ": "a video (AVI)",
    rb"\x1a\x45\xdf\xa3": "a video (Matroska or WebM)",
    rb"OggS": "a video (Ogg)",
    rb"FLV\x01": "a video (FLV)",
    rb"\x30\x26\xb2\x75": "a video (WMV)",
    rb"\0\0\x01[\xb3\xba]": "a video (MPEG)",
    rb"GIF8[79]a": "a picture (GIF)",
    rb"\x89PNG": "a picture (PNG)",
    rb"\xff\xd8\xff": "a picture (JPEG)",
    rb"RIFF....WEBP": "a picture (WebP)",
    rb"II\*\0|MM\0\*": "a picture (TIFF)",
    rb"BM....\0\0\0\0": "a picture (BMP)",
    rb"P[56]\s": "a picture (PGM or PPM)",
}
"""Videos and pictures: description by a regular expression for the first bytes."""

_PICTURE_ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".pgm", ".ppm")
_EMULATE = "Turn it into events with flybench emulate."

_EVT = {"2.0": "evt2", "2": "evt2", "2.1": "evt21", "21": "evt21", "3.0": "evt3", "3": "evt3"}
_HEAD_BYTES = 1 << 14

BINARY_ENDINGS = (
    ".aedat4", ".aedat", ".raw", ".dat", ".es", ".h5", ".hdf5", ".npy", ".npz",
)  # fmt: skip
"""Endings of binary formats: such a file that looks like text has been truncated."""


def check_readable(path: Path) -> None:
    """Check that a path is a readable file that is not empty.

    Raises:
        FormatError: the path does not exist, is a folder or another special file, is empty, or may
            not be read.
    """
    try:
        if path.is_dir():
            pictures = any(file.suffix.lower() in _PICTURE_ENDINGS for file in path.iterdir())
            remedy = _EMULATE if pictures else "Give a file of events in it."
            raise FormatError(f"{path} is a folder{' of pictures' * pictures}. {remedy}")
        if not path.exists():
            raise FormatError(f"{path} does not exist. Check its name and folder.")
        if not path.is_file():
            raise FormatError(f"{path} is not a regular file. Copy the events into one first.")
        if path.stat().st_size == 0:
            raise FormatError(f"{path} is empty (0 bytes). Record or copy it again.")
        with path.open("rb"):
            pass
    except OSError as error:
        raise FormatError(
            f"{path} cannot be read ({error.strerror}). Check its permissions."
        ) from error


def identify_format(path: Path) -> str:
    """Return the name of a file's format, one of `FORMATS`.

    Raises:
        FormatError: the file has none of these formats, or is truncated in its header.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    for magic, name in _MAGIC.items():
        if head.startswith(magic):
            return name
    for magic, name in _MAGIC.items():
        if magic.startswith(head) and path.suffix.lower() not in (".txt", ".csv"):
            raise truncated_header(path, head, f" of {FORMATS[name]}")
    for magic, (description, remedy) in _UNSUPPORTED.items():
        if head.startswith(magic):
            raise FormatError(f"{path} is {description}, which cannot be read. {remedy}")
    for pattern, description in _PICTURES.items():
        if re.match(pattern, head, re.DOTALL):
            raise FormatError(f"{path} is {description}, not a recording of events. {_EMULATE}")
    name = _prophesee(head) if head.startswith(b"%") else ""
    if name:
        return name
    if _is_text(head):
        return "text"
    remedy = "Convert it to one of these with the software that wrote it."
    if path.suffix.lower() in ("", ".raw", ".bin"):
        remedy = "Read a RAW file without a header with --format evt2, evt21 or evt3, and --size."
    raise FormatError(
        f"{path} begins with {head[:8]!r}, which is none of the formats that can be read. Allowed "
        f"is {', '.join(FORMATS.values())}. {remedy}"
    )


def truncated_header(path: Path, head: bytes, of_format: str = "") -> FormatError:
    """Return the error for a file that ends within its header.

    Args:
        path: path of the file.
        head: all bytes of the file.
        of_format: the format's description after " of ", if it is known.
    """
    return FormatError(
        f"{path} contains only the beginning of a header{of_format} (bytes: {len(head)}). It was "
        "truncated in its header. Copy it again."
    )


def percent_header(head: bytes) -> tuple[dict[str, str], int]:
    """Parse the header of a Prophesee file, whose lines begin with a percent sign.

    Returns:
        Values by keyword in lower case, and the position where the data begin [bytes].
    """
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
    name = prophesee_format(facts)
    if name:
        return name
    return "dat" if "version" in facts or facts.get("data", "").startswith("file") else ""


def prophesee_format(facts: Mapping[str, str]) -> str:
    """Return the name of the RAW format that a header states; empty if it states none.

    Args:
        facts: values of the header by keyword in lower case.
    """
    evt = re.match(r"EVT([\d.]+)", facts.get("format", ""), re.IGNORECASE)
    version = evt[1] if evt else facts.get("evt", "")
    return _EVT.get(version, "")


def _is_text(head: bytes) -> bool:
    """Return True if the first line is text; later lines may still be damaged."""
    first = head.removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0]
    printable = re.fullmatch(rb"([\t\r\x20-\x7e]|\xc2\xb5)*", first)
    return printable is not None and b"\0" not in head
