"""Every claim can hold and can fail: the tests change one value of a table in which all hold."""

from typing import Any

import pytest

from scenarios.pipeline.registry import CONTRAST, FLOORLESS_FRAME_FLY, FLY, FRAME_FLY
from scenarios.study.claims import direction as direction
from scenarios.study.claims import response as response
from scenarios.study.claims.all_claims import CLAIMS, evaluate_claims
from scenarios.study.claims.claim import DAY, NIGHT
from scenarios.study.rows import Row

SPEEDS = (1.0, 1.5, 2.0)


def make_row(lighting: str, omega: float, method: str, seed: int) -> Row:
    """Make a row with which every claim holds."""
    frames = method in (FRAME_FLY, FLOORLESS_FRAME_FLY)
    blind = frames and lighting == NIGHT
    return {
        "sequence": f"{lighting}_{omega:.2f}",
        "lighting": lighting,
        "omega_rad_s": omega,
        "image_speed_px_s": 300.0 * omega,
        "duration_s": 1.0,
        "truth": "right",
        "method": method,
        "seed": seed,
        "verdict": "right",
        "accuracy": 0.9,
        "accuracy_after_100ms": 0.1 if blind else 0.98 if not frames else 0.8,
        "response_mean": 0.1 * omega if frames else 0.8,
        "response_variation": 0.5 + omega / 10 if frames else 0.2,
        "velocity_error_px_s": 3.0 if method == CONTRAST else None,
        "velocity_bias_px_s": -1.0 if method == CONTRAST else None,
        "roi_iou": 0.6 + 0.01 * seed if method == FLY else None,
        "centroid_error_px": 12.0 if method == FLY else None,
        "grms": 100.0 * omega,
        "cpu_s": 30.0 if method == CONTRAST else 0.2,
        "ms_per_estimate": 50.0 if method == CONTRAST else 1.0,
        "ns_per_event": 3000.0 if method == CONTRAST else 100.0,
        "estimates": 7 if blind else 38,
    }


def make_table(*, where: dict[str, Any] | None = None, **changes: Any) -> list[Row]:
    """Make all rows, with changes in those that have the values of `where`."""
    rows = [
        make_row(lighting, omega, method, seed)
        for lighting in (DAY, NIGHT)
        for omega in SPEEDS
        for method in (FLY, FRAME_FLY, FLOORLESS_FRAME_FLY, CONTRAST)
        for seed in (0, 1)
    ]
    for row in rows:
        if all(row[name] == value for name, value in (where or {}).items()):
            row.update(changes)
    return rows


def test_all_claims_but_one_hold_for_the_papers_numbers() -> None:
    found = evaluate_claims(make_table())
    assert len(found) == len(CLAIMS)
    untested = [claim for claim in found if claim.holds != "holds"]
    assert [claim.holds for claim in untested] == ["not tested"]
    assert "background" in untested[0].statement
    for claim in found:
        assert claim.evidence.endswith(".")
        assert claim.where


FRAMES = {"method": FLOORLESS_FRAME_FLY}


