from dataclasses import fields
from typing import Any

import pytest

from sim import CrossingConfig, SceneConfigError
from sim.distractors import Distractors, Pavement, RelativeDirection, VehicleKind


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("wind_grade", 9),
        ("wind_grade", 2.5),
        ("wind_grade", -1),
        ("far_vehicle", "left"),
        ("far_vehicle_kind", "tram"),
        ("far_vehicle_speed_m_s", 0.0),
        ("far_vehicle_reflectance", 0.01),
        ("pedestrian", "yes"),
        ("pedestrian_pavement", "middle"),
        ("pedestrian_speed_m_s", 4.0),
        ("pedestrian_lag_s", float("nan")),
        ("shake_rms_deg", -0.1),
        ("shake_corner_hz", 0.0),
        ("flicker_hz", 50),
        ("flicker_depth", 1.5),
        ("seed", -1),
    ],
)
def test_a_message_names_value_range_and_remedy(field: str, value: Any) -> None:
    with pytest.raises(SceneConfigError) as refusal:
        Distractors(**{field: value})
    message = str(refusal.value)
    assert field in message
    assert str(value) in message
    assert "Allowed is" in message
    assert message.count(". ") >= 2


def test_by_default_nothing_else_moves() -> None:
    extra = Distractors()
    assert extra.wind_grade == 0
    assert extra.far_vehicle is extra.pedestrian is RelativeDirection.NONE
    assert not extra.shakes
    assert not extra.flickers


def test_names_from_the_command_line_become_members() -> None:
    extra = Distractors(
        far_vehicle="same",  # type: ignore[arg-type]
        far_vehicle_kind="van",  # type: ignore[arg-type]
        pedestrian_pavement="near",  # type: ignore[arg-type]
    )
    assert extra.far_vehicle is RelativeDirection.SAME
    assert extra.far_vehicle_kind is VehicleKind.VAN
    assert extra.pedestrian_pavement is Pavement.NEAR


def test_every_field_is_documented() -> None:
    for field in fields(Distractors):
        assert f"{field.name}: " in str(Distractors.__doc__)


def test_a_pedestrian_on_the_near_pavement_needs_more_distance() -> None:
    near = Distractors(pedestrian=RelativeDirection.SAME, pedestrian_pavement=Pavement.NEAR)
    with pytest.raises(SceneConfigError, match=r"distance_m is 3\.5.*near pavement.*Allowed is 4"):
        CrossingConfig(distance_m=3.5, distractors=near)
    CrossingConfig(distance_m=4.5, distractors=near)
    CrossingConfig(distance_m=3.5, distractors=Distractors(pedestrian=RelativeDirection.SAME))
