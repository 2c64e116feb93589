"""Make the textures and tyres under `sim/assets`: `python -m tools.make_textures`.

The results are committed, so that the MJCF files open in any MuJoCo viewer. This script makes each
of them again, bit for bit, from its seed. A texture holds linear reflectance relative to its
material's colour, 8 bits, and tiles without a seam.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

ASSETS = Path(__file__).parents[1] / "sim" / "assets"
SEED = 1
"""Seed of all textures and meshes (any number works)."""
Image = npt.NDArray[np.float64]


def main() -> None:
    """Write every texture and mesh."""
    rng = np.random.default_rng(SEED)
    textures = {
        "asphalt": asphalt(rng),
        "paving": paving(rng),
        "brick": brick(rng),
        "plaster": plaster(rng),
        "foliage": foliage(rng),
        "bark": bark(rng),
    }
    for name, image in textures.items():
        pixels = np.clip(np.rint(image * 255), 1, 255).astype(np.uint8)
        cv2.imwrite(str(ASSETS / f"{name}.png"), pixels, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    (ASSETS / "tyre.obj").write_text(tyre(), encoding="ascii")


def noise(rng: np.random.Generator, size: int, scale_px: float) -> Image:
    """Return smooth tiling noise: zero mean, unit deviation, features of about `scale_px`."""
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size)))
    spectrum = np.fft.fft2(rng.standard_normal((size, size)))
    image = np.fft.ifft2(spectrum * np.exp(-((frequency * scale_px) ** 2) * 4)).real
    return np.asarray((image - image.mean()) / image.std())


def asphalt(rng: np.random.Generator, size: int = 1024) -> Image:
    """Return asphalt: stones of a few millimetres in tar, with worn patches and a mended crack."""
    grain = 0.08 * noise(rng, size, 1.5) + 0.05 * noise(rng, size, 5)
    wear = 0.05 * noise(rng, size, 60) + 0.04 * noise(rng, size, 160)
    crack = np.abs(noise(rng, size, 120)) < 0.012
    return np.clip(0.62 + grain + wear - 0.3 * cv2.GaussianBlur(crack * 1.0, (0, 0), 1), 0.15, 1)


def paving(rng: np.random.Generator, size: int = 1024, stones: int = 16) -> Image:
    """Return paving: square concrete slabs of different shades with dark joints."""
    shade = np.kron(rng.normal(0.72, 0.07, (stones, stones)), np.ones((size // stones,) * 2))
    edge = np.arange(size) % (size // stones) < 2
    image = shade + 0.06 * noise(rng, size, 2) + 0.04 * noise(rng, size, 30)
    image[edge, :] *= 0.5
    image[:, edge] *= 0.5
    return np.clip(image, 0.1, 1)


def brick(rng: np.random.Generator, size: int = 1024, courses: int = 32, bricks: int = 16) -> Image:
    """Return brickwork in running bond: bricks of different shades in light mortar."""
    height, length = size // courses, size // bricks
    rows, columns = np.mgrid[0:size, 0:size]
    course = rows // height
    along = columns + (course % 2) * (length // 2)
    shade = rng.normal(0.55, 0.11, (courses, bricks))[course, (along // length) % bricks]
    mortar = (rows % height < 3) | (along % length < 3)
    image = np.where(mortar, 0.85, shade) + 0.04 * noise(rng, size, 2)
    return np.clip(image + 0.04 * noise(rng, size, 90), 0.1, 1)


def plaster(rng: np.random.Generator, size: int = 512) -> Image:
    """Return rough plaster with stains."""
    return np.clip(0.8 + 0.04 * noise(rng, size, 1.5) + 0.05 * noise(rng, size, 70), 0.3, 1)


def foliage(rng: np.random.Generator, size: int = 256) -> Image:
    """Return foliage: bright leaves over dark gaps."""
    blades = noise(rng, size, 6) + 0.7 * noise(rng, size, 3)
    return np.clip(0.45 + 0.28 * np.tanh(1.2 * blades) + 0.05 * noise(rng, size, 40), 0.08, 1)


def bark(rng: np.random.Generator, size: int = 128) -> Image:
    """Return bark: furrows along the trunk."""
    furrows = cv2.GaussianBlur(np.tile(noise(rng, size, 2), (3, 1)), (1, 31), 0)[size : 2 * size]
    return np.clip(0.6 + 0.25 * furrows, 0.1, 1)


def tyre(segments: int = 32) -> str:
    """Return a tyre of outer radius 1 about the y axis, open in the middle, as Wavefront OBJ.

    Returns:
        The text of the file: a profile with six corners, rotated about the axis.
    """
    profile = [(0.8, -0.1), (0.93, -0.17), (1.0, -0.07), (1.0, 0.07), (0.93, 0.17), (0.8, 0.1)]
    lines = []
    for angle in np.arange(segments) * 2 * np.pi / segments:
        for radius, y in profile:
            x, z = radius * np.cos(angle), radius * np.sin(angle)
            lines.append(f"v {x:.4f} {y:.4f} {z:.4f}")
    sides, count = len(profile), segments * len(profile)
    for ring in range(segments):
        for k in range(sides):
            a, b = ring * sides + k, ring * sides + (k + 1) % sides
            c, d = (b + sides) % count, (a + sides) % count
            lines += [f"f {a + 1} {b + 1} {c + 1}", f"f {a + 1} {c + 1} {d + 1}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
