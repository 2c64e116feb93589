"""Regression tests: inputs that once caused an error, most found by the generated tests."""

import signal
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest

from flybench.events import Events
from formats import FormatError, open_events, read_events, write_events
from formats.columns import ReadOptions
from formats.isolated_reader import IsolatedReader
from tests.formats.sample_files import SIZE, make_file, random_events

W, H = SIZE
E = random_events(200)


def two_gigabytes_of_zeros_compressed() -> bytes:
    packer = zlib.compressobj(1)
    first, more = (
        packer.compress(bytes(1 << 24)) + packer.flush(zlib.Z_FULL_FLUSH) for _ in range(2)
    )
    return first + 127 * more + packer.flush()


def test_headers_that_claim_gigabytes_allocate_nothing(tmp_path: Path) -> None:
    zeros = two_gigabytes_of_zeros_compressed()
    header = np.lib.format.magic(1, 0)
    text = b"{'descr': '<i8', 'fortran_order': False, 'shape': (10000000000, 4), }\n"
    (tmp_path / "a.npy").write_bytes(header + len(text).to_bytes(2, "little") + text)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in "txyp":
            file.create_dataset(f"events/{name}", (10**12,), "i8", chunks=(1 << 20,))
    aedat4 = make_file(tmp_path, "a.aedat4", E).read_bytes()
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
            data.id.write_direct_chunk((0,), zeros)
    for name, message in (
        ("b.npy", "should contain -32 bytes"),
        ("b.h5", "damaged in events|more than 1 GB"),
        ("a.npy", "should contain 320000000000 bytes"),
        ("a.h5", "should contain 1000000000000 events"),
        ("a.aedat4", f"packet at byte {packet}"),
    ):
        with pytest.raises(FormatError, match=message):
            read_events(tmp_path / name)


@pytest.mark.parametrize("last_us", [3, 16_777_215, 20_000_000, 200_000_000, 5_000_000_000])
def test_evt3_clock_overflows(tmp_path: Path, last_us: int) -> None:
    path, events = tmp_path / "a.raw", random_events(2)
    events["t"] = 0, last_us
    write_events(path, [events], width=W, height=H)
    assert np.array_equal(read_events(path), events)


@pytest.mark.parametrize("end", [b"\n", b"", b"\r\n"])
@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ((b"5002 2 3", b"1 5003 2 3 1"), "5002 2 3"),
        ((b"5002 2 3 1 5003", b"2 3 1"), "5002 2 3 1 5003"),
        ((b"5002 2 3 1 5003 2 3 1", b""), "5002 2 3 1 5003 2 3 1"),
    ],
)
def test_lines_whose_numbers_only_match_in_all_are_refused(
    tmp_path: Path, lines: tuple[bytes, bytes], found: str, end: bytes
) -> None:
    text = (end or b"\n").join((b"5001 2 3 1", *lines)) + end
    (tmp_path / "a.txt").write_bytes(text)
    with pytest.raises(FormatError, match=rf"line at byte 1[12] is '{found}'\."):
        read_events(tmp_path / "a.txt", size=(9, 9))


@pytest.mark.parametrize("line", [b"5002 2 \xff 1", b"5002 2 \0 1", b"5002 2 3 1 \xc2"])
@pytest.mark.parametrize("size", [SIZE, None])
def test_stray_bytes_in_text_are_refused(
    tmp_path: Path, line: bytes, size: tuple[int, int] | None
) -> None:
    (tmp_path / "a.txt").write_bytes(b"5001 2 3 1\n" + line + b"\n")
    with pytest.raises(FormatError, match=r"line at byte 11|none of the formats"):
        read_events(tmp_path / "a.txt", size=size)


@pytest.mark.parametrize("states_size", [True, False])
@pytest.mark.parametrize("name", ["a.csv", "a.txt"])
def test_truncated_text_gives_the_events_before(
    tmp_path: Path, name: str, states_size: bool
) -> None:
    path = make_file(tmp_path, name, E)
    data = path.read_bytes().rstrip()
    if not states_size:
        data = data.split(b"\n", 1)[1]
    path.write_bytes(data[: data.rindex(b"\n") + 3])
    with open_events(path) as file:
        assert (file.width, file.height) == SIZE
        assert file.size_source == ("the file" if states_size else "the events")
        got: list[Events] = []
        with pytest.raises(FormatError, match="may be truncated"):
            got.extend(chunk.events for chunk in file)
    assert np.array_equal(np.concatenate(got), E[:-1])


@pytest.mark.parametrize(
    ("name", "length"),
    [("evt3.raw", 40), ("evt2.raw", 5), ("a.aedat4", 1), ("a.npz", 1), ("a.dat", 13), ("a.h5", 3)],
)
def test_a_file_truncated_in_its_header_is_not_taken_for_text(
    tmp_path: Path, name: str, length: int
) -> None:
    path = make_file(tmp_path, name, E)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(FormatError, match=rf"bytes: {length}.*truncated in its header"):
        read_events(path)


def test_an_aedat4_truncated_in_its_packet_table_has_all_events(tmp_path: Path) -> None:
    path = make_file(tmp_path, "a.aedat4", E)
    complete = path.read_bytes()
    path.write_bytes(complete[:-1])
    assert np.array_equal(read_events(path), E)
    path.write_bytes(complete[:-10])
    with pytest.raises(FormatError, match=r"packet table.*head -c \d+$") as caught:
        read_events(path)
    path.write_bytes(complete[: int(str(caught.value).split()[-1])])  # as the message advises
    assert np.array_equal(read_events(path), E)


@pytest.mark.parametrize("text", ["# 346 260\nt,x", "# 346 2", "#"])
def test_csv_truncated_in_its_header_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(FormatError, match="no line of numbers"):
        read_events(tmp_path / "a.csv")


def test_a_wrong_polarity_is_not_taken_for_an_undistorted_x(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("346 260\n0.1 1 1 1\n0.2 2 1 0\n0.3 1 1 7\n")
    with pytest.raises(FormatError, match=r"p = 7\.0"):
        read_events(tmp_path / "a.txt")


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (signal.SIGKILL, "to be read. It is damaged"),
        (signal.SIGABRT, "or its parser aborted"),
        (signal.SIGSEGV, "crashed its parser"),
    ],
)
def test_a_parser_that_dies_raises_a_format_error(
    tmp_path: Path, number: signal.Signals, message: str
) -> None:
    path = make_file(tmp_path, "a.txt", E)
    with IsolatedReader(path, "text", ReadOptions()) as reader:
        reader._process.send_signal(number)
        with pytest.raises(FormatError, match=message):
            list(reader.messages())
