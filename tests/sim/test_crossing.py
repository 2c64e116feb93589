"""Samples of a crossing: ground truth compared with projections, and rendered luminance."""

import itertools
import math
from typing import Any

import cv2
import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from emulator import EventSensor, SensorConfig
from flybench.direction import CARDINAL, Direction
from sim import (
    Crossing,
    CrossingConfig,
    DenseTruth,
    Distractors,
    Lighting,
    Preview,
    Profile,
    RelativeDirection,
    TruthProbe,
    project,
)
from sim.errors import SceneConfigError
from sim.motion.trajectory import MAX_BEARING_RAD
from sim.render.filament import FilamentRenderer
from sim.render.luminance_model import luminance_model
from sim.scene.scene import build_spec

FOCAL_PX = 6e-3 / 18.5e-6

COARSE = {"step_px": 40.0 / 5, "supersample": 1, "max_step_ms": 20.0}


def make_crossing(lighting: str = "day", direction: str = "right", **options: Any) -> Crossing:
    return Crossing(
        CrossingConfig(
            lighting=Lighting(lighting),
            direction=Direction(direction),
            **(COARSE | options),
        )
    )


@pytest.mark.parametrize("profile", list(Profile))
@pytest.mark.parametrize("direction", CARDINAL)
def test_truth_agrees_with_the_projected_trajectory(direction: str, profile: str) -> None:
    """Compared with the closed forms of a flank at distance d, seen by a rolled camera."""
    omega, distance = 1.61, 6.89
    crossing = make_crossing(direction=direction, profile=Profile(profile))
    along = {"right": (1, 0), "left": (-1, 0), "up": (0, -1), "down": (0, 1)}[direction]
    probe, sky = TruthProbe(crossing.scene, crossing.intrinsics), np.full((260, 346), -1, np.int32)
    for t_us in crossing.times_us()[::9]:
        truth, angle = (
            probe.measure(t_us, crossing.seconds(t_us), sky),
            omega * crossing.seconds(t_us),
        )
        tangent = angle if profile == Profile.CONSTANT_SPEED else math.tan(angle)
        rate = omega if profile == Profile.CONSTANT_SPEED else omega / math.cos(angle) ** 2
        way_px = (truth.reference_px - [173, 130]) @ np.array(along)
        assert way_px == pytest.approx(FOCAL_PX * tangent, abs=1e-6)
        assert truth.image_velocity_px_s == pytest.approx(FOCAL_PX * rate * np.array(along))
        assert truth.angular_velocity_rad_s == pytest.approx(rate / (1 + tangent**2))
        assert truth.position_m == pytest.approx(distance * tangent)
        assert truth.direction == direction


@pytest.mark.parametrize(("lighting", "direction"), [("day", "right"), ("night", "up")])
def test_the_mask_covers_the_projection_of_the_vehicle(lighting: str, direction: str) -> None:
    crossing = make_crossing(lighting, direction)
    fully_visible = 0
    for sample in itertools.islice(crossing.samples(), 0, None, 5):
        truth = sample.truth
        corners, _ = project(
            crossing.scene.body_corners_m(truth.position_m),
            crossing.scene.pose,
            crossing.intrinsics,
        )
        low, high = np.clip([corners.min(axis=0), corners.max(axis=0)], 0, [346, 260])
        assert truth.position_m == pytest.approx(
            1.61 * crossing.config.distance * crossing.seconds(sample.t_us)
        )
        assert truth.mask.shape == (260, 346)
        if truth.bounding_box_px is None or truth.centroid_px is None:
            assert not truth.in_view
            assert truth.visibility < 0.1
            continue
        x0, y0, x1, y1 = truth.bounding_box_px
        assert (np.array([x0, y0]) >= low - 1).all()
        assert (np.array([x1, y1]) <= high + 1).all()
        assert (np.array([x0, y0]) <= truth.centroid_px).all()
        assert (truth.centroid_px <= np.array([x1, y1])).all()
        if truth.visibility > 0.99 and 0 < x0 < x1 < 346 and 0 < y0 < y1 < 260:
            fully_visible += 1
            bumpers = project(_bumpers(truth.position_m), crossing.scene.pose, crossing.intrinsics)[
                0
            ]
            axis = 0 if direction == "right" else 1
            ends = sorted(bumpers[:, axis])
            assert (x0, y0)[axis] == pytest.approx(ends[0], abs=3)
            assert (x1, y1)[axis] == pytest.approx(ends[1], abs=3)
            assert truth.mask.sum() > 0.5 * (x1 - x0) * (y1 - y0)
    assert fully_visible >= 2


def _bumpers(position_m: float) -> npt.NDArray[np.float64]:
    """(2, 3) near ends of the bumpers of `sedan.xml` [m]."""
    return np.array([[position_m + x, y, 0.38] for x, y in ((-2.28, -0.78), (2.28, -0.72))])


