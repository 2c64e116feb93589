"""The pixels of a batch that noise may carry across a threshold: the second pass over a batch.

The mean difference d of each pixel is sampled at five times of the step, and its hazard is that of
`emulator.pixel.noisy.passage`, with one turning point of d at most. A pixel whose clock survives it
is finished. The others are left to `emulator.pixel.noisy.step`.
"""

from __future__ import annotations

from emulator.noise.first_passage import surprise
from emulator.noise.photoreceptor_noise import noise_of
from emulator.pixel.batch import (
    CHANGE,
    CLOCK,
    CORNER,
    CROSSING,
    DRIFT,
    LAG,
    LEAK,
    LOG_FROM,
    LOG_TO,
    NEW_CLOCK,
    OTHER,
    OUTCOME,
    SECOND_LAG,
    SIGMA,
    SILENT,
    THETA_OFF,
    THETA_ON,
    Batch,
    Reals,
    rounded_up,
)
from emulator.pixel.noisy.passage import diffusion_rate
from emulator.pixel.source_follower import amplitudes, separated
from emulator.pixel.state import PixelModel
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp

COPIED = (
    LAG,
    SECOND_LAG,
    CHANGE,
    LEAK,
    CLOCK,
    THETA_ON,
    THETA_OFF,
    LOG_FROM,
    LOG_TO,
    DRIFT,
    CORNER,
    SIGMA,
)
"""Fields that the pass reads."""

LONGEST = 2.5
"""Longest step, in time constants of the last low-pass: in a quarter of it d is nearly straight."""


@compiled
def solve_near(batch: Batch, model: PixelModel, count: int, span_us: float) -> None:
    """Finish the near pixels among the first `count` of a batch that stay silent.

    Args:
        batch: outcome CROSSING is replaced by SILENT, with the new clock, or by OTHER.
        model: constants of the sensor.
        count: number of pixels.
        span_us: duration of the step [µs].
    """
    fields, near, own = batch.fields, batch.crossing, batch.crossing_fields
    found = 0
    for k in range(count):
        near[found] = k
        found += fields[OUTCOME + k] == CROSSING
    for field in COPIED:
        for m in range(found):
            own[field + m] = fields[field + near[m]]
    spend_clocks(own, model, rounded_up(found), span_us)
    for m in range(found):
        left = own[NEW_CLOCK + m]
        fields[NEW_CLOCK + near[m]] = left
        fields[OUTCOME + near[m]] = SILENT if left > 0.0 else OTHER


@inlined
def rising_hazard(before: float, turn: float, after: float) -> float:
    """Return the hazard of an approach from `before` by way of `turn` to `after`, all −ln Φ(h)."""
    return max(turn - before, 0.0) + max(after - turn, 0.0)


@compiled
def spend_clocks(own: Reals, model: PixelModel, count: int, span_us: float) -> None:
    """Compute what a step leaves on the clocks of the first `count` pixels; below 0 they fire."""
    per_us, quarter = 1.0 / span_us, 0.25 * span_us
    has_follower = model.follower_us > 0.0
    for k in range(count):
        corner = own[CORNER + k]
        slope = (own[LOG_TO + k] - own[LOG_FROM + k]) * per_us
        tau_us = 1.0 / corner
        a, b, second_corner = own[LAG + k] - slope * tau_us, 0.0, 0.0
        if has_follower:
            follower_us = separated(tau_us, model.follower_us)
            a, b = amplitudes(own[LAG + k], own[SECOND_LAG + k], slope, tau_us, follower_us)
            second_corner = 1.0 / follower_us
        rise = (slope + own[DRIFT + k]) * quarter
        e1, f1 = exp(-quarter * corner), exp(-quarter * second_corner)
        e2, f2 = e1 * e1, f1 * f1
        start = own[CHANGE + k] + own[LEAK + k]
        level = start + a + b
        d1 = level + rise - a * e1 - b * f1
        d2 = level + 2.0 * rise - a * e2 - b * f2
        d3 = level + 3.0 * rise - a * (e2 * e1) - b * (f2 * f1)
        end = level + 4.0 * rise - a * (e2 * e2) - b * (f2 * f2)
        top, bottom = max(max(d1, d2), d3), min(min(d1, d2), d3)
        turn = top if top > max(start, end) else d2
        turn = bottom if bottom < min(start, end) else turn
        noise = noise_of(own[SIGMA + k], corner, corner, model.follower_us)
        hazard = 0.0
        per_sigma = 1.0 / own[SIGMA + k]
        for side in (1.0, -1.0):
            theta = own[THETA_ON + k] if side > 0.0 else own[THETA_OFF + k]
            before, after = (theta - side * start) * per_sigma, (theta - side * end) * per_sigma
            middle, nearest = (theta - side * d2) * per_sigma, (theta - side * turn) * per_sigma
            steady = diffusion_rate(noise, before) + 4.0 * diffusion_rate(noise, middle)
            steady += diffusion_rate(noise, after)
            hazard += steady * (span_us / 6.0)
            hazard += rising_hazard(surprise(before), surprise(nearest), surprise(after))
        own[NEW_CLOCK + k] = own[CLOCK + k] - hazard
