"""The lights of an `Illumination` in Filament, instead of those of the model."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco import mjrf

from sim.render.illumination import Illumination
from sim.render.luminance_model import COLOUR_TYPE

SHADOW_MAP_PX = 2048
"""Side of the shadow map: the largest that Filament allows."""
SKY_PX = 32
"""Side of each face of the white sky (assumed)."""


def neutral_options(*, linear_colours: bool) -> mujoco.MjModel:
    """Return a model whose rendering options add nothing that is not light, such as occlusion.

    Args:
        linear_colours: True if colours are linear, not sRGB.
    """
    colours = f'<text name="{COLOUR_TYPE}" data="linear"/>' if linear_colours else ""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><custom><numeric name="filament.ao.enabled" data="0"/>{colours}</custom></mujoco>'
    )


class SkyAndSun:
    """A white sky that surrounds the scene, and a sun that casts shadows."""

    def __init__(self, context: Any, scene: Any, illumination: Illumination) -> None:
        """Add the lights to a scene.

        Args:
            context: Filament's context.
            scene: its scene, without lights.
            illumination: the illuminance.
        """
        self._texture = _white_cube(context)
        self._lights = [_sky(context, self._texture, illumination)]
        if illumination.sun_lux > 0:
            self._lights.append(_sun(context, illumination))
        for light in self._lights:
            scene.add_light(light)
        scene.set_skybox(self._texture)

    def update(self, _: mujoco.MjData) -> None:
        """Do nothing: sky and sun do not move."""


def _white_cube(context: Any) -> Any:
    config = mjrf.TextureConfig()
    config.width, config.height = SKY_PX, 6 * SKY_PX
    config.format = mjrf.PixelFormat.PIXEL_FORMAT_RGB8
    config.color_space = mjrf.ColorSpace.COLORSPACE_LINEAR
    config.sampler_type = mjrf.SamplerType.TEXTURE_CUBE
    texture, data = context.create_texture(config), mjrf.TextureData()
    data.set_image(b"\xff" * (3 * SKY_PX * 6 * SKY_PX))
    texture.upload(data)
    return texture


def _sky(context: Any, texture: Any, illumination: Illumination) -> Any:
    params = mjrf.LightParams()
    params.type, params.texture = mjrf.LightType.LIGHT_IMAGE, texture
    params.intensity = illumination.sky_lux / np.pi
    return context.create_light(params)


def _sun(context: Any, illumination: Illumination) -> Any:
    params, to_sun = mjrf.LightParams(), illumination.to_sun
    params.type = mjrf.LightType.LIGHT_DIRECTIONAL
    params.color = np.ones(3, np.float32)
    params.intensity = illumination.sun_lux / to_sun[2]
    params.cast_shadow, params.shadow_map_size = True, SHADOW_MAP_PX
    sun = context.create_light(params)
    sun.set_pose(np.zeros(3, np.float32), -to_sun.astype(np.float32))
    return sun
