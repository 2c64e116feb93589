"""The three numbers at the top of the report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scenarios.output.numbers import plain_number
from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.claims.claim import NIGHT, Claim, published_frame_fly
from scenarios.study.rows import Row
from scenarios.study.statistics import interval_of, select
from scenarios.styles.method_style import method_style

CORRECT, TIME = "accuracy_after_100ms", "ms_per_estimate"


@dataclass(frozen=True)
class Headline:
    """One number, and what it says."""

    number: str
    meaning: str


def headlines(rows: Sequence[Row], claims: Sequence[Claim]) -> list[Headline]:
    """Return up to three numbers; one whose methods did not run is left out.

    Args:
        rows: rows of the paper's sequences with the default sensor.
        claims: verdicts with the default sensor.
    """
    return [*_claims(claims), *_steps(rows), *_times(rows)]


def _claims(claims: Sequence[Claim]) -> Iterator[Headline]:
    tested = [claim.holds for claim in claims if claim.holds != "not tested"]
    if tested:
        part, fails = tested.count("holds in part"), tested.count("does not hold")
        yield Headline(
            f"{tested.count('holds')} of {len(tested)}",
            f"claims of the paper hold; {part} in part, {fails} not",
        )


def _steps(rows: Sequence[Row]) -> Iterator[Headline]:
    """Yield the share of correct steps of the fly, at night if there is a night."""
    night = select(rows, lighting=NIGHT)
    shown = night or rows
    fly = interval_of(select(shown, method=FLY), CORRECT)
    if fly is None:
        return
    when = " at night" if night else ""
    meaning = f"of the steps of the {method_style(FLY).label}{when} are correct"
    other = published_frame_fly(shown)
    frames = interval_of(select(shown, method=other), CORRECT)
    if frames is not None:
        share = plain_number(100 * frames.mean, 2)
        meaning += f"; {share} % of those of the {method_style(other).label}"
    yield Headline(f"{plain_number(100 * fly.mean)} %", meaning)


def _times(rows: Sequence[Row]) -> Iterator[Headline]:
    fly, contrast = (interval_of(select(rows, method=m), TIME) for m in (FLY, CONTRAST))
    if fly is None:
        return
    meaning = f"of CPU time for an estimate of the {method_style(FLY).label}"
    if contrast is not None:
        meaning += f"; {plain_number(contrast.mean)} ms for {method_style(CONTRAST).label}"
    yield Headline(f"{plain_number(fly.mean)} ms", meaning)
