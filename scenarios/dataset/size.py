"""Estimated size of a dataset, before anything is rendered."""

from __future__ import annotations

import math

from flybench.direction import Direction
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.sequence_plan import SequencePlan
from sim import CrossingConfig, Lighting, VehicleKind

_VEHICLE_M = {
    VehicleKind.SEDAN: (2.3, 1.8),
    VehicleKind.VAN: (2.56, 2.16),
    VehicleKind.MOTORCYCLE: (1.05, 0.8),
}
"""Half the length and the width of each vehicle [m]; see `sim/assets`."""
_EVENTS_PER_PX = 17.0
"""Events per pixel in a crossing, without noise (measured: 11 to 17 with the default sensor)."""
_NOISE_HZ_PER_PX = {Lighting.DAY: 0.3, Lighting.DUSK: 2.0, Lighting.NIGHT: 9.0}
"""Rate of noise by time of day (measured by day and at night; assumed at dusk)."""
_EVENT_BYTES = {Label.EVENT_SOURCE: 1.2, Label.EVENT_FLOW: 3.5}
"""Size per event of its labels [bytes] (measured), besides that of the event itself."""
_PLAIN_EVENT_BYTES = 2.9
_PLAIN_RECORD_BYTES = 13
"""Size of an event in a shard [bytes]."""
_FRAME_BYTES = {
    Label.FLOW: 0.4,
    Label.VELOCITY: 0.7,
    Label.DEPTH: 0.6,
    Label.MASKS: 0.02,
    Label.COCO: 0.015,
    Label.IMAGES: 1.6,
}
"""Size per pixel and label [bytes] (measured at 346×260 px by day and by night)."""
_APS_BYTES_PER_PX = 1.02
"""Size per pixel of a frame [bytes] (measured)."""
_APS_HZ = {Lighting.DAY: 40.0, Lighting.DUSK: 20.0, Lighting.NIGHT: 5.0}
"""Rate of frames by time of day (measured by day and at night; assumed at dusk)."""
_CAMERA_BYTES_S = 85_000
"""Size of the camera's poses per second [bytes] (measured)."""
_OTHER_BYTES = 80_000
"""Size of all other files of a sequence [bytes] (measured: 40 to 70 kB)."""


def duration_s(plan: SequencePlan) -> float:
    """Return about how long a sequence is [s]; `Crossing.duration_us` is exact."""
    if not isinstance(plan.scene, CrossingConfig):
        return plan.build_scene().duration_us * 1e-6
    crossing, lens = plan.crossing, plan.lens
    level = crossing.direction in (Direction.RIGHT, Direction.LEFT)
    half_view = lens.half_width_rad if level else lens.half_height_rad
    half_length_m, width_m = _VEHICLE_M[crossing.vehicle]
    reach_m = (crossing.distance + width_m) * math.tan(half_view) + half_length_m
    speed_m_s = crossing.omega_rad_s * crossing.distance
    return 2 * (reach_m / speed_m_s + crossing.lead_s)


def estimated_bytes(plan: SequencePlan) -> int:
    """Return about how large the folder of a sequence is [bytes].

    It is an estimate for a vehicle in a calm street. Wind, shake and lower contrast thresholds than
    the default make more events. A model is taken to have as many events (assumed).
    """
    is_street = isinstance(plan.scene, CrossingConfig)
    lighting = plan.crossing.lighting if is_street else Lighting.DAY
    seconds, pixels = duration_s(plan), plan.sensor.width * plan.sensor.height
    times = 1 + seconds * 1e6 / plan.period_us
    events = pixels * (_EVENTS_PER_PX + _NOISE_HZ_PER_PX[lighting] * seconds)
    per_event = _PLAIN_EVENT_BYTES + sum(_EVENT_BYTES.get(label, 0) for label in plan.labels)
    per_frame = sum(_FRAME_BYTES.get(label, 0) for label in plan.labels)
    size = events * per_event + pixels * times * per_frame + _OTHER_BYTES
    if Label.SHARD in plan.labels:
        size += events * _PLAIN_RECORD_BYTES + pixels * times * per_frame
    if Label.APS in plan.labels:
        size += pixels * seconds * _APS_HZ[lighting] * _APS_BYTES_PER_PX
    if Label.CAMERA in plan.labels:
        size += _CAMERA_BYTES_S * seconds
    return round(size)
