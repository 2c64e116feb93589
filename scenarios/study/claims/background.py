"""The paper's claim on moving backgrounds: attention suppresses them."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

from scenarios.pipeline.registry import DETECTORS, FLY, FLY_EVERYWHERE, ROBUST, WIDE
from scenarios.study.claims.claim import (
    Claim,
    Verdict,
    format_interval,
    mean_texts,
    not_tested,
)
from scenarios.study.claims.small_table import SmallTable
from scenarios.study.conditions import moving_background_rows
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, distinct, interval_of, mean_interval, select
from scenarios.styles.method_style import method_style

CORRECT = "accuracy_after_100ms"


def background_is_suppressed(rows: Sequence[Row]) -> Claim:
    """Test the abstract and Section II-C: attention suppresses background motion.

    It holds if attention makes more steps correct over all sequences with a moving background and
    fewer in none of them, and in part if it makes more correct in any of them. More or fewer means
    that the 95 % interval of the difference over the seeds does not include 0.
    """
    statement, where = "attention suppresses background motion", "Abstract, Section II"
    own = moving_background_rows(rows)
    overall = attention_gain(own, FLY)
    if overall is None:
        missing = "no run with a moving background of the fly with attention and without"
        return not_tested(statement, where, missing)
    gains = {
        name: gain
        for name in distinct(own, "sequence")
        if (gain := attention_gain(select(own, sequence=name), FLY)) is not None
    }
    better = [name for name, gain in gains.items() if gain.low > 0.0]
    worse = [name for name, gain in gains.items() if gain.high < 0.0]
    with_it, without = (
        format_interval(interval_of(select(own, method=method), CORRECT), "%")
        for method in (FLY, FLY_EVERYWHERE)
    )
    evidence = (
        f"Of the settled steps in front of a moving background, {with_it} are correct with "
        f"attention, and {without} without, a difference of {_points(overall)}. Attention makes "
        f"more steps correct in {len(better)} of {len(gains)} sequences, and fewer in {len(worse)} "
        "(95 % intervals)."
    )
    if all(row[CORRECT] == 1.0 for row in select(own, method=FLY_EVERYWHERE)):
        evidence += " Every step is correct without attention, so that there is nothing to gain."
    for method in (WIDE, ROBUST):
        if (gain := attention_gain(own, method)) is not None:
            label = method_style(method).label
            evidence += f" For “{label}” the difference is {_points(gain)}."
    return Claim(statement, where, _verdict(overall, better, worse), evidence, _tables(own))


def attention_gain(rows: Sequence[Row], method: str) -> Interval | None:
    """Return the share of correct steps with attention minus that without, over the seeds.

    Args:
        rows: rows of one sequence or more.
        method: a method of the registry that has an entry without attention.

    Returns:
        The difference, paired by sequence and seed; None if there is no pair.
    """
    without = {
        (row["sequence"], row["seed"]): row[CORRECT]
        for row in select(rows, method=DETECTORS[method].without_attention)
    }
    found: dict[int, list[float]] = {}
    for row in select(rows, method=method):
        other = without.get((row["sequence"], row["seed"]))
        if other is not None and row[CORRECT] is not None:
            found.setdefault(row["seed"], []).append(row[CORRECT] - other)
    return mean_interval([fmean(values) for values in found.values()])


def _verdict(overall: Interval, better: Sequence[str], worse: Sequence[str]) -> Verdict:
    if overall.low > 0.0 and not worse:
        return "holds"
    return "holds in part" if better else "does not hold"


def _points(gain: Interval) -> str:
    scaled = Interval(100 * gain.mean, 100 * gain.low, 100 * gain.high, gain.number)
    text = format_interval(scaled, digits=2)
    return f"{text} percentage point" + ("" if text == "1" else "s")


def _tables(rows: Sequence[Row]) -> tuple[SmallTable, ...]:
    """Return the correct steps with and without attention, for each lighting and background."""
    tables = []
    for lighting in distinct(rows, "lighting"):
        own = select(rows, lighting=lighting)
        backgrounds = distinct(own, "background")
        lines = []
        for method in (FLY, FLY_EVERYWHERE):
            found = {
                name: interval_of(select(own, method=method, background=name), CORRECT)
                for name in backgrounds
            }
            cells = tuple(mean_texts(found, "%").values())
            lines.append((method_style(method).label, cells))
        title = f"correct steps [%], {lighting}"
        tables.append(SmallTable(title, "background", tuple(backgrounds), tuple(lines)))
    return tuple(tables)
