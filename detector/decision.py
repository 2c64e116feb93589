"""The decision that all detectors share: from two responses to one direction or none."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from detector.estimate import MotionEstimate
from flybench.direction import Direction

F64 = npt.NDArray[np.float64]

_BELOW_ONE = math.nextafter(1.0, 0.0)


def clip_to_open_interval(value: float) -> float:
    """Return the value, clipped to the open interval (−1, 1)."""
    return max(-_BELOW_ONE, min(_BELOW_ONE, value))


def winner_take_all(
    hs: float,
    vs: float,
    *,
    snr: tuple[float, float],
    snr_floor: float,
    shares: tuple[float, float] = (1.0, 1.0),
    share_floor: float = 0.0,
) -> Direction:
    """Return the direction of the stronger system, or `NONE` if its response is below a floor.

    In a tie the horizontal system wins.

    Args:
        hs: normalised response of the horizontal system.
        vs: normalised response of the vertical system.
        snr: signal-to-noise ratio of each system; for the fly, see
            `detector.fly.tangential.signal_to_noise`.
        snr_floor: least ratio that counts as motion.
        shares: response of each system as a share of the sum of its two directions; for the fly,
            see `detector.fly.tangential.shares_of_total`.
        share_floor: least absolute share that counts as motion.
    """
    is_horizontal = abs(hs) >= abs(vs)
    response, ratio = (hs, snr[0]) if is_horizontal else (vs, snr[1])
    share = abs(shares[0] if is_horizontal else shares[1])
    if response == 0.0 or ratio < snr_floor or share < share_floor:
        return Direction.NONE
    if is_horizontal:
        return Direction.RIGHT if response > 0 else Direction.LEFT
    return Direction.DOWN if response > 0 else Direction.UP


def velocity_estimate(
    t_us: int,
    velocity_px_s: tuple[float, float],
    *,
    limit_px_s: float,
    ratio: float,
    ratio_floor: float,
    image_centre_px: tuple[float, float],
) -> MotionEstimate:
    """Return the estimate of a detector that measures one velocity and has no attention.

    Args:
        t_us: end of the window [µs].
        velocity_px_s: (x, y) of the image velocity [px/s]; it becomes `response`.
        limit_px_s: speed at which hs or vs is 1 [px/s].
        ratio: how far the velocity stands out from chance.
        ratio_floor: least ratio that counts as motion.
        image_centre_px: (x, y), reported as the view centre [px].
    """
    hs, vs = (clip_to_open_interval(v / limit_px_s) for v in velocity_px_s)
    return MotionEstimate(
        t_us=t_us,
        hs=hs,
        vs=vs,
        direction=winner_take_all(hs, vs, snr=(ratio, ratio), snr_floor=ratio_floor),
        strength=max(abs(hs), abs(vs)),
        response=velocity_px_s,
        view_centre_px=image_centre_px,
        roi_px=None,
    )


def population_estimate(
    t_us: int,
    *,
    rightward: F64,
    downward: F64,
    total: float,
    snr_floor: float,
    image_centre_px: tuple[float, float],
) -> MotionEstimate:
    """Return the estimate of a detector that sums the responses of cells and has no attention.

    Args:
        t_us: end of the window [µs].
        rightward: rightward minus leftward response of each cell; their sum becomes `response`.
        downward: downward minus upward response of each cell.
        total: sum of the responses of all cells in all directions.
        snr_floor: least ratio of a sum to √Σd², the standard deviation that random signs would
            give, that counts as motion.
        image_centre_px: (x, y), reported as the view centre [px].
    """
    response = float(rightward.sum()), float(downward.sum())
    hs, vs = (clip_to_open_interval(r / total) if total > 0.0 else 0.0 for r in response)
    return MotionEstimate(
        t_us=t_us,
        hs=hs,
        vs=vs,
        direction=winner_take_all(
            hs, vs, snr=(sum_to_noise(rightward), sum_to_noise(downward)), snr_floor=snr_floor
        ),
        strength=max(abs(hs), abs(vs)),
        response=response,
        view_centre_px=image_centre_px,
        roi_px=None,
    )


def sum_to_noise(opponent: F64) -> float:
    """Return |Σd| / √Σd² of the opponent responses d of cells; 0 if none responds."""
    d = opponent.ravel()
    power = float(np.square(d).sum())  # BLAS would start threads for a grid of cells
    return abs(float(d.sum())) / math.sqrt(power) if power > 0.0 else 0.0
