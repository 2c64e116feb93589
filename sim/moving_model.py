"""Any MuJoCo model whose state is a function of time, and the exact truth of one of its cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from sim.errors import SceneConfigError
from sim.geometry.pinhole import Pose
from sim.geometry.rigid_transform import body_poses, compose_transforms
from sim.raster import flow
from sim.raster.visibility import VisibilityMap
from sim.render.luminance_model import luminance_model
from sim.render.model_camera import camera_id, camera_intrinsics
from sim.render.model_state import ModelState
from sim.truth.dense_truth import BACKGROUND, RATE_STEP_S
from sim.truth.model_truth import ModelTruth

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int8]
Place = Callable[[mujoco.MjData, float], None]
"""Function that sets `data.qpos`, `data.mocap_pos` and `data.mocap_quat` for a time [s]."""
MAX_OBJECTS = 127
"""Most moving objects: their numbers are 8-bit."""


@dataclass(frozen=True)
class ModelObject:
    """A moving object of a model.

    Attributes:
        name: name of its topmost body, or "body_" and its number.
        bodies: numbers of its rigid bodies.
    """

    name: str
    bodies: tuple[int, ...]

    @property
    def kind(self) -> str:
        """Kind of the object: every object of a model is one of its own."""
        return self.name


class MovingModel:
    """Exact geometry of a model as one of its cameras sees it, at any time.

    The interface is that of `DenseTruth`, with times since the start of the motion. The state of
    the model depends on time alone, so that velocities and displacements follow from the poses at
    two or three times. An instance must not be used by several threads at once.

    Attributes:
        lens: intrinsics of the camera.
        objects: the moving objects.
        object_of_body: (bodies + deforming,) int8 number of the object that each body belongs to,
            or `BACKGROUND`; all that deforms belongs to the background.
        deforming: the model's flexes, skins, spatial tendons and slider-cranks that are rendered.
            A model with any has no `displacement_px`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        camera: str,
        place: Place,
        *,
        width: int,
        height: int,
        objects: Sequence[str] = (),
    ) -> None:
        """Find the moving objects and prepare the geometry.

        Args:
            model: the model, which is not changed.
            camera: name of the camera.
            place: function that sets the positions for a time. It is also called for times up to
                10 µs before the start and after the end.
            width: width of the image [px].
            height: height of the image [px].
            objects: names of bodies, each of which is an object with all bodies below it; empty:
                every body of the world that can move, or has a part that can.

        Raises:
            SceneConfigError: there is no such camera or body; nothing can move; there are more than
                `MAX_OBJECTS` objects; or there are mocap bodies beside something that deforms.
        """
        self._model, self._place = model, place
        self.lens = camera_intrinsics(model, camera, width=width, height=height)
        self._data, self._state = mujoco.MjData(model), ModelState(model, camera_id(model, camera))
        self._truth = ModelTruth(luminance_model(model), self._state, self.lens)
        self.deforming = self._truth.deforming
        _check_mocap(model, len(self.deforming))
        owner = _named_owners(model, objects) if objects else model.body_rootid.copy()
        owner[model.body_weldid == 0] = BACKGROUND
        roots = [int(k) for k in np.unique(owner) if k != BACKGROUND]
        _check_number(model, len(roots))
        self.objects = tuple(
            ModelObject(model.body(k).name or f"body_{k}", tuple(np.flatnonzero(owner == k)))
            for k in roots
        )
        self.object_of_body = np.full(model.nbody + len(self.deforming), BACKGROUND, np.int8)
        for number, root in enumerate(roots):
            self.object_of_body[: model.nbody][owner == root] = number

    def data_at(self, t_s: float) -> mujoco.MjData:
        """Return the state at a time [s]; the next call changes it.

        Raises:
            SceneConfigError: a position is not finite.
        """
        data = self._data
        self._place(data, t_s)
        positions = np.concatenate([data.qpos, data.mocap_pos.ravel(), data.mocap_quat.ravel()])
        if not np.isfinite(positions).all():
            raise SceneConfigError(
                f"the trajectory gives positions that are not finite at {t_s:g} s. Allowed are "
                "finite numbers. Correct the function or the keyframes."
            )
        return data

    def pose_at(self, t_s: float) -> Pose:
        """Return the pose of the camera at a time [s]."""
        return self._state.load(self.data_at(t_s))

    def poses_in_camera(self, t_s: float) -> F64:
        """(bodies, 3, 4) transforms from each body's frame to the camera's frame."""
        pose = self.pose_at(t_s)
        return compose_transforms(body_poses(self._state.data), pose.world_to_camera)

    def twists(self, t_s: float) -> F64:
        """(bodies, 3, 4) velocity fields in the camera's frame; see `DenseTruth.twists`."""
        before, now, after = (
            self.poses_in_camera(t) for t in (t_s - RATE_STEP_S, t_s, t_s + RATE_STEP_S)
        )
        return flow.twists_between(before, now, after, 2 * RATE_STEP_S)

    def visible(self, t_s: float) -> VisibilityMap:
        """Return the body that the middle of each pixel shows, and its nearness."""
        return self._truth.visible(self.data_at(t_s))

    def flow_px_s(self, t_s: float) -> F32:
        """(height, width, 2) float32 image velocity of what the middle of each pixel shows."""
        if self.deforming:
            return self._truth.flow_px_s(self._data_with_velocity(t_s))
        return flow.flow_px_s(self.visible(t_s), self.twists(t_s), self.lens)

    def displacement_px(self, from_s: float, to_s: float) -> F32:
        """(height, width, 2) float32 displacement; see `DenseTruth.displacement_px`.

        Raises:
            SceneConfigError: something in the model deforms.
        """
        if self.deforming:
            raise SceneConfigError(
                f"the model has the {self.deforming[0].kind} {self.deforming[0].name!r}, which "
                "deforms. Allowed are rigid bodies. Use the image velocity."
            )
        moves = flow.transforms_between(self.poses_in_camera(from_s), self.poses_in_camera(to_s))
        return flow.displacement_px(self.visible(from_s), moves, self.lens)

    def fastest_px_s(self, t_s: float) -> float:
        """Return the highest image speed at a pixel centre [px/s]."""
        velocity = self.flow_px_s(t_s)
        return float(np.fmax.reduce(np.hypot(velocity[..., 0], velocity[..., 1]), axis=None))

    def _data_with_velocity(self, t_s: float) -> mujoco.MjData:
        """Return the state at a time with the joints' velocities (central differences)."""
        before = self.data_at(t_s - RATE_STEP_S).qpos.copy()
        after = self.data_at(t_s + RATE_STEP_S).qpos.copy()
        data = self.data_at(t_s)
        mujoco.mj_differentiatePos(self._model, data.qvel, 2 * RATE_STEP_S, before, after)
        return data


