"""A model without colour: every one replaced by the grey of the same luminance."""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from sim.scene import srgb
from sim.scene.lighting import LUMINANCE_OF_RGB, relative_luminance

_COLOUR_CODE = "filament.material.base_color_type"


def luminance_model(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy of `model` in which every colour is the grey of the same luminance.

    As the renderer does, colours of materials and geoms are taken as sRGB unless the model says
    that they are linear, and textures as linear unless their colour space is sRGB.
    """
    grey = copy.copy(model)
    coded = not _is_linear(model)
    for rgba in (grey.mat_rgba, grey.geom_rgba):
        rgba[:, :3] = _grey(rgba[:, :3], coded)
    for k in range(grey.ntex):
        if grey.tex_nchannel[k] >= 3:
            texels = _texels(grey, k)[:, :3]
            coded = grey.tex_colorspace[k] == mujoco.mjtColorSpace.mjCOLORSPACE_SRGB
            texels[:] = np.rint(255 * _grey(texels / 255, coded)).astype(np.uint8)
    for diffuse in grey.light_diffuse:  # which scales its intensity
        diffuse[:] = relative_luminance(diffuse)
    return grey


def _grey(colours: npt.NDArray[Any], coded: bool) -> npt.NDArray[np.float64]:
    """(n, 1) greys of the same luminance as (n, 3) colours, in the same code."""
    linear = srgb.decoded(colours) if coded else np.asarray(colours, np.float64)
    grey = linear @ LUMINANCE_OF_RGB
    return np.asarray(srgb.encoded(grey) if coded else grey)[:, None]


def _is_linear(model: mujoco.MjModel) -> bool:
    """Whether the model says that its colours are linear."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXT, _COLOUR_CODE)
    if number < 0:
        return False
    start, size = int(model.text_adr[number]), int(model.text_size[number])
    return bytes(model.text_data[start : start + size]).rstrip(b"\0") == b"linear"


def _texels(model: mujoco.MjModel, texture: int) -> npt.NDArray[np.uint8]:
    """(n, channels) view on a texture's pixels."""
    start, channels = int(model.tex_adr[texture]), int(model.tex_nchannel[texture])
    count = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
    texels: npt.NDArray[np.uint8] = model.tex_data[start : start + count].reshape(-1, channels)
    return texels
