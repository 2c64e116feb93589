"""Keyframes: when they are, how bodies are cut out of them, and how they share a time."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.keyframes.store import Keyframe, KeyframeStore, Piece, cut_pieces, keyframe_times
from sim.raster.aperture import LENS_BLUR_PX, on_grid
from sim.scene.moving_objects import MovingObject

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

TIMES = list(range(0, 1000, 10))


def passing(px_a_step: float) -> tuple[F64, npt.NDArray[np.bool_]]:
    """Corners of a box that crosses at a steady speed, one corner twice as fast; 20 to 79 seen."""
    corners = np.zeros((100, 8, 2))
    corners[..., 0] = px_a_step * np.arange(100)[:, None]
    corners[:, 5] *= 2
    step = np.arange(100)
    return corners, (step >= 20) & (step < 80)


@pytest.mark.parametrize("spacing_px", [1.0, 7.0, 32.0, 1e6])
def test_keyframes_come_before_the_fastest_corner_has_gone_too_far(spacing_px: float) -> None:
    corners, seen = passing(1.5)
    times = keyframe_times(TIMES, corners, seen, spacing_px)
    assert (times[0], times[-1]) == (200, 790)
    steps = np.array(times) // 10
    gaps = np.diff(corners[steps, 5, 0])
    assert (gaps > 0).all()
    assert (gaps < spacing_px + 3.0).all()  # it is noticed a step late
    assert (gaps[:-1] >= spacing_px).all()


def test_what_is_never_seen_has_no_keyframe_and_what_is_seen_once_has_one() -> None:
    corners, seen = passing(1.5)
    assert keyframe_times(TIMES, corners, np.zeros_like(seen), 8.0) == []
    assert keyframe_times(TIMES, corners, np.arange(100) == 33, 8.0) == [330]
    assert keyframe_times(TIMES, corners * 0, seen, 8.0) == [200, 790]


SIZE, CORNER = 3, (4, 7)
VIEWS = {body: np.full((3, 4), float(body)) for body in (2, 5, 6)}


def labels() -> I32:
    """A disc of body 2 half behind a stripe of body 5, in 12 × 14 pixels; body 6 is hidden."""
    y, x = np.mgrid[: 12 * SIZE, : 14 * SIZE]
    label = np.where((x - 17) ** 2 + (y - 15) ** 2 < 120, 2, -1)
    label[:, 20:26] = 5
    return label.astype(np.int32)


@pytest.mark.parametrize("blur_px", [0.0, LENS_BLUR_PX])
def test_an_even_body_keeps_its_luminance_up_to_its_edge(blur_px: float) -> None:
    label = labels()
    glow = {2: 50.0, 5: 900.0}
    fine = np.select([label == 2, label == 5], [50.0, 900.0], default=3.0).astype(np.float32)
    pieces = cut_pieces(
        np.stack([fine, 2 * fine]), label, VIEWS, CORNER, SIZE, blur_px, per_pixel=SIZE
    )
    assert set(pieces) == {2, 5}
    for body, piece in pieces.items():
        seen = piece.cover > 1e-6
        assert seen.sum() > (label == body).sum() * (1.1 if blur_px else 1.0)
        for part, gain in zip(piece.light, (1, 2), strict=True):
            assert part[seen] / piece.cover[seen] == pytest.approx(gain * glow[body], rel=1e-4)
        assert piece.view is VIEWS[body]


@pytest.mark.parametrize("per_pixel", [SIZE, 1])
def test_pieces_lie_where_they_were_cut_and_lose_nothing(per_pixel: int) -> None:
    label = labels()
    fine = np.random.default_rng(0).uniform(1, 2, (1, *label.shape)).astype(np.float32)
    pieces = cut_pieces(fine, label, VIEWS, CORNER, SIZE, LENS_BLUR_PX, per_pixel=per_pixel)
    for body, piece in pieces.items():
        whole = on_grid((label == body).astype(np.float32), SIZE, per_pixel=per_pixel)
        rows, columns = piece.cover.shape
        y, x = piece.y0 - CORNER[1] * per_pixel, piece.x0 - CORNER[0] * per_pixel
        part = np.s_[y : y + rows, x : x + columns]
        np.testing.assert_allclose(piece.cover, whole[part], atol=1e-6)
        whole[part] = 0
        assert np.abs(whole).max() < 1e-6


class Drawn:
    """Two objects, of bodies 1 and 2, and what was drawn of them."""

    def __init__(self, parts: int = 1) -> None:
        self.log: list[tuple[str, int]] = []
        self.parts = parts
        none = np.empty(0, np.int64)
        self.objects = tuple(
            MovingObject(name, "box", body, np.array([body]), none, np.zeros((2, 3)), none)
            for name, body in (("one", 1), ("two", 2))
        )
        plan = {"one": [100, 200, 400], "two": [300]}
        carriers = np.arange(3, dtype=np.int32)
        self.store = KeyframeStore(plan, self.objects, self.draw, carriers=carriers, per_pixel=1)

    def draw(self, obj: MovingObject, t_us: int) -> Keyframe:
        self.log.append((obj.name, t_us))
        light = np.full((self.parts, 2, 3), float(t_us), np.float32)
        light[1:] = 10
        cover = np.full((2, 3), 0.5, np.float32)
        return Keyframe(t_us, {obj.root: Piece(7, 9, light, cover, np.eye(3, 4))})


VIEWS_NOW = np.tile(np.eye(3, 4), (3, 1, 1))


@pytest.mark.parametrize(
    ("t_us", "shares", "light"),
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
def test_two_keyframes_share_the_time_between_them(
    t_us: int, shares: tuple[float, float], light: list[float]
) -> None:
    drawn = Drawn()
    drawn.store.advance(t_us)
    surfaces = drawn.store.surfaces(t_us, VIEWS_NOW, mains=1.0)
    np.testing.assert_allclose(surfaces.shares[1:3], [shares, (1, 0)])
    for key, luminance in enumerate(light):
        start, x0, y0, width, height = surfaces.pieces[1, key]
        assert (x0, y0, width, height) == (7, 9, 3, 2)
        np.testing.assert_array_equal(surfaces.light[start : start + 6], luminance)
    start = surfaces.pieces[2, 0, 0]
    np.testing.assert_array_equal(surfaces.light[start : start + 6], 300)
    assert surfaces.pieces[1, len(light) :, 3].sum() == surfaces.pieces[2, 1, 3] == 0
    assert surfaces.light.shape == surfaces.cover.shape


def test_each_keyframe_is_drawn_once() -> None:
    drawn = Drawn()
    for t_us in range(0, 500, 7):
        drawn.store.advance(t_us)
    assert sorted(drawn.log) == [("one", 100), ("one", 200), ("one", 400), ("two", 300)]


def test_the_mains_part_swings_alone() -> None:
    drawn = Drawn(parts=2)
    drawn.store.advance(0)
    for mains in (1.0, 0.0, 1.5, 1.0):
        surfaces = drawn.store.surfaces(0, VIEWS_NOW, mains)
        start = surfaces.pieces[2, 0, 0]
        assert surfaces.light[start] == pytest.approx(300 + 10 * mains)


def test_moves_lead_from_the_camera_now_to_the_camera_then() -> None:
    """A body 2 m to the right of where it was is seen 2 m farther left in its keyframe."""
    drawn = Drawn()
    drawn.store.advance(0)
    views = VIEWS_NOW.copy()
    views[1, 0, 3] = 2.0
    surfaces = drawn.store.surfaces(0, views, mains=1.0)
    np.testing.assert_allclose(surfaces.moves[2] @ [0, 0, 5, 1], [-2, 0, 5])
    np.testing.assert_allclose(surfaces.moves[4] @ [0, 0, 5, 1], [0, 0, 5])