def test_outside_the_changed_rectangle_the_luminance_is_exactly_that_of_the_sample_before() -> None:
    extra = Distractors(far_vehicle=RelativeDirection.OPPOSITE)
    before, crossing = None, make_crossing("night", distractors=extra)
    times_us = crossing.times_us()
    for sample in crossing.samples(times_us[len(times_us) // 3 : len(times_us) // 2]):
        x0, y0, x1, y1 = sample.changed
        if before is not None:
            same = before == sample.luminance
            same[y0:y1, x0:x1] = True
            assert same.all()
        before = sample.luminance


@pytest.mark.parametrize("lighting", list(Lighting))
def test_by_day_the_last_frame_equals_the_first(lighting: str) -> None:
    crossing = make_crossing(lighting)
    images = [
        s.luminance for s in crossing.samples([0, crossing.duration_us // 2, crossing.duration_us])
    ]
    assert not np.array_equal(images[0], images[1])
    if lighting == Lighting.DAY:
        assert np.array_equal(images[0], images[2])


def test_by_day_events_come_from_the_vehicle_and_its_shadow() -> None:
    crossing = make_crossing(step_px=4.0, supersample=2)
    sensor = EventSensor(SensorConfig.noise_free(), seed=0)
    near, count, times_us = 0, 0, crossing.times_us()
    for sample in crossing.samples(times_us[: len(times_us) // 2]):
        events = sensor.step(sample.t_us, sample.luminance).events
        around = cv2.dilate(sample.truth.mask.astype(np.uint8), np.ones((41, 61), np.uint8))
        near += int(np.count_nonzero(around[events["y"], events["x"]]))
        count += events.size
    assert count > 50_000
    assert near > 0.999 * count


def test_two_renderers_give_the_same_bits() -> None:
    crossing = make_crossing()
    times_us = [0, crossing.duration_us // 3, crossing.duration_us // 2]
    frames = []
    for _ in range(3):
        with crossing.full_frame_renderer() as render:
            frames.append([render(t_us) for t_us in times_us])
    assert np.array_equal(frames[0], frames[1])
    assert np.array_equal(frames[0], frames[2])


@pytest.mark.parametrize(
    ("lighting", "lux"), [("day", 40_000.0), ("day", 100.0), ("dusk", 60.0), ("night", 5.0)]
)
def test_the_road_has_the_configured_illuminance(lighting: str, lux: float) -> None:
    """Measured on a white patch at the origin, with the vehicle 15 m away."""
    crossing = make_crossing(lighting, illuminance_lux=lux)
    spec = build_spec(crossing.config)
    spec.add_material(name="patch", rgba=[1, 1, 1, 1], metallic=0, roughness=1)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.5, 0.5, 0.005],
        material="patch",
        castshadow=False,
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.joint("vehicle/travel").qpos[0] = 15.0
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    with FilamentRenderer(luminance_model(model), crossing.intrinsics) as renderer:
        renderer.update(data)
        patch, _ = project(np.array([[0.0, 0.0, 0.01]]), crossing.scene.pose, crossing.intrinsics)
        x, y = map(int, patch[0])
        measured = renderer.luminance(crossing.scene.pose, (x, y, x + 1, y + 1), supersample=4)
    assert measured[0, 0] * math.pi == pytest.approx(lux, rel=0.06)


def test_a_lead_too_long_for_constant_angular_velocity_is_refused_before_rendering() -> None:
    """Includes leads so near the limit that only times just beyond the sequence exceed it."""

    def end_s(lead_s: float) -> float:
        crossing = make_crossing(profile=Profile.CONSTANT_OMEGA, lead_s=lead_s)
        probe, sky = (
            TruthProbe(crossing.scene, crossing.intrinsics),
            np.full((260, 346), -1, np.int32),
        )
        for t_us in (0, crossing.times_us()[-1]):
            probe.measure(t_us, crossing.seconds(t_us), sky)
        return crossing.seconds(crossing.duration_us)

    room_s = MAX_BEARING_RAD / 1.61 - (end_s(0.1) - 0.1)
    assert end_s(room_s - 0.021) > 0
    for lead_s in (room_s - 0.019, room_s - 1e-6, room_s + 0.01):
        with pytest.raises(SceneConfigError, match="bearing"):
            make_crossing(profile=Profile.CONSTANT_OMEGA, lead_s=lead_s)


@pytest.mark.parametrize("lighting", list(Lighting))
def test_the_sequence_begins_and_ends_with_the_vehicle_out_of_view(lighting: str) -> None:
    crossing = make_crossing(lighting)
    lead_us = crossing.config.lead_s * 1e6
    geometry, target = DenseTruth(crossing.scene, crossing.intrinsics), crossing.scene.target.bodies
    visible_us = [
        t
        for t in crossing.times_us()
        if np.isin(geometry.visible(crossing.seconds(t)).body, target).any()
    ]
    assert lead_us <= min(visible_us) < lead_us + 100_000
    assert lead_us <= crossing.duration_us - max(visible_us) < lead_us + 100_000


def test_the_preview_is_a_colour_image() -> None:
    crossing = make_crossing()
    with Preview(crossing) as preview:
        picture = preview.render(crossing.duration_us // 2, scale=1)
    assert picture.shape == (260, 346, 3)
    assert picture.dtype == np.uint8
    assert 40 < picture.mean() < 220
    assert np.abs(picture[..., 0].astype(int) - picture[..., 2]).max() > 40
