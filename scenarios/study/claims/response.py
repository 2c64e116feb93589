"""The paper's claims of how responses compare: their strength, velocity, frames and time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import fmean

from scipy.stats import spearmanr

from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.claims.claim import (
    DAY,
    NIGHT,
    Claim,
    Verdict,
    by_sequence,
    graded,
    not_tested,
    paper_frame_fly,
    slowest_first,
    told,
)
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, each, interval_of, mean_interval, select

VARIATION, STRENGTH = "response_variation", "response_mean"
FEW_FPS = 10.0
"""The paper's bound."""
MUCH = 10.0
"""How many times faster counts as much: an order of magnitude (assumed)."""
_LEAST_SPEEDS = 3


def fly_is_steadier(rows: Sequence[Row]) -> Claim:
    """Section III: clearer and more stable than frames."""
    return _frames_against_fly(
        "the event-driven fly's response is steadier than the frame-based model's",
        _pairs(rows, VARIATION, where_missing=float("inf")),
        lambda fly, frames: fly < frames,
        "Standard deviation of the settled response over its mean, of the fly and of the "
        "frame-based one: {pairs}; less in {good} sequences.",
    )


def frames_are_weaker(rows: Sequence[Row]) -> Claim:
    """Section III: frame-based responses are generally weaker."""
    return _frames_against_fly(
        "the frame-based model's response is weaker than the event-driven fly's",
        _pairs(rows, STRENGTH, where_missing=0.0),
        lambda fly, frames: frames < fly,
        "Mean settled response along the true direction, of the fly and of the frame-based one, "
        "each normalised by a sigmoid of its own scale: {pairs}; the latter less in {good} "
        "sequences.",
    )


def _frames_against_fly(
    statement: str,
    pairs: Mapping[str, tuple[float, float]],
    holds: Callable[[float, float], bool],
    evidence: str,
) -> Claim:
    """A claim on each sequence's pair of fly and frames; `evidence` has {pairs} and {good}."""
    where = "Section III, Fig. EX1 and EX2"
    if not pairs:
        return not_tested(statement, where, "no run of both flies")
    good = sum(holds(fly, frames) for fly, frames in pairs.values())
    told_pairs = ", ".join(f"{n} {_number(a)} and {_number(b)}" for n, (a, b) in pairs.items())
    told_evidence = evidence.format(pairs=told_pairs, good=f"{good} of {len(pairs)}")
    return Claim(statement, where, graded(good / len(pairs)), told_evidence)


def frames_are_weak_when_slow(rows: Sequence[Row]) -> Claim:
    """Section III: 1.21 rad/s."""
    statement = "at the lowest velocity by day frames give but a weak response, events a clear one"
    where, day = "Section III, Fig. EX1", select(rows, lighting=DAY)
    frames = select(day, method=paper_frame_fly(rows))
    flies = select(day, method=FLY)
    names = slowest_first(frames)
    if len(names) < _LEAST_SPEEDS or not flies:
        return not_tested(statement, where, "too few velocities of both flies by day")
    strength = {n: v.mean for n, v in by_sequence(frames, STRENGTH).items() if v is not None}
    slow, others = strength.get(names[0], 0.0), [strength.get(n, 0.0) for n in names[1:]]
    fly = interval_of(select(flies, sequence=names[0]), "accuracy_after_100ms")
    weak, clear = slow < min(others), fly is not None and fly.mean >= 0.5
    evidence = (
        f"At {names[0].partition('_')[2]} rad/s the frame-based response is {slow:.2g}, at higher "
        f"velocities {', '.join(f'{v:.2g}' for v in others)}; the event-driven fly is right in "
        f"{told(fly, '%')} of the steps there."
    )
    return Claim(statement, where, graded((weak + clear) / 2 if clear else 0.0), evidence)


def frames_get_uneven(rows: Sequence[Row]) -> Claim:
    """Section III: less smooth as velocity rises."""
    statement = "the frame-based response gets less smooth as velocity rises by day"
    own = select(rows, method=paper_frame_fly(rows), lighting=DAY)
    return _rises(own, VARIATION, statement, "Section III, Fig. EX1 B", "relative deviation")


def grms_rises(rows: Sequence[Row]) -> Claim:
    """Fig. EX3 B."""
    statement = "the event-driven fly's GRMS generally rises with velocity"
    own = select(rows, method=FLY)
    return _rises(own, "grms", statement, "Section III, Fig. EX3 B", "GRMS in 1/s")


def contrast_knows_velocity(rows: Sequence[Row]) -> Claim:
    """Fig. EX3 A."""
    statement = "the velocities of contrast maximisation rise with velocity"
    own = [
        row | {"said_px_s": row["image_speed_px_s"] + row["velocity_bias_px_s"]}
        for row in select(rows, method=CONTRAST)
        if row["velocity_bias_px_s"] is not None
    ]
    claim = _rises(own, "said_px_s", statement, "Section III, Fig. EX3 A", "mean velocity in px/s")
    if claim.holds == "not tested":
        return claim
    error = interval_of(own, "velocity_error_px_s")
    more = f"{claim.evidence} The root mean square error is {told(error, 'px/s')}."
    return Claim(claim.statement, claim.where, claim.holds, more)


