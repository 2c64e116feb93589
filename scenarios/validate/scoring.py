"""Run a detector on a window, and count its right and wrong steps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from statistics import median

from detector.errors import DetectorConfigError
from detector.estimate import FrameDetector
from flybench.direction import Direction
from flybench.events import empty_events
from formats import Chunk
from scenarios.detect.run_detector import run_detector
from scenarios.detect.verdict import STILL, TOO_SHORT, RecordingVerdict, memory_us
from scenarios.pipeline.feeding import DetectorFeed
from scenarios.pipeline.user_detectors import find_method
from scenarios.validate.stimulus import Stimulus


@dataclass(frozen=True)
class Score:
    """Score of a method in a window, in one variant of it. A step is one estimate.

    Attributes:
        truth: true direction in this variant.
        steps: number of steps.
        right: steps with the true direction; if nothing moves, steps without one.
        wrong: steps with another direction; if nothing moves, None.
        none: steps without a direction; if nothing moves, None.
        false_alarms: steps with a direction if nothing moves; otherwise None.
        first_right_us: end of the first right step, after the start of the window [µs]; None
            without one, or if nothing moves.
        verdict: verdict of `flybench detect` on the window.
        note: why the method could not run; empty if it ran.
        failed: why the detector failed; the counts are then those until it failed, and no sum
            includes them. Empty if it did not fail.
    """

    truth: Direction
    steps: int = 0
    right: int = 0
    wrong: int | None = None
    none: int | None = None
    false_alarms: int | None = None
    first_right_us: int | None = None
    verdict: str = ""
    note: str = ""
    failed: str = ""

    @property
    def verdict_is_right(self) -> bool:
        """True if the verdict is the true direction, or that nothing moves."""
        return self.verdict == (STILL if self.truth is Direction.NONE else self.truth.value)


@dataclass(frozen=True)
class Total:
    """Sum of the scores that are complete; each share is None if no step counts for it.

    Attributes:
        steps: number of steps.
        right: share of right steps in all steps.
        wrong: share of wrong steps in the steps of windows with motion.
        none: share of steps without a direction in the same steps.
        false_alarms: share of steps with a direction in the steps of windows without motion.
        first_right_us: median of the first right steps [µs]; None without any.
        right_verdicts: number of right verdicts.
        verdicts: number of verdicts, without "too short to judge".
        too_short: number of windows that are too short to judge.
        note: why the method could not run in any, or failed in all; empty if one is complete.
    """

    steps: int
    right: float | None
    wrong: float | None
    none: float | None
    false_alarms: float | None
    first_right_us: float | None
    right_verdicts: int
    verdicts: int
    too_short: int
    note: str

    @classmethod
    def of(cls, scores: Iterable[Score]) -> Total:
        """Return the sum of some scores."""
        scores = list(scores)
        ran = [score for score in scores if not score.note and not score.failed]
        reasons = [score.note or score.failed for score in scores]
        moving = sum(s.steps for s in ran if s.truth is not Direction.NONE)
        still = sum(s.steps for s in ran if s.truth is Direction.NONE)
        first = [s.first_right_us for s in ran if s.first_right_us is not None]
        return cls(
            steps=moving + still,
            right=_share((s.right for s in ran), moving + still),
            wrong=_share((s.wrong for s in ran), moving),
            none=_share((s.none for s in ran), moving),
            false_alarms=_share((s.false_alarms for s in ran), still),
            first_right_us=median(first) if first else None,
            right_verdicts=sum(score.verdict_is_right for score in ran),
            verdicts=sum(score.verdict != TOO_SHORT for score in ran),
            too_short=sum(score.verdict == TOO_SHORT for score in ran),
            note="" if ran else " ".join(dict.fromkeys(reasons)),
        )


def _share(counts: Iterable[int | None], steps: int) -> float | None:
    return sum(count or 0 for count in counts) / steps if steps else None


def score(method: str, stimulus: Stimulus, truth: Direction) -> Score:
    """Run a fresh detector on a window and score its steps.

    The detector starts without a memory at the start of the window, so that its first steps have
    little to go by. All steps of the window count.

    Raises:
        MethodError: there is no such method, or it does not follow its protocol.
    """
    try:
        detector = find_method(method).make(width=stimulus.width, height=stimulus.height)
    except DetectorConfigError as error:
        return Score(truth, note=str(error))
    if isinstance(detector, FrameDetector) and not stimulus.frames:
        return Score(truth, note="The method needs APS frames, and the window has none.")
    feed = DetectorFeed(method, detector, width=stimulus.width, height=stimulus.height)
    return _score(feed, stimulus, truth)


def _score(feed: DetectorFeed, stimulus: Stimulus, truth: Direction) -> Score:
    verdict = RecordingVerdict(memory_us(feed.detector))
    first_right_us: int | None = None
    for part in run_detector(_chunks(stimulus), feed, until_us=stimulus.duration_us):
        verdict.add(part)
        for estimate in part.estimates:
            if estimate.direction is truth and first_right_us is None:
                first_right_us = int(estimate.t_us)
    failed = "" if feed.failure is None else str(feed.failure).removeprefix(f"{feed.method}: ")
    counts, moves = verdict.counts, truth is not Direction.NONE
    return Score(
        truth,
        steps=verdict.steps,
        right=counts[truth],
        wrong=verdict.moving - counts[truth] if moves else None,
        none=counts[Direction.NONE] if moves else None,
        false_alarms=None if moves else verdict.moving,
        first_right_us=first_right_us if moves else None,
        verdict=verdict.word,
        failed=failed,
    )


def _chunks(stimulus: Stimulus) -> Iterator[Chunk]:
    """Yield the chunks of a window; an empty one starts the detector's time with the window."""
    yield Chunk(empty_events())
    yield Chunk(stimulus.events, stimulus.frames)
