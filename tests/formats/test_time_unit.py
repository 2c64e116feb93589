"""Decide the unit of timestamps."""

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formats import FormatError, open_events, read_events
from formats.time_unit import choose_unit, to_microseconds, unit_us
from tests.formats.sample_files import FILE_MAKERS, SIZE, make_file, random_events

PATH = Path("a.npy")
US: Any = np.sort(np.random.default_rng(0).integers(0, 500_000, 20_000)) + 123
"""Times of a recording with 40,000 events/s [µs]."""

STEPS: Any = np.repeat(np.unique(US[:2000] // 5), 100)
"""Steps at various intervals, with 100 events each."""


def chosen(times: Any, stated: str | None = None) -> tuple[str, str]:
    unit = choose_unit(times, option=None, stated=stated, source="as it says", path=PATH)
    return unit.name, unit.warning


@pytest.mark.parametrize(
    ("times", "unit"),
    [
        (US, "us"),
        (US.astype(np.float64), "us"),
        (US.astype(np.float32), "us"),
        (US.astype(np.uint32), "us"),
        (US * 1000, "ns"),
        (US * 1000.0, "ns"),
        (US * 1000 + 1_700_000_000_123_456_789, "ns"),
        (US * 70_000 + np.arange(US.size), "ns"),  # in µs there would be 0.6 events/s
        (US / 1e6, "s"),
        (US / 1e6 + 1.7e9, "s"),
        (US / 1e3, "ms"),
        (US[:0], "us"),
        (US[:1], "us"),
        (np.zeros(1000, np.int64), "us"),
        (np.arange(1000) * 50, "us"),  # the same intervals everywhere: not of a camera
        (np.array([0.0, 1e6, 5e6]), "us"),
        (np.array([0.5, 1e6, 5e6]), "s"),
    ],
)
def test_values_decide_the_unit_without_a_warning(times: Any, unit: str) -> None:
    assert chosen(times) == (unit, "")


@pytest.mark.parametrize(
    ("times", "unit", "warning"),
    [
        (STEPS * 1000, "us", "multiples of 1000.*--time-unit: ns"),
        (STEPS / 1000, "s", "three decimals.*--time-unit: ms"),
        (np.repeat(np.arange(300), 50), "us", "count up from 0 or 1.*--time-unit: .*1/30s"),
        (US * 1999, "us", "gives 20 events.*In ns there would be 20,0.*--time-unit ns"),
        (US * 10, "us", "gives 4,000 events per second.*--time-unit ns"),
        (US * 10**11, "us", "read in µs.*events per second.*--time-unit"),
    ],
)
def test_what_is_uncertain_is_a_warning(times: Any, unit: str, warning: str) -> None:
    name, text = chosen(times)
    assert name == unit
    assert re.search(warning, text)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (np.repeat(np.arange(300), 1000), "from 0 to 65, which are ms or frame numbers.*1/30s"),
        (US + 0.25, "may be ms or µs.*--time-unit"),
    ],
)
def test_units_that_the_values_do_not_decide_are_refused(times: Any, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        chosen(times)


def test_a_stated_unit_is_taken_and_an_implausible_rate_is_a_warning() -> None:
    assert chosen(US, "us") == ("us", "")
    name, warning = chosen(US * 1_000_000, "us")
    assert name == "us"
    assert "0.04 events per second" in warning


def test_a_unit_may_count_steps() -> None:
    assert unit_us("1/30s") == Fraction(10**6, 30)
    assert unit_us("33.3 ms") == 33_300
    assert unit_us("µs") == 1
    for wrong in ("min", "0s", "1/0s", "-1s", "", "1e3s"):
        with pytest.raises(FormatError, match=r"Allowed is one of s, ms, us, ns"):
            unit_us(wrong)
    times = np.array([0, 1, 3])
    assert to_microseconds(times, "1/30s", path=PATH).tolist() == [0, 33_333, 100_000]
    assert to_microseconds(times, "ms", path=PATH).tolist() == [0, 1000, 3000]
    assert to_microseconds(times * 1999, "ns", path=PATH).tolist() == [0, 1, 5]


@pytest.mark.parametrize("time", [float("nan"), float("inf"), 1e20])
def test_times_that_are_too_large_are_refused(time: float) -> None:
    for unit in ("s", "us"):
        with pytest.raises(FormatError, match="not a finite number"):
            to_microseconds(np.array([1.0, time]), unit, path=PATH)
    with pytest.raises(FormatError, match="not a finite number"):
        to_microseconds(np.array([10**17]), "s", path=PATH)


@pytest.mark.parametrize("name", FILE_MAKERS)
def test_every_format_takes_another_unit(tmp_path: Path, name: str) -> None:
    events = random_events()
    path = make_file(tmp_path, name, events)
    with open_events(path, size=SIZE, time_unit="ms") as file:
        assert file.header_fields["time unit"] == "ms, from --time-unit"
        got = np.concatenate([chunk.events["t"] for chunk in file])
    ratio = 1e-3 if name == "a.txt" else 1e3  # its times are in seconds
    assert np.allclose(got, events["t"] * ratio, atol=0.5)


def test_whole_seconds_that_flybench_wrote_as_text_are_read_back(tmp_path: Path) -> None:
    events = random_events(500)
    events["t"] = np.arange(500) * 1_000_000
    for part in (events, events[:5]):
        assert np.array_equal(read_events(make_file(tmp_path, "a.txt", part)), part)


def test_files_with_other_units_are_read_as_recorded(tmp_path: Path) -> None:
    events = random_events(5000)
    for k, factor in enumerate((1.0, 1000, 1e-6, 1e-3)):
        path = tmp_path / f"{k}.npz"
        columns: Any = {name: events[name] for name in "xyp"}
        np.savez(path, t=events["t"] * factor, **columns)
        assert np.array_equal(read_events(path, size=SIZE), events)
