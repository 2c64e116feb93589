"""Shadows of the moving objects and beams of their lamps at one time, ready for compositing."""

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
from sim.raster.shared_corners import share_corners
from sim.raster.triangles import TriangleSoup
from sim.scene.moving_objects import MovingObject
from sim.shadows.affected_rectangles import beam_rectangle, shadow_rectangle
from sim.shadows.shadow_maps import (
    MAP_SIDE,
    ShadowMap,
    ShadowSource,
    render_shadow_map,
    shadow_sources,
)

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

MAX_SHADOWS = 29
"""Maximum number of pairs of a light and a moving object: a pixel's 32-bit label has one bit for
each."""
MIN_CONE_EDGE = 1 / 1024
"""Minimum width of a beam's soft edge, as a difference of cosines; the limit of Filament's spot
lights."""


@dataclass(frozen=True, eq=False)
class AffectedAreas:
    """Image areas that shadows and beams of the moving objects can change at one time.

    Attributes:
        shadows: for each shadow, the index of its light in `AffectedAreaFinder.sources`, the object
            that casts it, and the rectangle that it can darken.
        beams: for each beam, the number of its light, and the rectangle that it can reach.
    """

    shadows: list[tuple[int, MovingObject, Rectangle]]
    beams: list[tuple[int, Rectangle]]

    @property
    def rectangles(self) -> list[Rectangle]:
        """The rectangles of all shadows and beams."""
        return [area for _, _, area in self.shadows] + [area for _, area in self.beams]


