"""Samples half way between others: a cubic, and where it applies."""

import itertools
import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from sim import Crossing, CrossingConfig, LuminanceCache
from sim.cache.luminance_file import LuminanceSample
from sim.geometry.rectangles import Rectangle
from sim.keyframes.midpoints import DARKEST_CD_M2, with_midpoints

WHOLE = (0, 0, 3, 2)
F32 = npt.NDArray[np.float32]


def sample(t_us: int, level: float, changed: Rectangle = WHOLE) -> LuminanceSample:
    """Return an image of which only the second column has a level of its own."""
    luminance = np.full((2, 3), 7.0, np.float32)
    luminance[:, 1] = level
    return LuminanceSample(t_us, luminance, np.full((2, 3), t_us, np.int32), changed)


def course(t_us: float) -> float:
    """Return a luminance whose logarithm is a parabola in time."""
    x = t_us / 1000
    return math.exp(2 + 0.3 * x - 0.2 * x**2)


def test_a_parabola_is_met_exactly() -> None:
    times = [0, 1000, 2000, 3000, 4000, 5000]
    found = list(with_midpoints(sample(t, course(t)) for t in times))
    assert [s.t_us for s in found] == [0, 1000, 1500, 2000, 2500, 3000, 3500, 4000, 5000]
    for s in found:
        assert s.luminance[:, 1] == pytest.approx(course(s.t_us), rel=1e-6)
        assert (s.luminance[:, [0, 2]] == 7).all()
        assert (s.body == s.t_us // 1000 * 1000).all()


def test_an_edge_between_light_and_dark_overshoots_by_little() -> None:
    """A cubic of luminance would be −61 cd/m² where the edge ends."""
    levels = [1000.0, 1000.0, 1000.0, 1.0, 1.0, 1.0]
    found = list(with_midpoints(sample(1000 * k, level) for k, level in enumerate(levels)))
    before, edge, after = (s.luminance[0, 1] for s in found if s.t_us % 1000)
    assert before == pytest.approx(1000 ** (17 / 16))
    assert edge == pytest.approx(math.sqrt(1000))
    assert after == pytest.approx(1000 ** (-1 / 16))


def test_darkness_is_a_finite_level() -> None:
    found = list(with_midpoints(sample(1000 * k, level) for k, level in enumerate([0, 0, 9, 9])))
    assert found[2].luminance[0, 1] == pytest.approx(math.sqrt(9 * DARKEST_CD_M2))
    assert (found[2].luminance[:, 0] == 7).all()


@pytest.mark.parametrize("count", range(4))
def test_few_samples_are_passed_through(count: int) -> None:
    given = [sample(1000 * k, 5.0) for k in range(count)]
    assert list(with_midpoints(given)) == given


def test_there_is_none_where_the_intervals_differ() -> None:
    times = [0, 1000, 2000, 3000, 3800, 4600, 5400]
    found = [s.t_us for s in with_midpoints(sample(t, course(t)) for t in times)]
    assert found == [0, 1000, 1500, 2000, 3000, 3800, 4200, 4600, 5400]


def test_the_changed_rectangle_holds_every_change() -> None:
    """Each sample changes another area, and may be equal to the one before."""
    rng, images, given = np.random.default_rng(0), [np.ones((8, 9), np.float32)], []
    for k in range(12):
        x0, y0 = rng.integers(0, 5, 2)
        image = images[-1].copy()
        area = (int(x0), int(y0), int(x0) + 3, int(y0) + 2) if k % 4 else (0, 0, 0, 0)
        image[area[1] : area[3], area[0] : area[2]] *= rng.uniform(0.5, 2)
        images.append(image)
        whole = (0, 0, 9, 8)
        body = np.zeros((8, 9), np.int32)
        given.append(LuminanceSample(1000 * k, image, body, area if k else whole))
    found = list(with_midpoints(given))
    assert len(found) == 12 + 9
    for before, after in itertools.pairwise(found):
        same = before.luminance == after.luminance
        x0, y0, x1, y1 = after.changed
        same[y0:y1, x0:x1] = True
        assert same.all()


OPTIONS = {"step_px": 5.0, "supersample": 1, "max_step_ms": 20.0, "omega_rad_s": 3.0}


def test_a_draft_renders_less_and_has_samples_in_between() -> None:
    full = Crossing(CrossingConfig(**OPTIONS))  # type: ignore[arg-type]
    draft = Crossing(CrossingConfig(quality="draft", **OPTIONS))  # type: ignore[arg-type]
    drawn = draft.times_us()
    assert len(drawn) < 0.8 * len(full.times_us())
    times = [s.t_us for s in draft.samples()]
    assert set(drawn) < set(times)
    assert len(times) > 1.5 * len(drawn)
    assert times == sorted(times)
    assert [s.t_us for s in draft.samples(drawn[:5])] == drawn[:5]


def test_fine_quality_adds_samples_to_those_in_the_cache(tmp_path: Path) -> None:
    cache = LuminanceCache(tmp_path)
    full = Crossing(CrossingConfig(**OPTIONS), cache=cache)  # type: ignore[arg-type]
    rendered = {s.t_us: s.luminance for s in full.samples()}
    count = cache.rendered
    fine = Crossing(CrossingConfig(quality="fine", **OPTIONS), cache=cache)  # type: ignore[arg-type]
    samples = {s.t_us: s for s in fine.samples()}
    assert cache.rendered == count
    assert set(rendered) < set(samples)
    assert len(samples) > 1.5 * len(rendered)
    for t_us, luminance in rendered.items():
        np.testing.assert_array_equal(samples[t_us].luminance, luminance)
