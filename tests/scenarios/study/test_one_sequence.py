"""The progress of one sequence; `test_study` runs a rendered one."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from scenarios.pipeline.registry import FLY, FLY_EVERYWHERE, FRAME_FLY, SPIKING
from scenarios.recording import sequence_recorder
from scenarios.study import one_sequence
from scenarios.study.conditions import BACKGROUND_OMEGA_RAD_S, SECTION_US, Background
from scenarios.study.moving_backgrounds import in_front_of_moving_backgrounds
from scenarios.study.one_sequence import SequenceTask, evaluate_crossing
from scenarios.study.results import DEFAULT_SENSOR
from sim import Crossing, CrossingConfig, Lighting
from tests.scenarios.pipeline.drawn_samples import CROSSING, bar_samples

TASK = SequenceTask(CrossingConfig(), methods=(FLY, FRAME_FLY), seeds=(3,))


@pytest.mark.parametrize("ahead_us", [[], [0, 60_000, 148_500]])
def test_rendering_ahead_is_a_part_of_the_progress(
    monkeypatch: pytest.MonkeyPatch, ahead_us: list[int]
) -> None:
    monkeypatch.setattr(one_sequence, "make_crossing", lambda *_: CROSSING)
    monkeypatch.setattr(type(CROSSING), "render_ahead", lambda *_: iter(ahead_us))
    monkeypatch.setattr(type(CROSSING), "samples", lambda *_: bar_samples())
    progress: list[float] = []
    evaluate_crossing(TASK, lambda done, whole: progress.append(done / whole))
    assert progress == sorted(progress)
    assert len(progress) == len(ahead_us) + 100
    rendered_us = ahead_us[-1] if ahead_us else 0
    assert progress[len(ahead_us)] == rendered_us / (rendered_us + CROSSING.duration_us)


def test_a_slow_method_sees_the_first_sensors_only() -> None:
    task = SequenceTask(
        CrossingConfig(), methods=(FLY, SPIKING), seeds=(3, 8), high_threshold_seeds=(3,)
    )
    found = {key: [d.method for d in detectors] for key, detectors in task.all_detectors().items()}
    assert list(found.values()) == [[FLY, SPIKING], [FLY], [FLY, SPIKING]]
    assert list(found)[:2] == [(DEFAULT_SENSOR, 3), (DEFAULT_SENSOR, 8)]
    assert task.sensors[list(found)[2][0]].theta_on == 0.4


def test_each_lighting_has_four_moving_backgrounds_with_and_without_attention() -> None:
    tasks = [
        SequenceTask(CrossingConfig(lighting=at, omega_rad_s=v), (FLY, FRAME_FLY), (0, 1, 2, 3, 4))
        for at in (Lighting.DAY, Lighting.NIGHT)
        for v in (1.0, 2.0)
    ]
    moving = list(in_front_of_moving_backgrounds(tasks))
    assert [(t.crossing.lighting, t.background) for t in moving] == [
        (at, background) for at in (Lighting.DAY, Lighting.NIGHT) for background in Background
    ]
    assert {t.seeds for t in moving} == {(0, 1, 2)}
    assert {t.methods for t in moving} == {(FLY, FRAME_FLY, FLY_EVERYWHERE)}
    assert {t.crossing.omega_rad_s for t in moving} == set(
        map(BACKGROUND_OMEGA_RAD_S.get, (Lighting.DAY, Lighting.NIGHT))
    )
    assert moving[0].name == "day_1.61_wind"
    assert moving[0].crossing.distractors.wind_grade > 0
    last = moving[3].crossing.distractors
    assert (last.wind_grade > 0, last.far_vehicle.value, last.shakes) == (True, "opposite", True)


def test_only_the_middle_is_drawn_in_front_of_a_moving_background() -> None:
    task = SequenceTask(CrossingConfig(), methods=(FLY,), seeds=(3,))
    assert one_sequence._times_us(task, CROSSING) == CROSSING.times_us()
    (moving, *_) = in_front_of_moving_backgrounds([task])
    times_us = one_sequence._times_us(moving, CROSSING)
    assert set(times_us) < set(CROSSING.times_us())
    assert (times_us[0] + times_us[-1]) / 2 == pytest.approx(CROSSING.duration_us / 2, abs=3000)
    assert times_us[-1] - times_us[0] == pytest.approx(SECTION_US, abs=6000)


def test_a_recording_has_a_colour_preview_every_tenth_of_a_second(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    drawn: list[int] = []

    def preview_jpegs(_crossing: Crossing, times_us: Sequence[int]) -> list[bytes]:
        drawn.extend(times_us)
        return [b""] * len(times_us)

    monkeypatch.setattr(sequence_recorder, "preview_jpegs", preview_jpegs)
    with one_sequence._recorder(TASK, tmp_path / "day.rrd", CROSSING):
        pass
    assert drawn == list(range(0, CROSSING.duration_us + 1, 100_000))
