"""Detector parameters scaled to another sensor or speed."""

from typing import Any

import pytest

from detector.errors import DetectorConfigError
from detector.fly.config import FlyConfig
from flybench.direction import Direction
from scenarios.errors import ScenarioError
from scenarios.pipeline.scaled_detectors import make_scaled
from tests.detector.moving_dots import texture


def config_of(method: str, **options: Any) -> Any:
    made = make_scaled(method, width=692, height=520, **options)
    config: Any = getattr(made.detector, "config", None)
    return config


def test_nothing_is_scaled_by_default() -> None:
    made = make_scaled("fly", width=1280, height=720)
    assert made.changes == {}
    assert config_of("fly") == FlyConfig()


def test_lengths_in_the_image_are_scaled_by_the_sensors_width() -> None:
    made = make_scaled("fly", width=692, height=520, to_sensor=True)
    assert made.changes == {"cell_px": 6, "roi_radius_px": 100}
    assert config_of("plane-fit", to_sensor=True).limit_px_s == 3000.0
    assert config_of("plane-fit", to_sensor=True).radius_px == 2  # a length on the chip
    assert config_of("frame-fly-coarse", to_sensor=True).cell_px == 6


def test_times_stay_multiples_of_the_hop() -> None:
    config = config_of("wide", time_scale=0.3333)
    assert config.hop_us == 3333
    assert config.window_us == 5 * 3333
    assert config.further_delays_us == (10 * 3333, 20 * 3333)
    assert config.tau_us == 3 * 3333
    assert config_of("contrast-maximisation", time_scale=2.0).limit_px_s == 750.0


def test_a_scaled_fly_finds_the_same_directions_on_a_larger_sensor() -> None:
    events = texture(400.0, Direction.DOWN, most=60_000)
    large = events.copy()
    large["x"], large["y"] = 2 * events["x"], 2 * events["y"]
    own = make_scaled("fly", width=346, height=260).detector.push(events)
    scaled = make_scaled("fly", width=692, height=520, to_sensor=True).detector.push(large)
    assert [e.direction for e in scaled] == [e.direction for e in own]
    assert [e.vs for e in scaled] == pytest.approx([e.vs for e in own], abs=1e-3)


@pytest.mark.parametrize("scale", [float("nan"), -1.0, 1e6])
def test_a_scale_out_of_range_is_refused(scale: float) -> None:
    with pytest.raises(ScenarioError, match="The default is 1, which leaves times unchanged"):
        make_scaled("fly", width=346, height=260, time_scale=scale)


def test_a_sensor_too_large_for_scaling_is_refused() -> None:
    with pytest.raises(DetectorConfigError, match="cell_px is"):
        make_scaled("fly", width=30_000, height=30_000, to_sensor=True)


def test_a_users_class_cannot_be_scaled() -> None:
    method = "tests.scenarios.sweep.quick_sweep:FailingDetector"
    with pytest.raises(ScenarioError, match="whose parameters cannot be scaled"):
        make_scaled(method, width=692, height=520, to_sensor=True)
