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
    direction.region_encloses_vehicle,
    response.fly_is_steadier,
    response.frames_are_weaker,
    response.frames_are_weak_when_slow,
    direction.fly_is_consistent,
    response.frame_response_less_smooth,
    direction.frame_fly_fails_at_night,
    direction.fly_responds_at_night,
    response.frames_are_few_at_night,
    direction.fly_finds_direction,
    direction.contrast_finds_direction,
    response.contrast_velocity_rises,
    response.grms_rises,
    response.fly_is_faster,
)


def evaluate_claims(rows: Sequence[Row]) -> list[Claim]:
    """Test every claim on the table of the study."""
    return [claim(rows) for claim in CLAIMS]
