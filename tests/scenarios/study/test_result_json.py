"""Results as JSON."""

from dataclasses import fields, replace
from typing import cast

import numpy as np

from scenarios.study.result_json import result_from_json, result_to_json
from tests.scenarios.study.synthetic_results import make_sequence


def test_a_result_comes_back_without_loss() -> None:
    result = make_sequence("night", 1.42)
    run = result.runs[0]
    odd = replace(
        run.estimates[0], strength=cast("float", np.float32(0.1)), hs=0.1 + 0.2, roi_px=None
    )
    result = replace(result, runs=(replace(run, estimates=(odd, *run.estimates)), *result.runs))
    back = result_from_json(result_to_json(result))
    assert back.runs == result.runs
    assert back.runs[0].estimates[0].direction is odd.direction
    for name in ("velocity_t_us", "velocity_px_s"):
        before, after = getattr(result, name), getattr(back, name)
        assert after.dtype == before.dtype
        assert np.array_equal(after, before)
    for shot, again in zip(result.snapshots, back.snapshots, strict=True):
        for field in fields(shot):
            before, after = getattr(shot, field.name), getattr(again, field.name)
            assert type(after) is type(before)
            assert np.array_equal(after, before) if before is not None else after is None
            assert getattr(after, "dtype", None) == getattr(before, "dtype", None)
    plain = ("lighting", "omega_rad_s", "speed_km_h", "duration_us", "in_view_us", "direction")
    assert all(getattr(back, name) == getattr(result, name) for name in plain)
