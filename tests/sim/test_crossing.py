"""A crossing as rendered: truth against the camera's own projection, light against full frames."""

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
from sim.scene.scene import compose

FOCAL_PX = 6e-3 / 18.5e-6

COARSE = {"step_px": 40.0 / 5, "supersample": 1, "max_step_ms": 20.0}


def crossing(lighting: str = "day", direction: str = "right", **options: Any) -> Crossing:
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
    """Against closed forms written out here: a flank at distance d, seen by a rolled camera."""
    omega, distance = 1.61, 6.89
    it = crossing(direction=direction, profile=Profile(profile))
    along = {"right": (1, 0), "left": (-1, 0), "up": (0, -1), "down": (0, 1)}[direction]
    probe, nothing = TruthProbe(it.scene, it.intrinsics), np.full((260, 346), -1, np.int32)
    for t_us in it.times_us()[::9]:
        truth, angle = probe.at(t_us, it.seconds(t_us), nothing), omega * it.seconds(t_us)
        tangent = angle if profile == Profile.CONSTANT_SPEED else math.tan(angle)
        rate = omega if profile == Profile.CONSTANT_SPEED else omega / math.cos(angle) ** 2
        way_px = (truth.reference_px - [173, 130]) @ np.array(along)
        assert way_px == pytest.approx(FOCAL_PX * tangent, abs=1e-6)
        assert truth.image_velocity_px_s == pytest.approx(FOCAL_PX * rate * np.array(along))
        assert truth.angular_velocity_rad_s == pytest.approx(rate / (1 + tangent**2))
        assert truth.position_m == pytest.approx(distance * tangent)
        assert truth.direction == direction


