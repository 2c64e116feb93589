"""The kinds of labels, and which of them a scene and a sensor can give."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Any

from scenarios.errors import ScenarioError


class Label(StrEnum):
    """Kinds of labels; each is optional."""

    FLOW = "flow"
    VELOCITY = "velocity"
    DEPTH = "depth"
    MASKS = "masks"
    BOXES = "boxes"
    COCO = "coco"
    EVENT_SOURCE = "event_source"
    EVENT_FLOW = "event_flow"
    MOTION = "motion"
    CAMERA = "camera"
    APS = "aps"
    IMAGES = "images"
    SHARD = "shard"


BY_DEFAULT = tuple(label for label in Label if label is not Label.SHARD)
"""Labels of a file that names none; a shard repeats the others and doubles the size."""

CONTENTS = {
    Label.FLOW: "displacement of every pixel to the next and to the previous label, 16-bit PNG",
    Label.VELOCITY: "image velocity of every pixel [px/s], HDF5",
    Label.DEPTH: "depth along the optical axis, 16-bit PNG of 1/256 m, 0 for the sky",
    Label.MASKS: "instance masks, 8-bit PNG, 0 for the background",
    Label.BOXES: "boxes and tracks, as in DSEC-Detection",
    Label.COCO: "boxes and masks as COCO JSON, one file per split",
    Label.EVENT_SOURCE: "object and cause of every event, HDF5",
    Label.EVENT_FLOW: "true image velocity at every event [px/s], HDF5",
    Label.MOTION: "direction, angular velocity and image velocity of every object, CSV",
    Label.CAMERA: "intrinsics, and the pose of the camera every millisecond",
    Label.APS: "frames of the sensor, 16-bit PNG, with the times of their exposure",
    Label.IMAGES: "preview at the time of every label, 8-bit PNG",
    Label.SHARD: "events and images of all samples as one tar file, for WebDataset",
}
"""What each label is, for the dataset's card."""

_IMPOSSIBLE = {
    "disparity": "The scene has one camera, and disparity needs two. Use depth.",
    "imu": "The camera has no inertial sensor. Use camera for its pose.",
}
"""Labels of other datasets that no scene can give, and what to do instead."""


def parse_labels(key: str, value: Any) -> tuple[Label, ...]:
    """Return the labels of a list, in the order of `Label`.

    Args:
        key: key of the list in the file, for messages.
        value: candidate.

    Raises:
        ScenarioError: it is not a list of labels, names a label twice, or names one that no scene
            can give.
    """
    names = [label.value for label in Label]
    if not isinstance(value, list):
        raise ScenarioError(
            f"{key} is {value!r}. Allowed is a list of {', '.join(names)}. Leave it out for all "
            "labels."
        )
    for name in value:
        if isinstance(name, str) and name in _IMPOSSIBLE:
            raise ScenarioError(f"{key} holds {name!r}. {_IMPOSSIBLE[name]}")
        if name not in names:
            raise ScenarioError(
                f"{key} holds {name!r}. Allowed is one of {', '.join(names)}. Correct the name."
            )
        if value.count(name) > 1:
            raise ScenarioError(f"{key} holds {name!r} twice. Allowed is once. Remove one of them.")
    wanted = tuple(label for label in Label if label in value)
    if Label.COCO in wanted and Label.IMAGES not in wanted:
        raise ScenarioError(
            f"{key} holds 'coco' without 'images'. A COCO file describes images. Add 'images', or "
            "use boxes and masks."
        )
    return wanted


def check_frames(key: str, labels: Sequence[Label], frameless: Sequence[str]) -> None:
    """Refuse frames of a sensor that has none.

    Args:
        key: key of the labels in the file, for messages.
        labels: labels that the file asks for.
        frameless: presets and files of sensors that have no frames.

    Raises:
        ScenarioError: frames are asked for, and a sensor has none.
    """
    if Label.APS in labels and frameless:
        raise ScenarioError(
            f"{key} holds 'aps', and the sensor may be {frameless[0]!r}, which has no frames. "
            "Remove 'aps', or choose davis346 or davis240."
        )


def check_target(key: str, labels: Sequence[Label]) -> None:
    """Refuse the motion of the target of a model, which has none.

    Raises:
        ScenarioError: it is asked for.
    """
    if Label.MOTION in labels:
        raise ScenarioError(
            f"{key} holds 'motion', and the scene is a model, which has no vehicle whose direction "
            "could be stated. Use velocity and masks."
        )
