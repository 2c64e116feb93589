"""A bank of space-time filters of several speeds and 8 directions, and its normalisation.

The filters read events in cells of 2×2 px and respond at every other cell. They are separable: a
temporal filter turns the events into an image, to which the factors of x and y of a Gabor filter
are applied. Opposite directions share them, because only the sign of the odd part differs.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from detector.cells import OUTSIDE, centred_cells
from detector.space_time_filters.filters import SUPPORT, biphasic, gabor, monophasic, mu_of_speed
from flybench.events import Events
from flybench.kernels import compiled, compiled_fastmath

CELL_PX = 2
"""Side of a cell [px] (assumed). A period of the Gabor filter has six cells."""
_STRIDE = 2
"""Cells from one response to the next (assumed): 4 px, the standard deviation of a filter."""
_DEVIATIONS = 6.0
"""Reach of a Gabor filter [standard deviations]: beyond it, weights are below 2e-8."""
_TABLE = 512
"""Number of ages at which the temporal filters are tabulated (assumed)."""
DIRECTIONS = 8
"""Number of directions; direction k is k · 45° from right to down (assumed; the paper shows its
filters in steps of 45°)."""

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]


class FilterBank:
    """Filters of all speeds and directions for a sensor."""

    def __init__(
        self, speeds_px_s: F64, *, sigma: float, frequency: float, width: int, height: int
    ) -> None:
        """Tabulate the filters.

        Args:
            speeds_px_s: preferred speeds [px/s].
            sigma: σ of the Gabor filters.
            frequency: spatial frequency of the Gabor filters [1/px].
            width: sensor columns [px].
            height: sensor rows [px].
        """
        mus = np.array([mu_of_speed(v, frequency) for v in speeds_px_s.tolist()])
        self.support_us = np.ceil(SUPPORT * mus * 1e6)
        ages = (np.arange(_TABLE) + 0.5) / _TABLE * SUPPORT
        self._temporal = np.stack([monophasic(ages, 1.0), biphasic(ages, 1.0)]).astype(np.float32)
        self._cells = odd_cells(height), odd_cells(width)
        self._cell_of = tuple(
            centred_cells(size, CELL_PX, cells)
            for size, cells in zip((height, width), self._cells, strict=True)
        )
        self.shape = (self._cells[0] + 1) // _STRIDE, (self._cells[1] + 1) // _STRIDE
        self._axis = axis_filters(sigma=sigma, frequency=frequency)

    def responses(self, events: Events, end_us: int) -> F32:
        """Return the responses at a time (equation 25).

        Args:
            events: sorted by t, all before `end_us`; those older than `support_us` have no effect.
            end_us: time [µs].

        Returns:
            (speeds, directions, rows, columns) float32.
        """
        images = np.zeros((2, self.support_us.size, *self._cells), np.float32)
        _accumulate(events, end_us, self.support_us, self._temporal, self._cell_of, images)
        return _directions(images[0], images[1], self._axis)


def odd_cells(size_px: int) -> int:
    """Return the number of cells along an axis: odd, so that the responses are symmetrical."""
    return (size_px // CELL_PX - 1) // 2 * 2 + 1


class AxisFilters(NamedTuple):
    """Factors of the Gabor filters along one axis: the weights of cells around a response.

    Each is (2·reach + 1,) float32, from the cell `reach` before the response to that after it.

    Attributes:
        plain: of frequency 0.
        even: real part at f₀.
        odd: imaginary part at f₀.
        even_oblique: real part at f₀/√2.
        odd_oblique: imaginary part at f₀/√2.
    """

    plain: F32
    even: F32
    odd: F32
    even_oblique: F32
    odd_oblique: F32


def axis_filters(*, sigma: float, frequency: float) -> AxisFilters:
    """Return the factors of an axis.

    Args:
        sigma: σ of the Gabor filters.
        frequency: their spatial frequency [1/px].
    """
    reach = math.ceil(_DEVIATIONS * sigma / (2.0 * math.pi) / CELL_PX)
    distance_px = -np.arange(-reach, reach + 1, dtype=np.float64) * CELL_PX
    plain, straight, oblique = (
        gabor(distance_px, frequency * share, sigma) for share in (0.0, 1.0, math.sqrt(0.5))
    )
    parts = (plain.real, straight.real, straight.imag, oblique.real, oblique.imag)
    return AxisFilters(*(np.ascontiguousarray(part, np.float32) for part in parts))


def _directions(mono: F32, bi: F32, axis: AxisFilters) -> F32:
    """Return the responses of all directions to the images of the temporal filters (equation 25).

    They respond most to a wave that moves against the frequency vector of the Gabor filter, so that
    the odd part has a minus sign.
    """
    right = _part(bi, axis.plain, axis.even), _part(mono, axis.plain, axis.odd)
    below = _part(bi, axis.even, axis.plain), _part(mono, axis.odd, axis.plain)
    even = _part(bi, axis.even_oblique, axis.even_oblique)
    twice_odd = _part(bi, axis.odd_oblique, axis.odd_oblique)
    x_odd = _part(mono, axis.even_oblique, axis.odd_oblique)
    y_odd = _part(mono, axis.odd_oblique, axis.even_oblique)
    below_right = even - twice_odd, x_odd + y_odd
    below_left = even + twice_odd, y_odd - x_odd
    axes = (right, below_right, below, below_left)
    return np.stack([e - o for e, o in axes] + [e + o for e, o in axes], axis=1)


@compiled_fastmath
def _part(images: Any, down: Any, across: Any) -> Any:
    """Filter images along both axes, and keep every other row and column.

    BLAS would be as fast on one core, but its threads cost many times as much on a busy machine.
    """
    speeds, rows, columns = images.shape
    reach = down.size // 2
    height, width = (rows + 1) // 2, (columns + 1) // 2
    responses = np.zeros((speeds, height, width), np.float32)
    # The even and the odd cells of a row lie apart, so that both loops run over neighbours.
    line = np.zeros((2, width + reach + 1), np.float32)
    whole = np.zeros(columns, np.float32)
    for s in range(speeds):
        for y in range(height):
            whole[:] = 0.0
            for k in range(max(0, reach - 2 * y), min(down.size, rows - 2 * y + reach)):
                weight, row = down[k], images[s, 2 * y + k - reach]
                for x in range(columns):
                    whole[x] += weight * row[x]
            for x in range(columns):
                line[(x + reach) % 2, (x + reach) // 2] = whole[x]
            response = responses[s, y]
            for k in range(across.size):
                weight, cells = across[k], line[k % 2, k // 2 :]
                for x in range(width):
                    response[x] += weight * cells[x]
    return responses


@compiled
def _accumulate(
    events: Any, end_us: int, support_us: Any, temporal: Any, cell_of: Any, images: Any
) -> None:
    """Add each event, with its polarity as its sign, to the images of its temporal filters."""
    speeds = images.shape[1]
    ages = temporal.shape[1]
    for n in range(events.size - 1, -1, -1):
        event = events[n]
        row, column = cell_of[0][event.y], cell_of[1][event.x]
        if row == OUTSIDE or column == OUTSIDE:
            continue
        sign = np.float32(1.0 if event.p else -1.0)
        age_us = float(end_us - event.t)
        for s in range(speeds):
            age = int(age_us / support_us[s] * ages)
            if age < ages:
                images[0, s, row, column] += sign * temporal[0, age]
                images[1, s, row, column] += sign * temporal[1, age]


class Normalisation:
    """Divisive inhibition by the responses around a point (equation 31)."""

    def __init__(
        self,
        *,
        beta: float,
        alpha_p: float,
        alpha_q: float,
        sigma_px: float,
        shape: tuple[int, int],
    ) -> None:
        """Tabulate the weights c of the pool.

        Args:
            beta: β.
            alpha_p: α_p.
            alpha_q: α_q.
            sigma_px: standard deviation of the pool [px].
            shape: rows and columns of the responses.
        """
        self._beta, self._alpha_p, self._alpha_q = beta, alpha_p, alpha_q
        self._down, self._across = (_pool(n, sigma_px / (CELL_PX * _STRIDE)) for n in shape)

    def __call__(self, responses: F32) -> F32:
        """Return the normalised responses.

        The pool is the mean over all directions and speeds, weighted by a Gaussian in space.

        Args:
            responses: (speeds, directions, rows, columns).

        Returns:
            The same shape, each in [0, β).
        """
        active = np.maximum(responses, np.float32(0.0))
        pool = self._down @ active.mean(axis=(0, 1)) @ self._across.T
        return np.asarray(self._beta * active / (self._alpha_p + active + pool / self._alpha_q))


def _pool(number: int, sigma: float) -> F32:
    """Return Gaussian weights, (number, number); an inner row sums to 1."""
    distance = np.arange(number)[:, None] - np.arange(number)
    reach = np.arange(-number, number + 1)
    total = np.exp(-(reach**2) / (2.0 * sigma**2)).sum()
    return np.asarray(np.exp(-(distance**2) / (2.0 * sigma**2)) / total, np.float32)
