from dataclasses import FrozenInstanceError
from typing import Any

import pytest

from emulator import ApsConfig, ReadoutConfig, ReadoutKind, SensorConfig, SensorConfigError


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("width", 0),
        ("width", 3.5),
        ("height", 40_000),
        ("theta_on", 0.0),
        ("theta_off", -0.2),
        ("theta_on", float("nan")),
        ("theta_mismatch", -0.1),
        ("dark_lux", 0.0),
        ("f_number", 0.0),
        ("transmission", 1.1),
        ("refractory_us", -1),
        ("refractory_us", 2.5),
        ("leak_hz", -0.1),
        ("leak_hz_per_lux", -1e-5),
        ("leak_spread", 3.1),
        ("leak_tail_fraction", 1.1),
        ("leak_tail_spread", -0.1),
        ("dark_current_spread", float("nan")),
        ("hot_fraction", 1.5),
        ("hot_hz_max", 10.0),
        ("noise_sigma", "much"),
        ("bandwidth_limit_hz", True),
        ("follower_hz", -1.0),
        ("temperature_c", 500.0),
        ("dark_doubling_k", 0.0),
        ("leak_doubling_k", -7.0),
        ("dead_fraction", 2.0),
        ("crazy_fraction", -0.1),
        ("crazy_hz_max", 1.0),
        ("pixel_pitch_um", 0.0),
        ("focal_length_mm", -6.0),
    ],
)
def test_a_value_out_of_range_is_named_in_the_message(name: str, value: Any) -> None:
    with pytest.raises(
        SensorConfigError, match=rf"{name} is {value!r}\. Allowed is a .*number from"
    ):
        SensorConfig(**{name: value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("exposure_us", 0),
        ("exposure_max_us", 5),
        ("target_dn", 700.0),
        ("saturation_dn", 1024),
        ("fixed_pattern", -0.1),
    ],
)
def test_an_aps_value_out_of_range_is_named_in_the_message(name: str, value: Any) -> None:
    with pytest.raises(SensorConfigError, match=f"{name} is {value!r}"):
        ApsConfig(**{name: value})


def test_noise_free_changes_only_the_noise() -> None:
    clean, real = SensorConfig.noise_free(), SensorConfig()
    assert (clean.theta_on, clean.theta_mismatch) == (real.theta_on, real.theta_mismatch)
    assert clean.bandwidth_limit_hz == real.bandwidth_limit_hz
    assert (clean.leak_hz, clean.leak_hz_per_lux, clean.noise_sigma) == (0.0, 0.0, 0.0)
    assert clean.hot_fraction == 0.0
    assert not clean.aps.noise


def test_a_configuration_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        SensorConfig().width = 10  # type: ignore[misc]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"limit_hz": 0.0}, "limit_hz is 0.0. Allowed is a number from 1 to 1e"),
        ({"latency_us": 0.5}, "latency_us is 0.5. Allowed is a whole number"),
        ({"scan_period_us": 0}, "scan_period_us is 0. Allowed is a whole number from 1"),
        ({"kind": "frame"}, "kind is 'frame'. Allowed is one of row_arbiter, round_robin, scan"),
        ({"lines": "x"}, "lines is 'x'. Allowed is one of rows, columns"),
        ({"line_words": 1.5}, "line_words is 1.5. Allowed is a whole number"),
    ],
)
def test_a_readout_value_out_of_range_is_named_in_the_message(
    changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(SensorConfigError, match=words):
        ReadoutConfig(**changes)


def test_the_kind_of_the_readout_may_be_given_by_its_name() -> None:
    assert ReadoutConfig(kind="scan").kind is ReadoutKind.SCAN  # type: ignore[arg-type]


def test_the_focal_length_in_pixels_follows_from_lens_and_pixel_pitch() -> None:
    assert SensorConfig().focal_length_px == 6.0e-3 / 18.5e-6
    assert SensorConfig(focal_length_mm=12.0, pixel_pitch_um=4.0).focal_length_px == 3000.0


def test_parts_of_a_wrong_type_are_refused() -> None:
    with pytest.raises(
        SensorConfigError, match=r"aps is None\. Allowed is a value of type ApsConfig"
    ):
        SensorConfig(aps=None)  # type: ignore[arg-type]
    with pytest.raises(
        SensorConfigError, match=r"readout is 1\. Allowed is a value of type Readout"
    ):
        SensorConfig(readout=1)  # type: ignore[arg-type]
    with pytest.raises(SensorConfigError, match=r"noise is 'no'\. Allowed is True or False"):
        ApsConfig(noise="no")  # type: ignore[arg-type]


def test_a_leak_too_high_at_the_given_temperature_is_refused() -> None:
    assert SensorConfig(temperature_c=85.0).warm_leak_hz < 100.0
    with pytest.raises(SensorConfigError, match=r"warm_leak_hz is .* from 0 to 10000\. Lower"):
        SensorConfig(temperature_c=150.0, leak_doubling_k=5.0)