def _named_owners(model: mujoco.MjModel, names: Sequence[str]) -> npt.NDArray[np.int64]:
    """(bodies,) number of the named body nearest above each body, or `BACKGROUND`."""
    owner = np.full(model.nbody, BACKGROUND, np.int64)
    numbers = [_body_number(model, name) for name in names]
    for k in range(1, model.nbody):  # a parent's number is lower than its child's
        owner[k] = k if k in numbers else owner[model.body_parentid[k]]
    return owner


def _body_number(model: mujoco.MjModel, name: str) -> int:
    number = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name))
    if number > 0 and model.body_weldid[number] > 0:
        return number
    movable = [model.body(k).name for k in range(1, model.nbody) if model.body_weldid[k] > 0]
    listed = ", ".join(name for name in movable if name)
    raise SceneConfigError(
        f"the model has no body {name!r} that can move. Allowed is one of {listed or 'none'}. "
        "Correct the name, or give the body a joint."
    )


def _check_mocap(model: mujoco.MjModel, deforming: int) -> None:
    if model.nmocap and deforming:
        raise SceneConfigError(
            f"the model has {model.nmocap} mocap bodies, which have no velocity, and {deforming} "
            "parts that deform. Allowed is one of both. Give the bodies joints instead."
        )


def _check_number(model: mujoco.MjModel, count: int) -> None:
    if count == 0:
        raise SceneConfigError(
            f"nothing in the model can move: it has {model.njnt} joints and {model.nmocap} mocap "
            "bodies. Allowed is at least one. Add a <joint/> to a body."
        )
    if count > MAX_OBJECTS:
        raise SceneConfigError(
            f"the model has {count} moving objects. Allowed are {MAX_OBJECTS}. Name those to label."
        )


def compiled_bytes(model: mujoco.MjModel) -> bytes:
    """Return a compiled model, with its meshes and textures, as MuJoCo's binary format."""
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content.tobytes()
