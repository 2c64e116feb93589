"""A slow, exact simulation of noisy event pixels, which the fast kernels are compared with.

The noise is drawn in small steps: exactly, as the output of one or two low-passes of white noise
(Gillespie 1996 for one; the same by matrix for two). Between two steps a single low-pass may cross
a threshold unseen; the probability of that is the one of a Brownian bridge (Giraudo, Sacerdote
1999).
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from scipy.linalg import expm

Reals = npt.NDArray[np.float64]


class ExactPixel(NamedTuple):
    """Constants of all pixels.

    Attributes:
        sigma: standard deviation of the noise at the output [ln units].
        tau_us: time constant of the photoreceptor [µs].
        follower_us: time constant of the follower, 0 without one [µs].
        refractory_us: time in reset after an event [µs].
        leak_per_us: drift of the memorised value [ln units/µs].
    """

    sigma: float
    tau_us: float
    follower_us: float = 0.0
    refractory_us: float = 0.0
    leak_per_us: float = 0.0


class ExactEvents(NamedTuple):
    """Events of all pixels, pixel by pixel; all fields are (n,).

    Attributes:
        pixel: index of the pixel.
        t_us: time [µs].
        on: True for ON.
    """

    pixel: npt.NDArray[np.int64]
    t_us: Reals
    on: npt.NDArray[np.bool_]


def exact_events(
    pixel: ExactPixel,
    theta_on: Reals,
    theta_off: Reals,
    *,
    times_us: Reals,
    log_lux: Reals,
    phase: Reals,
    settle_us: float,
    seed: int,
    steps_per_tau: int = 24,
) -> ExactEvents:
    """Return the events of pixels that see an input which is linear between samples.

    Args:
        pixel: constants of the pixels.
        theta_on: (pixels,) ON thresholds [ln units].
        theta_off: (pixels,) OFF thresholds [ln units].
        times_us: (samples,) times of the samples of the input, from 0 [µs].
        log_lux: (samples,) u at these times [ln lux].
        phase: (pixels,) mean difference to the memorised value at the start [ln units].
        settle_us: time with the first input before time 0, without events in the result [µs].
        seed: seed of the random numbers.
        steps_per_tau: steps in the shorter time constant. The time of an event is exact to a step.
    """
    shortest_us = pixel.tau_us if pixel.follower_us == 0.0 else min(pixel.tau_us, pixel.follower_us)
    step_us = shortest_us / steps_per_tau
    count = round((times_us[-1] + settle_us) / step_us)
    grid_us = np.arange(count + 1) * step_us - settle_us
    mean = _filtered(np.interp(grid_us, times_us, log_lux), pixel, step_us)
    keep, draw, start = _noise_matrices(pixel, step_us)
    random = np.random.default_rng(seed)
    found = _simulate(
        pixel, theta_on, theta_off, phase, mean, grid_us[0], step_us, keep, draw, start, random
    )
    later = found[1] > 0.0
    return ExactEvents(found[0][later], found[1][later], found[2][later])


def _filtered(u: Reals, pixel: ExactPixel, step_us: float) -> Reals:
    """Return the output of the low-passes for an input that is linear within each step."""
    for tau_us in (pixel.tau_us, pixel.follower_us):
        if tau_us > 0.0:
            u = _low_pass(u, tau_us / step_us)
    return u


@numba.njit(cache=True)
def _low_pass(u: Reals, tau: float) -> Reals:
    out = np.empty_like(u)
    out[0] = lagged = u[0]
    decay = np.exp(-1.0 / tau)
    for k in range(1, u.size):
        slope = u[k] - u[k - 1]
        lag = slope * tau + (u[k - 1] - lagged - slope * tau) * decay
        lagged = u[k] - lag
        out[k] = lagged
    return out


def _noise_matrices(pixel: ExactPixel, step_us: float) -> tuple[Reals, Reals, Reals]:
    """Return what a step keeps of the noise, and factors of what it and the start draw.

    The state is (photoreceptor, follower); white noise enters the photoreceptor. Without a follower
    its entry is 0.
    """
    tau, follower = pixel.tau_us, pixel.follower_us
    if follower == 0.0:
        kept = np.exp(-step_us / tau)
        drawn = pixel.sigma * np.sqrt(1.0 - kept**2)
        return np.diag([kept, 0.0]), np.diag([drawn, 0.0]), np.diag([pixel.sigma, 0.0])
    first = pixel.sigma**2 * (tau + follower) / tau
    stationary = np.array([[first, 0.0], [0.0, pixel.sigma**2]])
    stationary[0, 1] = stationary[1, 0] = first * tau / (tau + follower)
    keep = expm(np.array([[-1.0 / tau, 0.0], [1.0 / follower, -1.0 / follower]]) * step_us)
    added = stationary - keep @ stationary @ keep.T
    return keep, np.linalg.cholesky(added), np.linalg.cholesky(stationary)


@numba.njit(cache=True)
def _simulate(  # type: ignore[no-untyped-def]
    pixel, theta_on, theta_off, phase, mean, start_us, step_us, keep, draw, start, random
):
    index, times, ons = [0], [-np.inf], [False]
    hold = round(pixel.refractory_us / step_us)
    variance = 2.0 * pixel.sigma**2 / pixel.tau_us * step_us
    bridge = pixel.follower_us == 0.0
    for i in range(theta_on.size):
        g, h = random.normal(), random.normal()
        first = start[0, 0] * g + start[0, 1] * h
        second = start[1, 0] * g + start[1, 1] * h
        output = mean[0] + (first if bridge else second)
        memory = mean[0] - phase[i]
        waiting = 0
        for k in range(1, mean.size):
            g, h = random.normal(), random.normal()
            old_first = first
            first = keep[0, 0] * first + draw[0, 0] * g
            second = keep[1, 0] * old_first + keep[1, 1] * second + draw[1, 0] * g + draw[1, 1] * h
            before, output = output, mean[k] + (first if bridge else second)
            if waiting > 0:
                waiting -= 1
                memory = output
                continue
            low = before - memory
            memory -= pixel.leak_per_us * step_us
            high = output - memory
            on, off = high >= theta_on[i], high <= -theta_off[i]
            if bridge and not (on or off):
                gap, later = theta_on[i] - low, theta_on[i] - high
                on = random.random() < np.exp(-2.0 * gap * later / variance)
                gap, later = theta_off[i] + low, theta_off[i] + high
                off = not on and random.random() < np.exp(-2.0 * gap * later / variance)
            if on or off:
                index.append(i)
                times.append(start_us + (k - random.random()) * step_us)
                ons.append(on)
                memory += theta_on[i] if on else -theta_off[i]
                if hold > 0:
                    waiting, memory = hold, output
    return np.array(index), np.array(times), np.array(ons)
