"""A lamp's light at a place: past a mover's shadow, and in a mover's beam."""

import math

import numpy as np
import pytest

from sim.shadows.lamp_light import BIAS_M, beam_lux, share_let_through

SIZES = np.array([[6, 8]])


def let_through(u: float, v: float, w: float, *, parallel: bool, caster: float) -> float:
    """Share at a place, of a map whose columns from 4 on show something so near."""
    maps = np.full((1, 10, 10), -np.inf, np.float32)
    maps[0, :, 4:] = caster
    return share_let_through(maps, SIZES, np.array([parallel]), 0, u, v, w)


@pytest.mark.parametrize(("column", "share"), [(1.5, 1), (3.5, 1), (3.75, 0.75), (4, 0.5), (5, 0)])
def test_a_caster_nearer_to_the_sun_shuts_it_out(column: float, share: float) -> None:
    assert let_through(column, 3.0, -2.0, parallel=True, caster=-1.0) == pytest.approx(share)
    assert let_through(column, 3.0, 0.0, parallel=True, caster=-1.0) == 1


def test_nothing_darkens_itself() -> None:
    assert let_through(5.0, 3.0, -1.0, parallel=True, caster=-1.0) == 1
    assert let_through(5.0, 3.0, -1.0 - 2 * BIAS_M, parallel=True, caster=-1.0) == 0


def test_before_a_lamp_places_are_homogeneous_and_nearness_is_one_over_the_distance() -> None:
    far, near = 4.0, 1.0
    for w, share in ((far, 0), (near, 1)):
        seen = let_through(5.0 * w, 3.0 * w, w, parallel=False, caster=1 / 2.0)
        assert seen == share
    assert let_through(5.0, 3.0, -1.0, parallel=False, caster=9.0) == 1  # behind the lamp


@pytest.mark.parametrize(("u", "v"), [(0.4, 3.0), (7.0, 3.0), (5.0, 0.4), (5.0, 5.0)])
def test_beyond_the_part_of_a_map_in_use_nothing_is_dark(u: float, v: float) -> None:
    assert let_through(u, v, -2.0, parallel=True, caster=0.0) == 1


def lux(x: float, y: float, z: float, normal: tuple[float, float, float]) -> float:
    """From 1000 cd at the origin along z, full within 10°, dark beyond 20°; its range is 60 m."""
    inner, outer = math.cos(math.radians(10)), math.cos(math.radians(20))
    scale = 1 / (inner - outer)
    beam = np.array([[0, 0, 0, 0, 0, 1, 1000.0, scale, -outer * scale]])
    return beam_lux(beam, 0, 60.0, x, y, z, *normal)


def test_a_beam_falls_off_with_the_square_of_the_distance_and_the_cosine() -> None:
    fade = (1 - (5 / 60) ** 4) ** 2
    assert lux(0, 0, 5, (0, 0, -1)) == pytest.approx(1000 / 25 * fade)
    slope = math.radians(60)
    normal = math.sin(slope), 0.0, -math.cos(slope)
    assert lux(0, 0, 5, normal) == pytest.approx(0.5 * 1000 / 25 * fade)


def test_a_beam_ends_at_its_rim_at_its_range_and_behind_a_surface() -> None:
    aside = 5 * math.tan(math.radians(20.1))
    assert lux(aside, 0, 5, (0, 0, -1)) == 0
    assert 0 < lux(5 * math.tan(math.radians(19.9)), 0, 5, (0, 0, -1)) < 1
    assert lux(0, 0, 61, (0, 0, -1)) == 0
    assert lux(0, 0, 5, (0, 0, 1)) == 0
    assert lux(0, 0, -5, (0, 0, -1)) == 0
