"""Samples half way between rendered ones, by a cubic in time of the logarithm of luminance.

Pixels take the logarithm of luminance to change linearly between two samples. A cubic follows a
moving edge more closely. A cubic of luminance itself does so, too, but it overshoots where light
changes by factors: at dusk and at night it adds up to 7 % of events that do not exist (measured in
the combinations of `python -m tools.convergence_table`).
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled, inlined
from flybench.portable_math import exp, log
from sim.cache.luminance_file import LuminanceSample
from sim.geometry.rectangles import Rectangle, enclosing_rectangle

F32 = npt.NDArray[np.float32]

MAX_UNEVENNESS = 0.1
"""How much longer than the shortest the longest of three intervals may be, relative to it, so that
they count as equal (assumed)."""
DARKEST_CD_M2 = 1e-6
"""Lower luminance counts as this, because 0 has no logarithm (assumed: a hundredth of the darkest
night sky) [cd/m²]."""


def with_midpoints(
    samples: Iterable[LuminanceSample],
) -> Generator[LuminanceSample, None, None]:
    """Yield samples, and one half way between two where their neighbours are as far apart.

    It shows the bodies of the sample before it. The logarithm of its luminance is the Catmull-Rom
    cubic through the two samples before it and the two after it, (−a + 9 b + 9 c − d) / 16.

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
    """Set `out`, which is equal to b, half way from b to c in a rectangle; see `with_midpoints`."""
    x0, y0, x1, y1 = rectangle
    for row in range(y0, y1):
        i = np.uintp(row)
        for column in range(x0, x1):
            j = np.uintp(column)
            before, after = b[i, j], c[i, j]
            if a[i, j] == before and before == after and after == d[i, j]:
                continue  # what stands still is exactly constant
            inner = _log(before) + _log(after)
            out[i, j] = exp((9.0 * inner - _log(a[i, j]) - _log(d[i, j])) / 16.0)


@inlined
def _log(luminance: float) -> float:
    """Return the logarithm of a luminance, which is at least `DARKEST_CD_M2`."""
    return log(max(luminance, DARKEST_CD_M2))
