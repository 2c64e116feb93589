"""The inputs that once broke something, each kept as the test that it does so no more.

What the generated tests of `test_fuzz` and `test_writers` find is written down here by hand.
"""

import signal
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest

from flybench.events import Events
from formats import FormatError, open_events, read_events, write_events
from formats.columns import Options
from formats.isolated_reader import Guard
from tests.formats.samples import SIZE, make, some_events

W, H = SIZE
E = some_events(200)


def two_gigabytes_of_nothing() -> bytes:
    packer = zlib.compressobj(1)
    first, more = (
        packer.compress(bytes(1 << 24)) + packer.flush(zlib.Z_FULL_FLUSH) for _ in range(2)
    )
    return first + 127 * more + packer.flush()


def test_promises_of_gigabytes_are_not_kept(tmp_path: Path) -> None:
    nothing = two_gigabytes_of_nothing()
    header = np.lib.format.magic(1, 0)
    text = b"{'descr': '<i8', 'fortran_order': False, 'shape': (10000000000, 4), }\n"
    (tmp_path / "a.npy").write_bytes(header + len(text).to_bytes(2, "little") + text)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in "txyp":
            file.create_dataset(f"events/{name}", (10**12,), "i8", chunks=(1 << 20,))
    aedat4 = make(tmp_path, "a.aedat4", E).read_bytes()
    packet = 18 + int.from_bytes(aedat4[14:18], "little")
    grown = aedat4[: packet + 4] + (2**31 - 1).to_bytes(4, "little") + aedat4[packet + 8 :]
    (tmp_path / "a.aedat4").write_bytes(grown)
    text = text.replace(b"(10000000000, 4)", b"(-1, 4)        ")
    (tmp_path / "b.npy").write_bytes(header + len(text).to_bytes(2, "little") + text)
    with h5py.File(tmp_path / "b.h5", "w") as file:
        for name in "txyp":
            data = file.create_dataset(
                f"events/{name}", (1 << 28,), "i8", chunks=(1 << 28,), compression="gzip"
            )
            data.id.write_direct_chunk((0,), nothing)
    for name, says in (
        ("b.npy", "promises -32 bytes"),
        ("b.h5", "damaged in events|more than 1 GB"),
        ("a.npy", "promises 320000000000 bytes"),
        ("a.h5", "promises 1000000000000 events"),
        ("a.aedat4", f"packet at byte {packet}"),
    ):
        with pytest.raises(FormatError, match=says):
            read_events(tmp_path / name)


@pytest.mark.parametrize("last_us", [3, 16_777_215, 20_000_000, 200_000_000, 5_000_000_000])
def test_evt3_clock_turns(tmp_path: Path, last_us: int) -> None:
    path, events = tmp_path / "a.raw", some_events(2)
    events["t"] = 0, last_us
    write_events(path, [events], width=W, height=H)
    assert np.array_equal(read_events(path), events)


@pytest.mark.parametrize("line", [b"2 2 \xff 1", b"2 2 \0 1", b"2 2 3 1 \xc2"])
@pytest.mark.parametrize("size", [SIZE, None])
def test_stray_bytes_in_text(tmp_path: Path, line: bytes, size: tuple[int, int] | None) -> None:
    (tmp_path / "a.txt").write_bytes(b"1 2 3 1\n" + line + b"\n")
    with pytest.raises(FormatError, match=r"line at byte 8|none of the formats"):
        read_events(tmp_path / "a.txt", size=size)


@pytest.mark.parametrize("says_size", [True, False])
@pytest.mark.parametrize("name", ["a.csv", "a.txt"])
def test_cut_text_gives_what_comes_before(tmp_path: Path, name: str, says_size: bool) -> None:
    path = make(tmp_path, name, E)
    data = path.read_bytes().rstrip()
    if not says_size:
        data = data.split(b"\n", 1)[1]
    path.write_bytes(data[: data.rindex(b"\n") + 3])
    with open_events(path) as file:
        assert (file.width, file.height) == SIZE
        assert file.size_from == ("the file" if says_size else "the events")
        got: list[Events] = []
        with pytest.raises(FormatError, match="may have been cut"):
            got.extend(chunk.events for chunk in file)
    assert np.array_equal(np.concatenate(got), E[:-1])


@pytest.mark.parametrize(
    ("name", "length"),
    [("evt3.raw", 40), ("evt2.raw", 5), ("a.aedat4", 1), ("a.npz", 1), ("a.dat", 13), ("a.h5", 3)],
)
def test_a_file_cut_in_its_header_is_not_taken_for_text(
    tmp_path: Path, name: str, length: int
) -> None:
    path = make(tmp_path, name, E)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(FormatError, match=rf"bytes: {length}.*cut in its header"):
        read_events(path)


def test_an_aedat4_cut_in_its_table_holds_all_events(tmp_path: Path) -> None:
    path = make(tmp_path, "a.aedat4", E)
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    assert np.array_equal(read_events(path), E)
    path.write_bytes(whole[:-10])
    with pytest.raises(FormatError, match=r"table of its packets.*head -c \d+$") as caught:
        read_events(path)
    path.write_bytes(whole[: int(str(caught.value).split()[-1])])  # as the sentence says
    assert np.array_equal(read_events(path), E)


@pytest.mark.parametrize("text", ["# 346 260\nt,x", "# 346 2", "#"])
def test_csv_cut_in_its_header(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(FormatError, match="no line of numbers"):
        read_events(tmp_path / "a.csv")


def test_a_wrong_polarity_is_not_taken_for_an_undistorted_x(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("346 260\n0.1 1 1 7\n")
    with pytest.raises(FormatError, match=r"p = 7\.0"):
        read_events(tmp_path / "a.txt")


@pytest.mark.parametrize(
    ("number", "says"),
    [
        (signal.SIGKILL, "to be read; it is damaged"),
        (signal.SIGABRT, "or its reader gave up"),
        (signal.SIGSEGV, "stopped its reader"),
    ],
)
def test_a_reader_that_dies_is_a_sentence(
    tmp_path: Path, number: signal.Signals, says: str
) -> None:
    path = make(tmp_path, "a.txt", E)
    with Guard(path, "text", Options()) as guard:
        guard._process.send_signal(number)
        with pytest.raises(FormatError, match=says):
            list(guard.messages())
