"""The tasks of the study with a moving background."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from scenarios.pipeline.registry import DETECTORS
from scenarios.study.conditions import FURTHER_SEEDS, Background, with_background
from scenarios.study.one_sequence import SequenceTask


def in_front_of_moving_backgrounds(tasks: Sequence[SequenceTask]) -> Iterator[SequenceTask]:
    """Yield one task of each lighting in front of every background, without a recording.

    Its methods are those of the task, and the flies among them without attention. Its sensors are
    the first few of the task.
    """
    for task in {task.crossing.lighting: task for task in tasks}.values():
        for background in Background:
            yield replace(
                task,
                crossing=with_background(task.crossing, background),
                methods=_with_and_without_attention(task.methods),
                background=background.value,
                seeds=task.seeds[:FURTHER_SEEDS],
                high_threshold_seeds=(),
                recording=None,
            )


def _with_and_without_attention(methods: Sequence[str]) -> tuple[str, ...]:
    blind = (DETECTORS[name].without_attention for name in methods if name in DETECTORS)
    return tuple(dict.fromkeys([*methods, *(name for name in blind if name is not None)]))
