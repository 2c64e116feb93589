"""The paper's claims about which method finds the direction of motion, and when."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.claims.claim import (
    DAY,
    NEARLY_ALL,
    NIGHT,
    Claim,
    Verdict,
    format_interval,
    mean_by_sequence,
    mean_texts,
    not_tested,
    published_frame_fly,
    verdict_from_share,
)
from scenarios.study.claims.small_table import tables_by_velocity
from scenarios.study.rows import Row
from scenarios.study.statistics import interval_of, select
from scenarios.styles.method_style import method_style

AFTER = "accuracy_after_100ms"
LOST, WORKS = 0.5, 0.5
"""Motion detection is "largely lost" at night if fewer than half of the steps are correct. It works
by day if at least half are."""
OVERLAP = 0.5
"""Smallest overlap of region and box that counts as enclosed: the usual bound of object detection
(M. Everingham et al., "The PASCAL visual object classes challenge", 2010)."""


def fly_finds_direction(rows: Sequence[Row]) -> Claim:
    """Test Fig. EX3 C, the proposed method."""
    return _is_right(
        rows, FLY, "the event-driven fly finds the correct direction in every sequence"
    )


def contrast_finds_direction(rows: Sequence[Row]) -> Claim:
    """Test Fig. EX3 C, contrast maximisation."""
    statement = "contrast maximisation finds the correct direction in every sequence"
    return _is_right(rows, CONTRAST, statement)


def _is_right(rows: Sequence[Row], method: str, statement: str) -> Claim:
    where, own = "Section III, Fig. EX3 C", select(rows, method=method)
    if not own:
        return not_tested(statement, where, f"no run of {method}")
    correct = [row for row in own if row["verdict"] == row["truth"]]
    evidence = (
        f"The verdict over the whole crossing is correct in {len(correct)} of {len(own)} runs. Of "
        f"the single steps in view, {format_interval(interval_of(own, 'accuracy'), '%')} are "
        "correct."
    )
    return Claim(statement, where, verdict_from_share(len(correct) / len(own)), evidence)


def frame_fly_fails_at_night(rows: Sequence[Row]) -> Claim:
    """Test Section III: the frame-based model at night."""
    statement = "at night the frame-based model largely loses its motion detection"
    where, method = "Section III, Fig. EX2 B", published_frame_fly(rows)
    night = interval_of(select(rows, method=method, lighting=NIGHT), AFTER)
    day = interval_of(select(rows, method=method, lighting=DAY), AFTER)
    if night is None or day is None:
        missing = "no settled steps of the frame-based fly both by day and at night"
        return not_tested(statement, where, missing)
    evidence = (
        f"As published, it is correct in {format_interval(night, '%')} of the steps at night and "
        f"in {format_interval(day, '%')} by day."
    )
    if method != FRAME_FLY:
        floor = interval_of(select(rows, method=FRAME_FLY, lighting=NIGHT), AFTER)
        evidence += (
            " With our floor on its signal-to-noise ratio, it is correct in "
            f"{format_interval(floor, '%')} at night."
        )
    found = mean_by_sequence(select(rows, method=method), AFTER)
    tables = tables_by_velocity(
        "correct steps [%]", {method_style(method).label: mean_texts(found, "%")}
    )
    lost, works = night.mean < LOST, day.mean >= WORKS
    part: Verdict = "holds in part" if lost or night.high < day.low else "does not hold"
    return Claim(statement, where, "holds" if lost and works else part, evidence, tables)


def fly_responds_at_night(rows: Sequence[Row]) -> Claim:
    """Test Section III: the proposed model at night."""
    statement = "at night the event-driven fly continues to respond stably"
    return _is_reliable(rows, NIGHT, statement, "Section III, Fig. EX2 A")


def fly_is_consistent(rows: Sequence[Row]) -> Claim:
    """Test Section III: the proposed model at rising velocities."""
    statement = "by day the event-driven fly's response is consistent as velocity rises"
    return _is_reliable(rows, DAY, statement, "Section III, Fig. EX1 A")


def _is_reliable(rows: Sequence[Row], lighting: str, statement: str, where: str) -> Claim:
    found = mean_by_sequence(select(rows, method=FLY, lighting=lighting), AFTER)
    known = {name: value for name, value in found.items() if value is not None}
    if not known:
        return not_tested(statement, where, f"no settled step of the fly in the {lighting} scenes")
    reliable = [name for name, value in known.items() if value.mean >= NEARLY_ALL]
    evidence = (
        f"At {len(reliable)} of {len(known)} velocities, {100 * NEARLY_ALL:.0f} % or more of the "
        "steps after 100 ms in view are correct."
    )
    tables = tables_by_velocity(
        "correct steps [%]", {method_style(FLY).label: mean_texts(known, "%")}
    )
    return Claim(statement, where, verdict_from_share(len(reliable) / len(known)), evidence, tables)


def region_encloses_vehicle(rows: Sequence[Row]) -> Claim:
    """Test Sections II-C and III: the region of interest."""
    statement = "the attended region adapts to the vehicle and encloses it"
    where, own = "Section II, Fig. EX1 A and EX2 A", select(rows, method=FLY)
    known = {n: v for n, v in mean_by_sequence(own, "roi_iou").items() if v is not None}
    if not known:
        return not_tested(statement, where, "no settled step of the fly")
    enclosed = [name for name, value in known.items() if value.mean >= OVERLAP]
    offset = interval_of(own, "centroid_error_px")
    evidence = (
        f"The overlap of region and true box is {100 * OVERLAP:.0f} % or more in {len(enclosed)} "
        f"of {len(known)} sequences (intersection over union). The view centre is off by "
        f"{format_interval(offset, 'px')}."
    )
    tables = tables_by_velocity("overlap [%]", {method_style(FLY).label: mean_texts(known, "%")})
    return Claim(statement, where, verdict_from_share(len(enclosed) / len(known)), evidence, tables)
