"""Events of the default rendering and of full rendering, compared with a finer rendering."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from flybench.direction import Direction
from flybench.events import Events
from scenarios.convergence.matching import Match, match
from scenarios.convergence.measure import (
    COLUMNS,
    SENSOR,
    Rendering,
    events_of,
    measure_convergence,
    piece_times_us,
    target_speed_px_s,
    with_keyframe_times_us,
)
from sim import Crossing, CrossingConfig, Distractors, Lighting, RelativeDirection, VehicleKind
from sim.distractors import Pavement
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rectangles import enclosing_rectangle

CASES: dict[str, dict[str, Any]] = {
    "sedan to the right by day, a pedestrian before it": {
        "distractors": Distractors(
            pedestrian=RelativeDirection.SAME, pedestrian_pavement=Pavement.NEAR
        ),
    },
    "motorcycle upwards by day, trees in the wind": {
        "vehicle": VehicleKind.MOTORCYCLE,
        "direction": Direction.UP,
        "distractors": Distractors(wind_grade=5),
    },
    "van to the left by day, a motorcycle beyond it": {
        "vehicle": VehicleKind.VAN,
        "direction": Direction.LEFT,
        "distractors": Distractors(
            far_vehicle=RelativeDirection.SAME, far_vehicle_kind=VehicleKind.MOTORCYCLE
        ),
    },
    "sedan downwards by day, the camera shakes": {
        "direction": Direction.DOWN,
        "distractors": Distractors(shake_rms_deg=0.2),
    },
    "sedan upwards at dusk": {"lighting": Lighting.DUSK, "direction": Direction.UP},
    "van to the right at dusk, a pedestrian beyond it": {
        "lighting": Lighting.DUSK,
        "vehicle": VehicleKind.VAN,
        "distractors": Distractors(pedestrian=RelativeDirection.OPPOSITE),
    },
    "sedan to the left by night, a sedan beyond it": {
        "lighting": Lighting.NIGHT,
        "direction": Direction.LEFT,
        "distractors": Distractors(far_vehicle=RelativeDirection.OPPOSITE),
    },
    "motorcycle to the right by night, lamps flicker": {
        "lighting": Lighting.NIGHT,
        "vehicle": VehicleKind.MOTORCYCLE,
        "distractors": Distractors(flicker_hz=100, flicker_depth=0.05),
    },
}
MIDDLE = Intrinsics(width=230, height=150)
"""The centre of the sensor, with two fifths of its pixels."""
PIECE_PX = 1.5
FINE_SIZE = 5
"""Supersampling of the finer rendering; it has the same times as the others, so that only errors of
sampling in space are compared."""
CHANCE = 0.005
"""Tolerance for shares of the events of a short piece: events along an edge are correlated."""
EXCESS_CHANCE = 0.01
"""Tolerance for the number of events, in which errors of both signs may cancel by chance."""
MAX_NEEDLESS = 0.002
"""Greatest share of events where nothing changes. They occur where an edge moves along itself,
since its aliasing differs from that of the finer rendering."""

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Compared:
    """Comparison of one case with the finer rendering.

    Attributes:
        default: match of the default rendering.
        full: match of the full rendering.
        needless: share of the default's events at pixels that do not change in the finer rendering,
            and whose neighbours do not change either.
        untouched: True if luminance outside the default's changed rectangles is constant.
    """

    default: Match
    full: Match
    needless: float
    untouched: bool


@lru_cache(maxsize=len(CASES))
def compared(name: str) -> Compared:
    it = Crossing(CrossingConfig(**CASES[name]), MIDDLE)
    times_us = piece_times_us(it, PIECE_PX, it.config.step_px)
    with it.keyframe_renderer(with_keyframe_times_us(it, times_us)) as draw:
        composites = [draw(t_us) for t_us in times_us]
    window = enclosing_rectangle([w for c in composites for w in c.rectangles])
    default = [c.luminance for c in composites]
    fine = render_in_full(it, times_us, FINE_SIZE, window, default[0])
    coarse = render_in_full(it, times_us, 2, window, default[0])
    reference, events, rough = (
        events_of_images(times_us, images) for images in (fine, default, coarse)
    )
    x0, y0, x1, y1 = window
    outside = np.ones(default[0].shape, np.bool_)
    outside[y0:y1, x0:x1] = False
    return Compared(
        match(events, reference),
        match(rough, reference),
        needless_share(events, fine),
        all(np.array_equal(image[outside], default[0][outside]) for image in default),
    )


def events_of_images(times_us: list[int], images: list[Image]) -> Events:
    """Return the events of a sensor with images in its corner and constant luminance elsewhere."""
    rows, columns = np.subtract((SENSOR.height, SENSOR.width), images[0].shape)
    whole = (np.pad(image, ((0, rows), (0, columns)), constant_values=1.0) for image in images)
    return events_of(zip(times_us, whole, strict=True))


def needless_share(events: Events, fine: list[Image]) -> float:
    """Return the share of events at pixels where neither they nor their neighbours change."""
    changing = np.ptp(np.log(np.stack(fine)), axis=0) > 1e-3
    near = np.zeros_like(changing)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            near |= np.roll(changing, (i, j), (0, 1))
    return float(1 - near[events["y"], events["x"]].mean())


def render_in_full(
    it: Crossing,
    times_us: list[int],
    size: int,
    window: tuple[int, int, int, int],
    background: Image,
) -> list[Image]:
    """Return images rendered in full inside a window, and equal to `background` outside."""
    x0, y0, x1, y1 = window
    images = []
    with it.full_frame_renderer(size, window) as draw:
        for t_us in times_us:
            image = background.copy()
            image[y0:y1, x0:x1] = draw(t_us)
            images.append(image)
    return images


@pytest.mark.parametrize("name", CASES)
def test_the_default_is_no_worse_than_full_rendering(name: str) -> None:
    case = compared(name)
    default, coarse = case.default, case.full
    assert abs(default.excess) <= abs(coarse.excess) + EXCESS_CHANCE
    assert default.median_us <= coarse.median_us
    for mine, others in ((default.recall, coarse.recall), (default.precision, coarse.precision)):
        assert np.all(np.array(mine) >= np.array(others) - CHANCE)


@pytest.mark.parametrize("name", CASES)
def test_pixels_that_do_not_change_have_no_events(name: str) -> None:
    case = compared(name)
    assert case.untouched
    assert case.needless <= MAX_NEEDLESS


def test_over_all_cases_the_default_is_better_than_full_rendering() -> None:
    cases = [compared(name) for name in CASES]

    def mean(of: str, number: Any) -> float:
        return float(np.mean([number(getattr(case, of)) for case in cases]))

    assert mean("default", lambda m: m.excess**2) < mean("full", lambda m: m.excess**2)
    assert mean("default", lambda m: m.median_us) < mean("full", lambda m: m.median_us)
    for limit in range(4):
        for side in ("recall", "precision"):
            share = [mean(w, lambda m: getattr(m, side)[limit]) for w in ("default", "full")]  # noqa: B023
            assert share[0] > share[1]


def test_there_is_one_row_per_rendering() -> None:
    renderings = (
        Rendering("full", 2, 0.5),
        Rendering("full", 1, 0.5),
        Rendering("keyframes", 1, 0.5, 8.0),
    )
    rows = [
        dict(zip(COLUMNS, r, strict=True))
        for r in measure_convergence(CrossingConfig(), 1.0, renderings)
    ]
    assert [tuple(row[name] or 0.0 for name in COLUMNS[:4]) for row in rows] == list(renderings)
    assert rows[0]["events_excess"] == 0
    assert rows[0]["median_us"] == 0
    assert rows[0]["recall_within_200us"] == rows[0]["precision_within_200us"] == 1
    assert all(
        0.3 < row["recall_within_2000us"] < 1 and row["events_excess"] != 0 for row in rows[1:]
    )
    assert all(row["cpu_ms_per_sample"] > 0 for row in rows)


def test_the_piece_lies_half_way_between_two_keyframes() -> None:
    crossing = Crossing(CrossingConfig(keyframe_px=16.0))
    piece_us = piece_times_us(crossing, 2.0, 0.5)
    first, *inside, last = with_keyframe_times_us(crossing, piece_us)
    assert inside == piece_us
    assert (first + last) / 2 == pytest.approx((piece_us[0] + piece_us[-1]) / 2, abs=2)
    assert (last - first) * 1e-6 * target_speed_px_s(crossing) == pytest.approx(16.0, rel=1e-3)


def test_the_piece_has_the_given_length() -> None:
    crossing = Crossing(CrossingConfig())
    times_us = piece_times_us(crossing, 3.0, 0.5)
    speed_px_s = 1.61 * crossing.intrinsics.focal_px
    assert len(times_us) == 7
    assert (times_us[-1] - times_us[0]) * 1e-6 * speed_px_s == pytest.approx(3.0, rel=1e-3)
