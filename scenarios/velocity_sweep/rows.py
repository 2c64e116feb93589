"""Measure one angular velocity: one rendered sequence, shown to one sensor per seed."""

from __future__ import annotations

from typing import Any

from scenarios.output.progress import ProgressBars
from scenarios.pipeline.repeats import run_repeats
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing
from scenarios.pipeline.scoring import score_estimates
from sim import LuminanceCache

Row = dict[str, Any]


def measure_velocity(
    config: RunConfig, seeds: int, progress: ProgressBars, *, cache: LuminanceCache | None = None
) -> list[Row]:
    """Render a sequence, or load it from the cache, and show it to several sensors.

    Args:
        config: configuration of the run; its seed is the first one.
        seeds: number of sensors.
        progress: progress display; it gets one line for the sequence.
        cache: cache for rendered luminance; None: no cache.

    Returns:
        One row per seed: the true motion, the method, the seed, and all scores.
    """
    advance = progress.track(config.title)
    advance(0, 0, "building street")
    crossing = make_crossing(config, cache)
    advance(0, 0, "first keyframes")
    used = range(config.seed, config.seed + seeds)
    by_seed, track = run_repeats(
        config, crossing.samples(), used, lambda t_us: advance(t_us, crossing.duration_us)
    )
    direction, omega = config.crossing.direction, config.crossing.omega_rad_s
    known = {
        "lighting": config.crossing.lighting.value,
        "omega_rad_s": omega,
        "image_speed_px_s": crossing.intrinsics.focal_px * omega,
        "truth": direction.value,
        "method": config.method,
    }
    return [
        known | {"seed": seed} | score_estimates(estimates, direction, track.in_view_us, track)
        for seed, estimates in zip(used, by_seed, strict=True)
    ]
