"""The logarithmic photoreceptor: a first-order low-pass whose cutoff follows the light.

The output v follows u = ln(photocurrent + dark current) through τ·dv/dt = u − v with 1/τ = 2πf and
f proportional to the current up to a bias limit (Lichtsteiner, Posch, Delbruck 2008).

Between two samples u is taken as a straight line. Of the inputs with an exact solution, this one
has no jumps (a constant would make one at every frame, and heap events there) and is what a
pattern with a smooth edge does to the logarithm. With the lag l = u − v and the slope r of u:

    l(s) = r·τ + (l(0) − r·τ)·exp(−s/τ)

which holds for steps of any length, and chains: two halves give the whole. Current is in lux on
the chip, time in µs, everything else in natural logarithms.
"""

from __future__ import annotations

from flybench.kernels import compiled, inlined
from flybench.portable_math import log

LOG_PIECE = 0.25
"""Largest change of u over which τ is held constant, at its value half-way: its mean is then off by
less than 0.3 %. Longer ramps are cut into pieces where τ follows the light."""


@inlined
def log_current(lux: float, dark_lux: float) -> float:
    """Steady output of the photoreceptor, u = ln(E + E_dark), at `lux` on the chip."""
    return log(lux + dark_lux)


@inlined
def corner_per_us(current_lux: float, corner_per_lux: float, corner_limit: float) -> float:
    """Corner 1/τ [1/µs] at a current of `current_lux`, the dark current included.

    Args:
        current_lux: current, as the illuminance that makes it [lux].
        corner_per_lux: 1/τ per lux [1/(µs·lux)].
        corner_limit: 1/τ that the biases allow [1/µs].
    """
    return min(corner_limit, corner_per_lux * current_lux)


@inlined
def lag_after(lag: float, slope: float, tau_us: float, decay: float) -> float:
    """Lag u − v after a ramp of `slope` per µs, for so long that exp(−s/τ) is `decay`."""
    steady = slope * tau_us
    return steady + (lag - steady) * decay


@compiled
def ramp_pieces(log_from: float, log_to: float, log_limit: float) -> int:
    """Into how many pieces to cut a ramp of u, so that τ may be constant in each.

    Args:
        log_from: u at the start [ln lux].
        log_to: u at the end [ln lux].
        log_limit: u above which τ is constant [ln lux].
    """
    if min(log_from, log_to) >= log_limit:
        return 1
    return 1 + int(abs(log_to - log_from) / LOG_PIECE)
