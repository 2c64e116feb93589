"""Body labels of a camera image, made by hand."""

import numpy as np
import numpy.typing as npt

from sim.scene.scene import Scene


def target_body_labels(mask: npt.NDArray[np.bool_], scene: Scene) -> npt.NDArray[np.int32]:
    """Return body numbers: the target's where a (height, width) mask is true, elsewhere sky."""
    return np.where(mask, np.int32(scene.target.root), np.int32(-1))