@pytest.mark.parametrize(
    ("claim", "where", "changed", "holds"),
    [
        (direction.fly_finds_direction, {"method": FLY}, {"verdict": "left"}, "does not hold"),
        (
            direction.fly_finds_direction,
            {"method": FLY, "omega_rad_s": 2.0},
            {"verdict": "none"},
            "holds in part",
        ),
        (
            direction.contrast_finds_direction,
            {"method": CONTRAST},
            {"verdict": "up"},
            "does not hold",
        ),
        (
            direction.fly_responds_at_night,
            {"method": FLY, "lighting": NIGHT},
            {"accuracy_after_100ms": 0.94},
            "does not hold",
        ),
        (
            direction.fly_is_consistent,
            {"method": FLY, "lighting": DAY, "omega_rad_s": 1.0},
            {"accuracy_after_100ms": 0.5},
            "holds in part",
        ),
        (
            direction.frame_fly_fails_at_night,
            FRAMES | {"lighting": NIGHT},
            {"accuracy_after_100ms": 0.8},
            "does not hold",
        ),
        (
            direction.frame_fly_fails_at_night,
            FRAMES | {"lighting": NIGHT},
            {"accuracy_after_100ms": 0.6},
            "holds in part",
        ),
        (
            direction.frame_fly_fails_at_night,
            FRAMES | {"lighting": DAY},
            {"accuracy_after_100ms": 0.3},
            "holds in part",
        ),
        (direction.region_encloses_vehicle, {"method": FLY}, {"roi_iou": 0.49}, "does not hold"),
        (
            direction.region_encloses_vehicle,
            {"method": FLY, "lighting": DAY},
            {"roi_iou": 0.2},
            "holds in part",
        ),
        (response.fly_is_steadier, FRAMES, {"response_variation": 0.1}, "does not hold"),
        (
            response.fly_is_steadier,
            FRAMES | {"lighting": DAY},
            {"response_variation": 0.1},
            "holds in part",
        ),
        (response.frames_are_weaker, FRAMES, {"response_mean": 0.9}, "does not hold"),
        (
            response.frames_are_weak_when_slow,
            FRAMES | {"lighting": DAY, "omega_rad_s": 1.0},
            {"response_mean": 0.9},
            "holds in part",
        ),
        (
            response.frames_are_weak_when_slow,
            {"method": FLY, "lighting": DAY, "omega_rad_s": 1.0},
            {"accuracy_after_100ms": 0.3},
            "does not hold",
        ),
        (
            response.frame_response_less_smooth,
            FRAMES | {"lighting": DAY, "omega_rad_s": 2.0},
            {"response_variation": 0.1},
            "does not hold",
        ),
        (
            response.grms_rises,
            {"method": FLY, "lighting": NIGHT, "omega_rad_s": 1.5},
            {"grms": 50.0},
            "holds in part",
        ),
        (response.grms_rises, {"method": FLY}, {"grms": 50.0}, "not tested"),
        (
            response.contrast_velocity_rises,
            {"method": CONTRAST, "omega_rad_s": 2.0},
            {"velocity_bias_px_s": -590.0},
            "does not hold",
        ),
        (
            response.frames_are_few_at_night,
            FRAMES | {"lighting": NIGHT},
            {"estimates": 9},
            "does not hold",
        ),
        (response.fly_is_faster, {"method": CONTRAST}, {"ns_per_event": 300.0}, "holds in part"),
        (response.fly_is_faster, {"method": CONTRAST}, {"ns_per_event": 90.0}, "does not hold"),
        (response.fly_is_real_time, {"method": FLY}, {"cpu_s": 1.1}, "does not hold"),
    ],
)
def test_a_claim_fails_if_the_numbers_contradict_it(
    claim: Any, where: dict[str, Any], changed: dict[str, Any], holds: str
) -> None:
    assert claim(make_table()).holds == "holds"
    assert claim(make_table(where=where, **changed)).holds == holds


@pytest.mark.parametrize("claim", CLAIMS)
def test_without_the_papers_methods_no_claim_is_tested(claim: Any) -> None:
    rows = [make_row(DAY, 1.0, "mine:Own", 0)]
    assert claim(rows).holds == "not tested"


def test_the_evidence_gives_the_numbers() -> None:
    claim = response.fly_is_faster(make_table())
    assert "takes the fly 1 ms (1 to 1), and contrast maximisation 50 ms (50 to 50)" in (
        claim.evidence
    )
    claim = direction.fly_finds_direction(
        make_table(where={"method": FLY, "seed": 1}, verdict="none")
    )
    assert "correct in 6 of 12 runs" in claim.evidence


def test_the_model_without_our_floor_is_used_if_it_ran() -> None:
    rows = [row for row in make_table() if row["method"] != FLOORLESS_FRAME_FLY]
    claim = direction.frame_fly_fails_at_night(rows)
    assert claim.holds == "holds"
    assert "With our floor" not in claim.evidence
    assert "With our floor" in direction.frame_fly_fails_at_night(make_table()).evidence
