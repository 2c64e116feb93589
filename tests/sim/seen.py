"""What a camera would see, drawn by hand."""

import numpy as np
import numpy.typing as npt

from sim.scene.scene import Scene


def target_on(mask: npt.NDArray[np.bool_], scene: Scene) -> npt.NDArray[np.int32]:
    """Numbers of bodies: the target's on the pixels of a mask, (height, width) bool, else sky."""
    return np.where(mask, np.int32(scene.target.root), np.int32(-1))
