"""All claims of the paper that the study can test, in the order of the paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenarios.study.claims import direction as direction
from scenarios.study.claims import response as response
from scenarios.study.claims.claim import Claim
from scenarios.study.rows import Row

CLAIMS: tuple[Callable[[Sequence[Row]], Claim], ...] = (
    response.fly_is_real_time,
    direction.background_is_suppressed,
    direction.attention_finds_it,
    response.fly_is_steadier,
    response.frames_are_weaker,
    response.frames_are_weak_when_slow,
    direction.fly_is_consistent,
    response.frames_get_uneven,
    direction.frames_fail_by_night,
    direction.fly_holds_by_night,
    response.frames_are_few_by_night,
    direction.fly_is_right,
    direction.contrast_is_right,
    response.contrast_knows_velocity,
    response.grms_rises,
    response.fly_is_faster,
)


def evaluate_claims(rows: Sequence[Row]) -> list[Claim]:
    """Test every claim on the table of the study."""
    return [claim(rows) for claim in CLAIMS]
