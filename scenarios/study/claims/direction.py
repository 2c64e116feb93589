"""The paper's claims of which method sees the direction of motion, and when."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.claims.claim import (
    DAY,
    MOST_STEPS,
    NIGHT,
    Claim,
    Verdict,
    by_sequence,
    graded,
    not_tested,
    paper_frame_fly,
    told,
)
from scenarios.study.rows import Row
from scenarios.study.statistics import interval_of, select

AFTER = "accuracy_after_100ms"
LOST, SEEN = 0.5, 0.5
"""By night "largely lost" is right in fewer than half of the steps; by day seen in more."""
OVERLAP = 0.5
"""Least overlap of region and box that counts as enclosed: the usual bound of object detection (M.
Everingham et al., "The PASCAL visual object classes challenge", 2010)."""


def fly_is_right(rows: Sequence[Row]) -> Claim:
    """Fig. EX3 C, the proposed method."""
    return _is_right(rows, FLY, "the event-driven fly tells the right direction in every sequence")


def contrast_is_right(rows: Sequence[Row]) -> Claim:
    """Fig. EX3 C, contrast maximisation."""
    return _is_right(
        rows, CONTRAST, "contrast maximisation tells the right direction in every sequence"
    )


def _is_right(rows: Sequence[Row], method: str, statement: str) -> Claim:
    where, own = "Section III, Fig. EX3 C", select(rows, method=method)
    if not own:
        return not_tested(statement, where, f"no run of {method}")
    right = [row for row in own if row["verdict"] == row["truth"]]
    evidence = (
        f"The verdict over the whole crossing is right in {len(right)} of {len(own)} runs; of the "
        f"single steps in view, {told(interval_of(own, 'accuracy'), '%')} are right."
    )
    return Claim(statement, where, graded(len(right) / len(own)), evidence)


def frames_fail_by_night(rows: Sequence[Row]) -> Claim:
    """Section III: the frame-based model by night."""
    statement = "by night the frame-based model largely loses its motion detection"
    where, method = "Section III, Fig. EX2 B", paper_frame_fly(rows)
    night = interval_of(select(rows, method=method, lighting=NIGHT), AFTER)
    day = interval_of(select(rows, method=method, lighting=DAY), AFTER)
    if night is None or day is None:
        return not_tested(
            statement, where, "no settled steps of the frame-based fly by both lights"
        )
    evidence = (
        f"As published it is right in {told(night, '%')} of the steps by night and in "
        f"{told(day, '%')} by day"
    )
    if method != FRAME_FLY:
        floor = interval_of(select(rows, method=FRAME_FLY, lighting=NIGHT), AFTER)
        evidence += f"; with our floor on its signal to noise, in {told(floor, '%')} by night"
    lost, seen = night.mean < LOST, day.mean >= SEEN
    part: Verdict = "holds in part" if lost or night.high < day.low else "does not hold"
    return Claim(statement, where, "holds" if lost and seen else part, evidence + ".")


def fly_holds_by_night(rows: Sequence[Row]) -> Claim:
    """Section III: the proposed model by night."""
    statement = "by night the event-driven fly goes on responding stably"
    return _holds_throughout(rows, NIGHT, statement, "Section III, Fig. EX2 A")


def fly_is_consistent(rows: Sequence[Row]) -> Claim:
    """Section III: the proposed model over velocities."""
    statement = "by day the event-driven fly's response is consistent as velocity rises"
    return _holds_throughout(rows, DAY, statement, "Section III, Fig. EX1 A")


def _holds_throughout(rows: Sequence[Row], light: str, statement: str, where: str) -> Claim:
    found = by_sequence(select(rows, method=FLY, lighting=light), AFTER)
    known = {name: value for name, value in found.items() if value is not None}
    if not known:
        return not_tested(statement, where, f"no settled step of the fly by {light}")
    good = [name for name, value in known.items() if value.mean >= MOST_STEPS]
    steps = ", ".join(f"{_speed(n)}: {told(v, '%')}" for n, v in known.items())
    evidence = (
        f"Right steps after 100 ms in view, by angular velocity in rad/s: {steps}; at "
        f"{len(good)} of {len(known)} they are {100 * MOST_STEPS:.0f} % or more."
    )
    return Claim(statement, where, graded(len(good) / len(known)), evidence)


def attention_finds_it(rows: Sequence[Row]) -> Claim:
    """Section II-C and III: the region of interest."""
    statement = "the attended region adapts to the vehicle and encloses it"
    where, own = "Section II, Fig. EX1 A and EX2 A", select(rows, method=FLY)
    known = {n: v for n, v in by_sequence(own, "roi_iou").items() if v is not None}
    if not known:
        return not_tested(statement, where, "no settled step of the fly")
    good = [name for name, value in known.items() if value.mean >= OVERLAP]
    off = interval_of(own, "centroid_error_px")
    lights = " and ".join(
        f"{told(interval_of(select(own, lighting=light), 'roi_iou'))} by {light}"
        for light in dict.fromkeys(row["lighting"] for row in own)
    )
    evidence = (
        f"Region and true box overlap (intersection over union) by {lights}; in {len(good)} of "
        f"{len(known)} sequences by {OVERLAP:g} or more; the view centre is {told(off, 'px')} off."
    )
    return Claim(statement, where, graded(len(good) / len(known)), evidence)


def background_is_suppressed(rows: Sequence[Row]) -> Claim:  # noqa: ARG001, a claim all the same
    """Abstract: attention against background motion."""
    return not_tested(
        "attention suppresses background motion",
        "Abstract, Section II",
        "nothing that moves but the vehicle, as the paper's sequences; see flybench run with "
        "distractors, and flybench envelope",
    )


def _speed(sequence: str) -> str:
    return sequence.partition("_")[2]
