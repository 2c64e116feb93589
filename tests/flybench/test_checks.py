"""Checks of configuration values."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
import pytest

from flybench.checks import Range, check_ranges, member
from flybench.errors import FlybenchError


class ConfigError(FlybenchError):
    pass


class Colour(StrEnum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Config:
    count: int = 3
    gain: float = 0.5
    width_m: float | None = None

    def __post_init__(self) -> None:
        ranges = {
            "count": Range(1, 9, remedy="Give whole cells."),
            "gain": Range(0.0, 1.0),
            "width_m": Range(1.0, 2.0, "m", optional=True),
        }
        check_ranges(self, ranges, ConfigError)


def test_numpy_numbers_become_python_numbers() -> None:
    config = Config(count=np.int64(4), gain=1, width_m=np.float32(1.5))  # type: ignore[arg-type]
    assert [type(v) for v in (config.count, config.gain, config.width_m)] == [int, float, float]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"count": 0},
            "count is 0. Allowed is a whole number from 1 to 9. "
            "Give whole cells. The default is 3.",
        ),
        (
            {"count": 2.0},
            "count is 2.0. Allowed is a whole number from 1 to 9. "
            "Give whole cells. The default is 3.",
        ),
        (
            {"gain": float("nan")},
            "gain is nan. Allowed is a number from 0 to 1. The default is 0.5.",
        ),
        (
            {"width_m": 3},
            "width_m is 3. Allowed is a number from 1 to 2 m. Choose a value in that range.",
        ),
    ],
)
def test_a_message_names_value_range_and_remedy(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as refused:
        Config(**values)
    assert str(refused.value) == message


@pytest.mark.parametrize("values", [{"count": True}, {"gain": "1"}, {"count": None}])
def test_other_types_are_refused(values: dict[str, Any]) -> None:
    with pytest.raises(ConfigError):
        Config(**values)


def test_a_member_is_found_by_its_value() -> None:
    assert member(Colour, "paint", "red", ConfigError) is Colour.RED


@pytest.mark.parametrize("value", ["green", "blue", 3, None])
def test_a_value_that_is_no_member_is_refused(value: Any) -> None:
    with pytest.raises(ConfigError, match=r"paint is .*Allowed is one of red\."):
        member(Colour, "paint", value, ConfigError, without=(Colour.BLUE,))
