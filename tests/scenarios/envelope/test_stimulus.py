"""The description of a synthetic stimulus."""

import math

import pytest

from flybench.direction import Direction
from scenarios.envelope.stimulus import Stimulus
from scenarios.errors import ScenarioError


def test_the_height_follows_from_the_length() -> None:
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
        ("length_px", 50.5),
        ("tilt_deg", 45.0),
        ("tilt_deg", math.nan),
        ("events_per_edge", 0),
        ("events_per_edge", 1.5),
        ("seed", -1),
        ("seed", 1.5),
        ("width", 0),
        ("height", 5000),
        ("contrast", "high"),
    ],
)
def test_a_value_out_of_range_is_refused(name: str, value: object) -> None:
    with pytest.raises(ScenarioError, match=f"{name} is .*{value}.*Allowed is"):
        Stimulus(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "value", "remedy"),
    [
        ("direction", "right", "Direction.RIGHT"),
        ("surface", "saloon", "Surface.PANELS"),
        ("background", "wind", "Background.STILL"),
    ],
)
def test_a_string_instead_of_a_member_is_refused(name: str, value: str, remedy: str) -> None:
    with pytest.raises(ScenarioError, match=f"{name} is '{value}', a str.*{remedy}"):
        Stimulus(**{name: value})  # type: ignore[arg-type]


def test_a_target_without_a_direction_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"'none'\. Allowed is right"):
        Stimulus(direction=Direction.NONE)
