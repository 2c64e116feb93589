from dataclasses import replace
from typing import Any

import pytest

from sim import CrossingConfig, SceneConfigError, omega_from_speed
from sim.config import DEFAULT_DISTANCE_M, Lighting


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("omega_rad_s", -1.0),
        ("omega_rad_s", 0.0),
        ("omega_rad_s", float("nan")),
        ("lighting", "twilight"),
        ("direction", "north"),
        ("profile", "sine"),
        ("distance_m", 0.5),
        ("illuminance_lux", 0.0),
        ("illuminance_lux", 1e6),
        ("lead_s", -1.0),
        ("step_px", 0.0),
        ("max_step_ms", 100.0),
        ("supersample", 0),
        ("supersample", 2.5),
        ("omega_rad_s", "fast"),
        ("step_px", True),
        ("keyframe_px", 128.0),
    ],
)
def test_a_message_names_value_and_range(field: str, value: Any) -> None:
    with pytest.raises(SceneConfigError) as refusal:
        CrossingConfig(**{field: value})
    message = str(refusal.value)
    assert field in message
    assert str(value) in message
    assert "Allowed is" in message


def test_names_from_the_command_line_become_members() -> None:
    config = CrossingConfig(lighting="night", direction="up")  # type: ignore[arg-type]
    assert config.lighting is Lighting.NIGHT
    assert config.distance == DEFAULT_DISTANCE_M[Lighting.NIGHT]


@pytest.mark.parametrize(
    ("lighting", "omegas"),
    [(Lighting.DAY, (1.21, 1.61, 2.01, 2.42)), (Lighting.NIGHT, (1.07, 1.42, 1.78, 2.14))],
)
def test_the_distances_give_the_papers_angular_velocities(
    lighting: Lighting, omegas: tuple[float, ...]
) -> None:
    found = [omega_from_speed(v, DEFAULT_DISTANCE_M[lighting]) for v in (30, 40, 50, 60)]
    assert found == pytest.approx(omegas, abs=0.01)


def test_what_the_lighting_gives_follows_the_lighting() -> None:
    night = replace(CrossingConfig(), lighting=Lighting.NIGHT)
    assert night.distance == 7.79
    assert night.illuminance == 10.0
    assert night.resolved()["distance_m"] == 7.79
    assert replace(CrossingConfig(distance_m=5.0), lighting=Lighting.NIGHT).distance == 5.0


def test_a_draft_doubles_the_distance_of_keyframes() -> None:
    assert CrossingConfig(quality="draft").drawn_keyframe_px == 64.0  # type: ignore[arg-type]
    with pytest.raises(SceneConfigError, match=r"keyframe_px is 64.0 in a draft.*1 to 32 px"):
        CrossingConfig(quality="draft", keyframe_px=64.0)  # type: ignore[arg-type]
