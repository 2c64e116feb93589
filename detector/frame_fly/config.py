"""The parameters of the frame-based fly, each with its unit and its source."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral

from detector.errors import DetectorConfigError
from flybench.checks import Range, check_ranges


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameFlyConfig:
    """Parameters of `FrameFly`: those of Fu and Yue (2020), and what they leave open.

    Source of every value that is not marked otherwise: Q. Fu and S. Yue, "Modelling Drosophila
    motion vision pathways for decoding the direction of translating objects against cluttered
    moving backgrounds", Biological Cybernetics 114 (4), 443 to 460, 2020. No value was fitted to
    our sequences.

    Attributes:
        full_scale_dn: APS count that becomes grey level 255 [DN], because the model is made for 8
            bits. Full scale of the 10 bits of the DAVIS346.
        cell_px: side of the squares that are averaged into one grey level [px]. 1 keeps the pixels,
            as the model does.
        sigma_centre_cells: σ of the excitatory Gaussian [cells].
        sigma_surround_cells: σ of the inhibitory Gaussian [cells], twice that of the excitatory.
        kernel_centre_cells: side of the excitatory kernel [cells]; odd.
        kernel_surround_cells: side of the inhibitory kernel [cells]; odd.
        depolarising_us: time constant of the adaptation while its input rises [µs].
        repolarising_us: time constant of the adaptation while its input falls or stays [µs].
        offsets_cells: distances between the two points of a correlator [cells].
        delays_us: time constant of the delay at each of these distances [µs].
        smoothing: weight of the present in the temporal smoothing of T4 and T5. The 0.9 of the
            source, read as the weight of the present, which gives the shortest delay (assumed).
        response_scale: response per cell that scales the sigmoid of the tangential cells.
        snr_floor: least signal-to-noise ratio of a response that counts as motion; see
            `detector.frame_fly.correlation.block_signal_to_noise`. As for the event-driven fly
            (assumed).

    Raises:
        DetectorConfigError: a value has the wrong type or is out of range.
    """

    full_scale_dn: float = 1023.0
    cell_px: int = 1
    sigma_centre_cells: float = 2.0
    sigma_surround_cells: float = 4.0
    kernel_centre_cells: int = 5
    kernel_surround_cells: int = 9
    depolarising_us: int = 1_000
    repolarising_us: int = 100_000
    offsets_cells: tuple[int, ...] = (2, 4, 6)
    delays_us: tuple[int, ...] = (200_000, 160_000, 120_000)
    smoothing: float = 0.9
    response_scale: float = 0.01
    snr_floor: float = 3.0

    @classmethod
    def preset(cls, name: str) -> FrameFlyConfig:
        """Return the parameters of a preset: "published", or "coarse" for faster motion.

        See `PRESETS`.

        Raises:
            DetectorConfigError: there is no preset of this name.
        """
        if not isinstance(name, str) or name not in PRESETS:
            raise DetectorConfigError(
                f"The preset is {name!r}. Allowed is one of {', '.join(map(repr, PRESETS))}."
            )
        return PRESETS[name]

    def __post_init__(self) -> None:
        """Check every value and convert it to its type."""
        check_ranges(self, _RANGES, DetectorConfigError)
        for name, (low, high) in _TUPLE_RANGES.items():
            self._check_tuple(name, low, high)
        if len(self.offsets_cells) != len(self.delays_us):
            raise DetectorConfigError(
                f"offsets_cells has {len(self.offsets_cells)} values and delays_us "
                f"{len(self.delays_us)}. Allowed is one delay for each distance. Add or remove "
                "values."
            )
        for name in ("kernel_centre_cells", "kernel_surround_cells"):
            if getattr(self, name) % 2 == 0:
                raise DetectorConfigError(
                    f"{name} is {getattr(self, name)}. Allowed is an odd number, so that the "
                    "kernel has a centre. Add 1."
                )

    def _check_tuple(self, name: str, low: int, high: int) -> None:
        values = getattr(self, name)
        is_tuple = isinstance(values, tuple | list) and 1 <= len(values) <= _MOST_OFFSETS
        if not is_tuple or not all(
            isinstance(v, Integral) and low <= int(v) <= high for v in values
        ):
            raise DetectorConfigError(
                f"{name} is {values!r}. Allowed is a tuple of 1 to {_MOST_OFFSETS} whole numbers "
                f"from {low} to {high}. Choose values in that range."
            )
        object.__setattr__(self, name, tuple(int(v) for v in values))


_MOST_OFFSETS = 16
"""Largest number of correlation distances (assumed)."""
_RANGES: dict[str, Range] = {
    "full_scale_dn": Range(1.0, 65_535.0),
    "cell_px": Range(1, 64),
    "sigma_centre_cells": Range(0.1, 100.0),
    "sigma_surround_cells": Range(0.1, 100.0),
    "kernel_centre_cells": Range(1, 99),
    "kernel_surround_cells": Range(1, 99),
    "depolarising_us": Range(1, 10_000_000),
    "repolarising_us": Range(1, 10_000_000),
    "smoothing": Range(0.01, 1.0),
    "response_scale": Range(1e-9, 1e6),
    "snr_floor": Range(0.0, 1000.0),
}
_TUPLE_RANGES = {"offsets_cells": (1, 1000), "delays_us": (1, 10_000_000)}

PRESETS = {
    "published": FrameFlyConfig(),
    "coarse": FrameFlyConfig(cell_px=3),
}
"""Parameters by name.

published: the model as published, on every pixel. Its distances of 2, 4 and 6 px a frame are 80 to
240 px/s at 40 frames per second, and a quarter of that at 10.

coarse: the same model on cells of 3 px, those of the event-driven fly, so that both models have the
same spatial resolution. All distances are then three times as long: 6 to 18 px a frame, or 240 to
720 px/s at 40 frames per second.
"""
