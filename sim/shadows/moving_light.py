"""What the movers do to the street's light at one time: shadows, and the beams of their lamps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle
from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.raster.triangles import Soup
from sim.render.filament import NO_SHADOW_GROUP
from sim.scene.moving_objects import MovingObject
from sim.shadows.affected_rectangles import beam_rectangle, shadow_rectangle
from sim.shadows.shadow_maps import MAP_SIDE, Lamp, ShadowMap, draw_shadow_map, shadowing_lamps

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

MOST_SHADOWS = 29
"""Most pairs of a light and a moving object: their states must fit one pixel's 32-bit label."""
LEAST_COSINE_STEP = 1 / 1024
"""The renderer's limit to how sharply a beam may end, as Filament's spot lights have it."""


@dataclass(frozen=True, eq=False)
class Reach:
    """What the movers' shadows and beams can change at one time.

    Attributes:
        shadows: number of the lamp, the object before it, and the rectangle that it can darken.
        beams: number of the light, and the rectangle that it can reach.
    """

    shadows: list[tuple[int, MovingObject, Rectangle]]
    beams: list[tuple[int, Rectangle]]

    @property
    def rectangles(self) -> list[Rectangle]:
        """All of them."""
        return [w for _, _, w in self.shadows] + [w for _, w in self.beams]


