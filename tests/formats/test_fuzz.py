"""Broken files: whatever their bytes are, the answer is events or one sentence."""

from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from formats import FormatError, open_events
from formats.columns import Options
from formats.identify import FORMATS, format_of
from formats.parser_process import MESSAGE, answer
from tests.formats.samples import MAKERS, SIZE, make, some_events

IN_C = ("a.aedat4", "a.h5", "evt3.raw", "evt2.raw", "a.dat", "a.es")
"""Files that libraries decode, which may end the process that they run in."""

OURS = tuple(sorted(set(MAKERS) - set(IN_C)))


@st.composite
def broken(draw: st.DrawFn, whole: bytes) -> bytes:
    """A file that was cut, or in which bytes were changed, taken out or put in."""
    if draw(st.booleans()):
        return whole[: draw(st.integers(0, len(whole)))] or b"\0"
    data = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, min(len(data), draw(st.sampled_from([200, 1 << 30])))))
        new = draw(st.binary(max_size=6) | st.sampled_from([b"\xff" * 4, b"\xff\xff\xff\x7f"]))
        data[at : at + draw(st.integers(0, 6))] = new
    return bytes(data) or b"\0"


@pytest.fixture(scope="module")
def wholes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("whole")
    return {name: make(folder, name, some_events(40)).read_bytes() for name in MAKERS}


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")  # a worker ends, and closes all, by itself
@pytest.mark.parametrize("name", OURS)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_our_own_parsers(
    tmp_path: Path, wholes: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    path = tmp_path / "broken"
    path.write_bytes(data.draw(broken(wholes[name])))
    try:
        found = format_of(path)
    except FormatError as error:
        check_sentence(str(error), path)
        return
    if found in ("aedat4", "hdf5", "evt3", "evt2", "dat", "es"):
        return
    out = BytesIO()
    answer(path, found, Options(SIZE), out)
    check_messages(out.getvalue(), path)


@pytest.mark.parametrize("name", IN_C)
@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_the_libraries_parsers(
    tmp_path: Path, wholes: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    path = tmp_path / "broken"
    path.write_bytes(data.draw(broken(wholes[name])))
    try:
        with open_events(path, size=SIZE) as file:
            assert file.format in FORMATS
            for chunk in file:
                assert chunk.events.size <= 1 << 18
    except FormatError as error:
        check_sentence(str(error), path)


def test_a_first_pass_says_that_it_is_at_work(tmp_path: Path, wholes: dict[str, bytes]) -> None:
    path, out = tmp_path / "a.csv", BytesIO()
    path.write_bytes(wholes["a.csv"].split(b"\n", 1)[1])  # without the line of the size
    answer(path, "text", Options(), out)
    assert out.getvalue().startswith(MESSAGE.pack(b"W", 0))


def check_sentence(text: str, path: Path) -> None:
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
            check_sentence(content.decode(), path)
    assert at == len(stream)
    assert kind in (b"X", b"Z")
