"""Events of synthetic stimuli."""

import numpy as np
import pytest

from flybench.direction import CARDINAL, Direction
from flybench.events import check_events
from scenarios.envelope.drawing import DrawnStimulus, draw_stimulus
from scenarios.envelope.stimulus import Background, Stimulus, Surface

QUIET = {"noise_hz": 0.0, "speed_px_s": 1000.0}


def share_in_box(drawn: DrawnStimulus, slack_px: int = 3) -> float:
    """Return the share of events inside the target's true box of their millisecond."""
    events, hits = drawn.events, 0
    for ms in range(drawn.duration_us // 1000 + 1):
        box = drawn.box_px(1000 * ms + 500)
        start, end = np.searchsorted(events["t"], (1000 * ms, 1000 * (ms + 1)))
        if box is not None:
            x, y = events["x"][start:end], events["y"][start:end]
            x0, y0, x1, y1 = box
            across = (x >= x0 - slack_px) & (x < x1 + slack_px)
            hits += int(np.count_nonzero(across & (y >= y0 - slack_px) & (y < y1 + slack_px)))
    return hits / events.size


@pytest.mark.parametrize("direction", CARDINAL)
def test_all_events_lie_in_the_true_box_of_the_target(direction: Direction) -> None:
    drawn = draw_stimulus(Stimulus(direction=direction, **QUIET))  # type: ignore[arg-type]
    check_events(drawn.events, width=346, height=260)
    assert drawn.events.size > 50_000
    assert share_in_box(drawn) == 1.0


@pytest.mark.parametrize("background", [Background.SHAKE, Background.WIND, Background.DISTRACTOR])
def test_motion_in_the_background_causes_events_outside_the_box(background: Background) -> None:
    drawn = draw_stimulus(Stimulus(background=background, speed_px_s=2000, noise_hz=0))
    check_events(drawn.events, width=346, height=260)
    assert share_in_box(drawn) < 0.98


def test_the_same_stimulus_gives_the_same_events() -> None:
    stimulus = Stimulus(speed_px_s=2000, background=Background.WIND, noise_hz=2, seed=5)
    np.testing.assert_array_equal(draw_stimulus(stimulus).events, draw_stimulus(stimulus).events)


def test_seeds_give_other_events() -> None:
    one, other = (
        draw_stimulus(Stimulus(speed_px_s=1500, noise_hz=0, seed=k)).events for k in (1, 2)
    )
    assert one.size != other.size


def test_noise_adds_to_the_same_signal() -> None:
    quiet, noisy = (draw_stimulus(Stimulus(speed_px_s=1500, noise_hz=hz)).events for hz in (0, 5))
    expected = 5 * 346 * 260 * 0.51
    assert noisy.size - quiet.size == pytest.approx(expected, rel=0.03)


def test_lower_contrast_gives_fewer_events() -> None:
    sizes = [draw_stimulus(Stimulus(contrast=c, **QUIET)).events.size for c in (0.1, 0.4, 1.0)]  # type: ignore[arg-type]
    assert sizes[0] < sizes[1] / 4 < sizes[2] / 8


def test_event_times_lie_between_the_images() -> None:
    events = draw_stimulus(Stimulus(speed_px_s=50, noise_hz=0)).events  # one image every 10 ms
    assert len(np.unique(events["t"] % 10_000)) > 5_000


def test_a_finer_step_changes_the_events_little(monkeypatch: pytest.MonkeyPatch) -> None:
    stimulus = Stimulus(noise_hz=0, speed_px_s=2000)
    coarse = draw_stimulus(stimulus).events
    monkeypatch.setattr("scenarios.envelope.drawing.STEP_PX", 0.1)
    fine = draw_stimulus(stimulus).events
    assert coarse.size == pytest.approx(fine.size, rel=0.02)
    times = [np.sort(e["t"][e["p"]]) for e in (coarse, fine)]
    assert np.median(times[0]) == pytest.approx(np.median(times[1]), abs=500)


def test_the_true_box_is_clipped_to_the_image() -> None:
    drawn = draw_stimulus(Stimulus(speed_px_s=1000, noise_hz=0, surface=Surface.PLAIN))
    first_us, last_us = drawn.in_view_us
    assert drawn.box_px(0) is None
    assert drawn.centroid_px(0) is None
    assert first_us == 201_000
    assert last_us == pytest.approx(drawn.duration_us, abs=1000)
    box, centroid = drawn.box_px(250_000), drawn.centroid_px(250_000)
    assert box is not None
    assert centroid is not None
    assert (box[0], box[2]) == (0, 50)
    assert centroid[0] == pytest.approx(25)
