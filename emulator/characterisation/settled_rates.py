"""Rates of ON and OFF events of a pixel that sees constant light, from the equations of the model.

At the end of its refractory period, a pixel memorises the light with its noise n0. From then on the
mean n(t) of the noise relaxes to 0 through the low-passes, and leak moves the memory down, so that
the mean difference is d(t) = n(t) − n0 + drift·t. Noise crosses a threshold with the hazard of
`emulator.pixel.noisy.hazard`. It is then θ_on above the memory, or θ_off below. A share of it is
left at the end of the refractory period, when the rest of the variance is new. So n0 is a Markov
chain, and its stationary distribution gives both rates. Averages over pixels take the mismatch of
the thresholds and the spread of the dark current by Gauss-Hermite quadrature.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from emulator.config import SensorConfig
from emulator.noise.first_passage import H_MAX, surprise
from emulator.noise.photoreceptor_noise import noise_of
from emulator.pixel.noisy.hazard import diffusion_rate, lead_at_event
from emulator.pixel.source_follower import separated
from flybench.kernels import compiled

_STATES = 41
"""Values of the memorised noise."""
_BEYOND = 4.0
"""Range of these values beyond the thresholds [σ]."""
_FIRST, _GROWTH = 0.05, 0.15
"""First step of time [τ], and growth of the steps as a share of the time so far."""
_MOVE = 0.25
"""Largest change of the mean in a step [σ]."""
_ALIVE = 1e-4
_MOST_STEPS = 4000
_CHAIN_STEPS = 60
_BRIGHT = 20.0
"""Illuminance, over the dark current, above which its spread does not matter."""
_NODES = np.array([-math.sqrt(3.0), 0.0, math.sqrt(3.0)])
_WEIGHTS = np.array([1.0, 4.0, 1.0]) / 6.0
"""Gauss-Hermite quadrature of a normal distribution, exact to the fifth power."""

F64 = npt.NDArray[np.float64]


def settled_rates(config: SensorConfig, lux: npt.ArrayLike, *, leak_factor: float = 1.0) -> F64:
    """Return the mean rates of pixels in constant light.

    Args:
        config: the sensor; hot and crazy pixels, and the readout, do not matter.
        lux: (n,) illuminance on the chip, without the dark current [lux].
        leak_factor: leak over its median.

    Returns:
        (n, 2) rates of ON and of OFF events of a pixel [Hz].
    """
    values = np.atleast_1d(np.asarray(lux, np.float64))
    per_hz = 2.0 * math.pi * 1e-6
    follower_us = 1.0 / (per_hz * config.follower_hz) if config.follower_hz else 0.0
    leak_hz = (config.warm_leak_hz + config.leak_hz_per_lux * values) * leak_factor
    rates = np.empty((values.size, 2))
    _mean_rates(
        values,
        config.theta_on,
        config.theta_off,
        config.theta_mismatch,
        config.warm_dark_lux,
        config.dark_current_spread,
        per_hz * config.bandwidth_hz_per_lux,
        per_hz * config.bandwidth_limit_hz,
        follower_us,
        config.noise_sigma,
        float(config.refractory_us),
        leak_hz * config.theta_on * 1e-6,
        _NODES,
        _WEIGHTS,
        rates,
    )
    return rates * 1e6


@compiled
def _mean_rates(
    lux: Any,
    theta_on: float,
    theta_off: float,
    mismatch: float,
    dark_lux: float,
    dark_spread: float,
    corner_per_lux: float,
    corner_limit: float,
    follower_us: float,
    sigma_0: float,
    refractory_us: float,
    drift: Any,
    nodes: Any,
    weights: Any,
    rates: Any,
) -> None:
    for k in range(lux.size):
        on = off = 0.0
        # The dark current matters only in dim light.
        several = lux[k] < _BRIGHT * dark_lux and dark_spread > 0.0
        for a in range(nodes.size):
            if not several and a != 1:
                continue
            current = lux[k] + dark_lux * math.exp(dark_spread * nodes[a])
            open_corner = corner_per_lux * current
            corner = min(open_corner, corner_limit)
            noise = noise_of(sigma_0, corner, open_corner, follower_us)
            decay = _decay(noise, 1.0 / corner, follower_us)
            for b in range(nodes.size):
                for c in range(nodes.size):
                    high = max(theta_on + mismatch * nodes[b], 0.01)
                    low = max(theta_off + mismatch * nodes[c], 0.01)
                    found = _rates(noise, decay, high, low, refractory_us, drift[k])
                    weight = weights[b] * weights[c]
                    weight *= weights[a] if several else 1.0
                    on += weight * found[0]
                    off += weight * found[1]
        rates[k, 0], rates[k, 1] = on, off


class _Decay(NamedTuple):
    """How the mean of the noise relaxes.

    Attributes:
        tau_us: time constant τ1 of the photoreceptor [µs].
        follower_us: time constant τ2 of the follower [µs].
        lead: photoreceptor's noise minus the follower's at an event [ln units].
    """

    tau_us: float
    follower_us: float
    lead: float


@compiled
def _decay(noise: Any, tau_us: float, follower_us: float) -> _Decay:
    lead = noise.sigma * lead_at_event(noise, follower_us, 0.0)
    return _Decay(tau_us, separated(tau_us, max(follower_us, 1e-3 * tau_us)), lead)


@compiled
def _output(decay: Any, output: float, ahead: float, time_us: float) -> float:
    """Return the follower's mean noise after a time; `ahead` is the photoreceptor's at first."""
    tau_us, follower_us = decay.tau_us, decay.follower_us
    first, second = math.exp(-time_us / tau_us), math.exp(-time_us / follower_us)
    mean: float = ahead * tau_us / (tau_us - follower_us) * (first - second) + output * second
    return mean


@compiled
def _lead_after(decay: Any, output: float, time_us: float) -> float:
    """Return the photoreceptor's noise minus the follower's some time after an event with noise."""
    ahead = output + math.copysign(decay.lead, output)
    left = ahead * math.exp(-time_us / decay.tau_us)
    return left - _output(decay, output, ahead, time_us)


@compiled
def _rates(
    noise: Any, decay: Any, theta_on: float, theta_off: float, refractory_us: float, drift: float
) -> tuple[float, float]:
    """Return the rates of one pixel [1/µs]."""
    sigma = noise.sigma
    if min(theta_on, theta_off) > 2.0 * H_MAX * sigma:  # noise reaches neither threshold
        return drift / (theta_on + drift * refractory_us), 0.0
    lowest = -theta_off - _BEYOND * sigma
    spacing = (theta_on + theta_off + 2.0 * _BEYOND * sigma) / (_STATES - 1)
    crossing = np.zeros((_STATES, _STATES))
    on_share, cycle_us = np.zeros(_STATES), np.zeros(_STATES)
    for i in range(_STATES):
        start = lowest + i * spacing
        ahead = start + _lead_after(decay, start, refractory_us)
        found = _follow(
            noise, decay, theta_on, theta_off, drift, start, ahead, lowest, spacing, crossing[i]
        )
        on_share[i], cycle_us[i] = found[0], found[1] + refractory_us
    chain = crossing @ _reset(noise, decay, refractory_us, lowest, spacing)
    state = np.full(_STATES, 1.0 / _STATES)
    for _ in range(_CHAIN_STEPS):
        state = state @ chain
        state /= state.sum()
    per_us = 1.0 / (state * cycle_us).sum()
    on = (state * on_share).sum()
    return on * per_us, (1.0 - on) * per_us


@compiled
def _reset(noise: Any, decay: Any, refractory_us: float, lowest: float, spacing: float) -> Any:
    """Return the probabilities of the noise after the refractory period, given that before it."""
    kept = math.exp(-refractory_us * noise.per_tau)
    width = noise.sigma * math.sqrt(1.0 - kept * kept)
    table = np.zeros((_STATES, _STATES))
    for i in range(_STATES):
        before = lowest + i * spacing
        ahead = before + math.copysign(decay.lead, before)
        mean = _output(decay, before, ahead, refractory_us)
        if width < 0.5 * spacing:
            _deposit(table[i], (mean - lowest) / spacing, 1.0)
            continue
        for j in range(_STATES):
            distance = (lowest + j * spacing - mean) / width
            table[i, j] = math.exp(-0.5 * distance * distance)
        table[i] /= table[i].sum()
    return table


@compiled
def _deposit(row: Any, place: float, weight: float) -> None:
    """Share a weight between the two states beside a place."""
    place = min(max(place, 0.0), row.size - 1.001)
    k = int(place)
    row[k] += weight * (k + 1 - place)
    row[k + 1] += weight * (place - k)


@compiled
def _follow(
    noise: Any,
    decay: Any,
    theta_on: float,
    theta_off: float,
    drift: float,
    start: float,
    ahead: float,
    lowest: float,
    spacing: float,
    crossing: Any,
) -> tuple[float, float]:
    """Follow a pixel from a reset to its next event.

    Args:
        noise: noise of the pixel.
        decay: how its mean relaxes.
        theta_on: its ON threshold [ln units].
        theta_off: its OFF threshold [ln units].
        drift: leak [ln units/µs].
        start: memorised noise n0 [ln units].
        ahead: photoreceptor's noise at that time [ln units].
        lowest: lowest value of the noise at the crossing [ln units].
        spacing: distance of these values [ln units].
        crossing: output, probability of each value.

    Returns:
        The probability of an ON event, and the mean time to the event [µs].
    """
    sigma, per_tau = noise.sigma, noise.per_tau
    time_us = 0.0
    d, alive, mean_us, on_share = 0.0, 1.0, 0.0, 0.0
    for _ in range(_MOST_STEPS):
        left = math.exp(-time_us * per_tau)
        speed = abs(drift - start * per_tau * left)
        step_us = _FIRST / per_tau + _GROWTH * time_us
        if speed > 0.0:
            step_us = min(step_us, max(_MOVE * sigma / speed, 0.01 / per_tau))
        after = _output(decay, start, ahead, time_us + step_us) - start
        after += drift * (time_us + step_us)
        middle = 0.5 * (d + after)
        h_on, h_off = (theta_on - middle) / sigma, (theta_off + middle) / sigma
        approach = (after - d) / (sigma * step_us * per_tau)
        on = diffusion_rate(noise, h_on, approach) * step_us
        off = diffusion_rate(noise, h_off, -approach) * step_us
        if h_on >= H_MAX:
            on = 0.0
        if h_off >= H_MAX:
            off = 0.0
        on += max(surprise((theta_on - after) / sigma) - surprise((theta_on - d) / sigma), 0.0)
        off += max(surprise((theta_off + after) / sigma) - surprise((theta_off + d) / sigma), 0.0)
        total = on + off
        survival = math.exp(-total)
        lost = alive * (1.0 - survival)
        inside = 0.5 if total < 1e-6 else 1.0 / total - survival / (1.0 - survival)
        mean_us += lost * (time_us + inside * step_us)
        if total > 0.0:
            on_share += lost * on / total
            memory = start - drift * (time_us + 0.5 * step_us) - lowest
            _deposit(crossing, (memory + theta_on) / spacing, lost * on / total)
            _deposit(crossing, (memory - theta_off) / spacing, lost * off / total)
        alive *= survival
        time_us += step_us
        d = after
        if alive < _ALIVE:
            break
    gone = 1.0 - alive
    if gone <= 0.0:
        return 0.0, time_us
    crossing /= gone
    # What is still alive after the last step goes on at the same mean.
    return on_share / gone, mean_us / gone + (alive * time_us / gone if alive > _ALIVE else 0.0)
