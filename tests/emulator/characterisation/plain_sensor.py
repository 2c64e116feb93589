"""Sensors whose parameters show directly: no noise, no spread, no follower, hardly any reset."""

from dataclasses import replace

from emulator import ApsConfig, ReadoutConfig, preset

PLAIN = replace(
    preset("davis346_2026_11"), noise_sigma=0.0, hot_fraction=0.0, readout=ReadoutConfig()
)
"""A sensor with leak and mismatch, but without noise."""

QUIET = replace(PLAIN, leak_hz=0.0, leak_hz_per_lux=0.0, aps=ApsConfig(noise=False))
"""The same sensor without leak."""
