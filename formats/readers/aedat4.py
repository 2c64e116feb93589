"""AEDAT 4, of DV and dv-processing: events and frames in packets, decoded by faery."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from formats.columns import Columns, Head, Item, Options, RawFrame, Reading
from formats.errors import FormatError, MissingLibraryError

_MAGIC_BYTES = 14
_PACKET_HEAD = struct.Struct("<iI")
_LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue (ITU-R BT.601)."""


def read(path: Path, options: Options) -> Reading:
    """The first stream of events and the first of frames.

    Raises:
        FormatError: the header is broken, or there is neither events nor frames.
        MissingLibraryError: faery is not installed.
    """
    del options
    decoder = _open(path)
    streams: dict[str, list[Any]] = {}
    for track in decoder.tracks():
        streams.setdefault(track.data_type, []).append(track)
    events, frames = streams.get("events", []), streams.get("frame", [])
    if not events and not frames:
        raise FormatError(
            f"{path} holds neither events nor frames, but {', '.join(streams) or 'nothing'}; give "
            "the recording of an event camera"
        )
    says = {"streams": ", ".join(f"{track.data_type} {track.id}" for track in decoder.tracks())}
    if len(events) > 1:
        says["streams"] += f"; events {events[0].id} is read"
    wanted = {track.id for track in events[:1] + frames[:1]}
    size = (events or frames)[0].dimensions
    return Head(size, says, has_frames=bool(frames)), _items(path, decoder, wanted)


def _open(path: Path) -> Any:
    try:
        from faery import aedat
    except ImportError as error:
        raise MissingLibraryError("faery", "AEDAT 4") from error
    try:
        return aedat.Decoder(path)
    except RuntimeError as error:
        table = _table_of(path)
        if not 0 < table < path.stat().st_size or _whole_packets(path)[1] is not None:
            raise
        raise FormatError(
            f"{path} is cut or damaged in the table of its packets, from byte {table} on; all that "
            f"comes before is whole; keep that with: head -c {table}"
        ) from error


def _items(path: Path, decoder: Any, wanted: set[int]) -> Iterator[Item]:
    whole, broken_at = _whole_packets(path)
    known = {track.id for track in decoder.tracks()}
    left = sum(stream in known for stream in whole) if broken_at is not None else None
    shift = 0
    while left is None or left > 0:
        try:
            track, packet = next(decoder)
        except StopIteration:
            break
        left = None if left is None else left - 1
        if track.id not in wanted:
            continue
        if track.data_type == "events":
            yield Columns(packet["t"], packet["x"], packet["y"], packet["on"])
        else:
            image, shift = _ten_bits(packet.pixels, packet.format, shift)
            yield RawFrame(*_exposure(packet), image)
    if broken_at is not None:
        raise FormatError(
            f"{path} is cut or damaged in the packet at byte {broken_at}; what comes before was "
            "read; copy the file again from where it was recorded"
        )


def _exposure(frame: Any) -> tuple[int, int]:
    if frame.exposure_end_t > 0:
        return int(frame.exposure_start_t), int(frame.exposure_end_t)
    return int(frame.t), int(frame.t)


def _ten_bits(pixels: Any, kind: str, shift: int) -> tuple[npt.NDArray[np.uint16], int]:
    """Pixels as DN of 10 bits, and the shift of those of 16 bits seen so far."""
    if pixels.ndim == 3:
        pixels = np.rint(pixels[..., :3].astype(np.float32) @ _LUMA).astype(pixels.dtype)
    if kind != "I;16" or pixels.dtype == np.uint8:
        return pixels.astype(np.uint16) << 2, shift
    if shift == 0 and pixels.size and pixels.max() > 1023:
        shift = 6
    return pixels.astype(np.uint16) >> shift, shift


def _whole_packets(path: Path) -> tuple[list[int], int | None]:
    """Streams of the packets that are whole, and where the first that is not begins."""
    length = path.stat().st_size
    streams: list[int] = []
    with path.open("rb") as file:
        file.seek(_MAGIC_BYTES)
        table = _table_position(file.read(int.from_bytes(file.read(4), "little")))
        at = file.tell()
        end = table if table > 0 else length
        while at < end:
            head = file.read(_PACKET_HEAD.size)
            if len(head) < _PACKET_HEAD.size:
                return streams, at
            stream, size = _PACKET_HEAD.unpack(head)
            if at + _PACKET_HEAD.size + size > min(end, length):
                return streams, at
            streams.append(stream)
            at += _PACKET_HEAD.size + size
            file.seek(at)
    return streams, None


def _table_of(path: Path) -> int:
    with path.open("rb") as file:
        file.seek(_MAGIC_BYTES)
        return _table_position(file.read(int.from_bytes(file.read(4), "little")))


def _table_position(header: bytes) -> int:
    """Where the table of packets is, the second field of the header's flatbuffer; -1: nowhere."""
    try:
        (root,) = struct.unpack_from("<I", header, 0)
        (back,) = struct.unpack_from("<i", header, root)
        size, _, _, field = struct.unpack_from("<4H", header, root - back)
        if size < 8 or field == 0:
            return -1
        return int(struct.unpack_from("<q", header, root + field)[0])
    except struct.error:
        return -1
