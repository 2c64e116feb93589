"""Scan conversion, compared with rays cast one by one."""

import numpy as np
import numpy.typing as npt
import pytest

from sim.raster.scan_conversion import (
    NO_LABEL,
    empty_buffer,
    label_bounds,
    project_triangles,
    rasterise,
    transform_points,
)

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I32 = npt.NDArray[np.int32]

HEIGHT, WIDTH, FOCAL, NEAR = 40, 60, 50.0, 0.1


def rasterised(
    triangles: F64,
    labels: npt.ArrayLike | None = None,
    *,
    rectangle: tuple[int, int, int, int] = (0, 0, WIDTH, HEIGHT),
    one_sided: bool = False,
) -> tuple[F32, I32]:
    x0, y0, x1, y1 = rectangle
    nearness, label = empty_buffer(y1 - y0, x1 - x0)
    numbers = np.arange(len(triangles)) if labels is None else np.asarray(labels)
    rasterise(triangles, numbers.astype(np.int32), x0, y0, nearness, label, one_sided)
    return nearness, label


def patchwork(step: float, seed: int) -> F64:
    """Return a rectangle, x from 6 to 54 and y from 6 to 30, cut into triangles.

    The corners are multiples of `step`.
    """
    random = np.random.default_rng(seed)
    corners = np.stack(np.meshgrid(np.arange(6.0, 55, 6), np.arange(6.0, 31, 6)), axis=-1)
    jitter = random.integers(-round(1.5 / step), round(1.5 / step) + 1, corners.shape) * step
    jitter[:, [0, -1], 0] = jitter[[0, -1], :, 1] = 0
    corners = corners + jitter
    a, b, c, d = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]
    fan = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 2)
    for triangle in fan:  # random first corner and orientation
        triangle[:] = np.roll(triangle, random.integers(3), axis=0)[:: random.choice([-1, 1])]
    return np.concatenate([fan, np.ones((len(fan), 3, 1))], axis=2)


@pytest.mark.parametrize("step", [0.5, 0.25, 1e-9])
@pytest.mark.parametrize("seed", range(5))
def test_triangles_that_share_edges_cover_each_point_once(step: float, seed: int) -> None:
    """With steps of ½, corners and edges pass exactly through many points."""
    count = sum(rasterised(one[None])[1] != NO_LABEL for one in patchwork(step, seed))
    wanted = np.zeros((HEIGHT, WIDTH), int)
    wanted[6:30, 6:54] = 1
    np.testing.assert_array_equal(count, wanted)


def test_a_point_on_an_edge_belongs_to_the_triangle_right_of_it_or_below_it() -> None:
    square = np.array([[2.5, 1.5, 1], [5.5, 1.5, 1], [5.5, 3.5, 1], [2.5, 3.5, 1]])
    _, label = rasterised(square[[[0, 1, 2], [0, 2, 3]]])
    rows, columns = np.nonzero(label != NO_LABEL)
    assert sorted(set(rows)) == [1, 2]
    assert sorted(set(columns)) == [2, 3, 4]


def random_triangles(count: int, seed: int) -> F64:
    """Return triangles in the camera's frame; about a third of them reach behind the camera."""
    random = np.random.default_rng(seed)
    middle = random.uniform([-2, -1.5, -1], [2, 1.5, 5], (count, 1, 3))
    return middle + random.uniform(-1.5, 1.5, (count, 3, 3))


def cast_rays(triangles: F64) -> tuple[F64, npt.NDArray[np.bool_]]:
    """Return (n, HEIGHT, WIDTH) nearness of each triangle, and the rays that are clear of edges.

    A ray meets the plane of a, b, c where (s, t, r) solves s a + t b + r c = ray. It meets the
    triangle if none of these is negative. The depth there is 1 / (s + t + r).
    """
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    rays = np.stack([(x - WIDTH / 2) / FOCAL, (y - HEIGHT / 2) / FOCAL, np.ones_like(x)])
    parts = np.linalg.solve(np.swapaxes(triangles, 1, 2), rays.reshape(3, -1))
    nearness = parts.sum(axis=1)
    hit = (parts.min(axis=1) >= 0) & (nearness > 0) & (nearness <= 1 / NEAR)
    clear = np.abs(parts).min(axis=1) > 1e-9
    shape = len(triangles), HEIGHT, WIDTH
    return np.where(hit, nearness, 0.0).reshape(shape), clear.all(axis=0).reshape(HEIGHT, WIDTH)


