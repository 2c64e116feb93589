"""The progress of one sequence; `test_study` runs a rendered one."""

import pytest

from scenarios.pipeline.registry import FLY, FRAME_FLY
from scenarios.study import one_sequence
from scenarios.study.one_sequence import SequenceTask, evaluate_crossing
from sim import CrossingConfig
from tests.scenarios.pipeline.drawn_samples import CROSSING, bar_samples

TASK = SequenceTask(CrossingConfig(), methods=(FLY, FRAME_FLY), seeds=(3,))


@pytest.mark.parametrize("ahead_us", [[], [0, 60_000, 148_500]])
def test_rendering_ahead_is_a_part_of_the_progress(
    monkeypatch: pytest.MonkeyPatch, ahead_us: list[int]
) -> None:
    monkeypatch.setattr(one_sequence, "make_crossing", lambda *_: CROSSING)
    monkeypatch.setattr(type(CROSSING), "render_ahead", lambda _: iter(ahead_us))
    monkeypatch.setattr(type(CROSSING), "samples", lambda _: bar_samples())
    progress: list[float] = []
    evaluate_crossing(TASK, lambda done, whole: progress.append(done / whole))
    assert progress == sorted(progress)
    assert len(progress) == len(ahead_us) + 100
    rendered_us = ahead_us[-1] if ahead_us else 0
    assert progress[len(ahead_us)] == rendered_us / (rendered_us + CROSSING.duration_us)
