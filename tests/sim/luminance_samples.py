"""Synthetic luminance samples, reproducible by seed."""

from collections.abc import Iterator

import numpy as np

from sim.cache.luminance_cache import LuminanceStream
from sim.cache.luminance_file import LuminanceSample

SHAPE = 5, 7
KEY = "a" * 64
OTHER_KEY = "b" * 64


def samples(
    start: int = 0, count: int = 4, seed: int = 0, shape: tuple[int, int] = SHAPE
) -> LuminanceStream:
    """Yield samples from number `start` on.

    Each changes a rectangle of the one before; the third changes nothing.
    """
    rng = np.random.default_rng(seed)
    height, width = shape
    luminance = rng.lognormal(3, 2, shape).astype(np.float32)
    body = rng.integers(-1, 9, shape, np.int32)
    rectangle = 0, 0, width, height
    for number in range(count):
        if number >= start:
            yield LuminanceSample(1000 * number, luminance.copy(), body.copy(), rectangle)
        x0, y0 = int(rng.integers(width - 1)), int(rng.integers(height - 1))
        rectangle = (x0, y0, width, height) if number != 1 else (0, 0, 0, 0)
        x0, y0, x1, y1 = rectangle
        luminance[y0:y1, x0:x1] *= rng.lognormal(0, 1, (y1 - y0, x1 - x0)).astype(np.float32)
        body[y0:y1, x0:x1] = rng.integers(-1, 300, (y1 - y0, x1 - x0))


def equal(one: Iterator[LuminanceSample], other: Iterator[LuminanceSample]) -> bool:
    """Return True if both give equal samples, bit for bit."""
    return [_bits(sample) for sample in one] == [_bits(sample) for sample in other]


def _bits(sample: LuminanceSample) -> tuple[object, ...]:
    arrays = sample.luminance, sample.body
    contents = [(array.dtype, array.shape, array.tobytes()) for array in arrays]
    return sample.t_us, sample.changed, *contents
