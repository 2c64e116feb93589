"""AEDAT 4 of DV and dv-processing: packets of events, frames, IMU samples, triggers; by faery."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from formats.columns import (
    Array,
    EventColumns,
    FileHeader,
    ParsedFile,
    ParsedFrame,
    ParsedItem,
    ReadOptions,
)
from formats.errors import FormatError, MissingLibraryError
from formats.samples import IMU_DTYPE, TRIGGER_DTYPE, ParsedSamples

_MAGIC_BYTES = 14
_PACKET_HEAD = struct.Struct("<iI")
_LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue in luma (ITU-R BT.601)."""

_IMU_SENSORS = {
    "acceleration_g": "accelerometer",
    "rotation_deg_s": "gyroscope",
    "magnetic_ut": "magnetometer",
}
"""faery's name of the sensor, by field of `IMU_DTYPE`."""


def read(path: Path, options: ReadOptions) -> ParsedFile:
    """Read the first stream of each kind: events, frames, IMU samples and triggers.

    Raises:
        FormatError: the header is damaged, or there are neither events nor frames.
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
            f"{path} contains neither events nor frames, but {', '.join(streams) or 'nothing'}. "
            "Give a recording of an event camera."
        )
    facts = {"streams": ", ".join(f"{track.data_type} {track.id}" for track in decoder.tracks())}
    if len(events) > 1:
        facts["streams"] += f"; events {events[0].id} is read"
    chosen = [*events[:1], *frames[:1], *streams.get("imus", [])[:1]]
    wanted = {track.id for track in chosen + streams.get("triggers", [])[:1]}
    size = (events or frames)[0].dimensions
    return FileHeader(size, facts, has_frames=bool(frames)), _items(path, decoder, wanted)


def _open(path: Path) -> Any:
    try:
        from faery import aedat
    except ImportError as error:
        raise MissingLibraryError("faery", "AEDAT 4") from error
    try:
        return aedat.Decoder(path)
    except RuntimeError as error:
        table = _table_of(path)
        if not 0 < table < path.stat().st_size or _complete_packets(path)[1] is not None:
            raise
        raise FormatError(
            f"{path} is truncated or damaged in its packet table, which starts at byte {table}. "
            "All packets before it are complete. Remove the table with: head -c "
            f"{table}"
        ) from error


def _items(path: Path, decoder: Any, wanted: set[int]) -> Iterator[ParsedItem]:
    complete, damaged_at = _complete_packets(path)
    known = {track.id for track in decoder.tracks()}
    left = sum(stream in known for stream in complete) if damaged_at is not None else None
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
            yield EventColumns(packet["t"], packet["x"], packet["y"], packet["on"])
        elif track.data_type == "imus":
            yield ParsedSamples(_imu(packet))
        elif track.data_type == "triggers":
            yield ParsedSamples(_triggers(packet))
        else:
            image, shift = _ten_bits(packet.pixels, packet.format, shift)
            yield ParsedFrame(*_exposure(packet), image)
    if damaged_at is not None:
        raise FormatError(
            f"{path} is truncated or damaged in the packet at byte {damaged_at}. The packets "
            "before it were read. Copy the file again from where it was recorded."
        )


def _imu(packet: Any) -> Array:
    """Return IMU samples; in the file: g, °/s, µT and °C (dv-processing, `dv::IMU`)."""
    samples = np.empty(packet.size, IMU_DTYPE)
    samples["t"], samples["temperature_c"] = packet["t"], packet["temperature"]
    for name, sensor in _IMU_SENSORS.items():
        for axis, letter in enumerate("xyz"):
            samples[name][:, axis] = packet[f"{sensor}_{letter}"]
    return samples


def _triggers(packet: Any) -> Array:
    samples = np.zeros(packet.size, TRIGGER_DTYPE)
    samples["t"], samples["kind"] = packet["t"], packet["source"]
    return samples


def _exposure(frame: Any) -> tuple[int, int]:
    if frame.exposure_end_t > 0:
        return int(frame.exposure_start_t), int(frame.exposure_end_t)
    return int(frame.t), int(frame.t)


def _ten_bits(pixels: Any, kind: str, shift: int) -> tuple[npt.NDArray[np.uint16], int]:
    """Convert an image to 10-bit grey levels [DN].

    Args:
        pixels: image of 8 or 16 bits, grey or colour.
        kind: faery's name of the pixel format.
        shift: right shift of earlier 16-bit images.

    Returns:
        The image, and the right shift for 16-bit images from now on: 6 once one exceeds 10 bits.
    """
    if pixels.ndim == 3:
        pixels = np.rint(pixels[..., :3].astype(np.float32) @ _LUMA).astype(pixels.dtype)
    if kind != "I;16" or pixels.dtype == np.uint8:
        return pixels.astype(np.uint16) << 2, shift
    if shift == 0 and pixels.size and pixels.max() > 1023:
        shift = 6
    return pixels.astype(np.uint16) >> shift, shift


def _complete_packets(path: Path) -> tuple[list[int], int | None]:
    """Return the stream of each complete packet, and the position of the first incomplete one."""
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
    """Return the position of the packet table; -1 if there is none.

    It is the second field of the header's flatbuffer.
    """
    try:
        (root,) = struct.unpack_from("<I", header, 0)
        (back,) = struct.unpack_from("<i", header, root)
        size, _, _, field = struct.unpack_from("<4H", header, root - back)
        if size < 8 or field == 0:
            return -1
        return int(struct.unpack_from("<q", header, root + field)[0])
    except struct.error:
        return -1
