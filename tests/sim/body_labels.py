"""Hand-made body labels, in place of those that a camera would see."""

import numpy as np
import numpy.typing as npt

from sim.scene.scene import Scene


def target_body_labels(mask: npt.NDArray[np.bool_], scene: Scene) -> npt.NDArray[np.int32]:
    """(height, width) int32: the target's root body where `mask` is True, elsewhere the sky."""
    return np.where(mask, np.int32(scene.target.root), np.int32(-1))
