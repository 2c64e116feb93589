"""The default drawing against full drawing, both against a finer one: by events."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, Events
from scenarios.commands.converge import (
    COLUMNS,
    SENSOR,
    Converge,
    Drawing,
    between_keyframes_us,
    converge,
    events_of,
    piece_times_us,
    target_px_s,
)
from scenarios.convergence.matching import Match, match
from scenarios.errors import ScenarioError
from sim import Crossing, CrossingConfig, Distractors, Lighting, RelativeDirection, VehicleKind
from sim.distractors import Pavement
from sim.geometry.pinhole import Intrinsics
from sim.geometry.rectangles import hull

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
"""The middle of the sensor: two fifths of the light to draw."""
PIECE_PX = 1.5
FINE_SIZE = 5
"""At the same times as the others: of the errors, those of the step are not what is compared."""
CHANCE = 0.005
"""Allowance to shares of the events of one short piece: along an edge they come and go together."""
CHANCE_OF_COUNT = 0.01
"""And to their number, in which errors of both signs cancel each other by chance."""
FLUTTER = 0.002
"""Share of events that may come where an edge slides along itself: its stairs are not the finer
drawing's."""

Image = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Compared:
    """A case, drawn in both ways.

    Attributes:
        default: against the fine drawing.
        full: likewise.
        needless: share of the default's events at pixels where nothing changes in the fine drawing,
            nor in their neighbours.
        untouched: whether the light outside of the default's windows is always the same.
    """

    default: Match
    full: Match
    needless: float
    untouched: bool


@lru_cache(maxsize=len(CASES))
def compared(name: str) -> Compared:
    it = Crossing(CrossingConfig(**CASES[name]), MIDDLE)
    times_us = piece_times_us(it, PIECE_PX, it.config.step_px)
    with it.keyframe_renderer(between_keyframes_us(it, times_us)) as draw:
        drawn = [draw(t_us) for t_us in times_us]
    window = hull([w for d in drawn for w in d.rectangles])
    keyed = [d.luminance for d in drawn]
    fine = full(it, times_us, FINE_SIZE, window, keyed[0])
    coarse = full(it, times_us, 2, window, keyed[0])
    reference, events, rough = (seen(times_us, images) for images in (fine, keyed, coarse))
    x0, y0, x1, y1 = window
    outside = np.ones(keyed[0].shape, np.bool_)
    outside[y0:y1, x0:x1] = False
    return Compared(
        match(events, reference),
        match(rough, reference),
        needless(events, fine),
        all(np.array_equal(image[outside], keyed[0][outside]) for image in keyed),
    )


def seen(times_us: list[int], images: list[Image]) -> Events:
    """Events of a whole sensor that sees images in its corner, and constant light elsewhere."""
    rows, columns = np.subtract((SENSOR.height, SENSOR.width), images[0].shape)
    whole = (np.pad(image, ((0, rows), (0, columns)), constant_values=1.0) for image in images)
    return events_of(zip(times_us, whole, strict=True))


def needless(events: Events, fine: list[Image]) -> float:
    """Share of events where nothing changes, nor in the neighbours."""
    changing = np.ptp(np.log(np.stack(fine)), axis=0) > 1e-3
    near = np.zeros_like(changing)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            near |= np.roll(changing, (i, j), (0, 1))
    return float(1 - near[events["y"], events["x"]].mean())


def full(
    it: Crossing, times_us: list[int], size: int, window: tuple[int, int, int, int], still: Image
) -> list[Image]:
    """Images drawn in full inside of a window, and as `still` outside."""
    x0, y0, x1, y1 = window
    images = []
    with it.full_frame_renderer(size, window) as draw:
        for t_us in times_us:
            image = still.copy()
            image[y0:y1, x0:x1] = draw(t_us)
            images.append(image)
    return images


@pytest.mark.parametrize("name", CASES)
def test_the_default_is_no_worse_than_drawing_every_sample_in_full(name: str) -> None:
    drawn = compared(name)
    default, coarse = drawn.default, drawn.full
    assert abs(default.count) <= abs(coarse.count) + CHANCE_OF_COUNT
    assert default.median_us <= coarse.median_us
    for mine, others in ((default.found, coarse.found), (default.real, coarse.real)):
        assert np.all(np.array(mine) >= np.array(others) - CHANCE)


