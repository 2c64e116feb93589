"""The pixels of a batch that fire in a step: the third pass over a batch.

The time of the event is that at which the hazard has used up the clock, by Newton's method. The
pixel is then reset (`emulator.pixel.noisy.advance.fire`, for many pixels at once) and followed to
the end of the step. Pixels that have not converged, or that fire again, are left to
`emulator.pixel.noisy.step`.
"""

from __future__ import annotations

import numpy as np

from emulator.noise.first_passage import surprise
from emulator.noise.random_numbers import exponential, gaussian, uniform
from emulator.pixel import fields as at
from emulator.pixel.batch import OTHER, SILENT, SINGLE, Batch, Reals, rounded_up
from emulator.pixel.noisy.advance import mark_of
from emulator.pixel.noisy.hazard import (
    hazards_of,
    lead_at_event,
    mean_diffusion_rate,
    spans_per_tau,
)
from emulator.pixel.noisy.near_batch import (
    course_of,
    quarter_differences,
    spend_clocks,
)
from emulator.pixel.noisy.passage import NoisyCourse, mean_difference, mean_slope
from emulator.pixel.noisy.wake_batch import follow, hold_in_reset
from emulator.pixel.state import MOVED, PixelModel, PixelState
from flybench.kernels import compiled, inlined

_NEWTON_STEPS = 8
"""Steps that suffice for nearly all pixels in moving light (assumed)."""

_TOLERANCE_US = 0.1
_RELATIVE_TOLERANCE = 1e-5
"""Largest last step of an event's time that has converged: in µs, or as a share of the time that
may hold the event, whichever is larger (assumed)."""

_CERTAIN = -2.5
"""Distance in σ from which Newton's method starts if the pixel is nearer at the end: there it has
nearly always fired (assumed)."""


@compiled
def solve_events(
    batch: Batch, state: PixelState, model: PixelModel, count: int, span_us: float
) -> None:
    """Compute the events of the `count` pixels that `solve_near` has left."""
    if count == 0:
        return
    own, rounded = batch.crossing_fields, rounded_up(count)
    fire_and_hold(batch, state, model, count, span_us, _NEWTON_STEPS)
    spend_clocks(own, model, rounded)
    follow(own, model, rounded)
    _return_events(batch, count)


@compiled
def fire_and_hold(
    batch: Batch, state: PixelState, model: PixelModel, count: int, span_us: float, rounds: int
) -> None:
    """Take the first `count` pixels of `crossing_fields` through an event and its reset.

    The reset ends at `span_us` at the latest; START is set to its end. EVENT_TIME is the time of
    the event, MARK 2·cause + polarity. OUTCOME is SINGLE; OTHER if the time has not converged;
    SILENT if there is no event in SPAN, and USED is then what it leaves of the clock. Newton's
    method takes `rounds` steps at most.
    """
    own, rounded = batch.crossing_fields, rounded_up(count)
    _draw(batch, state, model, count)
    _find_quarters(own, model, rounded)
    for _ in range(rounds):
        _improve_times(own, model, rounded)
        if _number_left(own, count) == 0:
            break
    for k in range(rounded):
        own[at.SPAN + k] = own[at.EVENT_TIME + k]
    follow(own, model, rounded)
    _fire(own, model, rounded)
    hold_in_reset(own, model, rounded, span_us)


@compiled
def _number_left(own: Reals, count: int) -> int:
    """Return how many of the first `count` pixels have not converged."""
    left = 0
    for k in range(count):
        left += own[at.OUTCOME + k] == OTHER
    return left


@compiled
def _draw(batch: Batch, state: PixelState, model: PixelModel, count: int) -> None:
    """Draw the random numbers of the next event of the first `count` pixels."""
    own = batch.crossing_fields
    for m in range(count):
        i = int(batch.indices[batch.crossing[m]])
        draw = np.int64(state.pixels[i].draws & ~MOVED)
        own[at.CHOICE + m] = uniform(model.seed, i, draw)
        own[at.NEW_CLOCK + m] = exponential(model.seed, i, draw + 1)
        own[at.GAUSSIAN + m] = gaussian(model.seed, i, draw + 2)


