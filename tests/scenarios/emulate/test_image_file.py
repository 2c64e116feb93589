"""Image files of any depth and orientation."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from scenarios.emulate.image_file import read_image

ORIENTATION = 0x0112
TURNED = {
    1: lambda image: image,
    2: lambda image: image[:, ::-1],
    3: lambda image: image[::-1, ::-1],
    4: lambda image: image[::-1],
    5: lambda image: image.swapaxes(0, 1),
    6: lambda image: np.rot90(image, -1),
    7: lambda image: image[::-1, ::-1].swapaxes(0, 1),
    8: lambda image: np.rot90(image),
}
"""What each EXIF orientation does (CIPA DC-008, orientation tag)."""


def picture(dtype: Any, *, colour: bool) -> npt.NDArray[Any]:
    """Return four areas that differ, 24 rows by 40 columns."""
    image = np.zeros((24, 40), dtype)
    image[:8, :16], image[:8, 16:], image[8:, :16] = (np.iinfo(dtype).max // k for k in (1, 2, 4))
    return np.stack([image, image // 2, image // 3], axis=2) if colour else image


@pytest.mark.parametrize("orientation", TURNED)
@pytest.mark.parametrize(
    ("ending", "dtype", "colour"),
    [
        (".jpg", np.uint8, True),
        (".jpg", np.uint8, False),
        (".png", np.uint8, True),
        (".png", np.uint16, False),
        (".tif", np.uint8, True),
        (".tif", np.uint16, False),
        (".webp", np.uint8, True),
    ],
)
def test_images_are_turned_as_their_exif_states(
    tmp_path: Path, ending: str, dtype: Any, colour: bool, orientation: int
) -> None:
    image, file = picture(dtype, colour=colour), tmp_path / f"a{ending}"
    exif = Image.Exif()
    exif[ORIENTATION] = orientation
    lossless: dict[str, Any] = {"lossless": True} if ending == ".webp" else {"subsampling": 0}
    Image.fromarray(image).save(file, exif=exif, quality=100, **lossless)
    found, true = read_image(file), TURNED[orientation](image)
    assert (found.dtype, found.shape) == (true.dtype, true.shape)
    assert np.abs(found.astype(int) - true).max() <= (4 if ending == ".jpg" else 0)


@pytest.mark.parametrize(
    ("ending", "dtype"),
    [(end, dtype) for end in (".png", ".tif", ".pgm", ".ppm") for dtype in (np.uint8, np.uint16)]
    + [(".bmp", np.uint8)],
)
def test_images_without_exif_are_read_as_they_are(tmp_path: Path, ending: str, dtype: Any) -> None:
    image, file = picture(dtype, colour=ending == ".ppm"), tmp_path / f"a{ending}"
    cv2.imwrite(str(file), image[..., ::-1] if image.ndim == 3 else image)
    found = read_image(file)
    assert found.dtype == dtype
    assert np.array_equal(found if found.ndim == image.ndim else found[..., 0], image)


def test_transparency_is_left_out_and_only_the_first_page_is_read(tmp_path: Path) -> None:
    image = picture(np.uint8, colour=True)
    clear = np.dstack([image[..., ::-1], np.full(image.shape[:2], 100, np.uint8)])
    cv2.imwrite(str(tmp_path / "clear.png"), clear)
    assert np.array_equal(read_image(tmp_path / "clear.png"), image)
    cv2.imwritemulti(str(tmp_path / "pages.tif"), [image[..., ::-1], image])
    assert np.array_equal(read_image(tmp_path / "pages.tif"), image)
