from typing import Any

import numpy as np
import pytest

from emulator import FrameError, luminance_of


@pytest.mark.parametrize(("dtype", "top"), [(np.uint8, 255), (np.uint16, 65535)])
@pytest.mark.parametrize("transfer", ["srgb", "linear"])
def test_black_is_zero_and_white_is_the_given_luminance(
    dtype: Any, top: int, transfer: Any
) -> None:
    image = np.array([[0, top]], dtype)
    luminance = luminance_of(image, white_cd_m2=250.0, transfer=transfer)
    assert luminance.dtype == np.float32
    assert luminance.tolist() == [[0.0, 250.0]]


def test_linear_levels_are_proportional() -> None:
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    luminance = luminance_of(image, white_cd_m2=510.0, transfer="linear")
    assert luminance == pytest.approx(2.0 * image)


def test_srgb_follows_the_standard() -> None:
    """Values of IEC 61966-2-1: grey 119 is 18.4 % of white, level 10 is on the linear part."""
    luminance = luminance_of(np.array([[119, 10, 188]], np.uint8), white_cd_m2=1.0)
    assert luminance[0] == pytest.approx([0.1845, 10 / 255 / 12.92, 0.5029], rel=2e-3)


def test_colours_are_weighted_by_luminance() -> None:
    image = np.zeros((1, 4, 3), np.uint8)
    image[0, 0, 0] = image[0, 1, 1] = image[0, 2, 2] = 255
    image[0, 3] = 255
    luminance = luminance_of(image, white_cd_m2=100.0)
    assert luminance[0] == pytest.approx([21.26, 71.52, 7.22, 100.0])


@pytest.mark.parametrize(
    ("image", "options", "words"),
    [
        (np.zeros((4, 4), np.float32), {}, "dtype float32. Allowed is uint8 or uint16"),
        (np.zeros((4, 4, 4), np.uint8), {}, r"shape \(4, 4, 4\)"),
        (np.zeros((4, 4), np.uint8), {"white_cd_m2": 0.0}, "white_cd_m2 is 0.0"),
        (np.zeros((4, 4), np.uint8), {"white_cd_m2": float("nan")}, "white_cd_m2 is nan"),
        ([[1, 2], [3, 4]], {}, "the image is a list. Allowed is an array"),
        (np.zeros((4, 4), np.uint8), {"white_cd_m2": "bright"}, "white_cd_m2 is 'bright'"),
        (np.zeros((4, 4), np.uint8), {"white_cd_m2": None}, "white_cd_m2 is None"),
        (np.zeros((4, 4), np.uint8), {"white_cd_m2": 1e39}, r"white_cd_m2 is 1e\+39"),
        (np.zeros((4, 4), np.uint8), {"transfer": "gamma"}, "transfer function is 'gamma'"),
    ],
)
def test_invalid_images_are_refused(image: Any, options: Any, words: str) -> None:
    with pytest.raises(FrameError, match=words):
        luminance_of(image, **{"white_cd_m2": 100.0, **options})
