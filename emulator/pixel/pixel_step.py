"""The course of one pixel's input through a step, cut into segments."""

from __future__ import annotations

from typing import NamedTuple

from emulator.pixel.photoreceptor import ramp_pieces
from emulator.pixel.segment import Mismatch, Segment, make_segment
from emulator.pixel.state import PixelModel
from flybench.kernels import inlined


class PixelStep(NamedTuple):
    """The course of u of one pixel from the time of its state to the end of the step.

    Attributes:
        constant_us: duration of the segment of constant luminance before the ramp [µs]: the time
            that the pixel has slept, and the step itself if its luminance does not change.
        constant_from_us: start of that segment, from the start of the step; 0 or negative [µs].
        log_from: u at the start [ln lux].
        log_to: u at the end [ln lux].
        piece_us: duration of each piece of the ramp [µs].
        pieces: number of pieces, 0 if the luminance does not change.
    """

    constant_us: float
    constant_from_us: float
    log_from: float
    log_to: float
    piece_us: float
    pieces: int


@inlined
def plan_step(
    model: PixelModel,
    log_from: float,
    log_to: float,
    changed: bool,
    slept_us: float,
    span_us: float,
) -> PixelStep:
    """Return the course of u in a step of `span_us` for a pixel that has slept for `slept_us`."""
    if not changed:
        return PixelStep(slept_us + span_us, -slept_us, log_from, log_from, span_us, 0)
    pieces = ramp_pieces(log_from, log_to, model.log_limit)
    return PixelStep(slept_us, -slept_us, log_from, log_to, span_us / pieces, pieces)


@inlined
def segment_of(
    model: PixelModel, mismatch: Mismatch, plan: PixelStep, number: int
) -> tuple[Segment, float, float]:
    """Return a segment, its start from the start of the step [µs], and its duration [µs].

    Segment −1 has constant luminance; segments 0 to pieces − 1 are the pieces of the ramp.
    """
    if number < 0:
        constant = make_segment(model, mismatch, plan.log_from, plan.log_from, plan.constant_us)
        return constant, plan.constant_from_us, plan.constant_us
    rise = (plan.log_to - plan.log_from) / plan.pieces
    low = plan.log_from + number * rise
    ramp = make_segment(model, mismatch, low, low + rise, plan.piece_us)
    return ramp, number * plan.piece_us, plan.piece_us
