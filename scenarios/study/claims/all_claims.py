"""All claims of the paper that the study can test, in the order of the paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenarios.study.claims import direction as direction
from scenarios.study.claims import response as response
from scenarios.study.claims.background import background_is_suppressed
from scenarios.study.claims.claim import Claim
from scenarios.study.results import DEFAULT_SENSOR, STILL
from scenarios.study.rows import Row
from scenarios.study.statistics import select

CLAIMS: tuple[Callable[[Sequence[Row]], Claim], ...] = (
    response.fly_is_real_time,
    background_is_suppressed,
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


def evaluate_claims(rows: Sequence[Row], sensor: str = DEFAULT_SENSOR) -> list[Claim]:
    """Test every claim on the table of the study.

    Args:
        rows: the table.
        sensor: name of the sensor whose rows count.
    """
    own = select(rows, sensor=sensor)
    still = select(own, background=STILL)
    return [claim(own if claim is background_is_suppressed else still) for claim in CLAIMS]