@pytest.mark.parametrize(("lighting", "direction"), [("day", "right"), ("night", "up")])
def test_the_mask_lies_where_the_vehicle_is_projected(lighting: str, direction: str) -> None:
    it = crossing(lighting, direction)
    whole = 0
    for sample in itertools.islice(it.samples(), 0, None, 5):
        truth = sample.truth
        corners, _ = project(
            it.scene.body_corners_m(truth.position_m), it.scene.pose, it.intrinsics
        )
        low, high = np.clip([corners.min(axis=0), corners.max(axis=0)], 0, [346, 260])
        assert truth.position_m == pytest.approx(
            1.61 * it.config.distance * it.seconds(sample.t_us)
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
            whole += 1
            bumpers = project(_bumpers(truth.position_m), it.scene.pose, it.intrinsics)[0]
            axis = 0 if direction == "right" else 1
            ends = sorted(bumpers[:, axis])
            assert (x0, y0)[axis] == pytest.approx(ends[0], abs=3)
            assert (x1, y1)[axis] == pytest.approx(ends[1], abs=3)
            assert truth.mask.sum() > 0.5 * (x1 - x0) * (y1 - y0)
    assert whole >= 2


def _bumpers(position_m: float) -> npt.NDArray[np.float64]:
    """Near ends of the bumpers of `sedan.xml` [m]."""
    return np.array([[position_m + x, y, 0.38] for x, y in ((-2.28, -0.78), (2.28, -0.72))])


def test_outside_of_what_changed_the_light_is_exactly_as_before() -> None:
    extra = Distractors(far_vehicle=RelativeDirection.OPPOSITE)
    before, it = None, crossing("night", distractors=extra)
    times_us = it.times_us()
    for sample in it.samples(times_us[len(times_us) // 3 : len(times_us) // 2]):
        x0, y0, x1, y1 = sample.changed
        if before is not None:
            same = before == sample.luminance
            same[y0:y1, x0:x1] = True
            assert same.all()
        before = sample.luminance


@pytest.mark.parametrize("lighting", list(Lighting))
def test_what_has_left_leaves_nothing_behind(lighting: str) -> None:
    it = crossing(lighting)
    after = [s.luminance for s in it.samples([0, it.duration_us // 2, it.duration_us])]
    assert not np.array_equal(after[0], after[1])
    if lighting == Lighting.DAY:
        assert np.array_equal(after[0], after[2])


def test_by_day_events_come_from_the_vehicle_and_its_shadow() -> None:
    it = crossing(step_px=4.0, supersample=2)
    sensor = EventSensor(SensorConfig.noise_free(), seed=0)
    near, count, times_us = 0, 0, it.times_us()
    for sample in it.samples(times_us[: len(times_us) // 2]):
        events = sensor.step(sample.t_us, sample.luminance).events
        around = cv2.dilate(sample.truth.mask.astype(np.uint8), np.ones((41, 61), np.uint8))
        near += int(np.count_nonzero(around[events["y"], events["x"]]))
        count += events.size
    assert count > 50_000
    assert near > 0.999 * count


def test_another_renderer_draws_the_same_bits() -> None:
    it = crossing()
    times_us = [0, it.duration_us // 3, it.duration_us // 2]
    frames = []
    for _ in range(3):
        with it.full_frames() as draw:
            frames.append([draw(t_us) for t_us in times_us])
    assert np.array_equal(frames[0], frames[1])
    assert np.array_equal(frames[0], frames[2])


@pytest.mark.parametrize(
    ("lighting", "lux"), [("day", 40_000.0), ("day", 100.0), ("dusk", 60.0), ("night", 5.0)]
)
def test_the_road_gets_the_illuminance_asked_for(lighting: str, lux: float) -> None:
    """Read off a white patch on the real street, beside where the vehicle will drive."""
    it = crossing(lighting, illuminance_lux=lux)
    spec = compose(it.config)
    spec.add_material(name="patch", rgba=[1, 1, 1, 1], metallic=0, roughness=1)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5, 0.5, 0.005], material="patch", group=2
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.joint("vehicle/travel").qpos[0] = 15.0
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    with FilamentRenderer(luminance_model(model), it.intrinsics) as renderer:
        renderer.update(data)
        patch, _ = project(np.array([[0.0, 0.0, 0.01]]), it.scene.pose, it.intrinsics)
        x, y = map(int, patch[0])
        seen = renderer.luminance(it.scene.pose, (x, y, x + 1, y + 1), supersample=4)
    assert seen[0, 0] * math.pi == pytest.approx(lux, rel=0.06)


def test_a_lead_that_constant_omega_has_no_room_for_is_refused_before_anything_is_drawn() -> None:
    """Near the limit, where only what is asked beyond the sequence's ends would pass it."""

    def seconds(lead_s: float) -> float:
        it = crossing(profile=Profile.CONSTANT_OMEGA, lead_s=lead_s)
        probe, nothing = TruthProbe(it.scene, it.intrinsics), np.full((260, 346), -1, np.int32)
        for t_us in (0, it.times_us()[-1]):
            probe.at(t_us, it.seconds(t_us), nothing)
        return it.seconds(it.duration_us)

    room_s = MAX_BEARING_RAD / 1.61 - (seconds(0.1) - 0.1)
    assert seconds(room_s - 0.021) > 0
    for lead_s in (room_s - 0.019, room_s - 1e-6, room_s + 0.01):
        with pytest.raises(SceneConfigError, match="bearing"):
            crossing(profile=Profile.CONSTANT_OMEGA, lead_s=lead_s)


@pytest.mark.parametrize("lighting", list(Lighting))
def test_the_sequence_begins_and_ends_with_the_vehicle_out_of_view(lighting: str) -> None:
    it = crossing(lighting)
    lead_us = it.config.lead_s * 1e6
    geometry, target = DenseTruth(it.scene, it.intrinsics), it.scene.target.bodies
    seen_us = [
        t for t in it.times_us() if np.isin(geometry.visible(it.seconds(t)).body, target).any()
    ]
    assert lead_us <= min(seen_us) < lead_us + 100_000
    assert lead_us <= it.duration_us - max(seen_us) < lead_us + 100_000


def test_the_preview_is_a_colour_picture() -> None:
    it = crossing()
    with Preview(it) as preview:
        picture = preview.draw(it.duration_us // 2, scale=1)
    assert picture.shape == (260, 346, 3)
    assert picture.dtype == np.uint8
    assert 40 < picture.mean() < 220
    assert np.abs(picture[..., 0].astype(int) - picture[..., 2]).max() > 40
