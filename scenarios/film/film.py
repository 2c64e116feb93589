"""The frames of a film: the panels of one or more recordings at each of its times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flybench.memory import check_memory
from scenarios.errors import ScenarioError
from scenarios.film.material import Material
from scenarios.film.panel import Panel
from scenarios.film.playback import moments

MAX_FRAMES = 100_000
"""Most frames of a film (assumed): more than an hour at 25 frames per second."""
_GAP_PX = 8
"""Width of the white gap between two panels."""
_BYTES_PER_PX = 40
"""Memory per pixel of the film: its image, and those of its panels and of the encoder (assumed)."""


@dataclass(frozen=True)
class FilmOptions:
    """How a film shows its recordings.

    Attributes:
        speed: recorded seconds per second of the film.
        fps: frames per second of the film.
        window_us: time from which each frame shows events [µs].
        scale: pixels of the film per sensor pixel; None: chosen by the size of the sensor.
        from_us: time at which the film begins [µs]; None: the start.
        to_us: time at which it ends [µs]; None: the end.
    """

    speed: float
    fps: int
    window_us: int
    scale: int | None = None
    from_us: int | None = None
    to_us: int | None = None

    @property
    def step_us(self) -> float:
        """Recorded time from one frame to the next [µs]."""
        return 1e6 * self.speed / self.fps

    def times_us(self, material: Material) -> list[int]:
        """Return the recorded time of each frame [µs].

        Raises:
            ScenarioError: the recording has nothing between `from_us` and `to_us`, or the film
                would have more than `MAX_FRAMES` frames.
        """
        start = material.from_us if self.from_us is None else max(self.from_us, material.from_us)
        end = material.to_us if self.to_us is None else min(self.to_us, material.to_us)
        if start > end:
            raise ScenarioError(
                f"{material.name} has no event between --from and --to. It lasts from "
                f"{material.from_us * 1e-6:.6f} s to {material.to_us * 1e-6:.6f} s. Choose times "
                "in between."
            )
        number = int((end - start) / self.step_us) + 1
        if number > MAX_FRAMES:
            raise ScenarioError(
                f"The film of {material.name} would have {number:,} frames. Allowed is up to "
                f"{MAX_FRAMES:,}. Give a higher --speed, or a section with --from and --to."
            )
        return [round(start + k * self.step_us) for k in range(1, number + 1)]


class Chapter:
    """Part of a film that shows one recording, or several side by side.

    Attributes:
        number: number of frames.
    """

    def __init__(self, materials: Sequence[Material], options: FilmOptions) -> None:
        """Draw what does not change.

        Args:
            materials: what the chapter shows, from left to right.
            options: how it shows it.

        Raises:
            ScenarioError: a recording has nothing in the section to show, or too much.
            MemoryBudgetError: the images need more memory than the budget allows.
        """
        times = [options.times_us(material) for material in materials]
        scales = [options.scale or _scale(material.width) for material in materials]
        pixels = sum(m.width * m.height * s**2 for m, s in zip(materials, scales, strict=True))
        check_memory(f"A film of {pixels / 1e6:.1f} million pixels", pixels * _BYTES_PER_PX)
        self.number = max(map(len, times))
        note = speed_text(options.speed)
        self._panels = [
            Panel(material, span_us=(own[0], max(own[-1], own[0] + 1)), scale=scale, note=note)
            for material, own, scale in zip(materials, times, scales, strict=True)
        ]
        self._moments = [
            moments(material.read(), own, options.window_us)
            for material, own in zip(materials, times, strict=True)
        ]

    def images(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Yield the frames; a recording that is shorter than the others stays at its last one."""
        height = max(panel.shape[0] for panel in self._panels)
        images: list[npt.NDArray[np.uint8]] = [np.empty(0, np.uint8)] * len(self._panels)
        for _ in range(self.number):
            for n, panel in enumerate(self._panels):
                moment = next(self._moments[n], None)
                if moment is not None:
                    images[n] = panel.draw(moment)
            yield _beside(images, height)


def speed_text(speed: float) -> str:
    """Return the speed of a film in words, such as "1/10 speed"."""
    if speed == 1:
        return "real time"
    if speed < 1 and abs(1 / speed - round(1 / speed)) < 1e-6 / speed:
        return f"1/{round(1 / speed)} speed"
    return f"{speed:g} × speed"


def _scale(width: int) -> int:
    """Return the magnification that makes an image at least about 640 pixels wide."""
    return max(1, round(640 / width))


def _beside(images: Sequence[npt.NDArray[np.uint8]], height: int) -> npt.NDArray[np.uint8]:
    """Return images side by side on white, with gaps."""
    parts: list[npt.NDArray[np.uint8]] = []
    for image in images:
        gap = _GAP_PX if parts else 0
        below = height - image.shape[0]
        parts.append(np.pad(image, ((0, below), (gap, 0), (0, 0)), constant_values=255))
    return np.concatenate(parts, axis=1)
