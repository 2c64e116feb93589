"""A claim of the paper and its verdict; `all_claims` lists all claims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from scenarios.output.numbers import plain_number
from scenarios.pipeline.registry import FLOORLESS_FRAME_FLY, FRAME_FLY
from scenarios.study.claims.small_table import SmallTable
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, distinct, interval_of, select

Verdict = Literal["holds", "holds in part", "does not hold", "not tested"]
NEARLY_ALL = 0.95
"""Share of correct steps from which a method counts as reliable, as in the envelope."""
DAY, NIGHT = "day", "night"


@dataclass(frozen=True)
class Claim:
    """One claim of the paper and the verdict of the study.

    Attributes:
        statement: the claim, in our words.
        where: section or figure of the paper that makes the claim.
        holds: verdict.
        evidence: reason for the verdict, one sentence or two with numbers.
        tables: the numbers behind the evidence; there may be none.
    """

    statement: str
    where: str
    holds: Verdict
    evidence: str
    tables: tuple[SmallTable, ...] = ()


def verdict_from_share(share: float) -> Verdict:
    """Return the verdict for the share of cases in which a claim holds."""
    if share >= 1.0:
        return "holds"
    return "holds in part" if share > 0.0 else "does not hold"


def not_tested(statement: str, where: str, missing: str) -> Claim:
    """Return a claim that the study cannot test, with what is missing as evidence."""
    return Claim(statement, where, "not tested", f"The study has {missing}.")


def published_frame_fly(rows: Sequence[Row]) -> str:
    """Return the method that is closest to the published frame-based fly.

    It is the one without our floor on the signal-to-noise ratio, if that one ran.
    """
    ran = distinct(rows, "method")
    return FLOORLESS_FRAME_FLY if FLOORLESS_FRAME_FLY in ran else FRAME_FLY


def mean_by_sequence(rows: Sequence[Row], column: str) -> dict[str, Interval | None]:
    """Return the mean of a column over the seeds and its confidence interval, by sequence."""
    return {
        name: interval_of(select(rows, sequence=name), column)
        for name in distinct(rows, "sequence")
    }


def slowest_first(rows: Sequence[Row]) -> list[str]:
    """Return the names of the sequences, sorted by angular velocity."""
    return distinct(sorted(rows, key=lambda row: float(row["omega_rad_s"])), "sequence")


def format_interval(interval: Interval | None, unit: str = "", *, digits: int = 3) -> str:
    """Format a mean and its 95 % interval, unless this is one number in so many digits.

    The unit "%" turns a share into a percentage.
    """
    if interval is None:
        return "no value"
    mean, low, high = (
        _scaled(v, unit, digits) for v in (interval.mean, interval.low, interval.high)
    )
    space = " " if unit else ""
    if interval.number == 1 or low == high:
        return f"{mean}{space}{unit}"
    return f"{mean}{space}{unit} ({low} to {high})"


def mean_texts(found: Mapping[str, Interval | None], unit: str = "") -> dict[str, str]:
    """Return the means as text, without their unit; the unit "%" turns shares into percentages."""
    return {name: "–" if i is None else _scaled(i.mean, unit, 3) for name, i in found.items()}


def _scaled(value: float, unit: str, digits: int) -> str:
    return plain_number(100.0 * value if unit == "%" else value, digits)
