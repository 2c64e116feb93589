"""Every claim can hold and can fail: the tests change one value of a table in which all hold."""

from typing import Any

import pytest

from scenarios.pipeline.registry import (
    CONTRAST,
    FLOORLESS_FRAME_FLY,
    FLY,
    FLY_EVERYWHERE,
    FRAME_FLY,
    ROBUST,
    ROBUST_EVERYWHERE,
)
from scenarios.study.claims import direction as direction
from scenarios.study.claims import response as response
from scenarios.study.claims.all_claims import CLAIMS, evaluate_claims
from scenarios.study.claims.background import attention_gain, background_is_suppressed
from scenarios.study.claims.claim import DAY, NIGHT
from scenarios.study.claims.small_table import SmallTable
from scenarios.study.conditions import HIGH_THRESHOLDS, moving_background_rows, paper_rows
from scenarios.study.results import DEFAULT_SENSOR, STILL, sequence_name
from scenarios.study.rows import Row

SPEEDS = (1.0, 1.5, 2.0)


def make_row(lighting: str, omega: float, method: str, seed: int, background: str = STILL) -> Row:
    """Make a row with which every claim holds."""
    frames = method in (FRAME_FLY, FLOORLESS_FRAME_FLY)
    blind = frames and lighting == NIGHT
    return {
        "sequence": sequence_name(lighting, omega, background),
        "lighting": lighting,
        "background": background,
        "sensor": DEFAULT_SENSOR,
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
    rows += [
        make_row(lighting, omega, method, seed, background)
        | {"accuracy_after_100ms": right - 0.01 * seed}
        for lighting in (DAY, NIGHT)
        for omega in SPEEDS[:1]
        for method, right in ((FLY, 0.9), (FLY_EVERYWHERE, 0.6))
        for background in ("wind", "shake")
        for seed in (0, 1)
    ]
    for row in rows:
        if all(row[name] == value for name, value in (where or {}).items()):
            row.update(changes)
    return rows


def test_all_sixteen_claims_hold_for_the_papers_numbers() -> None:
    found = evaluate_claims(make_table())
    assert len(found) == len(CLAIMS) == 16
    assert {claim.holds for claim in found} == {"holds"}
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
    assert claim(paper_rows(make_table())).holds == "holds"
    assert claim(paper_rows(make_table(where=where, **changed))).holds == holds


@pytest.mark.parametrize(
    ("where", "right", "holds"),
    [
        ({"method": FLY_EVERYWHERE}, 0.9, "does not hold"),
        ({"method": FLY}, 0.5, "does not hold"),
        ({"method": FLY, "background": "wind"}, 0.3, "holds in part"),
    ],
)
def test_the_claim_on_moving_backgrounds_compares_with_and_without_attention(
    where: dict[str, Any], right: float, holds: str
) -> None:
    assert background_is_suppressed(make_table()).holds == "holds"
    rows = make_table()
    for row in rows:
        if row["background"] != STILL and all(row[name] == value for name, value in where.items()):
            row["accuracy_after_100ms"] = right - 0.01 * row["seed"]
    assert background_is_suppressed(rows).holds == holds


def test_the_gain_of_attention_is_paired_by_sequence_and_seed() -> None:
    gain = attention_gain(moving_background_rows(make_table()), FLY)
    assert gain is not None
    assert (gain.mean, gain.low, gain.number) == pytest.approx((0.3, 0.3, 2))
    claim = background_is_suppressed(make_table())
    assert "a difference of 30 percentage points. " in claim.evidence
    assert "in 4 of 4 sequences, and fewer in 0" in claim.evidence
    assert claim.tables[0] == SmallTable(
        "correct steps [%], day",
        "background",
        ("wind", "shake"),
        (
            ("event-driven fly", ("89.5", "89.5")),
            ("event-driven fly, no attention", ("59.5", "59.5")),
        ),
    )
    assert "nothing to gain" not in claim.evidence
    assert "fly, robust" not in claim.evidence
    sure = make_table()
    for row in sure:
        if row["background"] != STILL:
            row["accuracy_after_100ms"] = 1.0
    assert "nothing to gain" in background_is_suppressed(sure).evidence


@pytest.mark.parametrize(
    ("right", "points"), [(0.65, "25 percentage points"), (0.89, "1 percentage point")]
)
def test_the_gain_of_the_other_flies_is_reported_where_they_ran(right: float, points: str) -> None:
    rows = make_table()
    rows += [
        make_row(DAY, SPEEDS[0], method, seed, "wind") | {"accuracy_after_100ms": right}
        for method, right in ((ROBUST, 0.9), (ROBUST_EVERYWHERE, right))
        for seed in (0, 1)
    ]
    claim = background_is_suppressed(rows)
    assert f"For “event-driven fly, robust” the difference is {points}." in claim.evidence
    assert "fly, wide" not in claim.evidence


def test_a_sensor_is_judged_by_its_own_rows() -> None:
    other = [row | {"sensor": HIGH_THRESHOLDS, "verdict": "left"} for row in make_table()]
    rows = make_table() + [row for row in other if row["background"] == STILL]
    assert {claim.holds for claim in evaluate_claims(rows)} == {"holds"}
    second = {claim.statement: claim.holds for claim in evaluate_claims(rows, HIGH_THRESHOLDS)}
    assert second["the event-driven fly finds the correct direction in every sequence"] == (
        "does not hold"
    )
    assert second["attention suppresses background motion"] == "not tested"


@pytest.mark.parametrize("claim", CLAIMS)
def test_without_the_papers_methods_no_claim_is_tested(claim: Any) -> None:
    rows = [make_row(DAY, 1.0, "mine:Own", 0)]
    assert claim(rows).holds == "not tested"


def test_the_evidence_gives_the_numbers() -> None:
    claim = response.fly_is_faster(paper_rows(make_table()))
    assert "takes the fly 1 ms, and contrast maximisation 50 ms, 50 times as long" in (
        claim.evidence
    )
    claim = direction.fly_finds_direction(
        paper_rows(make_table(where={"method": FLY, "seed": 1}, verdict="none"))
    )
    assert "correct in 6 of 12 runs" in claim.evidence


def test_numbers_by_velocity_are_small_tables_without_exponents() -> None:
    grms = response.grms_rises(paper_rows(make_table(where={"omega_rad_s": 2.0}, grms=80_512.0)))
    assert "rank correlation with velocity is 1 by day, 1 at night" in grms.evidence
    assert grms.tables[0] == SmallTable(
        "GRMS [1/s], day",
        "rad/s",
        ("1.00", "1.50", "2.00"),
        (("event-driven fly", ("100", "150", "80\u202f500")),),
    )
    steady = response.fly_is_steadier(paper_rows(make_table()))
    assert [name for name, _ in steady.tables[1].rows] == [
        "event-driven fly",
        "frame-based fly, no floor",
    ]


def test_the_model_without_our_floor_is_used_if_it_ran() -> None:
    rows = [row for row in paper_rows(make_table()) if row["method"] != FLOORLESS_FRAME_FLY]
    claim = direction.frame_fly_fails_at_night(rows)
    assert claim.holds == "holds"
    assert "With our floor" not in claim.evidence
    assert "With our floor" in direction.frame_fly_fails_at_night(paper_rows(make_table())).evidence
