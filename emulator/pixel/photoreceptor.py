"""The logarithmic photoreceptor: a first-order low-pass whose cutoff grows with the illuminance.

The output v follows u = ln(photocurrent + dark current) through τ·dv/dt = u − v with 1/τ = 2πf, and
f is proportional to the current up to a limit set by the biases (Lichtsteiner, Posch, Delbruck
2008).

Between two samples, u changes linearly. Of the inputs with an exact solution, this one has no jumps
(a constant input would jump at every frame, and concentrate events there), and the logarithm
changes in this way when a pattern with a smooth edge moves. With the lag l = u − v and the slope r
of u:

    l(s) = r·τ + (l(0) − r·τ)·exp(−s/τ)

This holds for steps of any length, and two half steps give the same as one whole step. Currents are
given in lux on the chip, times in µs, and everything else in natural logarithms.
"""

from __future__ import annotations

from flybench.kernels import compiled, inlined
from flybench.portable_math import log

LOG_PIECE = 0.25
"""Largest change of u over which τ is held constant, at its value in the middle. The mean of τ is
then wrong by less than 0.3 %. Longer ramps are cut into pieces where τ depends on the light."""


@inlined
def log_current(lux: float, dark_lux: float) -> float:
    """Return the steady output of the photoreceptor, u = ln(E + E_dark), at `lux` on the chip."""
    return log(lux + dark_lux)


@inlined
def inverse_tau_per_us(current_lux: float, corner_per_lux: float, corner_limit: float) -> float:
    """Return the corner frequency 1/τ [1/µs].

    Args:
        current_lux: current including the dark current, as an illuminance [lux].
        corner_per_lux: 1/τ per lux [1/(µs·lux)].
        corner_limit: 1/τ that the biases allow [1/µs].
    """
    return min(corner_limit, corner_per_lux * current_lux)


@inlined
def lag_after(lag: float, slope: float, tau_us: float, decay: float) -> float:
    """Return the lag u − v after a ramp of u.

    Args:
        lag: lag at the start of the ramp [ln units].
        slope: slope of u [ln units/µs].
        tau_us: time constant τ [µs].
        decay: exp(−s/τ) for a ramp of duration s.
    """
    steady = slope * tau_us
    return steady + (lag - steady) * decay


@compiled
def ramp_pieces(log_from: float, log_to: float, log_limit: float) -> int:
    """Return the number of pieces to cut a ramp of u into, so that τ may be constant in each.

    Args:
        log_from: u at the start [ln lux].
        log_to: u at the end [ln lux].
        log_limit: u above which τ is constant [ln lux].
    """
    if min(log_from, log_to) >= log_limit:
        return 1
    return 1 + int(abs(log_to - log_from) / LOG_PIECE)
