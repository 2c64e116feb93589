"""Illumination of the background at the pixel centres: the share of each light, and beams."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Projection
from sim.geometry.rectangles import Rectangle
from sim.keyframes.background import Background
from sim.keyframes.pixel_labels import EDGE
from sim.shadows.point_illumination import beam_lux, unshadowed_share
from sim.shadows.shadows_and_beams import ShadowsAndBeams

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]


@compiled
def shade_pixel_centres(
    background: Background,
    effects: ShadowsAndBeams,
    projection: Projection,
    rectangle: Rectangle,
    pixel_label: I32,
) -> tuple[F32, F32]:
    """Return the illumination of the background at the pixel centres of a rectangle.

    Args:
        background: the static background.
        effects: shadows and beams at this time.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
        pixel_label: (height, width) labels of the rectangle's pixels; shadows are added to them,
            see `_apply_shadow`.

    Returns:
        (lights, height, width) float32, share of each light that arrives; and (height, width)
        float32, illuminance from the moving objects' lamps [lux].
    """
    x0, y0, x1, y1 = rectangle
    depth = background.depth[y0:y1, x0:x1]
    lit = np.ones((len(effects.gains) - 1, *pixel_label.shape), np.float32)
    for shadow in range(len(effects.light)):
        light_share = lit[effects.light[shadow]]
        _apply_shadow(effects, shadow, projection, rectangle, depth, pixel_label, light_share)
    lux = np.zeros(pixel_label.shape, np.float32)
    for beam in range(len(effects.beams)):
        _add_beam(effects, beam, background.normals, projection, rectangle, depth, pixel_label, lux)
    return lit, lux


@compiled
def _apply_shadow(
    effects: ShadowsAndBeams,
    shadow: int,
    projection: Projection,
    rectangle: Rectangle,
    depth: F32,
    pixel_label: I32,
    lit: F32,
) -> None:
    """Apply one shadow to the background at the pixel centres, in place.

    Args:
        effects: shadows and beams at this time.
        shadow: index of the shadow.
        projection: projection of the camera.
        rectangle: x0, y0, x1, y1 [px].
        depth: (height, width) depth of the background [m].
        pixel_label: (height, width) labels, changed: a body if not negative. Negative labels are
            background, where each shadow has a bit of −1 − label, which is set where it is
            complete. A partial shadow gives `EDGE`.
        lit: (height, width) float32, share of the light that arrives; multiplied.
    """
    focal, centre_x, centre_y = projection
    maps, sizes, is_sun, view = effects.maps, effects.sizes, effects.is_sun, effects.views[shadow]
    u_right, v_right, w_right = view[0, 0] / focal, view[1, 0] / focal, view[2, 0] / focal
    x0, y0, x1, y1 = rectangle
    area = effects.shadow_areas[shadow]
    for row in range(max(area[1], y0) - y0, min(area[3], y1) - y0):
        below = (y0 + row + 0.5 - centre_y) / focal
        u_row = view[0, 1] * below + view[0, 2]
        v_row = view[1, 1] * below + view[1, 2]
        w_row = view[2, 1] * below + view[2, 2]
        for column in range(max(area[0], x0) - x0, min(area[2], x1) - x0):
            label = pixel_label[row, column]
            if label >= 0:
                continue
            z, right = depth[row, column], x0 + column + 0.5 - centre_x
            u = z * (u_right * right + u_row) + view[0, 3]
            v = z * (v_right * right + v_row) + view[1, 3]
            w = z * (w_right * right + w_row) + view[2, 3]
            share = unshadowed_share(maps, sizes, is_sun, shadow, u, v, w)
            if share >= 1.0:
                continue
            lit[row, column] *= share
            if label != EDGE:
                pixel_label[row, column] = EDGE if share > 0.0 else label - (1 << shadow)


@compiled
def _add_beam(
    effects: ShadowsAndBeams,
    beam: int,
    normals: F32,
    projection: Projection,
    rectangle: Rectangle,
    depth: F32,
    pixel_label: I32,
    lux: F32,
) -> None:
    """Add one beam's illuminance of the background at the pixel centres, in place [lux]."""
    focal, centre_x, centre_y = projection
    beams, range_m = effects.beams, effects.beam_range_m
    x0, y0, x1, y1 = rectangle
    areas = effects.beam_areas
    for v in range(max(y0, areas[beam, 1]), min(y1, areas[beam, 3])):
        for u in range(max(x0, areas[beam, 0]), min(x1, areas[beam, 2])):
            if pixel_label[v - y0, u - x0] >= 0:
                continue
            z = depth[v - y0, u - x0]
            x, y = (u + 0.5 - centre_x) / focal * z, (v + 0.5 - centre_y) / focal * z
            n_x, n_y, n_z = normals[v, u, 0], normals[v, u, 1], normals[v, u, 2]
            lux[v - y0, u - x0] += beam_lux(beams, beam, range_m, x, y, z, n_x, n_y, n_z)
