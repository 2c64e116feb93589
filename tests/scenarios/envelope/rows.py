"""Rows as `measure` gives them, made up."""

from dataclasses import asdict
from typing import Any

from scenarios.envelope.grid import BASE


def row(method: str = "m", right: float | None = 1.0, **changed: Any) -> dict[str, Any]:
    shares = {
        "accuracy_after_100ms": right,
        "opposite_after_100ms": None if right is None else 1 - right,
        "sideways_after_100ms": 0.0,
        "none_after_100ms": 0.0,
    }
    return {"method": method} | asdict(BASE) | shares | changed
