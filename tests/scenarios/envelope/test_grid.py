"""The points of an envelope."""

import pytest

from flybench.direction import CARDINAL, Direction
from scenarios.envelope.grid import BASE, LEVELS, TILT, TILTED_SURFACES, Grid
from scenarios.envelope.stimulus import Background
from scenarios.errors import ScenarioError


def test_every_factor_has_the_level_of_the_base_point() -> None:
    for name, values in LEVELS.items():
        assert getattr(BASE, name) in values


def test_speed_and_noise_are_crossed_and_other_factors_vary_one_at_a_time() -> None:
    levels = {"direction": CARDINAL, "background": tuple(Background)}
    points = Grid((100.0, 400.0), (1.0, 5.0), levels, crossed=(), seeds=1).points()
    crossed = {(p.speed_px_s, p.noise_hz) for p in points}
    assert crossed == {(100, 1), (100, 5), (400, 1), (400, 5)}
    for point in points:
        changed = [
            name for name in ("noise_hz", *levels) if getattr(point, name) != getattr(BASE, name)
        ]
        assert len(changed) <= 1
    assert len(points) == len(set(points)) == 2 * (2 + 3 + 3)


def test_a_crossed_factor_is_measured_at_every_noise() -> None:
    points = Grid((400.0,), (0.0, 9.0), {"direction": CARDINAL}, ("direction",), seeds=3).points()
    assert {(p.noise_hz, p.direction, p.seed) for p in points if p.noise_hz != BASE.noise_hz} == {
        (noise, direction, seed) for noise in (0, 9) for direction in CARDINAL for seed in range(3)
    }


def test_the_default_grid_is_small_and_covers_the_whole_range() -> None:
    points = Grid().points()
    assert len(points) < 1500
    assert {p.direction for p in points} == set(CARDINAL) - {Direction.NONE}
    assert (min(p.speed_px_s for p in points), max(p.speed_px_s for p in points)) == (30, 2000)
    assert (min(p.noise_hz for p in points), max(p.noise_hz for p in points)) == (0, 20)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"crossed": ("colour",)}, r"'colour'\. Allowed is contrast"),
        ({"speeds_px_s": ()}, "speed_px_s has no level"),
        ({"seeds": 0}, r"seeds is 0\. Allowed is 1 or more"),
        ({"seeds": 100_000}, "Allowed are 1,000,000"),
        ({"noises_hz": (-1.0,)}, r"noise_hz is -1\.0\. Allowed is"),
    ],
)
def test_an_invalid_grid_is_refused(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        Grid(**arguments)  # type: ignore[arg-type]


def test_tilt_is_also_measured_for_a_bar_and_a_band() -> None:
    points = Grid((400.0,), (1.0,), {TILT: (0.0, 15.0)}, crossed=(), seeds=1).points()
    found = {(point.surface, point.tilt_deg) for point in points}
    assert found == {
        (surface, tilt) for surface in (BASE.surface, *TILTED_SURFACES) for tilt in (0.0, 15.0)
    }
