"""Codes and layouts of single labels."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scenarios.dataset.labels.boxes import run_lengths
from scenarios.dataset.labels.camera import camera_matrix
from scenarios.dataset.labels.png import (
    decode_depth,
    decode_flow,
    encode_depth,
    encode_flow,
    read_png,
    write_png,
)
from scenarios.dataset.layout import label_times_us
from sim import Intrinsics


@given(
    arrays(np.float32, (3, 4, 2), elements=st.floats(-255.5, 255.5, width=32)),
)
def test_flow_survives_its_code_to_half_a_step(flow: np.ndarray) -> None:
    decoded, valid = decode_flow(encode_flow(flow))
    assert valid.all()
    assert np.abs(decoded - flow).max() <= 0.5 / 128 + 1e-5


@pytest.mark.parametrize("bad", [math.nan, -256.1, 256.0, math.inf])
def test_flow_that_has_no_code_is_not_valid(bad: float) -> None:
    flow = np.array([[[1.5, -2.0], [3.0, bad]]], np.float32)
    coded = encode_flow(flow)
    assert coded.tolist() == [[[32768 + 192, 32768 - 256, 1], [0, 0, 0]]]
    decoded, valid = decode_flow(coded)
    assert valid.tolist() == [[True, False]]
    assert decoded.tolist() == [[[1.5, -2.0], [0.0, 0.0]]]


def test_depth_survives_its_code_and_the_sky_is_0() -> None:
    depth = np.array([[0.5, 7.123, 255.9, 256.0, math.inf]], np.float32)
    coded = encode_depth(depth)
    assert coded.tolist() == [[128, 1823, 65510, 0, 0]]
    assert np.abs(decode_depth(coded)[0, :3] - depth[0, :3]).max() <= 0.5 / 256
    assert np.isinf(decode_depth(coded)[0, 3:]).all()


def test_png_files_hold_red_green_blue_and_16_bits(tmp_path: Path) -> None:
    image = np.arange(2 * 3 * 3, dtype=np.uint16).reshape(2, 3, 3) * 3000
    write_png(tmp_path / "a.png", image)
    assert (read_png(tmp_path / "a.png") == image).all()
    opencv = cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED)
    assert opencv is not None
    assert (opencv[..., ::-1] == image).all()
    write_png(tmp_path / "b.png", image[..., 0])
    assert (read_png(tmp_path / "b.png") == image[..., 0]).all()
    (tmp_path / "c.png").write_text("no image")
    with pytest.raises(OSError, match="is not an image"):
        read_png(tmp_path / "c.png")


@given(arrays(np.bool_, (5, 7)))
def test_run_lengths_give_the_mask_back_down_the_columns(mask: np.ndarray) -> None:
    coded = run_lengths(mask)
    values = np.arange(len(coded["counts"])) % 2 == 1
    decoded = np.repeat(values, coded["counts"]).reshape(coded["size"], order="F")
    assert (decoded == mask).all()


def test_the_principal_point_of_pixel_centres_is_half_a_pixel_less() -> None:
    assert camera_matrix(Intrinsics(10, 8, 20.0)) == [20.0, 20.0, 4.5, 3.5]


def test_labels_are_at_multiples_of_the_period() -> None:
    assert list(label_times_us(100_000, 50_000)) == [0, 50_000, 100_000]
    assert list(label_times_us(99_999, 50_000)) == [0, 50_000]
