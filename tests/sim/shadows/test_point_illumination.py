"""Illumination of a point: in and beside shadows, and in beams."""

import math

import numpy as np
import pytest

from sim.shadows.point_illumination import (
    SUN_BIAS_M,
    beam_lux,
    beam_of,
    find_unshadowed_shares,
)
from sim.shadows.shadows_and_beams import ShadowsAndBeams


def share_at(
    u: float, v: float, w: float, *, is_sun: bool, caster: float, nearness: float = 1.0
) -> float:
    """Return the share at a point, for a map with a caster of given nearness from column 4 on.

    Column, row and nearness of the point, `u`, `v` and `w`, are homogeneous for a lamp.
    """
    maps = np.full((1, 10, 10), -np.inf, np.float32)
    maps[0, :, 4:] = caster
    view = np.zeros((1, 3, 4))
    view[0, :, 3] = u, v, w
    shadow = ShadowsAndBeams(
        gains=np.ones(2),
        maps=maps,
        sizes=np.array([[6, 8]]),
        views=view,
        light=np.zeros(1, np.int64),
        is_sun=np.array([is_sun]),
        shadow_areas=np.array([[0, 0, 1, 1]]),
        beams=np.empty((0, 9)),
        beam_areas=np.empty((0, 4), np.int64),
        beam_range_m=1.0,
    )
    near, shares = np.full(1, nearness, np.float32), np.empty((3, 1))
    find_unshadowed_shares(shadow, 0, (0.0, 0.0, 0.0), near, 0, 1, shares)
    return float(shares[0, 0])


@pytest.mark.parametrize(("column", "share"), [(1.5, 1), (3.5, 1), (3.75, 0.75), (4, 0.5), (5, 0)])
def test_a_caster_nearer_to_the_sun_blocks_it(column: float, share: float) -> None:
    assert share_at(column, 3.0, -2.0, is_sun=True, caster=-1.0) == pytest.approx(share)
    assert share_at(column, 3.0, 0.0, is_sun=True, caster=-1.0) == 1


def test_a_surface_does_not_shade_itself() -> None:
    assert share_at(5.0, 3.0, -1.0, is_sun=True, caster=-1.0) == 1
    assert share_at(5.0, 3.0, -1.0 - 2 * SUN_BIAS_M, is_sun=True, caster=-1.0) == 0


def test_coordinates_of_a_lamps_map_are_homogeneous_and_nearness_is_inverse_distance() -> None:
    far, near = 4.0, 1.0
    for w, share in ((far, 0), (near, 1)):
        assert share_at(5.0 * w, 3.0 * w, w, is_sun=False, caster=1 / 2.0) == share
    assert share_at(5.0, 3.0, -1.0, is_sun=False, caster=9.0) == 1  # behind the lamp


@pytest.mark.parametrize("is_sun", [False, True])
@pytest.mark.parametrize("nearness", [0.25, 3.0])
def test_a_common_factor_of_a_point_changes_nothing(is_sun: bool, nearness: float) -> None:
    u, v, w = (3.75, 3.0, -2.0) if is_sun else (3.75 * 4.0, 3.0 * 4.0, 4.0)
    caster = -1.0 if is_sun else 0.5
    scaled = share_at(u, v, w, is_sun=is_sun, caster=caster, nearness=nearness)
    assert scaled == pytest.approx(0.75)


@pytest.mark.parametrize(("u", "v"), [(0.4, 3.0), (7.0, 3.0), (5.0, 0.4), (5.0, 5.0)])
def test_there_is_no_shadow_outside_the_used_part_of_a_map(u: float, v: float) -> None:
    assert share_at(u, v, -2.0, is_sun=True, caster=0.0) == 1


def test_only_a_point_at_the_edge_of_a_shadow_gets_part_of_the_light() -> None:
    """Rounding must not make an edge of a point that is fully lit or fully in the shadow."""
    random = np.random.default_rng(0)
    for u, v in zip(random.uniform(0.6, 3.4, 200), random.uniform(0.6, 4.4, 200), strict=True):
        assert share_at(u, v, -2.0, is_sun=True, caster=-1.0) == 1
        assert share_at(u + 4.0, v, -2.0, is_sun=True, caster=-1.0) == (u + 4.0 > 6.5)


def lux(
    x: float, y: float, z: float, normal: tuple[float, float, float], lamp_z: float = 0.0
) -> float:
    """Return the lux from 1000 cd at (0, 0, lamp_z) along z, full within 10° and dark beyond 20°.

    The beam's range is 60 m.
    """
    inner, outer = math.cos(math.radians(10)), math.cos(math.radians(20))
    scale = 1 / (inner - outer)
    beam = np.array([[0, 0, lamp_z, 0, 0, 1, 1000.0, scale, -outer * scale]])
    return beam_lux(beam_of(beam, 0), 60.0, x / z, y / z, 1 / z, normal)


def test_illuminance_falls_with_the_square_of_the_distance_and_the_cosine() -> None:
    fade = (1 - (5 / 60) ** 4) ** 2
    assert lux(0, 0, 5, (0, 0, -1)) == pytest.approx(1000 / 25 * fade)
    slope = math.radians(60)
    normal = math.sin(slope), 0.0, -math.cos(slope)
    assert lux(0, 0, 5, normal) == pytest.approx(0.5 * 1000 / 25 * fade)


def test_a_beam_is_dark_beyond_its_rim_and_range_and_on_surfaces_that_face_away() -> None:
    aside = 5 * math.tan(math.radians(20.1))
    assert lux(aside, 0, 5, (0, 0, -1)) == 0
    assert 0 < lux(5 * math.tan(math.radians(19.9)), 0, 5, (0, 0, -1)) < 1
    assert lux(0, 0, 61, (0, 0, -1)) == 0
    assert lux(0, 0, 5, (0, 0, 1)) == 0
    assert lux(0, 0, 5, (0, 0, -1), lamp_z=4) > 0
    assert lux(0, 0, 5, (0, 0, -1), lamp_z=6) == 0
