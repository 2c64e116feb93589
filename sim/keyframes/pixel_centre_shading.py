"""How the street at the pixels' middles is lit: which share of each light, and by which beams."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flybench.kernels import compiled
from sim.geometry.pinhole import Eye
from sim.geometry.rectangles import Rectangle
from sim.keyframes.background import Background
from sim.keyframes.pixel_labels import EDGE
from sim.shadows.lamp_light import beam_lux, share_let_through
from sim.shadows.moving_light import Lights

F32 = npt.NDArray[np.float32]
I32 = npt.NDArray[np.int32]


@compiled
def light_middles(
    street: Background, lights: Lights, eye: Eye, rectangle: Rectangle, code: I32
) -> tuple[F32, F32]:
    """How the street at the pixels' middles is lit; their codes learn of it.

    Returns:
        (lights, height, width) float32, share of each light that comes through, and
        (height, width) float32, what the movers' lamps add [lux].
    """
    x0, y0, x1, y1 = rectangle
    depth = street.depth[y0:y1, x0:x1]
    lit = np.ones((len(lights.gains) - 1, *code.shape), np.float32)
    for shadow in range(len(lights.light)):
        _shade_middles(lights, shadow, eye, rectangle, depth, code, lit[lights.light[shadow]])
    lux = np.zeros(code.shape, np.float32)
    for beam in range(len(lights.beams)):
        _beam_middles(lights, beam, street.normals, eye, rectangle, depth, code, lux)
    return lit, lux


@compiled
def _shade_middles(
    lights: Lights, shadow: int, eye: Eye, rectangle: Rectangle, depth: F32, code: I32, lit: F32
) -> None:
    """Let one shadow fall on the street at the pixels' middles.

    Args:
        lights: at this time.
        shadow: which of them.
        eye: the camera's.
        rectangle: x0, y0, x1, y1 [px].
        depth: (height, width) of the street [m].
        code: (height, width) the body that a pixel shows; below 0, each shadow has a bit of
            −1 − code, set where it is complete; `EDGE` where one is partial.
        lit: (height, width) float32, which share of the light comes through; multiplied.
    """
    focal, centre_x, centre_y = eye
    maps, sizes, parallel, view = lights.maps, lights.sizes, lights.parallel, lights.views[shadow]
    u_right, v_right, w_right = view[0, 0] / focal, view[1, 0] / focal, view[2, 0] / focal
    x0, y0, x1, y1 = rectangle
    reach = lights.reach[shadow]
    for row in range(max(reach[1], y0) - y0, min(reach[3], y1) - y0):
        below = (y0 + row + 0.5 - centre_y) / focal
        u_row = view[0, 1] * below + view[0, 2]
        v_row = view[1, 1] * below + view[1, 2]
        w_row = view[2, 1] * below + view[2, 2]
        for column in range(max(reach[0], x0) - x0, min(reach[2], x1) - x0):
            what = code[row, column]
            if what >= 0:
                continue
            z, right = depth[row, column], x0 + column + 0.5 - centre_x
            u = z * (u_right * right + u_row) + view[0, 3]
            v = z * (v_right * right + v_row) + view[1, 3]
            w = z * (w_right * right + w_row) + view[2, 3]
            share = share_let_through(maps, sizes, parallel, shadow, u, v, w)
            if share >= 1.0:
                continue
            lit[row, column] *= share
            if what != EDGE:
                code[row, column] = EDGE if share > 0.0 else what - (1 << shadow)


@compiled
def _beam_middles(
    lights: Lights,
    beam: int,
    normals: F32,
    eye: Eye,
    rectangle: Rectangle,
    depth: F32,
    code: I32,
    lux: F32,
) -> None:
    """Add what one beam gives the street at the pixels' middles [lux]."""
    focal, centre_x, centre_y = eye
    beams, reach_m = lights.beams, lights.beam_range_m
    x0, y0, x1, y1 = rectangle
    reach = lights.beam_reach
    for v in range(max(y0, reach[beam, 1]), min(y1, reach[beam, 3])):
        for u in range(max(x0, reach[beam, 0]), min(x1, reach[beam, 2])):
            if code[v - y0, u - x0] >= 0:
                continue
            z = depth[v - y0, u - x0]
            x, y = (u + 0.5 - centre_x) / focal * z, (v + 0.5 - centre_y) / focal * z
            n_x, n_y, n_z = normals[v, u, 0], normals[v, u, 1], normals[v, u, 2]
            lux[v - y0, u - x0] += beam_lux(beams, beam, reach_m, x, y, z, n_x, n_y, n_z)
