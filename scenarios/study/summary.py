"""The results of a study as plain values, for `summary.json`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from scenarios.study.claims.all_claims import evaluate_claims
from scenarios.study.claims.claim import Claim
from scenarios.study.conditions import (
    HIGH_THRESHOLDS,
    moving_background_rows,
    paper_rows,
    second_sensor_rows,
)
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, by_method_and_lighting, distinct, select


def summarise(rows: Sequence[Row], claims: Sequence[Claim]) -> dict[str, Any]:
    """Return statistics and verdicts for the paper's sequences, and for each other condition.

    Args:
        rows: the table of all backgrounds and sensors.
        claims: verdicts with the default sensor.
    """
    return {
        "statistics": _statistics(paper_rows(rows)),
        "claims": [asdict(claim) for claim in claims],
        "moving_backgrounds": {
            background: _statistics(select(rows, background=background))
            for background in distinct(moving_background_rows(rows), "background")
        },
        "second_sensor": {
            "statistics": _statistics(second_sensor_rows(rows)),
            "claims": [asdict(claim) for claim in evaluate_claims(rows, HIGH_THRESHOLDS)],
        },
    }


def _statistics(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the interval of every measure, by method and lighting."""
    return {
        method: {
            lighting: {name: _plain(value) for name, value in found.items()}
            for lighting, found in by_lighting.items()
        }
        for method, by_lighting in by_method_and_lighting(rows).items()
    }


def _plain(interval: Interval | None) -> dict[str, float] | None:
    return None if interval is None else asdict(interval)
