"""Names of the files of a sequence, and times of its labels. Readers need nothing else."""

from __future__ import annotations

EVENTS, RECTIFY = "events/left/events.h5", "events/left/rectify_map.h5"
EVENT_LABELS = "events/left/event_labels.h5"
FORWARD, BACKWARD, VELOCITY = "flow/forward", "flow/backward", "flow/velocity.h5"
DEPTH, MASKS, APS, IMAGES = "depth", "masks", "aps", "images/left/distorted"
IMAGE_TIMES = "images/timestamps.txt"
TRACKS, COCO = "object_detections/left/tracks.npy", "object_detections/left/coco.json"
MOTION, POSES, CALIBRATION = "motion.csv", "poses.csv", "calibration/cam_to_cam.yaml"
SHARD = "shard.tar"


def label_times_us(duration_us: int, period_us: int) -> range:
    """Return the times of the labels of a sequence: multiples of the period, up to its end [µs]."""
    return range(0, duration_us + 1, period_us)


def file_name(number: int) -> str:
    """Return the name of the PNG file of a label, as in DSEC."""
    return f"{number:06d}.png"
