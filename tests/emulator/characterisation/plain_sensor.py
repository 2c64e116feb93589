"""Sensors whose parameters show directly: no noise, no spread, no follower, hardly any reset."""

from emulator import ApsConfig, SensorConfig

PLAIN = SensorConfig(
    theta_on=0.18,
    theta_off=0.22,
    theta_mismatch=0.035,
    follower_hz=0.0,
    refractory_us=3,
    leak_hz=0.1,
    leak_hz_per_lux=2.4e-5,
    leak_spread=0.0,
    leak_tail_fraction=0.0,
    noise_sigma=0.0,
    dark_current_spread=0.0,
)
"""A sensor with leak and mismatch, but without noise."""

QUIET = SensorConfig(
    theta_on=0.18,
    theta_off=0.22,
    theta_mismatch=0.035,
    follower_hz=0.0,
    refractory_us=3,
    leak_hz=0.0,
    leak_hz_per_lux=0.0,
    noise_sigma=0.0,
    dark_current_spread=0.0,
    aps=ApsConfig(noise=False),
)
"""The same sensor without leak."""
