"""Small recordings in every format, written by other libraries where these can write them."""

import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import scipy.io

from emulator import ApsFrame
from flybench.events import EVENT_DTYPE, Events
from formats import open_writer
from tests.formats.ros_files import events_recorded, write_bag

SIZE = (346, 260)


def random_events(count: int = 300, *, last_us: int = 99_999, seed: int = 0) -> Events:
    """Return random events, spread over the sensor of a DAVIS346."""
    rng = np.random.default_rng(seed)
    events = np.zeros(count, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, last_us + 1, count))
    events["x"] = rng.integers(0, SIZE[0], count)
    events["y"] = rng.integers(0, SIZE[1], count)
    events["p"] = rng.random(count) < 0.4
    return events


def random_frames(count: int = 3) -> list[ApsFrame]:
    """Return frames of white noise, 25 ms apart."""
    rng = np.random.default_rng(1)
    return [
        ApsFrame(
            start_us=25_000 * k,
            end_us=25_000 * k + 9_000,
            image=rng.integers(0, 1024, SIZE[::-1]).astype(np.uint16),
        )
        for k in range(count)
    ]


def _with_flybench(path: Path, events: Events) -> None:
    with open_writer(path, width=SIZE[0], height=SIZE[1]) as writer:
        writer.write(events)
        if writer.takes_frames:
            for frame in random_frames():
                writer.write_frame(frame)


def _evt2(path: Path, events: Events) -> None:
    words, high = [], None
    for t, x, y, p in events.tolist():
        if t >> 6 != high:
            high = t >> 6
            words.append(8 << 28 | high)
        words.append(int(p) << 28 | (t & 63) << 22 | x << 11 | y)
    header = b"% evt 2.0\n% format EVT2;height=260;width=346\n% end\n"
    path.write_bytes(header + np.array(words, "<u4").tobytes())


def _dat(path: Path, events: Events) -> None:
    records = np.zeros((events.size, 2), "<u4")
    x, y, p = (events[name].astype(np.int64) for name in "xyp")
    records[:, 0], records[:, 1] = events["t"], p << 28 | y << 14 | x
    header = b"% Data file containing CD events.\n% Version 2\n% Height 260\n% Width 346\n"
    path.write_bytes(header + b"\x0c\x08" + records.tobytes())


def _es(path: Path, events: Events) -> None:
    from faery.extension import es

    converted = np.zeros(
        events.size, [("t", "<u8"), ("x", "<u2"), ("y", "<u2"), (("p", "on"), "?")]
    )
    for name in "txp":
        converted[name] = events[name]
    converted["y"] = SIZE[1] - 1 - events["y"]
    with es.Encoder(path, "dvs", False, SIZE) as encoder:
        encoder.write(converted)


def _evt21(path: Path, events: Events) -> None:
    words, high = [], None
    for t, x, y, p in events.tolist():
        if t >> 6 != high:
            high = t >> 6
            words.append(8 << 60 | high << 32)
        words.append(int(p) << 60 | (t & 63) << 54 | (x & ~31) << 43 | y << 32 | 1 << (x & 31))
    header = b"% evt 2.1\n% format EVT21;height=260;width=346\n% geometry 346x260\n% end\n"
    path.write_bytes(header + np.array(words, "<u8").tobytes())


def _aedat2(path: Path, events: Events) -> None:
    records = np.zeros(events.size + 2, [("address", ">u4"), ("t", ">u4")])
    records["t"][:-2], records["t"][-2:] = events["t"], events["t"][-1:].repeat(2)
    x, y = SIZE[0] - 1 - events["x"].astype(np.int64), SIZE[1] - 1 - events["y"].astype(np.int64)
    records["address"][:-2] = y << 22 | x << 12 | events["p"].astype(np.int64) << 11
    records["address"][-2:] = 0x8000_0123, 0x0000_0400  # a frame sample and a special event
    header = b"#!AER-DAT2.0\r\n# AEChip: eu.seebetter.ini.chips.davis.Davis346blue\r\n"
    path.write_bytes(header + records.tobytes())


def _aedat3(path: Path, events: Events) -> None:
    words = np.zeros((events.size, 2), "<u4")
    x, y, p = (events[name].astype(np.int64) for name in "xyp")
    words[:, 0] = x << 17 | y << 2 | p << 1 | 1
    words[:, 1] = events["t"]
    imu = struct.pack("<hhiiiiii", 3, 1, 36, 4, 0, 1, 1, 1) + bytes(36)
    data = b"#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: DAVIS346\r\n#!END-HEADER\r\n" + imu
    for part in np.array_split(words, 3):
        head = struct.pack("<hhiiiiii", 1, 1, 8, 4, 0, len(part), len(part), len(part))
        data += head + part.tobytes()
    path.write_bytes(data)


def _npy(path: Path, events: Events) -> None:
    np.save(path, events)


def matlab_structure(events: Events) -> dict[str, np.ndarray]:
    """Return the fields of the structure TD as MATLAB users store them: x and y from 1, doubles."""
    polarity = np.where(events["p"], 1.0, -1.0)
    return {"x": events["x"] + 1.0, "y": events["y"] + 1.0, "p": polarity, "ts": events["t"] * 1.0}


def _matlab_5(path: Path, events: Events) -> None:
    scipy.io.savemat(path, {"TD": matlab_structure(events)}, appendmat=False, do_compression=True)


def _matlab_73(path: Path, events: Events) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in matlab_structure(events).items():
            column = values.reshape(-1, 1).astype("u2" if name in "xy" else "f8")
            file.create_dataset(f"TD/{name}", data=column, compression="gzip")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\x02IM")


def _bag(path: Path, events: Events) -> None:
    write_bag(path, events_recorded(path, events))


FILE_MAKERS: dict[str, Callable[[Path, Events], None]] = {
    "a.aedat4": _with_flybench,
    "a.h5": _with_flybench,
    "evt3.raw": _with_flybench,
    "a.txt": _with_flybench,
    "a.csv": _with_flybench,
    "a.npz": _with_flybench,
    "evt2.raw": _evt2,
    "a.dat": _dat,
    "evt21.raw": _evt21,
    "a.es": _es,
    "davis.aedat": _aedat2,
    "caer.aedat": _aedat3,
    "a.npy": _npy,
    "5.mat": _matlab_5,
    "73.mat": _matlab_73,
    "1.bag": _bag,
    "2.db3": _bag,
    "a.mcap": _bag,
}
"""Function that writes a file, by its name; the stem names the format if the ending does not."""

WITHOUT_SIZE = ("a.npy", "5.mat", "73.mat")
"""Files that do not state the size of the sensor."""


def make_file(folder: Path, name: str, events: Events) -> Path:
    """Write the events to the file `name` in `folder` and return its path."""
    path = folder / name
    FILE_MAKERS[name](path, events)
    return path


def make_hdf5(path: Path, **data_sets: object) -> Path:
    """Write an HDF5 file with these data sets; `__` in a name stands for `/`."""
    with h5py.File(path, "w") as file:
        for name, values in data_sets.items():
            file[name.replace("__", "/")] = values
    return path
