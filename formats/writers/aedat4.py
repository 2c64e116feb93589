"""AEDAT 4: events, IMU samples and triggers are encoded by faery, frames by dv-processing.

faery encodes events fast but cannot create frames. dv-processing creates frames but takes events
one at a time. Frames therefore go to a second file. IMU samples and triggers go to a third, because
the header of a file lists its streams. faery merges the files at the end.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from contextlib import ExitStack, suppress
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
        self._frame_writer: Any = None
        self._dv: Any = None
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
        if self._frame_writer is None:
            try:
                import dv_processing
            except ImportError as error:
                raise MissingLibraryError("dv-processing", "AEDAT 4 with frames") from error
            self._dv = dv_processing
            config = dv_processing.io.MonoCameraWriter.Config(_SOURCE)
            config.addFrameStream((self.width, self.height))
            self._frame_writer = dv_processing.io.MonoCameraWriter(str(self._frames_path), config)
        source = self._dv.FrameSource.SENSOR
        exposure_us = frame.end_us - frame.start_us
        self._frame_writer.writeFrame(
            self._dv.Frame(frame.start_us, exposure_us, 0, 0, frame.image, source)
        )

    def _write_samples(self, samples: npt.NDArray[Any]) -> None:
        if self._sample_encoder is None:
            self._sample_encoder = self._begin(self._samples_path, ["imu", "triggers"])
        if samples.dtype == IMU_DTYPE:
            self._sample_encoder.write(0, to_faery_imu(samples))
        else:
            self._sample_encoder.write(1, to_faery_triggers(samples))

    def _finish(self) -> None:
        self._close(self._encoder)
        self._encoder = None
        more = []
        if self._frame_writer is not None:
            self._frame_writer = None  # its destructor writes the last frames
            more.append(self._frames_path)
        if self._sample_encoder is not None:
            self._close(self._sample_encoder)
            self._sample_encoder = None
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
        self._frame_writer = None
        for encoder in (self._encoder, self._sample_encoder):
            if encoder is not None:
                with suppress(Exception):
                    self._close(encoder)
        for path in (self._frames_path, self._samples_path, self._merged_path):
            path.unlink(missing_ok=True)

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
