"""Generated damaged files: the result is always events or a one-line error."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from formats import FormatError, open_events
from formats.columns import ReadOptions
from formats.identify import FORMATS, identify_format
from formats.parser_process import MESSAGE, parse
from tests.formats.sample_files import FILE_MAKERS, SIZE, make_file, random_events

DECODED_BY_LIBRARIES = ("a.aedat4", "a.h5", "evt3.raw", "a.es")
"""Files that native libraries decode, which may crash their process."""

TABLES = ("table.npy", "table.npz", "words.txt", "savetxt.txt")
"""Files whose columns have no names."""

DECODED_BY_FLYBENCH = (*sorted(set(FILE_MAKERS) - set(DECODED_BY_LIBRARIES)), *TABLES)

OPTIONS = (
    ReadOptions(SIZE),
    ReadOptions(SIZE, sort_within_us=1000),
    ReadOptions(SIZE, drop_unsorted=True),
    ReadOptions(sort_within_us=1000, drop_unsorted=True),
    ReadOptions(SIZE, time_unit="1/30s", columns="xytp"),
)


def make_table(path: Path) -> None:
    """Write events as a table whose columns have no names."""
    events = random_events(40)
    rows = np.stack([events[name] for name in "xytp"], axis=1).astype(float)
    if path.suffix == ".npy":
        np.save(path, rows)
    elif path.suffix == ".npz":
        np.savez(path, rows)
    elif path.name.startswith("words"):
        path.write_text("".join(f"{x} {y} {t:.0f} {p > 0}\n" for x, y, t, p in rows.tolist()))
    else:
        np.savetxt(path, rows)


@st.composite
def damaged(draw: st.DrawFn, intact: bytes) -> bytes:
    """Return the bytes of a file, truncated or with bytes changed, removed or inserted."""
    if draw(st.booleans()):
        return intact[: draw(st.integers(0, len(intact)))] or b"\0"
    data = bytearray(intact)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, min(len(data), draw(st.sampled_from([200, 1 << 30])))))
        new = draw(st.binary(max_size=6) | st.sampled_from([b"\xff" * 4, b"\xff\xff\xff\x7f"]))
        data[at : at + draw(st.integers(0, 6))] = new
    return bytes(data) or b"\0"


@pytest.fixture(scope="module")
def intact_files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("intact")
    for name in TABLES:
        make_table(folder / name)
    for name in FILE_MAKERS:
        make_file(folder, name, random_events(40))
    return {name: (folder / name).read_bytes() for name in (*FILE_MAKERS, *TABLES)}


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings(
    "ignore::ResourceWarning"
)  # a parser process closes its files when it ends
@pytest.mark.parametrize("name", DECODED_BY_FLYBENCH)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_parsers_of_flybench(
    tmp_path: Path, intact_files: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    path = tmp_path / "damaged"
    path.write_bytes(data.draw(damaged(intact_files[name])))
    try:
        name = identify_format(path)
    except FormatError as error:
        check_error_message(str(error), path)
        return
    if name in ("aedat4", "hdf5", "evt3", "es"):
        return
    out = BytesIO()
    parse(path, name, data.draw(st.sampled_from(OPTIONS)), out)
    check_messages(out.getvalue(), path)


@pytest.mark.parametrize("name", DECODED_BY_LIBRARIES)
@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_parsers_of_libraries(
    tmp_path: Path, intact_files: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    path = tmp_path / "damaged"
    path.write_bytes(data.draw(damaged(intact_files[name])))
    try:
        with open_events(path, size=SIZE) as file:
            assert file.format in FORMATS
            for chunk in file:
                assert chunk.events.size <= 1 << 18
    except FormatError as error:
        check_error_message(str(error), path)


def test_a_first_pass_sends_working_messages(
    tmp_path: Path, intact_files: dict[str, bytes]
) -> None:
    path, out = tmp_path / "a.csv", BytesIO()
    path.write_bytes(intact_files["a.csv"].split(b"\n", 1)[1])  # without its size
    parse(path, "text", ReadOptions(), out)
    assert out.getvalue().startswith(MESSAGE.pack(b"W", 0))


def check_error_message(text: str, path: Path) -> None:
    assert str(path) in text
    assert "\n" not in text
    assert "Traceback" not in text


def check_messages(stream: bytes, path: Path) -> None:
    at, kind = 0, b""
    while at < len(stream):
        kind, length = MESSAGE.unpack_from(stream, at)
        content = stream[at + MESSAGE.size : at + MESSAGE.size + length]
        at += MESSAGE.size + length
        if kind == b"X":
            check_error_message(content.decode(), path)
    assert at == len(stream)
    assert kind in (b"X", b"Z")
