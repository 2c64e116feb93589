"""Depth, optical flow and visible body of every pixel of a camera in any MuJoCo model."""

from __future__ import annotations

from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from sim.geometry.pinhole import Intrinsics, Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.deforming import DeformingShapes
from sim.raster.scan_conversion import NO_LABEL
from sim.raster.triangles import Triangles, TriangleSoup, triangle_soup
from sim.raster.visibility import VisibilityMap, overlay_triangles, visibility_map
from sim.render.filament import FAR_M
from sim.render.model_state import ModelState
from sim.truth.dense_truth import RATE_STEP_S

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]

DEFORMING_STEP_S = 1e-3
"""Half the interval of the central differences of what deforms [s]. MuJoCo's visualizer rounds its
corners to float32, which at 1 m is 4·10⁻⁵ m/s. A motion of frequency f loses (2π f · 10⁻³)²/6 of
its speed, 6·10⁻⁴ at 10 Hz."""


class ModelTruth:
    """Exact geometry of a model as one of its cameras sees it.

    Attributes:
        deforming: the model's flexes, skins, spatial tendons and slider-cranks that are rendered.
    """

    def __init__(self, model: mujoco.MjModel, state: ModelState, lens: Intrinsics) -> None:
        """Prepare the geometry.

        Args:
            model: model in which everything that is not rendered has a hidden group.
            state: poses of the model and its camera.
            lens: intrinsics of the camera.
        """
        self._model, self._state, self._lens = model, state, lens
        self._shapes = DeformingShapes(model)
        self.deforming = self._shapes.objects

    def visible(self, data: mujoco.MjData) -> VisibilityMap:
        """Return what the middle of each pixel shows; see `PhotometricCamera.visible`."""
        seen, pieces = self._seen(data)
        if pieces:
            owner = np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces])
            of_triangle = self._model.nbody + owner
            deforms = seen.body >= self._model.nbody
            seen.body[deforms] = of_triangle[seen.body[deforms] - self._model.nbody]
        return seen

    def flow_px_s(self, data: mujoco.MjData) -> F32:
        """Return the image velocity of each pixel; see `PhotometricCamera.flow_px_s`."""
        seen, pieces = self._seen(data)
        twists = flow.twists_between(*self._bodies_around(data), 2 * RATE_STEP_S)
        if pieces:
            number = np.unique(seen.body[seen.body >= self._model.nbody]) - self._model.nbody
            rates = self._triangle_rates(data, pieces, number)
            twists = np.concatenate([twists, rates])
        return flow.flow_px_s(seen, twists, self._lens)

    @cached_property
    def _soup(self) -> TriangleSoup:
        return triangle_soup(self._model, complete=True)

    def _seen(self, data: mujoco.MjData) -> tuple[VisibilityMap, list[Triangles]]:
        """Return the body of each pixel, and the triangles of each deforming object in the world.

        Where a pixel shows a deforming object, its body is the number of bodies plus the number of
        the triangle.
        """
        pose = self._state.load(data)
        seen = visibility_map(self._soup, body_poses(self._state.data), pose, self._lens)
        pieces = self._shapes.triangles(self._state.data)
        if pieces:
            overlay_triangles(seen, np.concatenate(pieces), self._model.nbody, pose, self._lens)
        beyond = seen.nearness < 1 / FAR_M
        seen.body[beyond], seen.nearness[beyond] = NO_LABEL, 0.0
        return seen, pieces

    def _bodies_around(self, data: mujoco.MjData) -> tuple[F64, F64, F64]:
        """(bodies, 3, 4) transforms from each body's frame to the camera's, before, now, after."""

        def poses(ahead_s: float) -> F64:
            pose = self._state.load(data, ahead_s)
            return compose_transforms(body_poses(self._state.data), pose.world_to_camera)

        return poses(-RATE_STEP_S), poses(0.0), poses(RATE_STEP_S)

    def _triangle_rates(
        self, data: mujoco.MjData, now: list[Triangles], wanted: npt.NDArray[np.int64]
    ) -> F64:
        """(triangles, 3, 4) velocity fields of the wanted triangles; zero for the others."""
        rates = np.zeros((sum(map(len, now)), 3, 4))
        if len(wanted):
            before, after = (
                self._pieces_in_camera(data, step) for step in (-DEFORMING_STEP_S, DEFORMING_STEP_S)
            )
            pose = self._state.load(data)
            middle = [_in_camera(piece, pose) for piece in now]
            corners = np.concatenate(list(map(_matched, before, middle, after)), axis=1)
            rates[wanted] = flow.triangle_rates(corners[:, wanted], 2 * DEFORMING_STEP_S)
        return rates

    def _pieces_in_camera(self, data: mujoco.MjData, ahead_s: float) -> list[Triangles]:
        pose = self._state.load(data, ahead_s)
        return [_in_camera(piece, pose) for piece in self._shapes.triangles(self._state.data)]


def _in_camera(triangles_m: Triangles, pose: Pose) -> Triangles:
    return np.asarray(triangles_m @ pose.world_to_camera[:, :3].T + pose.world_to_camera[:, 3])


def _matched(before: Triangles, now: Triangles, after: Triangles) -> F64:
    """Return the (3, n, 3, 3) corners of one object at three times, each time as many as now.

    A tendon that begins or ceases to touch a geom changes its number of parts. Then the side
    without the change is continued; if there is none, the motion is unknown, NaN.
    """
    if len(before) != len(now) and len(after) != len(now):
        before = after = np.full_like(now, np.nan)
    elif len(before) != len(now):
        before = 2 * now - after
    elif len(after) != len(now):
        after = 2 * now - before
    return np.stack([before, now, after])
