"""Saved states of a fly: named plain arrays, and the checks that they fit a detector."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from detector.errors import StateError
from detector.fly.config import FlyConfig

State = dict[str, npt.NDArray[Any]]
"""Arrays without Python objects; `np.savez(path, **state)` or `pickle` saves them."""

_FORMAT = 3
_REMEDY = "Pass everything that FlyDetector.state() returned, unchanged."


def state_header(config: FlyConfig, *, width: int, height: int) -> State:
    """Return what a state must match: its format, the parameters as JSON, the sensor size."""
    return {
        "format": np.array(_FORMAT),
        "config": np.array(json.dumps(asdict(config))),
        "sensor": np.array([width, height]),
    }


def check_header(state: Mapping[str, npt.NDArray[Any]], expected: State) -> None:
    """Refuse a value that is not a state, or a state of another format, configuration or sensor.

    Raises:
        StateError: the state does not match.
    """
    if not isinstance(state, Mapping):
        raise StateError(
            f"The state is of type {type(state).__name__}. Allowed are arrays by name. Pass what "
            "FlyDetector.state() returned, or np.load of the .npz file that it was saved to."
        )
    for name, array in state.items():
        if not isinstance(array, np.ndarray):
            raise StateError(
                f"{name} of the state is of type {type(array).__name__}. Allowed is an array. "
                f"{_REMEDY}"
            )
    for name, value in expected.items():
        found = state[name].tolist() if name in state else "missing"
        if found != value.tolist():
            raise StateError(
                f"{name} of the state is {found}. Allowed is that of this detector, "
                f"{value.tolist()}. Make a detector with the configuration and sensor of the state."
            )


def check_arrays(
    state: Mapping[str, npt.NDArray[Any]], expected: State, any_length: set[str]
) -> None:
    """Refuse a state whose arrays differ from a detector's own in name, dtype or shape.

    Args:
        state: candidate.
        expected: present state of the detector that is to take it.
        any_length: names of the arrays whose length may differ.

    Raises:
        StateError: an array is missing, has another dtype or shape, or contains NaN or infinity.
    """
    for name, own in expected.items():
        given = state.get(name)
        if given is None:
            raise StateError(f"The state has no {name}. {_REMEDY}")
        is_alike = given.dtype == own.dtype and given.ndim == own.ndim
        if not is_alike or (name not in any_length and given.shape != own.shape):
            raise StateError(
                f"{name} of the state is {given.dtype} of shape {given.shape}. Allowed is "
                f"{own.dtype} of shape {own.shape}. {_REMEDY}"
            )
        if given.dtype.kind == "f" and not np.isfinite(given).all():
            raise StateError(
                f"{name} of the state contains NaN or infinity. Allowed are finite numbers. "
                f"{_REMEDY}"
            )


def join_parts(parts: Mapping[str, State]) -> State:
    """Return one state of several parts; each name begins with that of its part."""
    return {f"{part}.{name}": a for part, state in parts.items() for name, a in state.items()}


def part_of(state: Mapping[str, npt.NDArray[Any]], part: str) -> State:
    """Return the arrays of one part, by their names within it."""
    prefix = f"{part}."
    return {name.removeprefix(prefix): a for name, a in state.items() if name.startswith(prefix)}