class AffectedAreaFinder:
    """Finds the image areas that shadows and beams of moving objects can change.

    Attributes:
        pose: pose of the camera.
        objects: the moving objects.
        shadow_lights: (n,) numbers of the lights that cast shadows.
        sources: the same lights as shadow sources.
        beams: (k,) numbers of the lights that move with the objects.
    """

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
            model: model whose fixed lights may be suns and spot lights.
            data: positions of the lights.
            objects: the moving objects.
            pose: pose of the camera.
            lens: intrinsics of the camera.
        """
        self.pose, self.objects = pose, objects
        self._model, self._lens = model, lens
        self.shadow_lights = _shadow_lights(model, objects)
        self.sources: list[ShadowSource] = shadow_sources(model, data, self.shadow_lights)
        none = np.empty(0, np.int64)
        self.beams: Numbers = np.concatenate([none, *(o.lamps for o in objects)])

    def find(self, data: mujoco.MjData) -> AffectedAreas:
        """Return the areas for the poses in `data`."""
        shadows = []
        for obj in self.objects:
            corners = obj.corners_m(data)
            for k, source in enumerate(self.sources):
                if area := shadow_rectangle(corners, source, self.pose, self._lens):
                    shadows.append((k, obj, area))
        beams = ((int(k), self._beam_area(data, int(k))) for k in self.beams)
        return AffectedAreas(shadows, [(k, area) for k, area in beams if area])

    def _beam_area(self, data: mujoco.MjData, light: int) -> Rectangle | None:
        angle = math.radians(self._model.light_cutoff[light])
        position, direction = data.light_xpos[light], data.light_xdir[light]
        return beam_rectangle(position, direction, angle, self.pose, self._lens)


class ShadowsAndBeams(NamedTuple):
    """Shadows and beams at a sample's time, in the camera's frame: right, down, forward [m].

    Attributes:
        gains: (1 + lights,) float64, factor of each layer of the background.
        maps: (shadows, rows, columns) float32, nearness of a moving object to its light; one map
            for each pair of a light and a moving object.
        sizes: (shadows, 2) int64, rows and columns of each map that are in use.
        views: (shadows, 3, 4) float64, map from the camera's frame to the shadow map's column, row
            and nearness; homogeneous for a lamp.
        light: (shadows,) int64, index of the light that is shadowed.
        is_sun: (shadows,) bool, True if that light is the sun.
        shadow_areas: (shadows, 4) int64, x0, y0, x1, y1 of the area that each can darken [px].
        beams: (n, 9) float64: position, direction, candela, and scale and offset of the cone's
            edge.
        beam_areas: (n, 4) int64, x0, y0, x1, y1 of the area that each can light [px].
        beam_range_m: distance at which the beams end.
    """

    gains: F64
    maps: F32
    sizes: Numbers
    views: F64
    light: Numbers
    is_sun: Bools
    shadow_areas: Numbers
    beams: F64
    beam_areas: Numbers
    beam_range_m: float


class ShadowBeamRenderer:
    """Renders shadow maps and describes beams for compositing."""

    def __init__(
        self, model: mujoco.MjModel, movers: TriangleSoup, finder: AffectedAreaFinder
    ) -> None:
        """Reserve the shadow maps.

        Args:
            model: model with the lights.
            movers: triangles of everything that moves.
            finder: affected areas of the same model.

        Raises:
            SceneConfigError: there are more than `MAX_SHADOWS` pairs of object and light.
        """
        self._finder = finder
        casting = model.geom_castshadow[movers.geom]
        self._casters = {
            o.name: share_corners(movers.subset(casting & np.isin(movers.body, o.bodies)))
            for o in finder.objects
        }
        pairs = len(finder.sources) * len(finder.objects)
        if pairs > MAX_SHADOWS:
            raise SceneConfigError(
                f"{len(finder.objects)} moving objects and {len(finder.sources)} lights make "
                f"{pairs} shadows. Allowed are up to {MAX_SHADOWS}. Remove some of the moving "
                "objects."
            )
        self._maps = np.empty((pairs, MAP_SIDE, MAP_SIDE), np.float32)
        self._to_world = inverse_transform(finder.pose.world_to_camera)
        # Taken now, because a renderer changes the model's lights for a moment.
        self._beams = {int(k): _beam_constants(model, int(k)) for k in finder.beams}
        self._beam_range_m = max((float(model.light_range[k]) for k in finder.beams), default=1.0)

    def render(
        self, data: mujoco.MjData, poses: F64, areas: AffectedAreas, gains: F64
    ) -> ShadowsAndBeams:
        """Render the shadow maps and collect the beams.

        Args:
            data: positions of bodies and lights.
            poses: (bodies, 3, 4) transform from each body's frame into the world.
            areas: affected areas at the same time.
            gains: factor of each layer of the background.
        """
        rendered: list[tuple[int, ShadowMap, Rectangle]] = []
        sources = self._finder.sources
        for k, obj, area in areas.shadows:
            out = self._maps[len(rendered)]
            made = render_shadow_map(sources[k], obj, self._casters[obj.name], data, poses, out)
            if made:
                rendered.append((k, made, area))
        views = np.array([made.view for _, made, _ in rendered]).reshape(-1, 3, 4)
        return ShadowsAndBeams(
            gains=gains,
            maps=self._maps,
            sizes=np.array([made.size for _, made, _ in rendered], np.int64).reshape(-1, 2),
            views=compose_transforms(self._to_world, views),
            light=np.array([k for k, _, _ in rendered], np.int64),
            is_sun=np.array([sources[k].is_sun for k, _, _ in rendered], np.bool_),
            shadow_areas=np.array([area for _, _, area in rendered], np.int64).reshape(-1, 4),
            beams=np.array([self._beam(data, k) for k, _ in areas.beams]).reshape(-1, 9),
            beam_areas=np.array([area for _, area in areas.beams], np.int64).reshape(-1, 4),
            beam_range_m=self._beam_range_m,
        )

    def _beam(self, data: mujoco.MjData, light: int) -> F64:
        """Return the row of `ShadowsAndBeams.beams` for a light, (9,)."""
        into = self._finder.pose.world_to_camera
        position = into[:, :3] @ data.light_xpos[light] + into[:, 3]
        direction = into[:, :3] @ data.light_xdir[light]
        return np.concatenate([position, direction, self._beams[light]])


def _beam_constants(model: mujoco.MjModel, light: int) -> F64:
    """Return candela, and scale and offset of the cone's edge, of a light."""
    outer = math.radians(model.light_cutoff[light])
    inner = outer * (1 - model.light_softness[light])
    scale = 1 / max(math.cos(inner) - math.cos(outer), MIN_CONE_EDGE)
    return np.array([model.light_intensity[light], scale, -math.cos(outer) * scale])


def _shadow_lights(model: mujoco.MjModel, objects: tuple[MovingObject, ...]) -> Numbers:
    """Return the numbers of the fixed lights that cast shadows."""
    moving = np.isin(np.arange(model.nlight), [k for o in objects for k in o.lamps])
    image = model.light_type == mujoco.mjtLightType.mjLIGHT_IMAGE
    shining = model.light_intensity > 0
    return np.flatnonzero(model.light_castshadow & shining & ~moving & ~image)
