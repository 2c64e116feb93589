"""Synthetic results of a study: made without rendering, and with known numbers."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from detector.estimate import MotionEstimate
from detector.metrics import Box
from flybench.direction import Direction
from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY, gives_velocity
from scenarios.pipeline.scoring import TargetTrack, score_estimates
from scenarios.study.results import MethodRun, SequenceResult, Snapshot

METHODS = (FLY, FRAME_FLY, CONTRAST)
IN_VIEW_US = (200_000, 700_000)
DURATION_US = 900_000


def make_snapshot(t_us: int = 450_000, *, box_px: Box | None = (8, 6, 22, 14)) -> Snapshot:
    rng = np.random.default_rng(t_us)
    return Snapshot(
        t_us=t_us,
        aps=rng.integers(1023, size=(24, 36)).astype(np.uint16),
        saliency=rng.random((8, 12), dtype=np.float32),
        cell_px=3,
        roi_px=(6, 6, 20, 16),
        box_px=box_px,
    )


def make_estimate(method: str, t_us: int, hs: float, speed_px_s: float) -> MotionEstimate:
    direction = Direction.RIGHT if hs > 0 else Direction.LEFT if hs < 0 else Direction.NONE
    return MotionEstimate(
        t_us=t_us,
        hs=hs,
        vs=0.05,
        direction=direction,
        strength=abs(hs),
        response=(speed_px_s, 0.0) if gives_velocity(method) else (1000 * hs, 0.0),
        view_centre_px=(18.0, 12.0),
        roi_px=(6, 6, 20, 16) if method == FLY else None,
    )


def make_run(method: str, seed: int, *, hs: float = 0.5, speed_px_s: float = 400.0) -> MethodRun:
    """Make a run with an estimate every 50 ms: about `hs` in view, and 0 outside."""
    track = TargetTrack()
    for t_us in range(0, DURATION_US, 10_000):
        in_view = IN_VIEW_US[0] <= t_us <= IN_VIEW_US[1]
        track.add(t_us, (8, 6, 22, 14) if in_view else None, (15.0, 10.0) if in_view else None)
    estimates = []
    for number, t_us in enumerate(range(50_000, DURATION_US, 50_000)):
        in_view = IN_VIEW_US[0] < t_us <= IN_VIEW_US[1]
        varied_hs = hs * (1 + 0.1 * math.sin(number + seed)) if in_view else 0.0
        estimates.append(make_estimate(method, t_us, varied_hs, speed_px_s + seed))
    return MethodRun(
        method=method,
        seed=seed,
        estimates=tuple(estimates),
        scores=score_estimates(estimates, "right", IN_VIEW_US, track),
        velocity_error_px_s=3.0 + seed if gives_velocity(method) and hs else None,
        cpu_s=0.01 * (1 + seed),
        events=1000,
        velocity_bias_px_s=1.0 if gives_velocity(method) and hs else None,
    )


def make_sequence(
    lighting: str = "day",
    omega_rad_s: float = 1.21,
    *,
    methods: Sequence[str] = METHODS,
    seeds: Sequence[int] = (0, 1, 2),
    **changes: Any,
) -> SequenceResult:
    speed_px_s = 324 * omega_rad_s
    result = SequenceResult(
        lighting=lighting,
        omega_rad_s=omega_rad_s,
        speed_km_h=30.0,
        duration_us=DURATION_US,
        in_view_us=IN_VIEW_US,
        velocity_t_us=np.arange(0, DURATION_US, 10_000),
        velocity_px_s=np.full(DURATION_US // 10_000, speed_px_s),
        snapshots=(make_snapshot(400_000), make_snapshot(), make_snapshot(500_000)),
        runs=tuple(
            make_run(method, seed, speed_px_s=speed_px_s) for seed in seeds for method in methods
        ),
    )
    return replace(result, **changes)
