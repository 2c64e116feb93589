"""Ground truth of each object, compared with closed forms and with projected points."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from flybench.direction import CARDINAL, Direction
from sim.config import CrossingConfig
from sim.distractors import Distractors, RelativeDirection, VehicleKind
from sim.geometry.pinhole import Intrinsics, project
from sim.motion.computed_ahead import BLOCK
from sim.raster.triangles import TriangleSoup
from sim.raster.visibility import visibility_map
from sim.scene.scene import Scene, build_scene
from sim.truth.ground_truth import GroundTruth
from sim.truth.probe import TruthProbe
from tests.sim.body_labels import target_body_labels

LENS = Intrinsics()
EVERYTHING = Distractors(
    wind_grade=4,
    far_vehicle=RelativeDirection.SAME,
    far_vehicle_lag_s=-0.3,
    pedestrian=RelativeDirection.OPPOSITE,
)


def scene_and_probe(**options: Any) -> tuple[Scene, TruthProbe]:
    scene = build_scene(CrossingConfig(**options))
    return scene, TruthProbe(scene, LENS)


def _flank_middle_m(scene: Scene, t_s: float) -> npt.NDArray[np.float64]:
    corners_m = scene.flank_m(scene.trajectory.position_m(t_s))
    return np.asarray(corners_m.mean(axis=0, keepdims=True))


def truth_at(probe: TruthProbe, t_s: float) -> GroundTruth:
    return probe.measure(0, t_s, probe.geometry.visible(t_s).body)


@pytest.mark.parametrize("direction", CARDINAL)
def test_the_target_moves_along_its_trajectory(direction: str) -> None:
    scene, probe = scene_and_probe(direction=Direction(direction))
    along = {"right": (1, 0), "left": (-1, 0), "up": (0, -1), "down": (0, 1)}[direction]
    for t_s in (-0.7, 0.0, 0.25):
        truth = truth_at(probe, t_s)
        assert truth.objects == (truth.target,)
        assert truth.target.kind == "sedan"
        speed = LENS.focal_px * 1.61
        assert truth.image_velocity_px_s == pytest.approx(speed * np.array(along), abs=1e-4)
        assert truth.angular_velocity_rad_s == pytest.approx(
            scene.trajectory.angular_velocity_rad_s(t_s), rel=1e-7
        )
        flank, _ = project(_flank_middle_m(scene, t_s), scene.pose, LENS)
        assert truth.reference_px == pytest.approx(flank[0])


def test_the_truth_at_announced_times_is_that_at_any_time() -> None:
    """Also for what is asked for later: visibility."""
    shaking = replace(EVERYTHING, shake_rms_deg=0.1)
    scene, probe = scene_and_probe(distractors=shaking)
    times_s = [0.02 * k for k in range(BLOCK + 3)]
    announced = TruthProbe(scene, LENS, times_s)
    asked = [times_s[0], times_s[1], 0.033, *times_s[BLOCK - 1 :]]
    found, wanted = ([truth_at(p, t) for t in asked] for p in (announced, probe))
    assert len({truth.target.reference_px[0] for truth in found}) == len(asked)
    for truth, alone in zip(found, wanted, strict=True):
        for one, other in zip(truth.objects, alone.objects, strict=True):
            np.testing.assert_array_equal(one.reference_px, other.reference_px)
            np.testing.assert_array_equal(one.image_velocity_px_s, other.image_velocity_px_s)
            assert one.angular_velocity_rad_s == other.angular_velocity_rad_s
            assert one.distance_m == other.distance_m
            assert one.visibility == other.visibility
    assert len({truth.target.visibility for truth in found}) > 1


def test_every_moving_object_has_its_name_and_its_pixels() -> None:
    scene, probe = scene_and_probe(distractors=EVERYTHING)
    truth = truth_at(probe, 0.1)
    assert [o.name for o in truth.objects] == [o.name for o in scene.objects]
    assert truth.objects[0] is truth.target
    assert {"target", "far_vehicle", "pedestrian", "tree_0"} <= {o.name for o in truth.objects}
    visible = probe.geometry.visible(0.1)
    for found, item in zip(truth.objects, scene.objects, strict=True):
        mask = np.isin(visible.body, item.bodies)
        assert np.array_equal(found.mask, mask)
        assert found.in_view == mask.any()
        if found.bounding_box_px is None or found.centroid_px is None:
            continue
        rows, columns = np.nonzero(mask)
        assert found.bounding_box_px == (
            columns.min(),
            rows.min(),
            columns.max() + 1,
            rows.max() + 1,
        )
        assert found.centroid_px == pytest.approx([columns.mean() + 0.5, rows.mean() + 0.5])
        assert not (mask & truth.mask).any() or found is truth.target


def test_a_vehicle_in_the_far_lane_has_the_motion_of_its_speed_and_distance() -> None:
    scene, probe = scene_and_probe(distractors=EVERYTHING)
    far = truth_at(probe, -0.3).objects[1]
    item = scene.objects[1]
    middle_m = item.box_m.mean(axis=0)
    depth = scene.model.body_pos[item.root, 1] + middle_m[1] - scene.pose.position_m[1]
    assert far.image_velocity_px_s == pytest.approx([LENS.focal_px * 10.0 / depth, 0], abs=1e-4)
    across = middle_m[0]  # its lag puts it at closest approach at this time
    assert far.angular_velocity_rad_s == pytest.approx(10 * depth / (depth**2 + across**2))
    height = scene.model.body_pos[item.root, 2] + middle_m[2] - scene.pose.position_m[2]
    assert far.distance_m == pytest.approx(math.hypot(depth, across, height))


def test_angular_velocity_is_the_rate_of_the_bearing() -> None:
    """Includes trees, whose boughs also sway towards the camera."""
    scene, probe = scene_and_probe(distractors=EVERYTHING)
    step_s, t_s = 1e-4, 0.3
    bearings = []
    for near_s in (t_s - step_s, t_s + step_s):
        poses = probe.geometry.poses_in_world(near_s)
        places = [poses[o.root] @ np.append(o.box_m.mean(axis=0), 1) for o in scene.objects]
        x, y, _ = (np.array(places) - scene.pose.position_m).T
        bearings.append(np.arctan2(y, x))
    rates = np.abs(bearings[1] - bearings[0]) / (2 * step_s)
    found = [o.angular_velocity_rad_s for o in truth_at(probe, t_s).objects]
    assert found[1:] == pytest.approx(rates[1:], rel=1e-5)


def test_the_shake_affects_the_image_velocity_but_not_the_angular_velocity() -> None:
    scene, shaken = scene_and_probe(distractors=Distractors(shake_rms_deg=0.5, seed=2))
    _, calm = scene_and_probe()
    step, t_s = 1e-4, 0.05
    points = [
        project(_flank_middle_m(scene, t), scene.pose_at(t), LENS)[0][0]
        for t in (t_s - step, t_s + step)
    ]
    found = truth_at(shaken, t_s)
    expected = (points[1] - points[0]) / (2 * step)
    assert found.image_velocity_px_s == pytest.approx(expected, abs=1e-3)
    without_shake = truth_at(calm, t_s)
    assert np.abs(found.image_velocity_px_s - without_shake.image_velocity_px_s).max() > 1.0
    assert found.angular_velocity_rad_s == pytest.approx(without_shake.angular_velocity_rad_s)
    assert found.target.distance_m == pytest.approx(without_shake.target.distance_m)


def test_visibility_accounts_for_the_image_border_and_for_occlusion() -> None:
    """Compared with each object alone before a camera with a much larger sensor."""
    _, probe = scene_and_probe(distractors=EVERYTHING)
    wide = TruthProbe(probe.geometry.scene, LENS.with_margin(2_000))
    for t_s in (-0.4, 0.0, 0.2):
        truth = truth_at(probe, t_s)
        for found, item in zip(truth.objects, probe.geometry.scene.objects, strict=True):
            alone = wide.geometry.soup.of_bodies(item.bodies)
            assert 0 <= found.visibility <= 1
            area = _area(alone, wide, t_s)
            assert found.visibility == pytest.approx(found.mask.sum() / area, abs=0.015)
    assert truth_at(probe, -1.2).visibility == 0
    assert truth_at(probe, 0.0).visibility > 0.99


def _area(soup: TriangleSoup, wide: TruthProbe, t_s: float) -> int:
    scene = wide.geometry.scene
    seen = visibility_map(
        soup, wide.geometry.poses_in_world(t_s), scene.pose, LENS.with_margin(2_000)
    )
    return int((seen.body >= 0).sum())


def test_box_and_centroid_are_those_of_the_mask() -> None:
    scene, probe = scene_and_probe(vehicle=VehicleKind.MOTORCYCLE)
    mask = np.zeros((260, 346), np.bool_)
    mask[120:150, 100:140] = True
    truth = probe.measure(5, 0.0, target_body_labels(mask, scene))
    assert truth.t_us == 5
    assert truth.bounding_box_px == (100, 120, 140, 150)
    assert truth.centroid_px == pytest.approx([120, 135])
    nothing = probe.measure(5, 0.0, target_body_labels(np.zeros_like(mask), scene))
    assert nothing.bounding_box_px is None
    assert nothing.centroid_px is None
    assert nothing.visibility == 0
    assert not nothing.in_view


def test_repeated_measurements_are_equal() -> None:
    _, probe = scene_and_probe(distractors=EVERYTHING)
    first = truth_at(probe, 0.1)
    truth_at(probe, -0.2)
    again = truth_at(probe, 0.1)
    for a, b in zip(first.objects, again.objects, strict=True):
        assert a.visibility == b.visibility
        assert np.array_equal(a.image_velocity_px_s, b.image_velocity_px_s)
        assert np.array_equal(a.labels, b.labels)
