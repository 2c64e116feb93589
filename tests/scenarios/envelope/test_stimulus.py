import math

import pytest

from detector.estimate import Direction
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import ScenarioError


def test_the_base_point_is_a_stimulus() -> None:
    assert Stimulus().height_px == 48


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("speed_px_s", 0.0),
        ("speed_px_s", math.nan),
        ("noise_hz", -1.0),
        ("noise_hz", math.inf),
        ("contrast", -0.1),
        ("length_px", 3),
        ("seed", -1),
    ],
)
def test_a_value_out_of_range_is_refused(name: str, value: float) -> None:
    with pytest.raises(ScenarioError, match=f"{name} of a drawn stimulus is {value}; allowed is"):
        Stimulus(**{name: value})  # type: ignore[arg-type]


def test_a_target_goes_somewhere() -> None:
    with pytest.raises(ScenarioError, match="'none'; allowed is right"):
        Stimulus(direction=Direction.NONE)
