"""Shadows of the moving objects and beams of their lamps at one time, ready for compositing."""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rectangles import Rectangle, steady_camera
from sim.geometry.rigid_transform import compose_transforms, inverse_transform
from sim.raster.shared_corners import share_corners
from sim.raster.triangles import TriangleSoup
from sim.scene.moving_objects import MovingObject, box_corners_m
from sim.shadows.affected_rectangles import (
    BeamLamps,
    ShadowLights,
    beams_in_view,
    shadow_rectangles,
)
from sim.shadows.shadow_maps import (
    MAP_SIDE,
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


class AffectedAreas(NamedTuple):
    """Image areas that shadows and beams of the moving objects can change at one time.

    Rectangles are x0, y0, x1, y1 [px]; all 0 if nothing is in the image.

    Attributes:
        shadows: (objects, lights, 4) int64, area that each object can darken for each light of
            `AffectedAreaFinder.sources`.
        beams: (n, 9) beams in view; see `ShadowsAndBeams`.
        beam_areas: (n, 4) int64, area that each of these can reach.
    """

    shadows: Numbers
    beams: F64
    beam_areas: Numbers

    @property
    def rectangles(self) -> list[Rectangle]:
        """The rectangles of all shadows and beams that are in the image."""
        found = self.shadows.reshape(-1, 4).tolist() + self.beam_areas.tolist()
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in found if x1]


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
        self.shadow_lights = _shadow_lights(model, objects)
        self.sources: list[ShadowSource] = shadow_sources(model, data, self.shadow_lights)
        self._lights = ShadowLights(
            np.array([source.axes[2] for source in self.sources]).reshape(-1, 3),
            np.array([source.position_m for source in self.sources]).reshape(-1, 3),
            np.array([source.is_sun for source in self.sources], np.bool_),
        )
        self._boxes_m = np.array([box_corners_m(o.box_m) for o in objects]).reshape(-1, 8, 3)
        self._roots = np.array([o.root for o in objects], np.int64)
        none = np.empty(0, np.int64)
        self.beams: Numbers = np.concatenate([none, *(o.lamps for o in objects)])
        # Taken now, because a renderer changes the model's lights for a moment.
        self._lamps = BeamLamps(
            self.beams,
            np.tan(np.radians(model.light_cutoff[self.beams].astype(np.float64))),
            np.array([_cone(model, int(k)) for k in self.beams]).reshape(-1, 3),
        )
        self._camera = steady_camera(pose, lens)

    def find(self, data: mujoco.MjData) -> AffectedAreas:
        """Return the areas for the poses in `data`."""
        bodies = self._roots, data.xpos, data.xmat
        return AffectedAreas(
            shadow_rectangles(self._boxes_m, *bodies, self._lights, self._camera),
            *beams_in_view(self._lamps, data.light_xpos, data.light_xdir, self._camera),
        )


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
        self._to_world = inverse_transform(finder.pose.world_to_camera)
        self._rows = ShadowsAndBeams(
            gains=np.empty(0),
            maps=np.empty((pairs, MAP_SIDE, MAP_SIDE), np.float32),
            sizes=np.empty((pairs, 2), np.int64),
            views=np.empty((pairs, 3, 4)),
            light=np.empty(pairs, np.int64),
            is_sun=np.empty(pairs, np.bool_),
            shadow_areas=np.empty((pairs, 4), np.int64),
            beams=np.empty((0, 9)),
            beam_areas=np.empty((0, 4), np.int64),
            beam_range_m=max((float(model.light_range[k]) for k in finder.beams), default=1.0),
        )

    def render(self, poses: F64, areas: AffectedAreas, gains: F64) -> ShadowsAndBeams:
        """Render the shadow maps and collect the beams.

        Args:
            poses: (bodies, 3, 4) transform from each body's frame into the world.
            areas: affected areas at the same time.
            gains: factor of each layer of the background.

        Returns:
            Shadows and beams. The next call overwrites them.
        """
        sources, rows, count = self._finder.sources, self._rows, 0
        for obj, of_lights in zip(self._finder.objects, areas.shadows.tolist(), strict=True):
            for k, area in enumerate(of_lights):
                if not area[2]:
                    continue
                out = rows.maps[count]
                caster = self._casters[obj.name]
                made = render_shadow_map(sources[k], obj, caster, poses, out)
                if made is None:
                    continue
                rows.sizes[count], rows.views[count] = made.size, made.view
                rows.light[count], rows.is_sun[count] = k, sources[k].is_sun
                rows.shadow_areas[count] = area
                count += 1
        return rows._replace(
            gains=gains,
            sizes=rows.sizes[:count],
            views=compose_transforms(self._to_world, rows.views[:count]),
            light=rows.light[:count],
            is_sun=rows.is_sun[:count],
            shadow_areas=rows.shadow_areas[:count],
            beams=areas.beams,
            beam_areas=areas.beam_areas,
        )


def _cone(model: mujoco.MjModel, light: int) -> F64:
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
