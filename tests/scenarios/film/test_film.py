"""Films: what a moment shows, the frames of a chapter, and what is read from a recording."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from detector.estimate import MotionEstimate
from emulator import ApsFrame
from flybench.direction import Direction
from flybench.events import EVENT_DTYPE, empty_events
from scenarios.errors import ScenarioError
from scenarios.film.film import Chapter, FilmOptions, speed_text
from scenarios.film.from_events import read_truth
from scenarios.film.from_rerun import rerun_material
from scenarios.film.material import Estimates, Material, Part, Truth
from scenarios.film.playback import moments
from scenarios.film.track import Track
from scenarios.output.colours import OFF, ON
from scenarios.recording import FileRecorder
from tests.scenarios.timed_events import events_at

WIDTH, HEIGHT = 346, 260


def material(*parts: Part, name: str = "name", **others: Any) -> Material:
    times = [int(t) for events, _ in parts for t in events["t"]]
    return Material(
        name=name,
        width=WIDTH,
        height=HEIGHT,
        from_us=min(times),
        to_us=max(times),
        estimates=others.get("estimates", Estimates()),
        truth=others.get("truth"),
        read=lambda: iter(parts),
    )


def test_a_track_holds_each_value_until_the_next() -> None:
    track = Track([10, 20], ["a", "b"])
    assert [track.at(t_us) for t_us in (9, 10, 19, 20, 99)] == [None, "a", "a", "b", "b"]


def test_a_moment_shows_the_events_of_its_window_and_the_latest_frame() -> None:
    dark, bright = np.zeros((2, 2)), np.ones((2, 2))
    parts = [(events_at(0, 5, 10), ((3, dark),)), (events_at(11, 20, 30), ((20, bright),))]
    seen = list(moments(parts, [2, 12, 20, 40], 10))
    assert [moment.events["t"].tolist() for moment in seen] == [[0], [5, 10, 11], [11, 20], []]
    assert [moment.frame for moment in seen] == [None, dark, bright, bright]


def test_the_image_has_each_polarity_in_its_colour_above_the_frame() -> None:
    events = np.array([(5, 3, 4, True), (6, 7, 8, False)], EVENT_DTYPE)
    frame = np.full((HEIGHT, WIDTH), 500, np.uint16)
    options = FilmOptions(speed=1, fps=25, window_us=100_000, scale=1)
    (image,) = Chapter([material((events, ((5, frame),)))], options).images()
    area = image[22 : 22 + HEIGHT]
    assert area[4, 3].tolist() == list(ON)
    assert area[8, 7].tolist() == list(OFF)
    assert area[100, 100].tolist() == [255, 255, 255]  # the brightest grey level


def test_the_legend_has_room_whatever_the_method_is_called() -> None:
    region = Track[tuple[int, int, int, int] | None]([0], [(10, 20, 30, 40)])
    shown = material(
        (events_at(0, 5), ()),
        estimates=Estimates(
            "robust-no-attention",
            hs=Track([0], [0.1]),
            vs=Track([0], [0.0]),
            direction=Track([0], ["right"]),
            region=region,
        ),
        truth=Truth(Track([0], ["right"]), Track([0], [(10, 20, 30, 40)])),
    )
    (image,) = Chapter([shown], FilmOptions(speed=1, fps=25, window_us=10, scale=1)).images()
    legend = image[22 + HEIGHT : 22 + HEIGHT + 20]
    assert (legend[:, :300] < 128).any()
    assert (legend[:, -10:] == 255).all()


def test_recordings_side_by_side_end_with_the_longest() -> None:
    short = material((events_at(0, 10_000), ()))
    long = material((events_at(0, 90_000), ()))
    options = FilmOptions(speed=1, fps=100, window_us=10_000, scale=1)
    chapter = Chapter([short, long], options)
    images = list(chapter.images())
    assert len(images) == chapter.number == 10
    assert images[0].shape[1] > 2 * WIDTH
    assert (images[4][:, :WIDTH] == images[9][:, :WIDTH]).all()
    assert (images[4] != images[9]).any()


def test_a_section_without_events_is_refused() -> None:
    options = FilmOptions(speed=1, fps=25, window_us=1, from_us=100)
    with pytest.raises(ScenarioError, match=r"no event between --from and --to.*0\.000050 s"):
        options.times_us(material((events_at(0, 50), ())))


def test_a_film_of_too_many_frames_is_refused() -> None:
    options = FilmOptions(speed=0.001, fps=120, window_us=1)
    with pytest.raises(ScenarioError, match=r"120,000,00. frames\. Allowed is up to 100,000"):
        options.times_us(material((events_at(0, 10**9), ())))


@pytest.mark.parametrize(
    ("speed", "text"),
    [(0.1, "1/10 speed"), (1, "real time"), (2, "2 × speed"), (0.3, "0.3 × speed")],
)
def test_the_speed_is_written_as_a_person_says_it(speed: float, text: str) -> None:
    assert speed_text(speed) == text


@pytest.fixture
def rrd(tmp_path: Path) -> Path:
    """Write a recording of two methods, the second with a region."""
    path = tmp_path / "recording.rrd"
    with FileRecorder(
        path,
        width=WIDTH,
        height=HEIGHT,
        method="mine:Own",
        has_maps=False,
        has_frames=True,
        name="title",
        parameters={"width": WIDTH, "height": HEIGHT},
        start_us=0,
    ) as recorder:
        recorder.log_events(events_at(0, 1500, 30_000))
        frame = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH)
        recorder.log_aps(ApsFrame(0, 2000, frame))
        for t_us, direction, region in (
            (10_000, Direction.LEFT, (1, 2, 30, 40)),
            (20_000, Direction.NONE, None),
        ):
            recorder.log_estimate(
                "mine:Own",
                MotionEstimate(
                    t_us=t_us,
                    hs=-0.5,
                    vs=0.25,
                    direction=direction,
                    strength=0.5,
                    response=(-0.5, 0.25),
                    roi_px=region,
                    view_centre_px=(9.0, 9.0),
                ),
            )
    return path


def test_a_rerun_recording_gives_back_what_was_recorded(rrd: Path) -> None:
    shown = rerun_material(rrd)
    assert (shown.name, shown.width, shown.height, shown.truth) == ("title", WIDTH, HEIGHT, None)
    events = np.concatenate([events for events, _ in shown.read()])
    assert events["t"].tolist() == [1000, 2000, 31_000]  # ends of the recording's milliseconds
    assert (events["x"].tolist(), events["p"].tolist()) == ([0, 1, 2], [True, False, True])
    ((end_us, image),) = [frame for _, frames in shown.read() for frame in frames]
    assert (end_us, image[1, 2]) == (2000, WIDTH + 2)
    estimates = shown.estimates
    assert estimates.method == "mine:Own"
    assert (estimates.hs.at(10_000), estimates.vs.at(10_000)) == (-0.5, 0.25)
    assert [estimates.direction.at(t) for t in (9_000, 10_000, 20_000)] == [None, "left", ""]
    assert [estimates.region.at(t) for t in (10_000, 20_000)] == [(1, 2, 30, 40), None]


def test_a_method_that_was_not_recorded_is_refused(rrd: Path) -> None:
    with pytest.raises(ScenarioError, match=r"--method is fly\. Allowed in .* is mine:Own\."):
        rerun_material(rrd, "fly")


def test_a_damaged_rerun_recording_is_refused(rrd: Path) -> None:
    rrd.write_bytes(rrd.read_bytes()[:100])
    with pytest.raises(ScenarioError, match=r"cannot be read|contains no events|does not state"):
        rerun_material(rrd)


def test_the_truth_is_read_from_the_table_of_a_run(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    assert read_truth(path) is None
    path.write_text(
        "t_us,direction,box_x0_px,box_y0_px,box_x1_px,box_y1_px\n0,right,,,,\n500,right,1,2,3,4\n",
        encoding="utf-8",
    )
    truth = read_truth(path)
    assert truth is not None
    assert (truth.direction.values, truth.box.values) == (["", "right"], [None, (1, 2, 3, 4)])


def test_no_events_at_all_are_a_short_film() -> None:
    seen = list(moments([(empty_events(), ())], [1, 2], 10))
    assert [moment.events.size for moment in seen] == [0, 0]
