"""Follows many pixels at once through a step without an event: with noise, or with a follower.

Most pixels stay so far from both thresholds that noise cannot carry them across; they need only
their state at the end of the step. The others are left to `emulator.pixel.noisy.near_batch`, or
taken through the step one by one (`emulator.pixel.noisy.step`, or `emulator.pixel.batch_events`
without noise).
"""

from __future__ import annotations

from emulator.noise.first_passage import H_MAX
from emulator.noise.leak import leak_drift
from emulator.noise.photoreceptor_noise import noise_of
from emulator.pixel import fields as at
from emulator.pixel.batch import CROSSING, OTHER, SILENT, Batch
from emulator.pixel.noisy.near_batch import LONGEST
from emulator.pixel.noisy.passage import bounds
from emulator.pixel.photoreceptor import LOG_PIECE, inverse_tau_per_us, lag_after, log_current
from emulator.pixel.source_follower import amplitudes, separated, separated_corner
from emulator.pixel.state import PixelModel
from flybench.kernels import compiled
from flybench.portable_math import exp


@compiled
def follow_quiet(batch: Batch, model: PixelModel, count: int, span_us: float) -> None:
    """Follow the first `count` pixels through `span_us`; SILENT are those that stay far away."""
    fields, changed = batch.fields, batch.changed
    per_us = 1.0 / span_us
    per_cd_m2 = model.lux_per_cd_m2
    has_noise = model.sigma_0 > 0.0
    has_follower = model.follower_us > 0.0
    for k in range(count):
        lag, leak, second_lag = fields[at.LAG + k], fields[at.LEAK + k], fields[at.SECOND_LAG + k]
        dark_lux = fields[at.DARK_LUX + k]
        log_from = log_current(fields[at.LUMINANCE_FROM + k] * per_cd_m2, dark_lux)
        log_to = log_current(fields[at.LUMINANCE_TO + k] * per_cd_m2, dark_lux)
        current_lux = exp(0.5 * (log_from + log_to))
        corner = inverse_tau_per_us(current_lux, model.corner_per_lux, model.corner_limit)
        tau_us = 1.0 / corner
        drift = leak_drift(model.leak, current_lux - dark_lux, fields[at.LEAK_FACTOR + k])
        noise = noise_of(
            model.sigma_0, corner, model.corner_per_lux * current_lux, model.follower_us
        )
        start_us = fields[at.START + k]
        left_us = span_us - start_us
        rise = log_to - log_from
        slope = rise * per_us
        short = (rise < LOG_PIECE) & (rise > -LOG_PIECE)
        rise *= 1.0 - start_us * per_us
        decay = exp(-left_us * corner)
        new_lag = lag_after(lag, slope, tau_us, decay)
        new_second = 0.0
        if has_follower:
            follower_us = separated(tau_us, model.follower_us)
            coupling, own = amplitudes(lag, second_lag, slope, tau_us, follower_us)
            coupling -= lag - slope * tau_us
            second_decay = exp(-left_us * separated_corner(corner, model.follower_us))
            new_second = slope * follower_us + coupling * decay + own * second_decay
        new_change = fields[at.CHANGE + k] + rise - (new_lag - lag) - (new_second - second_lag)
        new_leak = leak + drift * left_us
        total = lag + second_lag
        low, high = bounds(fields[at.CHANGE + k] + leak, second_lag, total, total + rise)
        margin, leaked = H_MAX * noise.sigma, drift * left_us
        within = high + margin + leaked < fields[at.THETA_ON + k]
        within &= low - margin > -fields[at.THETA_OFF + k]
        within |= left_us <= 0.0
        awake = (fields[at.REST + k] == 0.0) & ((leak >= 0.0) | (left_us <= 0.0)) & changed[k]
        bright = (log_from >= model.log_limit) & (log_to >= model.log_limit)
        followed = awake & (bright | short) & (fields[at.HOT_RATE + k] == 0.0)
        last_us = model.follower_us if has_follower else tau_us
        near = has_noise & (span_us <= LONGEST * last_us)
        fields[at.LOG_FROM + k] = log_from
        fields[at.LOG_TO + k] = log_to
        fields[at.NEW_LAG + k] = new_lag
        fields[at.NEW_CHANGE + k] = new_change
        fields[at.NEW_LEAK + k] = new_leak
        fields[at.NEW_CLOCK + k] = fields[at.CLOCK + k]
        fields[at.NEW_SECOND_LAG + k] = new_second
        fields[at.DRIFT + k] = drift
        fields[at.CORNER + k] = corner
        fields[at.SIGMA + k] = noise.sigma
        outcome = SILENT if within else (CROSSING if near else OTHER)
        fields[at.OUTCOME + k] = outcome if followed else OTHER
