"""Noise of quiet pixels against brightness, with its spread over the pixels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from emulator import ApsFrame

BRIGHTNESS_EDGES = (0.0, 1 / 32, 1 / 8, 1 / 2, 2.0)
"""Lower edges of the classes of brightness, relative to the mean level of the recording's frames:
levels of two cameras, or of two exposures, cannot be compared themselves."""
_MIN_EVENTS = 10
"""Fewest events from which the spread of a class is computed (assumed)."""

B1 = npt.NDArray[np.bool_]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]


@dataclass(frozen=True)
class NoiseClass:
    """Noise of the quiet pixels of one class of brightness.

    Attributes:
        from_brightness: lower edge of the brightness, relative to the mean; None: all quiet pixels.
        pixels: number of quiet pixels.
        seconds: duration of the recording [s].
        on: number of ON events of these pixels.
        off: number of OFF events of these pixels.
        silent: share of these pixels without an event; None without pixels.
        spread: standard deviation of ln(rate) over the pixels; None below 10 events.
    """

    from_brightness: float | None
    pixels: int
    seconds: float
    on: int
    off: int
    silent: float | None
    spread: float | None

    @property
    def on_hz(self) -> float | None:
        """Mean rate of ON events per pixel [Hz]; None without pixels."""
        return self.on / (self.pixels * self.seconds) if self.pixels else None

    @property
    def off_hz(self) -> float | None:
        """Mean rate of OFF events per pixel [Hz]; None without pixels."""
        return self.off / (self.pixels * self.seconds) if self.pixels else None

    @property
    def rate_hz(self) -> float | None:
        """Mean rate of events per pixel [Hz]; None without pixels."""
        return (self.on + self.off) / (self.pixels * self.seconds) if self.pixels else None


def brightness_label(from_brightness: float | None) -> str:
    """Return the range of a class of brightness, such as "1/8–1/2 of mean"."""
    if from_brightness is None:
        return "all quiet pixels"
    edges = [str(Fraction(edge)) for edge in BRIGHTNESS_EDGES]
    k = BRIGHTNESS_EDGES.index(from_brightness)
    if k == 0:
        return f"< {edges[1]} of mean"
    return f"{edges[k]}–{edges[k + 1]} of mean" if k + 1 < len(edges) else f"≥ {edges[k]} of mean"


class MeanFrame:
    """Mean of the APS frames of a recording.

    Attributes:
        frames: number of frames of the sensor's size; others are left out.
    """

    def __init__(self, *, width: int, height: int) -> None:
        self.frames = 0
        self._sum = np.zeros((height, width))

    def add(self, frames: Iterable[ApsFrame]) -> None:
        """Include frames."""
        for frame in frames:
            if frame.image.shape == self._sum.shape:
                self._sum += frame.image
                self.frames += 1

    def brightness(self) -> F64 | None:
        """Return the (rows, columns) mean level, relative to its mean; None without light."""
        mean = float(self._sum.mean())
        return self._sum / mean if mean > 0 else None


def spread_of_rates(counts: I64) -> float | None:
    """Return the standard deviation of ln(rate) over the pixels, for log-normal rates.

    The scatter of Poisson counts is removed: Var(n) = E(n) + Var(rate)·T². A log-normal law of the
    relative variance c² has a logarithm of the variance ln(1 + c²). Pixels of equal rate give 0,
    and so do those that fire more regularly than a Poisson process. Bursts count as spread.

    Args:
        counts: (n,) number of events of each pixel.

    Returns:
        The spread, 0 or more; None below 10 events.
    """
    if counts.sum() < _MIN_EVENTS:
        return None
    mean = float(counts.mean())
    relative_variance = max(0.0, float(counts.var()) - mean) / mean**2
    return math.sqrt(math.log1p(relative_variance))


def noise_classes(
    counts: I64, quiet: B1, brightness: F64 | None, span_us: int
) -> tuple[NoiseClass, ...]:
    """Return the noise of all quiet pixels, and then of each class of brightness.

    Args:
        counts: (2, rows, columns) number of OFF and of ON events.
        quiet: (rows, columns) True at quiet pixels.
        brightness: (rows, columns) level relative to the mean; None: no frames, and no classes.
        span_us: duration of the recording, above 0 [µs].
    """
    classes = [_noise_class(None, counts[:, quiet], span_us)]
    if brightness is not None:
        index = np.searchsorted(BRIGHTNESS_EDGES, brightness, side="right") - 1
        for k, edge in enumerate(BRIGHTNESS_EDGES):
            classes.append(_noise_class(edge, counts[:, quiet & (index == k)], span_us))
    return tuple(classes)


def _noise_class(edge: float | None, counts: I64, span_us: int) -> NoiseClass:
    totals = counts.sum(axis=0)
    return NoiseClass(
        from_brightness=edge,
        pixels=totals.size,
        seconds=span_us * 1e-6,
        on=int(counts[1].sum()),
        off=int(counts[0].sum()),
        silent=float(np.mean(totals == 0)) if totals.size else None,
        spread=spread_of_rates(totals),
    )
