"""The hazard of noise at the thresholds of one pixel.

The rate at which noise carries the pixel across is

    Λ' = A_on + A_off + B_on + B_off,  A = c·ν(h)/((1 + s·h)·τ),  B = max(0, −h')·φ(h)/Φ(h)
    h_on = (θ_on − d)/σ,  h_off = (θ_off + d)/σ

with the mean d of the difference to the memorised value, and the standard deviation σ of the noise
(`emulator.noise.first_passage`; the factor with s is for two low-passes in a row, see
`emulator.noise.photoreceptor_noise`; c ≤ 1 is `moving_share`). While d is monotone, the integral of
B is a difference of −ln Φ(h). As σ falls, B makes the crossing as sharp as that of a pixel without
noise.
"""

from __future__ import annotations

import math

from emulator.noise.first_passage import decay_rate, sojourn, surprise, surprise_slope
from emulator.noise.photoreceptor_noise import SMOOTHING, Noise
from emulator.pixel.segment import Mismatch
from flybench.kernels import inlined

_NEARER_PART = 0.35
"""Distance in σ over which ν falls to less than half, at usual distances of 2 to 5 σ."""

_WIDTH = 5e-4
"""Distance in σ by which every move is widened, so that no difference is divided by zero."""

_RICE = math.sqrt(0.5 * math.pi)
"""Mean slope of Gaussian noise as it crosses a fixed threshold, over its standard deviation."""

_SHORTEST = 1e-9
"""Shortest duration of a move, in correlation times, so that its speed is finite."""


@inlined
def distances(noise: Noise, mismatch: Mismatch, d: float) -> tuple[float, float]:
    """Return the distances h of d from the ON and the OFF threshold, in units of σ."""
    return (mismatch.theta_on - d) / noise.sigma, (mismatch.theta_off + d) / noise.sigma


@inlined
def moving_share(noise: Noise, h: float, speed: float) -> float:
    """Return the share c of the diffusion rate that is left at a threshold that moves.

    ν presumes that the noise near the threshold has crossed it long ago. If the threshold comes
    fast, that noise is still there, and B alone lets it cross. A process that approaches h at the
    speed v, in σ per correlation time, then has the density of crossings φ(h)·(v + h) (Durbin, J.
    Appl. Prob. 22, 1985, first approximation). Hence ν becomes m·(m + h), with m = φ/Φ; its ratio
    to ν is 1/(1 + 0.45y + 0.17y²), with y = max(1 − h, 0), within 9 % for −3 < h < 1. The weight
    of the fast form is v/(1 + v) (assumed). From a threshold that goes, the noise falls behind:
    1/(1 + |v|/2) is within a third of the Fokker-Planck equation for |v| up to 10 and h up to 3.

    Two low-passes make the noise smooth, with a slope of the standard deviation 1/√(τ1·τ2).
    Crossings of a smooth process have the density φ(h)·E[max(v + slope, 0)] (Rice 1944), of which B
    holds φ(h)·max(v, 0). The polynomial of x = |v|·√(τ1·τ2) approaches what is left.
    """
    v = abs(speed)
    x = v * noise.smoothing * (1.0 / SMOOTHING)
    y = max(1.0 - h, 0.0)
    near = 1.0 + y * (0.45 + y * 0.17)
    smooth = 1.0 + x * (1.25 + x * (1.07 + x * 1.4))
    left = near + v if speed > 0.0 else 1.0
    whole = near * (1.0 + v) if speed > 0.0 else 1.0 + 0.5 * v
    return left / (whole * smooth)


@inlined
def diffusion_rate(noise: Noise, h: float, speed: float) -> float:
    """Return the hazard A of noise at a threshold [1/µs].

    Args:
        noise: noise of the photoreceptor.
        h: distance of the threshold [σ].
        speed: −h', by which it approaches [σ per correlation time].
    """
    rate = decay_rate(h) * noise.per_tau / (1.0 + noise.smoothing * max(h, 0.0))
    return rate * moving_share(noise, h, speed)


