"""Points of a part that the renderer left out."""

import numpy as np
import pytest

from sim import CrossingConfig, Distractors, Lighting, RelativeDirection, VehicleKind
from sim.keyframes import rendering
from sim.keyframes.holes import REACH, fill_holes
from tests.sim.keyframes.test_rendering import keyframe_renderer


def test_a_hole_gets_the_mean_of_the_nearest_points_of_its_part() -> None:
    label = np.array([[1, 1, 2], [1, 1, 2], [-1, -1, 2]], np.int32)
    image = np.array([[[3, 5, 90], [4, 0, 90], [50, 60, 90]]], np.float32)
    fill_holes(image, label)
    assert image[0].tolist() == [[3, 5, 90], [4, 4, 90], [50, 60, 90]]


def test_farther_points_of_the_part_come_before_nearer_points_of_others() -> None:
    label = np.array([[1, 1, 2, 2, 1]], np.int32)
    image = np.array([[[0, 0, 8, 9, 7]]], np.float32)
    fill_holes(image, label)
    assert image[0].tolist() == [[7, 7, 8, 9, 7]]


def test_a_part_that_is_missing_altogether_gets_what_is_beside_it() -> None:
    label = np.array([[2, 1, -1, -1]], np.int32)
    image = np.array([[[6, 0, 4, 0]]], np.float32)
    fill_holes(image, label)
    assert image[0].tolist() == [[6, 5, 4, 0]]


def test_a_point_that_shows_light_in_any_layer_is_no_hole() -> None:
    label = np.array([[1, 1, 1]], np.int32)
    image = np.array([[[2, 0, 0]], [[0, 3, 0]]], np.float32)
    fill_holes(image, label)
    assert image[:, 0].tolist() == [[2, 0, 0], [0, 3, 3]]


def test_nothing_is_taken_from_beyond_the_reach() -> None:
    label = np.zeros((1, REACH + 2), np.int32)
    image = np.zeros((1, 1, REACH + 2), np.float32)
    image[..., -1] = 9.0
    fill_holes(image, label)
    assert image[0, 0, 0] == 0.0
    assert (image[0, 0, 1:] == 9.0).all()


FAR_VAN = Distractors(far_vehicle=RelativeDirection.SAME, far_vehicle_kind=VehicleKind.VAN)


@pytest.mark.parametrize(
    ("lighting", "distractors"),
    [
        (Lighting.DAY, Distractors()),
        (Lighting.DUSK, Distractors()),
        (Lighting.NIGHT, FAR_VAN),
    ],
)
def test_no_sky_shows_through_a_part(
    lighting: Lighting, distractors: Distractors, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, left = 0, 0

    def counting(image: np.ndarray, label: np.ndarray) -> None:
        nonlocal found, left
        found += int(((image == 0).all(axis=0) & (label >= 0)).sum())
        fill_holes(image, label)
        left += int(((image == 0).all(axis=0) & (label >= 0)).sum())

    monkeypatch.setattr(rendering, "fill_holes", counting)
    vehicle = VehicleKind.MOTORCYCLE
    config = CrossingConfig(lighting=lighting, vehicle=vehicle, distractors=distractors)
    with keyframe_renderer(config) as (scene, renderer):
        for t_us in (-200_000, -100_000, 0, 100_000, 200_000):
            for obj in scene.objects:
                renderer.render(obj, t_us)
    assert found > 0
    assert left == 0
