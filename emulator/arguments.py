"""Checks of arguments that several functions take: a sensor, a seed, a number of threads."""

from __future__ import annotations

from numbers import Integral
from typing import Any

from emulator.config import SensorConfig
from emulator.errors import SensorConfigError
from flybench.checks import Range

THREADS_MAX = 64
"""Largest number of threads of a sensor (assumed: more than any sensor can use)."""

_THREADS = Range(1, THREADS_MAX, remedy="Give one for each core that the sensor may use.")


def check_config(config: Any) -> SensorConfig:
    """Return the configuration of a sensor if it is one.

    Raises:
        SensorConfigError: it is no `SensorConfig`.
    """
    if not isinstance(config, SensorConfig):
        raise SensorConfigError(
            f"the sensor is {config!r}. Allowed is a SensorConfig. Make one, or take a known one "
            "by its name, such as preset('davis346')."
        )
    return config


def check_seed(seed: Any) -> int:
    """Return the seed as a Python integer if it is valid.

    Raises:
        SensorConfigError: it is negative or no integer.
    """
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise SensorConfigError(
            f"the seed is {seed!r}. Allowed is a whole number from 0. Choose one, such as 1."
        )
    return int(seed)


def check_threads(threads: Any) -> int:
    """Return the number of threads as a Python integer if it is valid.

    Raises:
        SensorConfigError: it is no integer from 1 to `THREADS_MAX`.
    """
    return int(_THREADS.check("threads", threads, SensorConfigError))
