"""Random numbers of the kernels: each depends only on a seed, a pixel and a count."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from flybench.portable_math import log, sine_and_cosine, to_double

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_S32 = np.uint64(32)
_LOW_WORD = np.uint64(0xFFFFFFFF)
_STEP = 2.0**-53
_PER_WORD = 2.0**-32
_WORDS = 2.0**26


@compiled
def uniform(seed: np.uint64, pixel: int, draw: int | np.int64) -> float:
    """Return a random number in (0, 1) that depends on (seed, pixel, draw) alone.

    The finaliser of SplitMix64 (Steele, Lea, Flood 2014), applied to the counter and to the seed.
    """
    z = ((np.uint64(pixel) << _S32) | np.uint64(draw)) * _GOLDEN
    for _ in range(2):
        z = (z ^ (z >> _S30)) * _MIX_1
        z = (z ^ (z >> _S27)) * _MIX_2
        z = (z ^ (z >> _S31)) + seed
    return (np.float64(z >> _S11) + 0.5) * _STEP


@compiled
def exponential(seed: np.uint64, pixel: int, draw: int | np.int64) -> float:
    """Return a unit exponential random number that depends on (seed, pixel, draw) alone."""
    return -log(uniform(seed, pixel, draw))


@compiled
def gaussian(seed: np.uint64, pixel: int, draw: int | np.int64) -> float:
    """Return a Gaussian random number of unit variance that depends on (seed, pixel, draw) alone.

    The transform of Box and Muller (1958), applied to the number `draw` and to the halves of its
    52 bits.
    """
    word = uniform(seed, pixel, draw) * _WORDS
    whole = math.floor(word)
    radius = math.sqrt(-2.0 * log((whole + 0.5) / _WORDS))
    _, cosine = sine_and_cosine(math.pi * (word - whole - 0.5))
    return radius * (2.0 * cosine * cosine - 1.0)


@compiled
def draw_gaussians(seed: np.uint64, first: np.uint64, out: npt.NDArray[np.float32]) -> None:
    """Fill `out` with independent Gaussian random numbers of unit variance.

    The transform of Box and Muller (1958), applied to the two 32-bit halves of the finaliser of
    SplitMix64; no number is beyond ±6.8.

    Args:
        seed: seed of the sequence.
        first: position in the sequence at which to begin, in pairs.
        out: (n,) float32, output array.
    """
    pairs = (out.size + 1) // 2
    ones, others = out[:pairs], out[out.size - pairs :]
    for k in range(pairs):
        z = (np.uint64(k) + first) * _GOLDEN + seed
        z = (z ^ (z >> _S30)) * _MIX_1
        z = (z ^ (z >> _S27)) * _MIX_2
        z = z ^ (z >> _S31)
        radius = math.sqrt(-2.0 * log((to_double(z >> _S32) + 0.5) * _PER_WORD))
        turn = (to_double(z & _LOW_WORD) + 0.5) * _PER_WORD - 0.5
        sine, cosine = sine_and_cosine(math.pi * turn)
        ones[k] = radius * (2.0 * sine * cosine)
        others[k] = radius * (1.0 - 2.0 * sine * sine)
