"""A noise-free sensor gives no events while nothing in the scene moves."""

import pytest

from emulator import EventSensor, SensorConfig
from sim import Crossing, CrossingConfig, Lighting


@pytest.mark.parametrize("lighting", list(Lighting))
def test_a_static_scene_without_noise_gives_no_events(lighting: Lighting) -> None:
    crossing = Crossing(CrossingConfig(lighting=lighting))
    sensor = EventSensor(SensorConfig.noise_free(), seed=0)
    with crossing.full_frame_renderer() as render:
        middle_us = crossing.duration_us // 2
        frames = [render(middle_us).copy() for _ in range(4)]
        moved = render(middle_us + 20_000)
        outputs = [sensor.step(k * 5_000, frames[k % len(frames)]) for k in range(20)]
    assert sum(output.events.size for output in outputs) == 0
    assert sensor.step(105_000, moved).events.size > 100
