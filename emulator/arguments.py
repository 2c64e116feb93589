"""Checks of what several functions take: a sensor, a seed, a number of threads."""

from __future__ import annotations

from numbers import Integral
from typing import Any

from emulator.config import SensorConfig
from emulator.errors import SensorConfigError

THREADS_MAX = 64
"""Most threads that a sensor takes (assumed: more than any of them can use)."""


def check_config(config: Any) -> SensorConfig:
    """Refuse what is no sensor.

    Raises:
        SensorConfigError: it is no `SensorConfig`.
    """
    if not isinstance(config, SensorConfig):
        raise SensorConfigError(
            f"the sensor is {config!r}; allowed is a SensorConfig; make one, or take one by "
            "name with preset, such as preset('davis346')"
        )
    return config


def check_seed(seed: Any) -> int:
    """Refuse what cannot seed anything; returns a Python integer.

    Raises:
        SensorConfigError: it is negative or no integer.
    """
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise SensorConfigError(
            f"the seed is {seed!r}; allowed is a whole number from 0; choose one, such as 1"
        )
    return int(seed)


def check_threads(threads: Any) -> int:
    """Refuse what is no number of threads; returns a Python integer.

    Raises:
        SensorConfigError: it is no integer from 1 to `THREADS_MAX`.
    """
    whole = isinstance(threads, Integral) and not isinstance(threads, bool)
    if not whole or not 1 <= threads <= THREADS_MAX:
        raise SensorConfigError(
            f"threads is {threads!r}; allowed is a whole number from 1 to {THREADS_MAX}; "
            "give one for each core that the sensor may use"
        )
    return int(threads)
