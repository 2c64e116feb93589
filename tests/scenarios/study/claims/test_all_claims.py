"""Every claim can hold, and can fail: a table in which all do, changed a figure at a time."""

from typing import Any

import pytest

from scenarios.pipeline.registry import CONTRAST, FLOORLESS_FRAME_FLY, FLY, FRAME_FLY
from scenarios.study.claims import direction as direction
from scenarios.study.claims import response as response
from scenarios.study.claims.all_claims import CLAIMS, hold_claims
from scenarios.study.claims.claim import DAY, NIGHT
from scenarios.study.rows import Row

SPEEDS = (1.0, 1.5, 2.0)


def row(light: str, omega: float, method: str, seed: int, **other: Any) -> Row:
    """One in which every claim holds."""
    frames = method in (FRAME_FLY, FLOORLESS_FRAME_FLY)
    blind = frames and light == NIGHT
    return {
        "sequence": f"{light}_{omega:.2f}",
        "lighting": light,
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
    } | other


def table(**changed: Any) -> list[Row]:
    """All rows; `changed` has what differs, for rows that `where` names."""
    where = changed.pop("where", {})
    rows = [
        row(light, omega, method, seed)
        for light in (DAY, NIGHT)
        for omega in SPEEDS
        for method in (FLY, FRAME_FLY, FLOORLESS_FRAME_FLY, CONTRAST)
        for seed in (0, 1)
    ]
    for one in rows:
        if all(one[name] == value for name, value in where.items()):
            one.update(changed)
    return rows


def test_all_hold_where_all_is_as_the_paper_says() -> None:
    found = hold_claims(table())
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
        (direction.fly_is_right, {"method": FLY}, {"verdict": "left"}, "does not hold"),
        (
            direction.fly_is_right,
            {"method": FLY, "omega_rad_s": 2.0},
            {"verdict": "none"},
            "holds in part",
        ),
        (direction.contrast_is_right, {"method": CONTRAST}, {"verdict": "up"}, "does not hold"),
        (
            direction.fly_holds_by_night,
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
            direction.frames_fail_by_night,
            FRAMES | {"lighting": NIGHT},
            {"accuracy_after_100ms": 0.8},
            "does not hold",
        ),
        (
            direction.frames_fail_by_night,
            FRAMES | {"lighting": NIGHT},
            {"accuracy_after_100ms": 0.6},
            "holds in part",
        ),
        (
            direction.frames_fail_by_night,
            FRAMES | {"lighting": DAY},
            {"accuracy_after_100ms": 0.3},
            "holds in part",
        ),
        (direction.attention_finds_it, {"method": FLY}, {"roi_iou": 0.49}, "does not hold"),
        (
            direction.attention_finds_it,
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
            response.frames_get_uneven,
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
            response.contrast_knows_velocity,
            {"method": CONTRAST, "omega_rad_s": 2.0},
            {"velocity_bias_px_s": -590.0},
            "does not hold",
        ),
        (
            response.frames_are_few_by_night,
            FRAMES | {"lighting": NIGHT},
            {"estimates": 9},
            "does not hold",
        ),
        (response.fly_is_faster, {"method": CONTRAST}, {"ns_per_event": 300.0}, "holds in part"),
        (response.fly_is_faster, {"method": CONTRAST}, {"ns_per_event": 90.0}, "does not hold"),
        (response.fly_is_real_time, {"method": FLY}, {"cpu_s": 1.1}, "does not hold"),
    ],
)
def test_a_claim_that_the_numbers_deny_is_denied(
    claim: Any, where: dict[str, Any], changed: dict[str, Any], holds: str
) -> None:
    assert claim(table()).holds == "holds"
    assert claim(table(where=where, **changed)).holds == holds


@pytest.mark.parametrize("claim", CLAIMS)
def test_without_the_methods_nothing_is_tested(claim: Any) -> None:
    rows = [row(DAY, 1.0, "mine:Own", 0)]
    assert claim(rows).holds == "not tested"


def test_evidence_tells_the_numbers() -> None:
    claim = response.fly_is_faster(table())
    assert (
        "1 ms (1 to 1) by the fly and 50 ms (50 to 50) by contrast maximisation" in claim.evidence
    )
    claim = direction.fly_is_right(table(where={"method": FLY, "seed": 1}, verdict="none"))
    assert "right in 6 of 12 runs" in claim.evidence


def test_the_published_model_is_judged_where_it_ran() -> None:
    rows = [r for r in table() if r["method"] != FLOORLESS_FRAME_FLY]
    claim = direction.frames_fail_by_night(rows)
    assert claim.holds == "holds"
    assert "with our floor" not in claim.evidence
    assert "with our floor" in direction.frames_fail_by_night(table()).evidence