@inlined
def mean_diffusion_rate(noise: Noise, before: float, after: float, spans: float) -> float:
    """Return the mean of `diffusion_rate` while h moves steadily from `before` to `after` [1/µs].

    The factors of ν are those of a place in the nearer part, where most crossings are.

    Args:
        noise: noise of the photoreceptor.
        before: distance of the threshold at the start [σ].
        after: distance at the end [σ].
        spans: correlation time over the duration of the move (`spans_per_tau`).
    """
    near, far = min(before, after) - _WIDTH, max(before, after) + _WIDTH
    weighted = near + min(0.5 * (far - near), _NEARER_PART)
    width = (far - near) * (1.0 + noise.smoothing * max(weighted, 0.0))
    share = moving_share(noise, weighted, (before - after) * spans)
    return (sojourn(near) - sojourn(far)) / width * noise.per_tau * share


@inlined
def spans_per_tau(noise: Noise, span_us: float) -> float:
    """Return the correlation time of the noise over a duration, which may be 0."""
    return 1.0 / max(span_us * noise.per_tau, _SHORTEST)


@inlined
def approach_hazard(noise: Noise, mismatch: Mismatch, before: float, after: float) -> float:
    """Return the hazard that d adds as it moves, monotone, from `before` to `after`."""
    on_before, off_before = distances(noise, mismatch, before)
    on_after, off_after = distances(noise, mismatch, after)
    on = max(surprise(on_after) - surprise(on_before), 0.0)
    off = max(surprise(off_after) - surprise(off_before), 0.0)
    return on + off


@inlined
def steady_rate(
    noise: Noise, mismatch: Mismatch, before: float, after: float, span_us: float
) -> float:
    """Return the mean hazard of noise and of a hot pixel as d moves from `before` to `after`."""
    on_before, off_before = distances(noise, mismatch, before)
    on_after, off_after = distances(noise, mismatch, after)
    spans = spans_per_tau(noise, span_us)
    rate = mean_diffusion_rate(noise, on_before, on_after, spans)
    rate += mean_diffusion_rate(noise, off_before, off_after, spans)
    return rate + abs(mismatch.hot_rate)


@inlined
def hazards_of(noise: Noise, h_on: float, h_off: float, speed: float) -> tuple[float, float]:
    """Return the hazards of the ON and of the OFF threshold, hot pixels aside [1/µs].

    Args:
        noise: noise of the photoreceptor.
        h_on: distance of d from the ON threshold, in units of σ.
        h_off: distance of d from the OFF threshold, in units of σ.
        speed: slope of d in σ [1/µs].
    """
    per_tau = speed / noise.per_tau
    on = diffusion_rate(noise, h_on, per_tau) + max(speed, 0.0) * surprise_slope(h_on)
    off = diffusion_rate(noise, h_off, -per_tau) + max(-speed, 0.0) * surprise_slope(h_off)
    return on, off


@inlined
def lead_at_event(noise: Noise, follower_us: float, speed: float) -> float:
    """Return by how much the photoreceptor's noise leads the follower's at an event [σ].

    The output of the follower moves on by (v − w)/τ2. Noise that crosses a threshold has, on
    average, the slope E[n'·max(v + n', 0)]/E[max(v + n', 0)] (Rice 1944), with n' as in
    `moving_share`. That is 1.25/(1 + 0.45x + 0.17x²) standard deviations of n', within 3 % for
    x < 3.

    Args:
        noise: noise of the photoreceptor.
        follower_us: time constant τ2 of the follower, 0 without one [µs].
        speed: speed v at which the threshold approaches, in σ [1/µs].
    """
    root_us = noise.smoothing * (1.0 / SMOOTHING) / noise.per_tau
    x = max(speed, 0.0) * root_us
    slope = _RICE / (1.0 + x * (0.45 + x * 0.17))
    return slope * follower_us / max(root_us, 1e-3)