def _rises(rows: Sequence[Row], column: str, statement: str, where: str, what: str) -> Claim:
    """Holds where the means rise at every step by every light; in part where by rank by any."""
    ranks: dict[str, float] = {}
    parts = []
    for light in each(rows, "lighting"):
        own = select(rows, lighting=light)
        found = by_sequence(own, column)
        means = [v.mean for n in slowest_first(own) if (v := found[n]) is not None]
        if len(means) >= _LEAST_SPEEDS and len(set(means)) > 1:
            ranks[light] = float(spearmanr(range(len(means)), means).statistic)
            series = ", ".join(f"{mean:.3g}" for mean in means)
            parts.append(f"by {light} {series} (rank correlation {ranks[light]:.2f})")
    if not ranks:
        return not_tested(statement, where, "too few velocities")
    evidence = f"From the lowest velocity to the highest, {what}: {'; '.join(parts)}."
    return Claim(statement, where, _of_ranks(list(ranks.values())), evidence)


def _of_ranks(ranks: Sequence[float]) -> Verdict:
    if min(ranks) > 1.0 - 1e-9:
        return "holds"
    return "holds in part" if max(ranks) > 0.0 else "does not hold"


def frames_are_few_by_night(rows: Sequence[Row]) -> Claim:
    """Caption of Fig. EX2."""
    statement = f"by night the APS gives fewer than {FEW_FPS:g} frames a second"
    where, own = "Caption of Fig. EX2", select(rows, method=paper_frame_fly(rows))
    night, day = (_rates(select(own, lighting=light)) for light in (NIGHT, DAY))
    if not night:
        return not_tested(statement, where, "no run of the frame-based fly by night")
    few = [rate for rate in night.values() if rate < FEW_FPS]
    evidence = f"It gives {_span(night)} frames a second by night"
    evidence += f" and {_span(day)} by day." if day else "."
    return Claim(statement, where, graded(len(few) / len(night)), evidence)


def _rates(rows: Sequence[Row]) -> dict[str, float]:
    """Frames a second by sequence; the first frame of a run makes no estimate."""
    found: dict[str, list[float]] = {}
    for row in rows:
        rate = (row["estimates"] + 1) / row["duration_s"]
        found.setdefault(row["sequence"], []).append(rate)
    return {name: fmean(rates) for name, rates in found.items()}


def _span(rates: dict[str, float]) -> str:
    low, high = min(rates.values()), max(rates.values())
    return f"{low:.1f}" if f"{low:.1f}" == f"{high:.1f}" else f"{low:.1f} to {high:.1f}"


def fly_is_faster(rows: Sequence[Row]) -> Claim:
    """Fig. EX3 D."""
    statement = "the event-driven fly takes much less time than contrast maximisation"
    where = "Section III, Fig. EX3 D"
    ratios = {
        column: _ratio(rows, column, CONTRAST, FLY)
        for column in ("ms_per_estimate", "ns_per_event")
    }
    by_estimate, by_event = ratios.values()
    if by_estimate is None or by_event is None:
        return not_tested(statement, where, "no run of both methods")
    least = min(by_estimate.mean, by_event.mean)
    rest: Verdict = "holds in part" if least > 1.0 else "does not hold"
    times = " and ".join(
        f"{told(interval_of(select(rows, method=m), 'ms_per_estimate'), 'ms')} by {name}"
        for m, name in ((FLY, "the fly"), (CONTRAST, "contrast maximisation"))
    )
    evidence = (
        f"An estimate takes {times} on one core, {told(by_estimate)} times as long; all estimates "
        f"over the same events take {told(by_event)} times as long, since contrast maximisation "
        "makes fewer."
    )
    return Claim(statement, where, "holds" if least >= MUCH else rest, evidence)


def fly_is_real_time(rows: Sequence[Row]) -> Claim:
    """Abstract: real-time implementation."""
    statement, where = "the event-driven fly is fit for real time", "Abstract"
    own = [row | {"load": row["cpu_s"] / row["duration_s"]} for row in select(rows, method=FLY)]
    if not own:
        return not_tested(statement, where, "no run of the fly")
    good = [row for row in own if row["load"] < 1.0]
    most = max(float(row["load"]) for row in own)
    evidence = (
        f"It takes {told(interval_of(own, 'load'), 's')} of one core a second of the stream on "
        f"this machine, at most {most:.3g} s, at 100 estimates a second."
    )
    return Claim(statement, where, graded(len(good) / len(own)), evidence)


def _pairs(
    rows: Sequence[Row], column: str, *, where_missing: float
) -> dict[str, tuple[float, float]]:
    """Means of the fly and of the frame-based one by sequence, where both ran."""
    fly, frames = (
        by_sequence(select(rows, method=method), column) for method in (FLY, paper_frame_fly(rows))
    )
    mean: Callable[[Interval | None], float] = lambda i: where_missing if i is None else i.mean  # noqa: E731
    return {name: (mean(fly[name]), mean(frames[name])) for name in fly if name in frames}


def _ratio(rows: Sequence[Row], column: str, over: str, under: str) -> Interval | None:
    """How many times one method's figure is another's, by seed and sequence, over the seeds."""
    known = {(r["sequence"], r["seed"]): r[column] for r in select(rows, method=under)}
    found: dict[int, list[float]] = {}
    for row in select(rows, method=over):
        if below := known.get((row["sequence"], row["seed"])):
            found.setdefault(row["seed"], []).append(row[column] / below)
    return mean_interval([fmean(ratios) for ratios in found.values()])


def _number(value: float) -> str:
    return "none" if value == float("inf") else f"{value:.2g}"
