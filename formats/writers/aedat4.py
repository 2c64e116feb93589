"""AEDAT 4: events, IMU samples and triggers are encoded by faery, frames by dv-processing.

faery encodes events fast but cannot create frames. dv-processing creates frames but takes events
one at a time, and it ends the process if the disk is full. It therefore writes each frame to
memory, from where faery copies it to a second file. IMU samples and triggers go to a third file,
because the header of a file lists its streams. At the end faery merges the files.
"""

from __future__ import annotations

import heapq
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar

import numpy.typing as npt

from emulator import ApsFrame
from flybench.events import Events
from formats.errors import MissingLibraryError
from formats.samples import IMU_DTYPE
from formats.writers.base import EventWriter
from formats.writers.faery_events import to_faery, to_faery_imu, to_faery_triggers

PACKET = 10_000
"""Most events in a packet, as in files of dv-processing."""

_PATH = "/mainloop/Recorder/outInfo/"
_STREAMS = {"events": "EVTS", "frames": "FRME", "imu": "IMUS", "triggers": "TRIG"}
"""Identifier of each stream's type, by the stream's name."""

_PACKET_KINDS = {"events": "events", "frame": "frames", "imus": "imu", "triggers": "triggers"}
"""Name of a stream, by faery's name of its packets."""
_SOURCE = "flybench"


class Aedat4Writer(EventWriter):
    """Writes events, APS frames with 10-bit grey levels in 16-bit pixels, IMU samples, triggers."""

    takes_frames: ClassVar[bool] = True
    takes_samples: ClassVar[bool] = True

    def _open(self, work: Path) -> None:
        self._encoder: Any = None
        self._frame_encoder: Any = None
        self._sample_encoder: Any = None
        self._frames_path, self._samples_path, self._merged_path = (
            work.with_name(f"{work.stem}.{name}{work.suffix}")
            for name in ("frames", "samples", "merged")
        )
        self._encoder = self._begin(work, ["events"])

    def _begin(self, path: Path, names: list[str]) -> Any:
        try:
            from faery import aedat
        except ImportError as error:
            raise MissingLibraryError("faery", "AEDAT 4") from error
        size = (self.width, self.height)
        nodes = [_stream(aedat, i, name, size) for i, name in enumerate(names)]
        node = aedat.DescriptionNode(name="outInfo", path=_PATH, attributes={}, nodes=nodes)
        encoder = aedat.Encoder(path, [node], aedat.LZ4_FASTEST)
        encoder.__enter__()
        return encoder

    def _write(self, events: Events) -> None:
        for start in range(0, events.size, PACKET):
            self._encoder.write(0, to_faery(events[start : start + PACKET]))

    def _write_frame(self, frame: ApsFrame) -> None:
        if self._frame_encoder is None:
            self._frame_encoder = self._begin(self._frames_path, ["frames"])
        self._frame_encoder.write(0, _frame_packet(frame))

    def _write_samples(self, samples: npt.NDArray[Any]) -> None:
        if self._sample_encoder is None:
            self._sample_encoder = self._begin(self._samples_path, ["imu", "triggers"])
        if samples.dtype == IMU_DTYPE:
            self._sample_encoder.write(0, to_faery_imu(samples))
        else:
            self._sample_encoder.write(1, to_faery_triggers(samples))

    def _finish(self) -> None:
        self._encoder, encoder = None, self._encoder
        self._close(encoder)
        more = []
        if self._frame_encoder is not None:
            self._frame_encoder, encoder = None, self._frame_encoder
            self._close(encoder)
            more.append(self._frames_path)
        if self._sample_encoder is not None:
            self._sample_encoder, encoder = None, self._sample_encoder
            self._close(encoder)
            more.append(self._samples_path)
        if more:
            self._merge([*more, self._work])
            self._merged_path.replace(self._work)

    def _merge(self, paths: list[Path]) -> None:
        """Merge files in order of time; of packets of one time, those of the first file first."""
        from faery import aedat

        with ExitStack() as stack:
            packets = heapq.merge(
                *(_packets(stack.enter_context(aedat.Decoder(path))) for path in paths),
                key=lambda packet: packet[0],
            )
            names = ["events", *(["frames"] if self._frames_path in paths else [])]
            names += ["imu", "triggers"] if self._samples_path in paths else []
            encoder = self._begin(self._merged_path, names)
            try:
                for _, name, packet in packets:
                    encoder.write(names.index(name), packet)
            finally:
                self._close(encoder)

    def _abandon(self) -> None:
        for encoder in (self._encoder, self._frame_encoder, self._sample_encoder):
            if encoder is not None:
                with suppress(Exception):
                    self._close(encoder)

    @staticmethod
    def _close(encoder: Any) -> None:
        encoder.__exit__(None, None, None)


def _stream(aedat: Any, number: int, name: str, size: tuple[int, int]) -> Any:
    """Return the description of one stream for the header."""

    def texts(**values: str) -> dict[str, Any]:
        return {key: aedat.DescriptionAttribute("string", value) for key, value in values.items()}

    sides = {
        key: aedat.DescriptionAttribute("int", side)
        for key, side in zip(("sizeX", "sizeY"), size, strict=True)
    }
    path = f"{_PATH}{number}/"
    info = aedat.DescriptionNode(
        name="info", path=f"{path}info/", attributes=sides | texts(source=_SOURCE), nodes=[]
    )
    attributes = texts(
        compression="LZ4",
        originalModuleName=_SOURCE,
        originalOutputName=name,
        typeDescription=name,
        typeIdentifier=_STREAMS[name],
    )
    return aedat.DescriptionNode(name=str(number), path=path, attributes=attributes, nodes=[info])


def _packets(decoder: Any) -> Iterator[tuple[int, str, Any]]:
    """Yield the time of a packet's end, the name of its stream, and the packet."""
    for track, packet in decoder:
        is_frame = track.data_type == "frame"
        end_us = packet.exposure_end_t if is_frame else packet["t"][-1]
        yield int(end_us), _PACKET_KINDS[track.data_type], packet


def _frame_packet(frame: ApsFrame) -> Any:
    """Return a frame as faery's decoder returns it, by way of a file in memory."""
    try:
        import dv_processing
    except ImportError as error:
        raise MissingLibraryError("dv-processing", "AEDAT 4 with frames") from error
    from faery import aedat

    height, width = frame.image.shape
    config = dv_processing.io.MonoCameraWriter.Config(_SOURCE)
    config.addFrameStream((width, height))
    with _memory_file("frame.aedat4") as path:
        writer = dv_processing.io.MonoCameraWriter(str(path), config)
        source, exposure_us = dv_processing.FrameSource.SENSOR, frame.end_us - frame.start_us
        writer.writeFrame(
            dv_processing.Frame(frame.start_us, exposure_us, 0, 0, frame.image, source)
        )
        del writer  # its destructor writes the frame
        with aedat.Decoder(path) as decoder:
            return next(packet for track, packet in decoder if track.data_type == "frame")


@contextmanager
def _memory_file(name: str) -> Iterator[Path]:
    """Yield the path of a file in memory; dv-processing wants its name to end in .aedat4."""
    descriptor = os.memfd_create(name)
    try:
        with tempfile.TemporaryDirectory() as folder:
            link = Path(folder) / name
            link.symlink_to(f"/proc/self/fd/{descriptor}")
            yield link
    finally:
        os.close(descriptor)
