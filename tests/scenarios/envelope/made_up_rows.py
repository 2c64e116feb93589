"""Made-up rows of an envelope."""

from dataclasses import asdict
from typing import Any

from scenarios.envelope.grid import BASE


def made_up_row(method: str = "m", correct: float | None = 1.0, **changed: Any) -> dict[str, Any]:
    """Return a row of the base point with a share of correct steps, and some values changed."""
    shares = {
        "accuracy_after_100ms": correct,
        "opposite_after_100ms": None if correct is None else 1 - correct,
        "sideways_after_100ms": 0.0,
        "none_after_100ms": 0.0,
    }
    return {"method": method} | asdict(BASE) | shares | changed
