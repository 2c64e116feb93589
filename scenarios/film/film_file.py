"""Write a film as MP4 (H.264) or as GIF, image by image."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from scenarios.errors import OutputError, ScenarioError
from scenarios.output.colours import OFF, ON

MP4, GIF = ".mp4", ".gif"
_QUALITY = {"crf": "27", "preset": "medium", "threads": "1"}
"""Constant quality at which single events stay visible (by eye); one thread, for equal bytes."""
_BITS = 5
"""Bits of each channel by which the nearest colour of the palette is found."""
_SHADES = 20
"""Shades between each event colour and white in the palette of a GIF."""
_MISSING = (
    "Films need the library PyAV, which is not installed. Install it with: pip install "
    "'flybench[all]', or in a clone: .venv/bin/pip install -e '.[all]'"
)


def load_encoder() -> Any:
    """Return the library that encodes films.

    Raises:
        OutputError: it is not installed.
    """
    try:
        import av
    except ImportError as error:
        raise OutputError(_MISSING) from error
    return av


class FilmFile:
    """A film that is being written. Use it as a context manager."""

    def __init__(self, path: Path, *, fps: int) -> None:
        """Create the file; its first image sets the size.

        Args:
            path: path of the file; its ending, .mp4 or .gif, states the format.
            fps: frames per second.

        Raises:
            OutputError: the library that encodes films is not installed.
            OSError: the file cannot be written.
        """
        self._av = load_encoder()
        self._is_gif = path.suffix.lower() == GIF
        self._container = self._av.open(str(path), "w", format="gif" if self._is_gif else "mp4")
        codec, pixels = ("gif", "pal8") if self._is_gif else ("libx264", "yuv420p")
        options = {} if self._is_gif else _QUALITY
        self._stream = self._container.add_stream(codec, rate=fps, options=options)
        self._stream.pix_fmt = pixels
        self._size: tuple[int, int] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self._write(None)
        self._container.close()

    def add(self, image: npt.NDArray[np.uint8]) -> None:
        """Add an image of (height, width, 3).

        Raises:
            ScenarioError: it is larger than the first one.
        """
        height, width, _ = image.shape
        if self._size is None:
            self._size = height + height % 2, width + width % 2  # H.264 needs even numbers
            self._stream.height, self._stream.width = self._size
        rows, columns = self._size[0] - height, self._size[1] - width
        if rows < 0 or columns < 0:
            raise ScenarioError(
                "The recordings have sensors of different sizes. Allowed in one film is one size. "
                "Choose one recording with --recording."
            )
        even = np.pad(image, ((0, rows), (0, columns), (0, 0)), constant_values=255)
        if self._is_gif:
            frame = self._av.VideoFrame.from_ndarray((_indices(even), _ARGB), format="pal8")
        else:
            frame = self._av.VideoFrame.from_ndarray(even, format="rgb24")
        self._write(frame)

    def _write(self, frame: Any) -> None:
        for packet in self._stream.encode(frame):
            self._container.mux(packet)


def _palette() -> npt.NDArray[np.uint8]:
    """Return 256 colours: greys, and shades between each event colour and white."""
    shades = [np.linspace(colour, (255, 255, 255), _SHADES, endpoint=False) for colour in (ON, OFF)]
    greys = np.linspace(0, 255, 256 - 2 * _SHADES)[:, None].repeat(3, axis=1)
    return np.concatenate([*shades, greys]).round().astype(np.uint8)


def _nearest() -> npt.NDArray[np.uint8]:
    """Return the index of the nearest colour of the palette for each colour of 5 bits a channel."""
    levels = np.arange(1 << _BITS, dtype=np.float32) * (255 / ((1 << _BITS) - 1))
    colours = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)
    nearest = np.empty(colours.shape[:3], np.uint8)
    for k, plane in enumerate(colours):
        nearest[k] = ((plane[..., None, :] - _COLOURS) ** 2).sum(axis=-1).argmin(axis=-1)
    return nearest


def _indices(image: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the (rows, columns) indices of the colours of an image in the palette."""
    red, green, blue = np.moveaxis(image >> (8 - _BITS), -1, 0)
    indices: npt.NDArray[np.uint8] = _NEAREST[red, green, blue]
    return indices


_COLOURS = _palette()
_NEAREST = _nearest()
_ARGB = np.concatenate([np.full((256, 1), 255, np.uint8), _COLOURS], axis=1)
