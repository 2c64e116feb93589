"""From the luminance of the scene to the illuminance on the chip."""

from __future__ import annotations

import math


def lux_per_cd_m2(*, f_number: float, transmission: float) -> float:
    """Return the illuminance on the chip per luminance of the scene (the camera equation).

    E = π·T·L/(4·N²) for an object much farther away than the focal length, without vignetting.

    Args:
        f_number: lens aperture N, focal length over diameter.
        transmission: fraction T of the light that passes the lens.

    Returns:
        E/L [lux per cd/m²].
    """
    return math.pi * transmission / (4.0 * f_number**2)
