"""The pixels of a batch that noise may carry across a threshold: the second pass over a batch.

The mean difference d of each pixel is sampled at five times of the rest of the step. Its hazard is
that of `emulator.pixel.noisy.passage`, with one turning point of d at most. A pixel whose clock
survives it is finished; the others are left to `emulator.pixel.noisy.fire_batch`.
"""

from __future__ import annotations

from emulator.noise.first_passage import surprise
from emulator.noise.photoreceptor_noise import noise_of
from emulator.pixel import fields as at
from emulator.pixel.batch import CROSSING, SILENT, Batch, Reals, rounded_up
from emulator.pixel.noisy.hazard import mean_diffusion_rate, spans_per_tau
from emulator.pixel.noisy.passage import NoisyCourse
from emulator.pixel.source_follower import amplitudes, separated, separated_corner
from emulator.pixel.state import PixelModel
from flybench.kernels import compiled, inlined
from flybench.portable_math import exp

COPIED = (
    at.LAG,
    at.SECOND_LAG,
    at.CHANGE,
    at.LEAK,
    at.CLOCK,
    at.THETA_ON,
    at.THETA_OFF,
    at.LOG_FROM,
    at.LOG_TO,
    at.DRIFT,
    at.CORNER,
    at.SIGMA,
    at.START,
)
"""Fields that the pass reads."""

KEPT = (*COPIED, at.SLOPE, at.SPAN, at.FIRST, at.SECOND)
"""Fields of the pixels that are left."""

LONGEST = 2.5
"""Longest step, in time constants of the last low-pass: in a quarter of it d is nearly straight."""


@compiled
def solve_near(batch: Batch, model: PixelModel, count: int, span_us: float) -> int:
    """Finish the near pixels among the first `count` of a batch that stay silent.

    Args:
        batch: outcome CROSSING is replaced by SILENT, with the new clock, if the pixel has no
            event. The others are left in `crossing` and `crossing_fields`, with KEPT.
        model: constants of the sensor.
        count: number of pixels.
        span_us: duration of the step [µs].

    Returns:
        The number of the others.
    """
    fields, near = batch.fields, batch.crossing
    found = 0
    for k in range(count):
        near[found] = k
        found += fields[at.OUTCOME + k] == CROSSING
    in_place = 2 * found > count
    own, taken = (fields, count) if in_place else (_copied(batch, found), found)
    per_us = 1.0 / span_us
    for m in range(rounded_up(taken)):
        own[at.SLOPE + m] = (own[at.LOG_TO + m] - own[at.LOG_FROM + m]) * per_us
        own[at.SPAN + m] = span_us - own[at.START + m]
    spend_clocks(own, model, rounded_up(taken))
    firing = 0
    for n in range(found):
        k = near[n]
        m = k if in_place else n
        left = own[at.NEW_CLOCK + m]
        fields[at.NEW_CLOCK + k] = left
        if left > 0.0:
            fields[at.OUTCOME + k] = SILENT
        else:
            for field in KEPT:
                batch.crossing_fields[field + firing] = own[field + m]
            near[firing] = k
            firing += 1
    return firing


@compiled
def _copied(batch: Batch, count: int) -> Reals:
    """Copy the first `count` pixels of `crossing` to `crossing_fields`, and return these."""
    fields, near, own = batch.fields, batch.crossing, batch.crossing_fields
    for field in COPIED:
        for m in range(count):
            own[field + m] = fields[field + near[m]]
    return own


@inlined
def course_of(own: Reals, k: int, model: PixelModel) -> NoisyCourse:
    """Return the course of a pixel, of which `spend_clocks` has stored the amplitudes."""
    corner, second_corner = own[at.CORNER + k], 0.0
    if model.follower_us > 0.0:
        second_corner = separated_corner(corner, model.follower_us)
    return NoisyCourse(
        own[at.CHANGE + k] + own[at.LEAK + k],
        own[at.SLOPE + k] + own[at.DRIFT + k],
        own[at.FIRST + k],
        own[at.SECOND + k],
        corner,
        second_corner,
        noise_of(own[at.SIGMA + k], corner, corner, model.follower_us),
    )


@inlined
def quarter_differences(
    course: NoisyCourse, quarter_us: float
) -> tuple[float, float, float, float]:
    """Return d after one, two, three and four quarters of a span."""
    a, b, rise = course.a, course.b, course.rate * quarter_us
    level = course.start + a + b
    e1, f1 = exp(-quarter_us * course.corner), exp(-quarter_us * course.second_corner)
    e2, f2 = e1 * e1, f1 * f1
    return (
        level + rise - a * e1 - b * f1,
        level + 2.0 * rise - a * e2 - b * f2,
        level + 3.0 * rise - a * (e2 * e1) - b * (f2 * f1),
        level + 4.0 * rise - a * (e2 * e2) - b * (f2 * f2),
    )


@compiled
def spend_clocks(own: Reals, model: PixelModel, count: int) -> None:
    """Compute what SPAN leaves on the clocks of the first `count` pixels; at 0 or less they fire.

    For the noise, the course of d is replaced by a line with the same mean and the same rise. Its
    approach to a threshold counts to the place where d turns, and from there to that of the other.
    """
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, slope, tau_us = own[at.LAG + k], own[at.SLOPE + k], 1.0 / own[at.CORNER + k]
        a, b = lag - slope * tau_us, 0.0
        if has_follower:
            follower_us = separated(tau_us, model.follower_us)
            a, b = amplitudes(lag, own[at.SECOND_LAG + k], slope, tau_us, follower_us)
        own[at.FIRST + k], own[at.SECOND + k] = a, b
        course = course_of(own, k, model)
        start = course.start
        d1, d2, d3, end = quarter_differences(course, 0.25 * own[at.SPAN + k])
        top, bottom = max(max(d1, d2), d3), min(min(d1, d2), d3)
        turn = top if top > max(start, end) else end
        turn = bottom if bottom < min(start, end) else turn
        per_sigma = 1.0 / own[at.SIGMA + k]
        theta_on, theta_off = own[at.THETA_ON + k], own[at.THETA_OFF + k]
        bend = (2.0 / 3.0) * (d2 - 0.5 * (start + end))
        line_start, line_end = start + bend, end + bend
        spans = spans_per_tau(course.noise, own[at.SPAN + k])
        on_start, on_end = (theta_on - line_start) * per_sigma, (theta_on - line_end) * per_sigma
        off_start, off_end = (
            (theta_off + line_start) * per_sigma,
            (theta_off + line_end) * per_sigma,
        )
        steady = mean_diffusion_rate(course.noise, on_start, on_end, spans)
        steady += mean_diffusion_rate(course.noise, off_start, off_end, spans)
        rises = turn > start
        near, far = (theta_on, theta_off) if rises else (theta_off, theta_on)
        sign = per_sigma if rises else -per_sigma
        hazard = surprise(near * per_sigma - sign * turn)
        hazard -= surprise(near * per_sigma - sign * start)
        back = surprise(far * per_sigma + sign * end) - surprise(far * per_sigma + sign * turn)
        hazard = steady * own[at.SPAN + k] + max(hazard, 0.0) + max(back, 0.0)
        own[at.NEW_CLOCK + k] = own[at.CLOCK + k] - hazard
