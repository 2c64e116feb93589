"""The results of a study, and the methods that failed."""

from dataclasses import replace

from scenarios.pipeline.registry import CONTRAST, FLY, FRAME_FLY
from scenarios.study.results import SequenceResult, without_failed
from tests.scenarios.study.synthetic_results import make_sequence


def failing(sequence: SequenceResult, method: str) -> SequenceResult:
    runs = (
        replace(run, failure=f"{run.method}: no wind") if run.method == method else run
        for run in sequence.runs
    )
    return replace(sequence, runs=tuple(runs))


def test_a_method_that_failed_in_one_sequence_is_left_out_of_all() -> None:
    sequences = [make_sequence(), failing(make_sequence(omega_rad_s=2.42), CONTRAST)]
    kept, failed = without_failed(sequences)
    assert failed == {CONTRAST: f"{CONTRAST}: no wind (sequence day_2.42)"}
    assert [{run.method for run in sequence.runs} for sequence in kept] == [{FLY, FRAME_FLY}] * 2
    assert len(kept[0].runs) == 6


def test_without_a_failure_nothing_is_left_out() -> None:
    sequences = [make_sequence()]
    assert without_failed(sequences) == (sequences, {})
