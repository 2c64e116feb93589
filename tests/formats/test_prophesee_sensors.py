"""The size of a Prophesee sensor from a header without width and height."""

import re
from pathlib import Path

import numpy as np
import pytest

from flybench.events import Events
from formats import FormatError, open_events, read_events
from formats.columns import ReadOptions
from formats.prophesee_sensors import possible_sizes, stated_size
from formats.readers import reader_of
from tests.formats.sample_files import SIZE, make_file, random_events

E = random_events()


def on_sensor(width: int, height: int) -> Events:
    """Return events in the top left part of a sensor that spans less than 90 % of any other."""
    events = E.copy()
    events["x"] = events["x"].astype(int) * (width - 1) // 345
    events["y"] = events["y"].astype(int) * (height - 1) // 259
    return events


def without_size(folder: Path, name: str, events: Events, header: str) -> Path:
    """Write a file whose header has these lines instead of the size."""
    path = make_file(folder, name, events)
    data = re.sub(
        rb"(?im)^% (height|width|geometry|format|camera_integrator_name)[^\n]*\n",
        b"",
        path.read_bytes(),
    )
    first, rest = data.split(b"\n", 1)
    path.write_bytes(first + b"\n" + header.encode() + rest)
    return path


@pytest.mark.parametrize(
    ("header", "size", "source"),
    [
        ("% plugin_name hal_plugin_gen31_fx3\n", (640, 480), "plugin_name hal_plugin_gen31_fx3"),
        ("% plugin_name hal_plugin_gen3_fx3\n", (640, 480), "plugin_name hal_plugin_gen3_fx3"),
        ("% plugin_name hal_plugin_gen41_evk3\n", (1280, 720), "plugin_name hal_plugin_gen41_evk3"),
        ("% plugin_name hal_plugin_prophesee\n% system_ID 49\n", (1280, 720), "system_ID 49"),
        ("% system_ID 28\n", (640, 480), "system_ID 28"),
        ("% system_ID 64\n", (320, 320), "system_ID 64"),
        ("% sensor_name IMX636\n", (1280, 720), "sensor_name IMX636"),
        ("% sensor_name GenX320\n", (320, 320), "sensor_name GenX320"),
        ("% sensor_generation 4.2\n", (1280, 720), "sensor_generation 4"),
        ("% format EVT3;height=480;width=640\n", (640, 480), "the file"),
        ("% geometry 640x480\n", (640, 480), "the file"),
    ],
)
@pytest.mark.parametrize("name", ["evt2.raw", "evt3.raw", "evt21.raw", "a.dat"])
def test_the_header_implies_the_size(
    tmp_path: Path, name: str, header: str, size: tuple[int, int], source: str
) -> None:
    if header.startswith("% format"):
        header = header.replace("EVT3", name.removesuffix(".raw").upper())
        if name == "a.dat":
            header = "% Height 480\n% Width 640\n"
    if name == "a.dat" and header.startswith("% geometry"):
        pytest.skip("DAT states its size in other lines")
    path = without_size(tmp_path, name, on_sensor(300, 200), header)
    stated, _ = reader_of("dat" if name == "a.dat" else name.removesuffix(".raw"))(
        path, ReadOptions()
    )
    assert stated.size == size
    assert source in stated.size_source


@pytest.mark.parametrize("name", ["evt2.raw", "evt3.raw", "evt21.raw", "a.dat"])
def test_a_file_without_its_size_is_read(tmp_path: Path, name: str) -> None:
    with open_events(without_size(tmp_path, name, E, "% system_ID 28\n")) as file:
        assert (file.width, file.height) == (640, 480)
        assert file.size_source == "the file's system_ID 28"
        assert np.array_equal(np.concatenate([chunk.events for chunk in file]), E)


@pytest.mark.parametrize("name", ["evt2.raw", "a.dat"])
@pytest.mark.parametrize(
    ("date", "extent", "size"),
    [
        ("2016-04-01 12:00:00", (100, 90), (304, 240)),  # as in N-CARS
        ("2017-12-31", (500, 300), (640, 480)),
        ("2020-01-01", (600, 470), (640, 480)),
        ("2020-01-01", (300, 235), (304, 240)),
    ],
)
def test_the_date_and_the_events_show_the_sensor(
    tmp_path: Path, name: str, date: str, extent: tuple[int, int], size: tuple[int, int]
) -> None:
    path = without_size(tmp_path, name, on_sensor(*extent), f"% Date {date}\n")
    with open_events(path) as file:
        assert (file.width, file.height) == size
        assert file.size_source == "the events"


@pytest.mark.parametrize("name", ["evt2.raw", "evt3.raw", "evt21.raw", "a.dat", "a.csv"])
def test_a_size_that_is_too_small_is_said_to_be(tmp_path: Path, name: str) -> None:
    path = make_file(tmp_path, name, E)
    first = int(np.argmax((E["x"] >= 330) | (E["y"] >= 250)))
    message = rf"event {first} has .* given as 330x250, .* larger size with --size"
    got: list[Events] = []
    with open_events(path, size=(330, 250)) as file, pytest.raises(FormatError, match=message):
        got.extend(chunk.events for chunk in file)
    assert np.array_equal(np.concatenate(got), E[:first])


@pytest.mark.parametrize("name", ["evt2.raw", "evt3.raw", "a.dat"])
def test_a_header_with_too_small_a_size_is_said_to_be_wrong(tmp_path: Path, name: str) -> None:
    path = make_file(tmp_path, name, E)
    path.write_bytes(path.read_bytes().replace(b"346", b"100").replace(b"260", b"100"))
    message = r"too small: .*100.*Correct" if name == "evt3.raw" else "0 to 99.*--size"
    with pytest.raises(FormatError, match=message):
        read_events(path)
    if name != "evt3.raw":  # faery checks it against the header
        assert np.array_equal(read_events(path, size=SIZE), E)


def test_unknown_headers_state_nothing() -> None:
    for facts in ({}, {"system_id": "-1"}, {"system_id": "999"}, {"geometry": "x"}):
        assert stated_size(facts) is None
    assert stated_size({"system_id": "28", "camera_integrator_name": "Prophesee"}) is not None
    assert stated_size({"system_id": "28", "camera_integrator_name": "someone else"}) is None
    assert possible_sizes({"date": "unknown"}) == possible_sizes({"date": "2021"}) == ()
