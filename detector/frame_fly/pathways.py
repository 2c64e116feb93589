"""The first stages of the frame-based fly: from frames to ON and OFF signals.

Each function is one stage of Fu and Yue (2020), in the order of processing: retina, lamina, and
input of the medulla. A map is (rows, columns) float32.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled

F32 = npt.NDArray[np.float32]


def weight_of_present(interval_us: float, tau_us: float) -> float:
    """Return α = Δ / (Δ + τ) of a first-order filter that is stepped once per frame.

    Args:
        interval_us: Δ, time since the previous frame [µs].
        tau_us: τ, time constant [µs].
    """
    return interval_us / (interval_us + tau_us)


def grey_levels(frame: npt.NDArray[np.uint16], *, full_scale_dn: float, cell_px: int) -> F32:
    """Return raw counts as grey levels from 0 to 255, averaged over cells.

    Args:
        frame: (height, width) uint16 [DN].
        full_scale_dn: count that becomes 255 [DN].
        cell_px: side of a cell [px]; incomplete cells at the right and lower edge are cut off.
    """
    rows, columns = frame.shape[0] // cell_px, frame.shape[1] // cell_px
    whole = frame[: rows * cell_px, : columns * cell_px].astype(np.float32)
    if cell_px > 1:
        whole = np.asarray(
            cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA), np.float32
        )
    return np.asarray(whole * np.float32(255.0 / full_scale_dn), np.float32)


def luminance_change(now: F32, before: F32) -> F32:
    """Return the difference of two frames (retina), P(t) = L(t) − L(t−1)."""
    return np.asarray(now - before, np.float32)


def gaussian_kernel(side: int, sigma: float) -> F32:
    """Return one axis of G(u, v) = 1/(2πσ²)·e^(−(u²+v²)/(2σ²)), cut to the kernel; (side,)."""
    u = np.arange(side) - side // 2
    kernel = np.exp(-(u**2) / (2.0 * sigma**2)) / (np.sqrt(2.0 * np.pi) * sigma)
    return np.asarray(kernel, np.float32)


def blurred(change: F32, kernel: F32) -> F32:
    """Convolve both axes with a kernel; edge values continue outside the image."""
    replicate = cv2.BORDER_REPLICATE
    return np.asarray(cv2.sepFilter2D(change, -1, kernel, kernel, borderType=replicate), np.float32)


def spatial_difference(centre: F32, surround: F32) -> F32:
    """Return the difference of Gaussians with its sign rule (lamina).

    Where centre and surround are both positive, the absolute difference counts as brightening;
    where both are negative, it counts as darkening. The rule does not cover opposite signs; the
    difference is then 0 (assumed).
    """
    difference = np.empty(centre.shape, np.float32)
    _subtract(centre.ravel(), surround.ravel(), difference.ravel())
    return difference


@compiled
def _subtract(centre: Any, surround: Any, difference: Any) -> None:
    for k in range(centre.size):
        size = abs(centre[k] - surround[k])
        if centre[k] > 0.0 and surround[k] > 0.0:
            difference[k] = size
        elif centre[k] < 0.0 and surround[k] < 0.0:
            difference[k] = -size
        else:
            difference[k] = 0.0


def on_off(signal: F32) -> F32:
    """Rectify a signal into the ON and OFF pathways; (2, rows, columns), each ≥ 0."""
    pathways = np.empty((2, *signal.shape), np.float32)
    _rectify(signal.ravel(), pathways.reshape(2, -1))
    return pathways


@compiled
def _rectify(signal: Any, pathways: Any) -> None:
    on, off = pathways
    for k in range(signal.size):
        on[k], off[k] = max(signal[k], np.float32(0.0)), max(-signal[k], np.float32(0.0))


class Adaptation:
    """Fast-depolarising, slow-repolarising adaptation: a signal minus its own low-pass.

    The low-pass has one time constant while the signal rises and another while it falls or stays,
    so that the first change passes and flicker is suppressed for a while.
    """

    def __init__(self, shape: tuple[int, ...], *, rising_us: float, falling_us: float) -> None:
        """Start with a signal and a low-pass of 0.

        Args:
            shape: shape of the signal.
            rising_us: time constant while the signal rises [µs].
            falling_us: time constant while the signal falls or stays [µs].
        """
        self._rising_us, self._falling_us = rising_us, falling_us
        self._low_pass = np.zeros(shape, np.float32)
        self._before = np.zeros(shape, np.float32)

    def step(self, signal: F32, *, interval_us: float) -> F32:
        """Return the adapted signal of the next frame, `interval_us` later, ≥ 0."""
        fast = np.float32(weight_of_present(interval_us, self._rising_us))
        slow = np.float32(weight_of_present(interval_us, self._falling_us))
        adapted = np.empty(signal.shape, np.float32)
        _adapt(
            signal.ravel(),
            self._before.ravel(),
            self._low_pass.ravel(),
            fast,
            slow,
            adapted.ravel(),
        )
        self._before = signal
        return adapted


@compiled
def _adapt(signal: Any, before: Any, low_pass: Any, fast: Any, slow: Any, adapted: Any) -> None:
    for k in range(signal.size):
        alpha = fast if signal[k] > before[k] else slow
        low_pass[k] += alpha * (signal[k] - low_pass[k])
        adapted[k] = max(signal[k] - low_pass[k], np.float32(0.0))
