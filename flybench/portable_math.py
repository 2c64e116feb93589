"""Exponential, logarithm, sine and cosine for kernels, with the same bits on every machine.

They use only sums and products, so that the compiler can process many pixels at a time, and the
compiler may not reorder or fuse them. The last bits of a mathematical library would depend on the
machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from flybench.kernels import inlined

EXP_RANGE = 700.0
"""Arguments of `exp` are clipped to ±700, where its result is 1e±304."""

_LOG2_E = 1.4426950408889634
_LN2_HIGH = 0.6931471803691238
_LN2_LOW = 1.9082149292705877e-10
_INTEGER = 6755399441055744.0
"""1.5·2^52: a double whose last bit has the value 1, so that adding it rounds to a whole number."""
_INTEGER_BITS = np.int64(0x4338000000000000)
_TWO_52 = 4503599627370496.0
_TWO_52_BITS = np.uint64(0x4330000000000000)
_ROOT_HALF_BITS = np.int64(0x3FE6A09E667F3BCD)
_MANTISSA_BITS = 52


def _conversion(result: Any, argument: Any, name: str) -> Any:
    """Intrinsic of one argument that is the LLVM instruction `name`."""

    def convert(_context: Any, _x: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            if name == "bitcast":
                return builder.bitcast(arguments[0], context.get_value_type(result))
            return builder.cttz(arguments[0], context.get_constant(types.boolean, 0))

        return result(argument), generate

    return intrinsic(convert)


_bits_of = _conversion(types.int64, types.float64, "bitcast")
_float_of = _conversion(types.float64, types.int64, "bitcast")


def _fused(_context: Any, _x: Any, _y: Any, _z: Any) -> Any:
    """Intrinsic of three arguments that is the LLVM instruction `fma`."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


fma: Any = intrinsic(_fused)
"""x·y + z with a single rounding, which is the same on every machine by definition."""

lowest_bit = _conversion(types.uint64, types.uint64, "cttz")
"""Index of the lowest set bit of a uint64; 64 if no bit is set."""


@inlined
def to_double(whole: np.uint64) -> float:
    """Return a whole number below 2^52 as a double, computed from its bits."""
    result: float = _float_of(np.int64(whole | _TWO_52_BITS)) - _TWO_52
    return result


@inlined
def sine_and_cosine(x: float) -> tuple[float, float]:
    """Return sine and cosine of x in ±π/2, from their series, with an error of at most 6e-8."""
    y = x * x
    sine = fma(
        fma(
            fma(fma(fma(-1.0 / 39916800.0, y, 1.0 / 362880.0), y, -1.0 / 5040.0), y, 1.0 / 120.0),
            y,
            -1.0 / 6.0,
        ),
        y,
        1.0,
    )
    cosine = fma(
        fma(
            fma(
                fma(
                    fma(fma(1.0 / 479001600.0, y, -1.0 / 3628800.0), y, 1.0 / 40320.0),
                    y,
                    -1.0 / 720.0,
                ),
                y,
                1.0 / 24.0,
            ),
            y,
            -0.5,
        ),
        y,
        1.0,
    )
    return x * sine, cosine


@inlined
def exp(x: float) -> float:
    """Return e^x with a relative error of at most 3e-13.

    It uses the series around the nearest multiple of ln 2.
    """
    x = max(min(x, EXP_RANGE), -EXP_RANGE)
    shifted = fma(x, _LOG2_E, _INTEGER)
    power = shifted - _INTEGER
    r = fma(power, -_LN2_LOW, fma(power, -_LN2_HIGH, x))
    r2 = r * r
    r4 = r2 * r2
    low = fma(fma(1.0 / 6.0, r, 0.5), r2, 1.0 + r)
    middle = fma(fma(1.0 / 5040.0, r, 1.0 / 720.0), r2, fma(1.0 / 120.0, r, 1.0 / 24.0))
    high = fma(1.0 / 3628800.0, r2, fma(1.0 / 362880.0, r, 1.0 / 40320.0))
    series = fma(high, r4 * r4, fma(middle, r4, low))
    result: float = _float_of(_bits_of(series) + (_bits_of(shifted) << _MANTISSA_BITS))
    return result


@inlined
def short_exp(x: float) -> float:
    """Return e^x for |x| < 700 with a relative error of at most 1.8e-7, faster than `exp`."""
    shifted = fma(x, _LOG2_E, _INTEGER)
    r = fma(shifted - _INTEGER, -_LN2_HIGH, x)
    r2 = r * r
    low = fma(fma(1.0 / 6.0, r, 0.5), r2, 1.0 + r)
    high = fma(1.0 / 720.0, r2, fma(1.0 / 120.0, r, 1.0 / 24.0))
    series = fma(high, r2 * r2, low)
    result: float = _float_of(_bits_of(series) + (_bits_of(shifted) << _MANTISSA_BITS))
    return result


@inlined
def log(x: float) -> float:
    """Return the logarithm of a positive normal number with an error of at most 2e-14.

    It uses the series of artanh around 1.
    """
    bits = _bits_of(x)
    exponent = (bits - _ROOT_HALF_BITS) >> _MANTISSA_BITS
    fraction = _float_of(bits - (exponent << _MANTISSA_BITS)) - 1.0
    power = _float_of(exponent + _INTEGER_BITS) - _INTEGER
    s = fraction / (2.0 + fraction)
    z = s * s
    z2 = z * z
    low = fma(fma(2.0 / 7.0, z, 2.0 / 5.0), z2, fma(2.0 / 3.0, z, 2.0))
    high = fma(2.0 / 15.0, z2, fma(2.0 / 13.0, z, 2.0 / 11.0))
    series = fma(fma(high, z, 2.0 / 9.0), z2 * z2, low)
    result: float = fma(power, _LN2_HIGH, fma(power, _LN2_LOW, s * series))
    return result