class LightReach:
    """The lights of a model and what moves in them: how far shadows and beams go."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        objects: tuple[MovingObject, ...],
        pose: Pose,
        lens: Intrinsics,
    ) -> None:
        """Find the lights.

        Args:
            model: whose still lights may be suns and spots.
            data: where they are.
            objects: what moves.
            pose: the camera's.
            lens: likewise.
        """
        self.pose, self.objects = pose, objects
        self._model, self._lens = model, lens
        self.shadowing = _shadowing_lights(model, objects)
        self.lamps: list[Lamp] = shadowing_lamps(model, data, self.shadowing)
        none = np.empty(0, np.int64)
        self.beams: Numbers = np.concatenate([none, *(o.lamps for o in objects)])

    def at(self, data: mujoco.MjData) -> Reach:
        """What shadows and beams can change, with the movers where `data` has them."""
        shadows = []
        for obj in self.objects:
            corners = obj.corners_m(data)
            for k, lamp in enumerate(self.lamps):
                if rectangle := shadow_rectangle(corners, lamp, self.pose, self._lens):
                    shadows.append((k, obj, rectangle))
        lit = ((int(k), self._beam_window(data, int(k))) for k in self.beams)
        return Reach(shadows, [(k, rectangle) for k, rectangle in lit if rectangle])

    def _beam_window(self, data: mujoco.MjData, light: int) -> Rectangle | None:
        angle = math.radians(self._model.light_cutoff[light])
        place, direction = data.light_xpos[light], data.light_xdir[light]
        return beam_rectangle(place, direction, angle, self.pose, self._lens)


class Lights(NamedTuple):
    """The lights at a sample's time, in the camera's frame: right, down, forward [m].

    Attributes:
        gains: (1 + lights,) float64, what each part of the street is multiplied by.
        maps: (shadows, rows, columns) float32, how near to its light a mover is; one map for
            each pair of light and mover.
        sizes: (shadows, 2) int64, rows and columns of each map that are in use.
        views: (shadows, 3, 4) float64, from the camera's frame to the map's columns, rows and
            nearness; homogeneous for a lamp.
        light: (shadows,) int64, which light is shadowed.
        parallel: (shadows,) bool, whether that is the sun.
        reach: (shadows, 4) int64, x0, y0, x1, y1 of what each can darken [px].
        beams: (n, 9) float64: place, direction, candela, and scale and offset of the cone's edge.
        beam_reach: (n, 4) int64, x0, y0, x1, y1 of what each can light [px].
        beam_range_m: where the beams end.
    """

    gains: F64
    maps: F32
    sizes: Numbers
    views: F64
    light: Numbers
    parallel: Bools
    reach: Numbers
    beams: F64
    beam_reach: Numbers
    beam_range_m: float


class MovingLight:
    """Shadows and beams, ready to compose."""

    def __init__(self, model: mujoco.MjModel, movers: Soup, reach: LightReach) -> None:
        """Prepare the shadows' maps.

        Args:
            model: with the lights.
            movers: the triangles of what moves.
            reach: of the same model.

        Raises:
            SceneConfigError: more pairs of object and light than can be told apart.
        """
        self._model, self._reach = model, reach
        casting = model.geom_group[movers.geom] != NO_SHADOW_GROUP
        self._casters = {
            o.name: movers.chosen(casting & np.isin(movers.body, o.bodies)) for o in reach.objects
        }
        pairs = len(reach.lamps) * len(reach.objects)
        if pairs > MOST_SHADOWS:
            raise SceneConfigError(
                f"{len(reach.objects)} moving objects before {len(reach.lamps)} lights make "
                f"{pairs} shadows; allowed is up to {MOST_SHADOWS}; switch some off"
            )
        self._maps = np.empty((pairs, MAP_SIDE, MAP_SIDE), np.float32)

    def lights(self, data: mujoco.MjData, poses: F64, reach: Reach, gains: F64) -> Lights:
        """Shadows and beams, ready to compose.

        Args:
            data: where the movers are.
            poses: (bodies, 3, 4) of all bodies in the world.
            reach: at the same time.
            gains: what each part of the street is multiplied by.
        """
        drawn: list[tuple[int, ShadowMap, Rectangle]] = []
        for k, obj, rectangle in reach.shadows:
            out = self._maps[len(drawn)]
            made = draw_shadow_map(
                self._reach.lamps[k], obj, self._casters[obj.name], data, poses, out
            )
            if made:
                drawn.append((k, made, rectangle))
        to_world = inverse_transform(self._reach.pose.into)
        views = [compose_transforms(to_world, made.view) for _, made, _ in drawn]
        ranges = [float(self._model.light_range[k]) for k, _ in reach.beams]
        return Lights(
            gains=gains,
            maps=self._maps,
            sizes=np.array([made.size for _, made, _ in drawn], np.int64).reshape(-1, 2),
            views=np.array(views, np.float64).reshape(-1, 3, 4),
            light=np.array([k for k, _, _ in drawn], np.int64),
            parallel=np.array([self._reach.lamps[k].parallel for k, _, _ in drawn], np.bool_),
            reach=np.array([rectangle for _, _, rectangle in drawn], np.int64).reshape(-1, 4),
            beams=np.array([self._beam(data, k) for k, _ in reach.beams]).reshape(-1, 9),
            beam_reach=np.array([rectangle for _, rectangle in reach.beams], np.int64).reshape(
                -1, 4
            ),
            beam_range_m=max(ranges, default=1.0),
        )

    def _beam(self, data: mujoco.MjData, light: int) -> F64:
        """(9,) a row of `Lights.beams`."""
        into = self._reach.pose.into
        outer = math.radians(self._model.light_cutoff[light])
        inner = outer * (1 - self._model.light_softness[light])
        scale = 1 / max(math.cos(inner) - math.cos(outer), LEAST_COSINE_STEP)
        place = into[:, :3] @ data.light_xpos[light] + into[:, 3]
        direction = into[:, :3] @ data.light_xdir[light]
        candela = self._model.light_intensity[light]
        return np.array([*place, *direction, candela, scale, -math.cos(outer) * scale])


def _shadowing_lights(model: mujoco.MjModel, objects: tuple[MovingObject, ...]) -> Numbers:
    """Numbers of the still lights that cast shadows."""
    moving = np.isin(np.arange(model.nlight), [k for o in objects for k in o.lamps])
    image = model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE
    shining = model.light_intensity > 0
    return np.flatnonzero(model.light_castshadow & shining & ~moving & ~image)