@pytest.mark.parametrize("name", CASES)
def test_where_nothing_changes_there_is_no_event(name: str) -> None:
    drawn = compared(name)
    assert drawn.untouched
    assert drawn.needless <= FLUTTER


def test_over_all_cases_the_default_is_better_than_drawing_every_sample_in_full() -> None:
    drawn = [compared(name) for name in CASES]

    def mean(of: str, number: Any) -> float:
        return float(np.mean([number(getattr(case, of)) for case in drawn]))

    assert mean("default", lambda m: m.count**2) < mean("full", lambda m: m.count**2)
    assert mean("default", lambda m: m.median_us) < mean("full", lambda m: m.median_us)
    for limit in range(4):
        for side in ("found", "real"):
            share = [mean(w, lambda m: getattr(m, side)[limit]) for w in ("default", "full")]  # noqa: B023
            assert share[0] > share[1]


def test_a_table_has_a_row_for_each_drawing() -> None:
    ways = (Drawing("full", 2, 0.5), Drawing("full", 1, 0.5), Drawing("keyframes", 1, 0.5, 8.0))
    rows = [dict(zip(COLUMNS[1:], r, strict=True)) for r in converge(CrossingConfig(), 1.0, ways)]
    assert [tuple(row[name] or 0.0 for name in COLUMNS[1:5]) for row in rows] == list(ways)
    assert rows[0]["events"] == 0
    assert rows[0]["median_us"] == 0
    assert rows[0]["found_within_200us"] == rows[0]["real_within_200us"] == 1
    assert all(0.3 < row["found_within_2000us"] < 1 and row["events"] != 0 for row in rows[1:])
    assert all(row["cpu_ms_a_sample"] > 0 for row in rows)


def test_a_piece_too_long_is_refused() -> None:
    with pytest.raises(ScenarioError, match="--piece-px is 100; allowed is 1 to 64"):
        Converge(piece_px=100.0).execute()


def test_the_piece_lies_half_way_between_two_keyframes() -> None:
    crossing = Crossing(CrossingConfig(keyframe_px=16.0))
    piece_us = piece_times_us(crossing, 2.0, 0.5)
    first, *inside, last = between_keyframes_us(crossing, piece_us)
    assert inside == piece_us
    assert (first + last) / 2 == pytest.approx((piece_us[0] + piece_us[-1]) / 2, abs=2)
    assert (last - first) * 1e-6 * target_px_s(crossing) == pytest.approx(16.0, rel=1e-3)


def test_the_piece_is_as_long_as_asked_for() -> None:
    crossing = Crossing(CrossingConfig())
    times_us = piece_times_us(crossing, 3.0, 0.5)
    speed_px_s = 1.61 * crossing.intrinsics.focal_px
    assert len(times_us) == 7
    assert (times_us[-1] - times_us[0]) * 1e-6 * speed_px_s == pytest.approx(3.0, rel=1e-3)


def stream(*rows: tuple[int, int, int, bool]) -> Events:
    return np.array(list(rows), EVENT_DTYPE)


def test_an_event_matches_the_nearest_of_its_pixel_and_polarity() -> None:
    reference = stream((100, 1, 2, True), (5000, 1, 2, True), (9000, 3, 2, False))
    events = stream((4700, 1, 2, True), (5600, 1, 2, True), (9000, 3, 2, True))
    found = match(events, reference)
    assert found.count == 0
    assert found.real == pytest.approx((0, 1 / 3, 2 / 3, 2 / 3))
    assert found.found == pytest.approx((0, 1 / 3, 1 / 3, 1 / 3))
    assert found.median_us == 450


def test_a_stream_matches_itself() -> None:
    rng = np.random.default_rng(0)
    events = np.zeros(500, EVENT_DTYPE)
    events["t"] = np.sort(rng.integers(0, 10_000, 500))
    events["x"], events["y"] = rng.integers(0, 346, 500), rng.integers(0, 260, 500)
    found = match(events, events)
    assert found.found == found.real == (1, 1, 1, 1)
    assert found.median_us == 0