@inlined
def _distances(own: Reals, k: int, d: float) -> tuple[float, float]:
    """Return the distances of d from the ON and the OFF threshold, in units of σ."""
    per_sigma = 1.0 / own[at.SIGMA + k]
    return (own[at.THETA_ON + k] - d) * per_sigma, (own[at.THETA_OFF + k] + d) * per_sigma


@inlined
def _hazard_between(
    own: Reals, k: int, course: NoisyCourse, before: float, after: float, span_us: float
) -> float:
    """Return the hazard while d moves steadily from `before` to `after`."""
    on_before, off_before = _distances(own, k, before)
    on_after, off_after = _distances(own, k, after)
    spans = spans_per_tau(course.noise, span_us)
    steady = mean_diffusion_rate(course.noise, on_before, on_after, spans)
    steady += mean_diffusion_rate(course.noise, off_before, off_after, spans)
    approach = max(surprise(on_after) - surprise(on_before), 0.0)
    approach += max(surprise(off_after) - surprise(off_before), 0.0)
    return steady * span_us + approach


@compiled
def _find_quarters(own: Reals, model: PixelModel, count: int) -> None:
    """Find the quarter of SPAN in which each pixel fires, and a time in it to start from.

    EARLIEST and LATEST are set to the ends of the quarter, LEVEL to d and USED to what is left of
    the clock at its start, SIDE to the direction of d, and EVENT_TIME to a time in it. If the pixel
    does not fire, OUTCOME is SILENT, and USED is what the whole of SPAN leaves of the clock.
    """
    for k in range(count):
        course = course_of(own, k, model)
        quarter_us = 0.25 * own[at.SPAN + k]
        d0 = course.start
        d1, d2, d3, d4 = quarter_differences(course, quarter_us)
        left1 = own[at.CLOCK + k] - _hazard_between(own, k, course, d0, d1, quarter_us)
        left2 = left1 - _hazard_between(own, k, course, d1, d2, quarter_us)
        left3 = left2 - _hazard_between(own, k, course, d2, d3, quarter_us)
        left4 = left3 - _hazard_between(own, k, course, d3, d4, quarter_us)
        late, second, last = left2 > 0.0, left1 > 0.0, left3 > 0.0
        number = (1.0 if second else 0.0) + (1.0 if late else 0.0) + (1.0 if last else 0.0)
        left = left3 if last else (left2 if late else (left1 if second else own[at.CLOCK + k]))
        low = d3 if last else (d2 if late else (d1 if second else d0))
        high = d4 if last else (d3 if late else (d2 if second else d1))
        on_low, off_low = _distances(own, k, low)
        on_high, off_high = _distances(own, k, high)
        before = on_low if high > low else off_low
        after = on_high if high > low else off_high
        share = min(1.0, (before - _CERTAIN) / (before - min(after, before - 1e-6)))
        own[at.EARLIEST + k] = number * quarter_us
        own[at.LATEST + k] = (number + 1.0) * quarter_us
        own[at.EVENT_TIME + k] = (number + max(share, 0.0)) * quarter_us
        own[at.LEVEL + k] = low
        own[at.SIDE + k] = 1.0 if high > low else -1.0
        own[at.USED + k] = left if left4 <= 0.0 else left4
        own[at.OUTCOME + k] = SINGLE if left4 <= 0.0 else SILENT


