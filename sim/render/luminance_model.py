"""Conversion of a model into one whose colours are greys of the same luminance."""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.rendered import KINDS, hide
from sim.render.illumination import Illumination
from sim.scene import srgb
from sim.scene.lighting import EMISSION_CD_M2, LUMINANCE_OF_RGB, relative_luminance

COLOUR_TYPE = "filament.material.base_color_type"
"""Custom text that states whether colours are linear."""


def luminance_model(
    model: mujoco.MjModel, illumination: Illumination | None = None
) -> mujoco.MjModel:
    """Return a copy of a model in which every colour is the grey of the same luminance.

    Everything that is not rendered is moved to a hidden group, so that it casts no shadow either.
    Colours are read as the renderer reads them: those of materials and geoms are sRGB unless the
    model states that they are linear; textures are linear unless their colour space is sRGB.

    Args:
        model: the model, which is not changed.
        illumination: light that replaces the model's. A material with an emission of 1 then has, in
            addition to what it reflects, the luminance of a white surface in this light, as in
            MuJoCo's classic renderer.
    """
    grey = copy.copy(model)
    hide(grey)
    if illumination is not None:
        grey.mat_emission *= illumination.lux / np.pi / EMISSION_CD_M2
    is_srgb = not has_linear_colours(model)
    cranks = grey.vis.rgba.slidercrank[None], grey.vis.rgba.crankbroken[None]
    for rgba in (grey.mat_rgba, *(getattr(grey, f"{kind}_rgba") for kind in KINDS), *cranks):
        rgba[:, :3] = _grey(rgba[:, :3], is_srgb)
    for k in range(grey.ntex):
        if grey.tex_nchannel[k] >= 3:
            texels = _texels(grey, k)[:, :3]
            if (texels == texels[:, :1]).all():  # grey already, as most of a street's are
                continue
            is_srgb = grey.tex_colorspace[k] == mujoco.mjtColorSpace.mjCOLORSPACE_SRGB
            texels[:] = np.rint(255 * _grey(texels / 255, is_srgb)).astype(np.uint8)
    for diffuse in grey.light_diffuse:  # a light's diffuse colour scales its intensity
        diffuse[:] = relative_luminance(diffuse)
    return grey


def _grey(colours: npt.NDArray[Any], is_srgb: bool) -> npt.NDArray[np.float64]:
    """(n, 1) greys of the same luminance as (n, 3) colours, in the colours' encoding."""
    linear = srgb.decoded(colours) if is_srgb else np.asarray(colours, np.float64)
    grey = linear @ LUMINANCE_OF_RGB
    return np.asarray(srgb.encoded(grey) if is_srgb else grey)[:, None]


def has_linear_colours(model: mujoco.MjModel) -> bool:
    """True if the model states that its colours are linear."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXT, COLOUR_TYPE)
    if number < 0:
        return False
    start, size = int(model.text_adr[number]), int(model.text_size[number])
    return bytes(model.text_data[start : start + size]).rstrip(b"\0") == b"linear"


def _texels(model: mujoco.MjModel, texture: int) -> npt.NDArray[np.uint8]:
    """(n, channels) view of a texture's pixels."""
    start, channels = int(model.tex_adr[texture]), int(model.tex_nchannel[texture])
    count = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
    texels: npt.NDArray[np.uint8] = model.tex_data[start : start + count].reshape(-1, channels)
    return texels