def projected(triangles: F64) -> tuple[F64, I32]:
    return project_triangles(triangles, FOCAL, WIDTH / 2, HEIGHT / 2, NEAR)


@pytest.mark.parametrize("seed", range(5))
def test_each_point_shows_the_triangle_that_its_ray_meets_first(seed: int) -> None:
    triangles = random_triangles(40, seed)
    nearness, label = rasterised(*projected(triangles))
    each, clear = cast_rays(triangles)
    nothing = each.max(axis=0) == 0
    np.testing.assert_array_equal((label == NO_LABEL)[clear], nothing[clear])
    np.testing.assert_array_equal(label[clear & ~nothing], each.argmax(axis=0)[clear & ~nothing])
    np.testing.assert_allclose(nearness[clear], each.max(axis=0)[clear], rtol=1e-5)


def test_the_order_of_triangles_does_not_matter() -> None:
    triangles = random_triangles(40, seed=9)
    order = np.random.default_rng(0).permutation(40)
    one, other = rasterised(*projected(triangles)), rasterised(*projected(triangles[order]))
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], np.append(order, NO_LABEL)[other[1]])


def test_triangles_seen_from_behind_are_skipped() -> None:
    """A front face is anticlockwise in the image, and its normal points to the camera."""
    triangles = random_triangles(60, seed=3)
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    front = np.einsum("ij,ij->i", across, triangles[:, 0]) < 0
    corners, source = projected(triangles)
    kept = front[source]
    assert 20 < front.sum() < 40
    one_sided = rasterised(corners, source, one_sided=True)
    np.testing.assert_array_equal(one_sided, rasterised(corners[kept], source[kept]))


@pytest.mark.parametrize("inside", [0, 1, 2, 3])
@pytest.mark.parametrize("nearer_m", [-1.0, NEAR / 2])
def test_the_near_plane_clips_triangles(nearer_m: float, inside: int) -> None:
    triangle = np.array([[[0, -1, nearer_m], [1, 1, nearer_m], [-1, 1, nearer_m]]])
    triangle[0, :inside, 2] = 2
    corners, source = projected(triangle)
    assert len(corners) == len(source) == (0, 1, 2, 1)[inside]
    assert (corners[..., 2] <= 1 / NEAR + 1e-9).all()


def test_a_rectangle_is_rasterised_as_in_the_whole_image() -> None:
    corners, source = projected(random_triangles(40, seed=4))
    nearness, label = rasterised(corners, source)
    part_nearness, part_label = rasterised(corners, source, rectangle=(7, 5, 31, 29))
    np.testing.assert_allclose(part_nearness, nearness[5:29, 7:31], rtol=1e-5)
    np.testing.assert_array_equal(part_label, label[5:29, 7:31])


def test_each_point_gets_the_transform_of_its_body() -> None:
    random = np.random.default_rng(1)
    points, transforms = random.normal(size=(9, 3)), random.normal(size=(4, 3, 4))
    body = random.integers(4, size=9).astype(np.int32)
    wanted = [
        transforms[b, :, :3] @ p + transforms[b, :, 3] for p, b in zip(points, body, strict=True)
    ]
    np.testing.assert_allclose(transform_points(points, body, transforms), wanted)


def test_bounds_are_those_of_the_triangles_with_the_label() -> None:
    triangles = np.random.default_rng(2).normal(size=(6, 3, 3))
    labels = np.array([0, 2, 2, 0, 0, 2], np.int32)
    bounds = label_bounds(triangles, labels, 3)
    for label in (0, 2):
        points = triangles[labels == label][..., :2].reshape(-1, 2)
        np.testing.assert_array_equal(bounds[label], [*points.min(axis=0), *points.max(axis=0)])
    assert (bounds[1, :2] > bounds[1, 2:]).all()
