"""Keyframes: how parts are cut out of them, and how two keyframes are weighted."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.geometry.pinhole import Projection
from sim.keyframes.store import Keyframe, KeyframeStore, Patch, cut_patches
from sim.raster.aperture import LENS_BLUR_PX, to_grid
from sim.scene.moving_objects import MovingObject
from tests.sim.keyframed_mover import at_once

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

SUPERSAMPLE, CORNER_PX = 3, (4, 7)
PROJECTION = Projection(50.0, 30.0, 20.0)
VIEWS = {part: np.full((3, 4), float(part)) for part in (2, 5, 6)}


def disc_behind_stripe() -> I32:
    """Return labels of 12 × 14 pixels: a disc of part 2 half behind a stripe of part 5.

    Part 6 is hidden.
    """
    y, x = np.mgrid[: 12 * SUPERSAMPLE, : 14 * SUPERSAMPLE]
    label = np.where((x - 17) ** 2 + (y - 15) ** 2 < 120, 2, -1)
    label[:, 20:26] = 5
    return label.astype(np.int32)


@pytest.mark.parametrize("blur_px", [0.0, LENS_BLUR_PX])
def test_an_even_part_keeps_its_luminance_up_to_its_edge(blur_px: float) -> None:
    label = disc_behind_stripe()
    luminance = {2: 50.0, 5: 900.0}
    image = np.select([label == 2, label == 5], [50.0, 900.0], default=3.0).astype(np.float32)
    layers = np.stack([image, 2 * image])
    patches = cut_patches(
        layers, label, VIEWS, CORNER_PX, SUPERSAMPLE, blur_px, per_pixel=SUPERSAMPLE
    )
    assert set(patches) == {2, 5}
    for part, patch in patches.items():
        visible = patch.coverage > 1e-6
        assert visible.sum() > (label == part).sum() * (1.1 if blur_px else 1.0)
        for layer, gain in zip(patch.luminance, (1, 2), strict=True):
            wanted = pytest.approx(gain * luminance[part], rel=1e-4)
            assert layer[visible] / patch.coverage[visible] == wanted
        assert patch.view is VIEWS[part]


@pytest.mark.parametrize("per_pixel", [SUPERSAMPLE, 1])
def test_patches_hold_everything_that_a_part_covers_in_its_place(per_pixel: int) -> None:
    label = disc_behind_stripe()
    image = np.random.default_rng(0).uniform(1, 2, (1, *label.shape)).astype(np.float32)
    patches = cut_patches(
        image, label, VIEWS, CORNER_PX, SUPERSAMPLE, LENS_BLUR_PX, per_pixel=per_pixel
    )
    for part, patch in patches.items():
        whole = to_grid((label == part).astype(np.float32), SUPERSAMPLE, per_pixel=per_pixel)
        rows, columns = patch.coverage.shape
        y, x = patch.y0 - CORNER_PX[1] * per_pixel, patch.x0 - CORNER_PX[0] * per_pixel
        box = np.s_[y : y + rows, x : x + columns]
        np.testing.assert_allclose(patch.coverage, whole[box], atol=1e-6)
        whole[box] = 0
        assert np.abs(whole).max() < 1e-6


class TwoObjects:
    """A store of two objects, of bodies 1 and 2, that records which keyframes are rendered."""

    def __init__(self, layers: int = 1) -> None:
        self.rendered: list[tuple[str, int]] = []
        self.layers = layers
        none = np.empty(0, np.int64)
        objects = tuple(
            MovingObject(name, "box", body, np.array([body]), none, np.zeros((2, 3)), none)
            for name, body in (("one", 1), ("two", 2))
        )
        plan = {"one": [100, 200, 400], "two": [300]}
        carriers = np.arange(3, dtype=np.int32)
        self.store = KeyframeStore(
            plan, objects, at_once(self.render), carriers=carriers, per_pixel=1
        )

    def render(self, obj: MovingObject, t_us: int) -> Keyframe:
        self.rendered.append((obj.name, t_us))
        luminance = np.full((self.layers, 2, 3), float(t_us), np.float32)
        luminance[1:] = 10
        coverage = np.full((2, 3), 0.5, np.float32)
        return Keyframe(t_us, {obj.root: Patch(7, 9, luminance, coverage, np.eye(3, 4))})


VIEWS_NOW = np.tile(np.eye(3, 4), (3, 1, 1))


@pytest.mark.parametrize(
    ("t_us", "weights", "luminances"),
    [
        (0, (1.0, 0.0), [100, 200]),
        (100, (1.0, 0.0), [100, 200]),
        (125, (0.75, 0.25), [100, 200]),
        (200, (1.0, 0.0), [200, 400]),
        (350, (0.25, 0.75), [200, 400]),
        (400, (1.0, 0.0), [400]),
        (999, (1.0, 0.0), [400]),
    ],
)
def test_two_keyframes_are_weighted_linearly_in_time(
    t_us: int, weights: tuple[float, float], luminances: list[float]
) -> None:
    store = TwoObjects().store
    store.advance(t_us)
    surfaces = store.surfaces(t_us, VIEWS_NOW, 1.0, PROJECTION)
    np.testing.assert_allclose(surfaces.weights[1:3], [weights, (1, 0)])
    for key, luminance in enumerate(luminances):
        start, x0, y0, width, height = surfaces.patches[1, key]
        assert (x0, y0, width, height) == (7, 9, 3, 2)
        np.testing.assert_array_equal(surfaces.grid[start : start + 6, 0], luminance)
    start = surfaces.patches[2, 0, 0]
    np.testing.assert_array_equal(surfaces.grid[start : start + 6, 0], 300)
    assert surfaces.patches[1, len(luminances) :, 3].sum() == surfaces.patches[2, 1, 3] == 0
    assert (surfaces.grid[:, 1] == 0.5).all()


def test_each_keyframe_is_rendered_once() -> None:
    objects = TwoObjects()
    for t_us in range(0, 500, 7):
        objects.store.advance(t_us)
    assert sorted(objects.rendered) == [("one", 100), ("one", 200), ("one", 400), ("two", 300)]


def test_the_keyframe_after_those_in_use_is_requested_ahead() -> None:
    objects = TwoObjects()
    objects.store.advance(0)
    assert objects.rendered == [("one", 100), ("one", 200), ("one", 400), ("two", 300)]


def test_flicker_scales_only_the_flickering_layer() -> None:
    store = TwoObjects(layers=2).store
    store.advance(0)
    for flicker in (1.0, 0.0, 1.5, 1.0):
        surfaces = store.surfaces(0, VIEWS_NOW, flicker, PROJECTION)
        start = surfaces.patches[2, 0, 0]
        assert surfaces.grid[start, 0] == pytest.approx(300 + 10 * flicker)


def test_matrices_lead_from_the_image_to_the_patch() -> None:
    """A body that moved 2 m to the right is found 2 m farther left in its keyframe."""
    store = TwoObjects().store
    store.advance(0)
    views = VIEWS_NOW.copy()
    views[1, 0, 3] = 2.0
    surfaces = store.surfaces(0, views, 1.0, PROJECTION)
    for row, x_m in ((1, -2.0), (2, 0.0)):
        x, y, z = surfaces.matrices[row, 0] @ [30, 20, 1, 1 / 5]  # on the optical axis, 5 m away
        assert x / z == pytest.approx(30 + 50 * x_m / 5 - 0.5 - 7)
        assert y / z == pytest.approx(20 - 0.5 - 9)
