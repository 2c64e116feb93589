"""What a camera would see, drawn by hand."""

import numpy as np
import numpy.typing as npt

from sim.scene import Scene
from sim.visible import Visible


def target_on(mask: npt.NDArray[np.bool_], scene: Scene) -> Visible:
    """The target 7 m away on the pixels of a mask, (height, width) bool, and elsewhere sky."""
    body = np.where(mask, np.int32(scene.target.root), np.int32(-1))
    return Visible(body, np.where(mask, np.float32(1 / 7), np.float32(0)))
