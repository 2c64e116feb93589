from dataclasses import dataclass

import numpy as np
import pytest

from detector.errors import DetectorConfigError
from detector.parameters import check_numbers


@dataclass(frozen=True)
class Config:
    count: int = 3
    gain: float = 0.5

    def __post_init__(self) -> None:
        check_numbers(self, {"count": (1, 9), "gain": (0.0, 1.0)})


def test_numbers_of_numpy_become_pythons() -> None:
    config = Config(count=np.int64(4), gain=1)  # type: ignore[arg-type]
    assert (type(config.count), type(config.gain)) == (int, float)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"count": 0}, "count is 0; allowed is a whole number from 1 to 9; the default is 3"),
        ({"count": 2.0}, "count is 2.0; allowed is a whole number"),
        ({"count": True}, "count is True"),
        ({"gain": float("nan")}, "gain is nan; allowed is 0 to 1"),
        ({"gain": "1"}, "gain is '1'"),
    ],
)
def test_others_are_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(DetectorConfigError, match=words):
        Config(**values)  # type: ignore[arg-type]
