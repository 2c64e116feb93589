"""One claim of the paper and its verdict; `all_claims` lists them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from scenarios.pipeline.registry import FLOORLESS_FRAME_FLY, FRAME_FLY
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, each, interval_of, select

Verdict = Literal["holds", "holds in part", "does not hold", "not tested"]
MOST_STEPS = 0.95
"""A method is right throughout where this share of its steps is: the envelope's bound."""
DAY, NIGHT = "day", "night"


@dataclass(frozen=True)
class Claim:
    """One claim of the paper, and what the study says of it.

    Attributes:
        statement: the claim, in our words.
        where: section or figure of the paper that makes it.
        holds: whether it does here.
        evidence: why, a sentence with numbers.
    """

    statement: str
    where: str
    holds: Verdict
    evidence: str


def graded(share: float) -> Verdict:
    """All of the cases, some, or none."""
    if share >= 1.0:
        return "holds"
    return "holds in part" if share > 0.0 else "does not hold"


def not_tested(statement: str, where: str, missing: str) -> Claim:
    """A claim for which the study lacks what it needs."""
    return Claim(statement, where, "not tested", f"The study has {missing}.")


def paper_frame_fly(rows: Sequence[Row]) -> str:
    """The frame-based fly that is as published: without our floor, where that one ran."""
    ran = each(rows, "method")
    return FLOORLESS_FRAME_FLY if FLOORLESS_FRAME_FLY in ran else FRAME_FLY


def by_sequence(rows: Sequence[Row], column: str) -> dict[str, Interval | None]:
    """A column's mean over the seeds, with its confidence, by sequence."""
    return {
        name: interval_of(select(rows, sequence=name), column) for name in each(rows, "sequence")
    }


def slowest_first(rows: Sequence[Row]) -> list[str]:
    """Names of the rows' sequences, by angular velocity."""
    return each(sorted(rows, key=lambda row: float(row["omega_rad_s"])), "sequence")


def told(interval: Interval | None, unit: str = "", *, digits: int = 3) -> str:
    """A mean and its 95 % interval in words; "%" makes a share a percentage."""
    if interval is None:
        return "nothing"
    scale = 100.0 if unit == "%" else 1.0
    mean, low, high = (
        f"{scale * v:.{digits}g}" for v in (interval.mean, interval.low, interval.high)
    )
    space = " " if unit else ""
    if interval.number == 1:
        return f"{mean}{space}{unit}"
    return f"{mean}{space}{unit} ({low} to {high})"