@compiled
def _improve_times(own: Reals, model: PixelModel, count: int) -> None:
    """Take one step of Newton's method; OTHER are those that are not yet within the tolerance."""
    for k in range(count):
        course = course_of(own, k, model)
        earliest, s = own[at.EARLIEST + k], own[at.EVENT_TIME + k]
        d, rising = mean_difference(course, s), own[at.SIDE + k] > 0.0
        speed = mean_slope(course, s) / own[at.SIGMA + k]
        on_before, off_before = _distances(own, k, own[at.LEVEL + k])
        on, off = _distances(own, k, d)
        spans = spans_per_tau(course.noise, s - earliest)
        steady = mean_diffusion_rate(course.noise, on_before, on, spans)
        steady += mean_diffusion_rate(course.noise, off_before, off, spans)
        h_before, h = (on_before, on) if rising else (off_before, off)
        excess = steady * (s - earliest) + surprise(h) - surprise(h_before) - own[at.USED + k]
        on_rate, off_rate = hazards_of(course.noise, on, off, speed)
        improved = s - excess / (on_rate + off_rate)
        improved = min(max(improved, earliest), own[at.LATEST + k])
        tolerance_us = max(_TOLERANCE_US, _RELATIVE_TOLERANCE * (own[at.LATEST + k] - earliest))
        near = abs(improved - s) < tolerance_us
        own[at.EVENT_TIME + k] = improved
        fires = own[at.OUTCOME + k] != SILENT
        own[at.OUTCOME + k] = (SINGLE if near else OTHER) if fires else SILENT


@compiled
def _fire(own: Reals, model: PixelModel, count: int) -> None:
    """Let the first `count` pixels fire; the new values are those at the time of the event."""
    for k in range(count):
        course = course_of(own, k, model)
        change, leak = own[at.NEW_CHANGE + k], own[at.NEW_LEAK + k]
        d = change + leak
        h_on, h_off = _distances(own, k, d)
        speed = mean_slope(course, own[at.EVENT_TIME + k]) / own[at.SIGMA + k]
        on_rate, off_rate = hazards_of(course.noise, h_on, h_off, speed)
        on = own[at.CHOICE + k] * (on_rate + off_rate) < on_rate
        noise = (own[at.THETA_ON + k] if on else -own[at.THETA_OFF + k]) - d
        own[at.MARK + k] = mark_of(on, change, leak, noise, True)
        sign = 1.0 if on else -1.0
        lead = (
            sign * own[at.SIGMA + k] * lead_at_event(course.noise, model.follower_us, sign * speed)
        )
        own[at.LAG + k] = own[at.NEW_LAG + k] - noise - lead
        own[at.SECOND_LAG + k] = own[at.NEW_SECOND_LAG + k] + lead
        own[at.CLOCK + k] = own[at.NEW_CLOCK + k]
        own[at.START + k] += own[at.EVENT_TIME + k]
        own[at.EVENT_TIME + k] = own[at.START + k]
        own[at.RESET + k] = model.refractory_us


@compiled
def _return_events(batch: Batch, count: int) -> None:
    """Copy the results of the first `count` pixels back to their batch."""
    fields, own = batch.fields, batch.crossing_fields
    for m in range(count):
        k = int(batch.crossing[m])
        outcome = own[at.OUTCOME + m]
        fields[at.OUTCOME + k] = outcome
        if outcome == SILENT:
            fields[at.NEW_CLOCK + k] = own[at.USED + m]
        elif own[at.NEW_CLOCK + m] <= 0.0:
            fields[at.OUTCOME + k] = OTHER
        elif outcome == SINGLE:
            fields[at.EVENT_TIME + k] = own[at.EVENT_TIME + m]
            fields[at.MARK + k] = own[at.MARK + m]
            fields[at.NEW_LAG + k] = own[at.NEW_LAG + m]
            fields[at.NEW_SECOND_LAG + k] = own[at.NEW_SECOND_LAG + m]
            fields[at.NEW_CHANGE + k] = own[at.NEW_CHANGE + m]
            fields[at.NEW_LEAK + k] = own[at.NEW_LEAK + m] - own[at.RESET + m]
            fields[at.NEW_CLOCK + k] = own[at.NEW_CLOCK + m]
