"""Saved states of a fly: plain arrays by name, and the check that they fit."""

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
"""Arrays without Python objects: `np.savez(path, **state)` keeps it, `pickle` too."""

_FORMAT = 1


def origin(config: FlyConfig, *, width: int, height: int) -> State:
    """What a state must agree with: its format, the parameters as JSON, the sensor's size."""
    return {
        "format": np.array(_FORMAT),
        "config": np.array(json.dumps(asdict(config))),
        "sensor": np.array([width, height]),
    }


def check_origin(state: Mapping[str, npt.NDArray[Any]], expected: State) -> None:
    """Refuse what is no state, and the state of another format, configuration or sensor.

    Raises:
        StateError: it is one.
    """
    if not isinstance(state, Mapping):
        raise StateError(
            f"the state is of type {type(state).__name__}; allowed are arrays by name; pass what "
            "FlyDetector.state() gave, or np.load of the .npz that keeps it"
        )
    for name, array in state.items():
        if not isinstance(array, np.ndarray):
            raise StateError(
                f"{name} of the state is of type {type(array).__name__}; allowed is an array; pass "
                "what FlyDetector.state() gave, whole"
            )
    for name, value in expected.items():
        found = state[name].tolist() if name in state else "missing"
        if found != value.tolist():
            raise StateError(
                f"the state's {name} is {found}; allowed is this detector's own, "
                f"{value.tolist()}; make a detector with the state's configuration and sensor"
            )


def check_arrays(state: Mapping[str, npt.NDArray[Any]], present: State, loose: set[str]) -> None:
    """Refuse a state whose arrays are not of the kind that a detector has now.

    Args:
        state: candidate.
        present: state of the detector that shall take it.
        loose: names of the arrays whose length may differ.

    Raises:
        StateError: a name is missing, or its array has another dtype or shape, or holds what is no
            finite number.
    """
    for name, mine in present.items():
        theirs = state.get(name)
        if theirs is None:
            raise StateError(f"the state has no {name}; pass what FlyDetector.state() gave, whole")
        is_alike = theirs.dtype == mine.dtype and theirs.ndim == mine.ndim
        if not is_alike or (name not in loose and theirs.shape != mine.shape):
            raise StateError(
                f"{name} of the state is {theirs.dtype} of shape {theirs.shape}; allowed is "
                f"{mine.dtype} of shape {mine.shape}; pass what FlyDetector.state() gave, whole"
            )
        if theirs.dtype.kind == "f" and not np.isfinite(theirs).all():
            raise StateError(
                f"{name} of the state holds NaN or infinity; allowed are finite numbers; pass what "
                "FlyDetector.state() gave, unchanged"
            )


def joined(parts: Mapping[str, State]) -> State:
    """One state of several, each name after its part's."""
    return {f"{part}.{name}": a for part, state in parts.items() for name, a in state.items()}


def part_of(state: Mapping[str, npt.NDArray[Any]], part: str) -> State:
    """The arrays of one part, by their own names."""
    start = f"{part}."
    return {name.removeprefix(start): a for name, a in state.items() if name.startswith(start)}
