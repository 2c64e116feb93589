"""All of a sample that follows from its time alone: poses, triangles, areas and gains."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.rectangles import Rectangle, merge_overlapping
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.keyframes.mover_visibility import MoverRaster
from sim.scene.lamp_flicker import FlickeringLamps
from sim.scene.scene import Scene
from sim.shadows.shadows_and_beams import AffectedAreaFinder, AffectedAreas

F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]


class Moment(NamedTuple):
    """The state of a scene at one time, as the steady camera sees it.

    Attributes:
        poses: (bodies, 3, 4) transform from each body's frame into the world.
        views: (bodies, 3, 4) transform from each body's frame to the camera's.
        triangles: (n, 3, 3) triangles of the moving parts on the sub-pixel grid.
        part: (n,) part of each triangle.
        drawn: rectangle around each moving object that is in the image.
        affected: areas that shadows and beams can change.
        changed: rectangles without overlap that hold all of these.
        flicker: relative flux of the flickering lamps.
        gains: factor of each layer of the background.
    """

    poses: F64
    views: F64
    triangles: F64
    part: I32
    drawn: list[Rectangle]
    affected: AffectedAreas
    changed: list[Rectangle]
    flicker: float
    gains: F64


class Moments:
    """Finds the state of a scene at any time."""

    def __init__(
        self,
        scene: Scene,
        data: mujoco.MjData,
        seconds: Callable[[int], float],
        raster: MoverRaster,
        areas: AffectedAreaFinder,
        flickering: FlickeringLamps | None,
    ) -> None:
        """Prepare; nothing is computed yet.

        Args:
            scene: the scene.
            data: poses of its model; changed.
            seconds: converts a time [µs] to the scene's time [s].
            raster: rasteriser of the moving objects.
            areas: finds the areas that shadows and beams can change.
            flickering: lamps that flicker; None if there are none.
        """
        self._scene, self._data, self._seconds = scene, data, seconds
        self._raster, self._areas = raster, areas
        lights, flickers = areas.shadow_lights, flickering is not None
        mains = np.isin(lights, flickering.lights if flickering else [])
        self._flickering_layers = np.array([False, *mains, *[True] * flickers])

    def at(self, t_us: int) -> Moment:
        """Return the state at a time [µs]."""
        t_s = self._seconds(t_us)
        self._scene.place(self._data, t_s)
        poses = body_poses(self._data)
        views = compose_transforms(poses, self._raster.pose.world_to_camera)
        triangles, part = self._raster.project_views(views)
        found = self._raster.rectangles(triangles, part, self._scene.objects)
        drawn = [rectangle for rectangle in found if rectangle]
        affected = self._areas.find(self._data)
        flicker = self._scene.flicker_factor(t_s)
        return Moment(
            poses=poses,
            views=views,
            triangles=triangles,
            part=part,
            drawn=drawn,
            affected=affected,
            changed=merge_overlapping(drawn + affected.rectangles),
            flicker=flicker,
            gains=np.where(self._flickering_layers, flicker, 1.0),
        )
