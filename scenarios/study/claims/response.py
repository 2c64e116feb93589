"""The paper's claims about the strength of responses, velocities, frame rates and CPU time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from statistics import fmean

from scenarios.output.numbers import plain_number
from scenarios.pipeline.registry import CONTRAST, FLY
from scenarios.study.claims.claim import (
    DAY,
    NIGHT,
    Claim,
    Verdict,
    format_interval,
    mean_by_sequence,
    mean_texts,
    not_tested,
    published_frame_fly,
    slowest_first,
    verdict_from_share,
)
from scenarios.study.claims.small_table import SmallTable, tables_by_velocity
from scenarios.study.rows import Row
from scenarios.study.statistics import Interval, distinct, interval_of, mean_interval, select
from scenarios.styles.method_style import method_style
from scenarios.velocity_sweep.grms import spearman

VARIATION, STRENGTH = "response_variation", "response_mean"
FEW_FPS = 10.0
"""The paper's bound on the frame rate at night [Hz]."""
MUCH_FASTER = 10.0
"""Ratio of times that counts as much faster: an order of magnitude (assumed)."""
_FEWEST_SPEEDS = 3
_WHEN = {DAY: "by day", NIGHT: "at night"}


def fly_is_steadier(rows: Sequence[Row]) -> Claim:
    """Test Section III: clearer and more stable than frames."""
    return _frames_against_fly(
        "the event-driven fly's response is steadier than the frame-based model's",
        _pairs(rows, VARIATION, where_missing=float("inf")),
        lambda fly, frames: fly < frames,
        published_frame_fly(rows),
        "deviation / mean",
        "The standard deviation of the settled response over its mean is smaller for the "
        "event-driven fly in {good} sequences.",
    )


def frames_are_weaker(rows: Sequence[Row]) -> Claim:
    """Test Section III: frame-based responses are generally weaker."""
    return _frames_against_fly(
        "the frame-based model's response is weaker than the event-driven fly's",
        _pairs(rows, STRENGTH, where_missing=0.0),
        lambda fly, frames: frames < fly,
        published_frame_fly(rows),
        "mean response",
        "The mean settled response along the true direction is smaller for the frame-based fly in "
        "{good} sequences. Each method normalises it by a sigmoid with its own scale.",
    )


def _frames_against_fly(
    statement: str,
    pairs: Mapping[str, tuple[float, float]],
    holds: Callable[[float, float], bool],
    frame_fly: str,
    what: str,
    evidence: str,
) -> Claim:
    """Test a claim that compares the event-driven with the frame-based fly in each sequence.

    Args:
        statement: the claim.
        pairs: values of the event-driven and of the frame-based fly, by sequence.
        holds: returns True if a pair agrees with the claim.
        frame_fly: name of the frame-based method.
        what: name of the values.
        evidence: format string with {good}.
    """
    where = "Section III, Fig. EX1 and EX2"
    if not pairs:
        return not_tested(statement, where, "no run of both flies")
    good = sum(holds(fly, frames) for fly, frames in pairs.values())
    text = evidence.format(good=f"{good} of {len(pairs)}")
    values = {
        method_style(method).label: {name: _number(pair[k]) for name, pair in pairs.items()}
        for k, method in enumerate((FLY, frame_fly))
    }
    tables = tables_by_velocity(what, values)
    return Claim(statement, where, verdict_from_share(good / len(pairs)), text, tables)


def frames_are_weak_when_slow(rows: Sequence[Row]) -> Claim:
    """Test Section III: 1.21 rad/s."""
    statement = "by day, at the lowest velocity, frames give a weak response and events a clear one"
    where, day = "Section III, Fig. EX1", select(rows, lighting=DAY)
    frames = select(day, method=published_frame_fly(rows))
    flies = select(day, method=FLY)
    names, method = slowest_first(frames), published_frame_fly(rows)
    if len(names) < _FEWEST_SPEEDS or not flies:
        return not_tested(statement, where, "too few velocities of both flies by day")
    strength = {n: v.mean for n, v in mean_by_sequence(frames, STRENGTH).items() if v is not None}
    slow, others = strength.get(names[0], 0.0), [strength.get(n, 0.0) for n in names[1:]]
    fly = interval_of(select(flies, sequence=names[0]), "accuracy_after_100ms")
    weak, clear = slow < min(others), fly is not None and fly.mean >= 0.5
    evidence = (
        f"The frame-based response at {names[0].partition('_')[2]} rad/s is "
        f"{'weaker than' if weak else 'not weaker than'} at every higher velocity. There the "
        f"event-driven fly is correct in {format_interval(fly, '%')} of the steps."
    )
    values = {method_style(method).label: {n: _number(strength.get(n, 0.0)) for n in names}}
    verdict = verdict_from_share((weak + clear) / 2 if clear else 0.0)
    tables = tables_by_velocity("mean response", values)
    return Claim(statement, where, verdict, evidence, tables)


def frame_response_less_smooth(rows: Sequence[Row]) -> Claim:
    """Test Section III: less smooth as velocity rises."""
    statement = "by day the frame-based response becomes less smooth as velocity rises"
    method, where = published_frame_fly(rows), "Section III, Fig. EX1 B"
    own = select(rows, method=method, lighting=DAY)
    return _rises(own, method, VARIATION, statement, where, "deviation / mean")


def grms_rises(rows: Sequence[Row]) -> Claim:
    """Test Fig. EX3 B."""
    statement = "the event-driven fly's GRMS generally rises with velocity"
    own = select(rows, method=FLY)
    return _rises(own, FLY, "grms", statement, "Section III, Fig. EX3 B", "GRMS [1/s]")


def contrast_velocity_rises(rows: Sequence[Row]) -> Claim:
    """Test Fig. EX3 A."""
    statement = "the velocities estimated by contrast maximisation rise with the true velocity"
    own = [
        row | {"estimated_px_s": row["image_speed_px_s"] + row["velocity_bias_px_s"]}
        for row in select(rows, method=CONTRAST)
        if row["velocity_bias_px_s"] is not None
    ]
    where, what = "Section III, Fig. EX3 A", "mean velocity [px/s]"
    claim = _rises(own, CONTRAST, "estimated_px_s", statement, where, what)
    if claim.holds == "not tested":
        return claim
    error = interval_of(own, "velocity_error_px_s")
    more = f"{claim.evidence} The root mean square error is {format_interval(error, 'px/s')}."
    return replace(claim, evidence=more)


def _rises(
    rows: Sequence[Row], method: str, column: str, statement: str, where: str, what: str
) -> Claim:
    """Test a claim that a column rises with velocity.

    It holds if the means rise at every step in every lighting, and in part if the rank correlation
    is positive in any lighting.
    """
    ranks: dict[str, float] = {}
    shown: dict[str, str] = {}
    for lighting in distinct(rows, "lighting"):
        own = select(rows, lighting=lighting)
        found = mean_by_sequence(own, column)
        means = [v.mean for n in slowest_first(own) if (v := found[n]) is not None]
        rank = spearman(range(len(means)), means)
        if rank is not None and len(means) >= _FEWEST_SPEEDS:
            ranks[lighting] = rank
            shown |= mean_texts({n: found[n] for n in slowest_first(own)})
    if not ranks:
        return not_tested(statement, where, "too few velocities")
    correlations = ", ".join(f"{rank:.2g} {_WHEN[name]}" for name, rank in ranks.items())
    evidence = f"The rank correlation with velocity is {correlations}."
    tables = tables_by_velocity(what, {method_style(method).label: shown})
    return Claim(statement, where, _verdict_from_ranks(list(ranks.values())), evidence, tables)


def _verdict_from_ranks(ranks: Sequence[float]) -> Verdict:
    if min(ranks) > 1.0 - 1e-9:
        return "holds"
    return "holds in part" if max(ranks) > 0.0 else "does not hold"


def frames_are_few_at_night(rows: Sequence[Row]) -> Claim:
    """Test the caption of Fig. EX2."""
    statement = f"at night the APS gives fewer than {FEW_FPS:g} frames per second"
    where, own = "Caption of Fig. EX2", select(rows, method=published_frame_fly(rows))
    night, day = (_frame_rates(select(own, lighting=lighting)) for lighting in (NIGHT, DAY))
    if not night:
        return not_tested(statement, where, "no run of the frame-based fly at night")
    few = [rate for rate in night.values() if rate < FEW_FPS]
    evidence = f"It gives {_range(night)} frames per second at night"
    evidence += f" and {_range(day)} by day." if day else "."
    return Claim(statement, where, verdict_from_share(len(few) / len(night)), evidence)


def _frame_rates(rows: Sequence[Row]) -> dict[str, float]:
    """Return the frames per second by sequence; the first frame of a run gives no estimate."""
    found: dict[str, list[float]] = {}
    for row in rows:
        rate = (row["estimates"] + 1) / row["duration_s"]
        found.setdefault(row["sequence"], []).append(rate)
    return {name: fmean(rates) for name, rates in found.items()}


def _range(rates: dict[str, float]) -> str:
    low, high = min(rates.values()), max(rates.values())
    return f"{low:.1f}" if f"{low:.1f}" == f"{high:.1f}" else f"{low:.1f} to {high:.1f}"


def fly_is_faster(rows: Sequence[Row]) -> Claim:
    """Test Fig. EX3 D."""
    statement = "the event-driven fly needs much less time than contrast maximisation"
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
    fly_ms, contrast_ms = (
        format_interval(interval_of(select(rows, method=method), "ms_per_estimate"), "ms")
        for method in (FLY, CONTRAST)
    )
    evidence = (
        f"On one core an estimate takes the fly {fly_ms}, and contrast maximisation {contrast_ms}, "
        f"{format_interval(by_estimate, digits=2)} times as long. For the same events, contrast "
        f"maximisation takes {format_interval(by_event, digits=2)} times as long, since it makes "
        "fewer estimates."
    )
    return Claim(
        statement, where, "holds" if least >= MUCH_FASTER else rest, evidence, (_times(rows),)
    )


def _times(rows: Sequence[Row]) -> SmallTable:
    """Return the CPU time of both methods, by estimate and by event."""
    columns = ("ms_per_estimate", "ns_per_event")
    lines = tuple(
        (
            method_style(method).label,
            tuple(
                format_interval(interval_of(select(rows, method=method), column)).split(" (")[0]
                for column in columns
            ),
        )
        for method in (FLY, CONTRAST)
    )
    return SmallTable("CPU time", "method", ("per estimate [ms]", "per event [ns]"), lines)


def fly_is_real_time(rows: Sequence[Row]) -> Claim:
    """Test the abstract: real-time implementation."""
    statement, where = "the event-driven fly runs in real time", "Abstract"
    own = [row | {"load": row["cpu_s"] / row["duration_s"]} for row in select(rows, method=FLY)]
    if not own:
        return not_tested(statement, where, "no run of the fly")
    good = [row for row in own if row["load"] < 1.0]
    most = max(float(row["load"]) for row in own)
    evidence = (
        f"For each second of the stream it needs {format_interval(interval_of(own, 'load'), 's')} "
        f"of one core of this machine, at most {plain_number(most)} s, with 100 "
        "estimates per second."
    )
    return Claim(statement, where, verdict_from_share(len(good) / len(own)), evidence)


def _pairs(
    rows: Sequence[Row], column: str, *, where_missing: float
) -> dict[str, tuple[float, float]]:
    """Return the means of the event-driven and of the frame-based fly, by sequence.

    Args:
        rows: the table.
        column: column to average.
        where_missing: value for a sequence without a mean.
    """
    fly, frames = (
        mean_by_sequence(select(rows, method=method), column)
        for method in (FLY, published_frame_fly(rows))
    )

    def mean(interval: Interval | None) -> float:
        return where_missing if interval is None else interval.mean

    return {name: (mean(fly[name]), mean(frames[name])) for name in fly if name in frames}


def _ratio(rows: Sequence[Row], column: str, over: str, under: str) -> Interval | None:
    """Return the ratio of two methods in a column, paired by sequence, over the seeds.

    Args:
        rows: the table.
        column: column to compare.
        over: method in the numerator.
        under: method in the denominator.
    """
    known = {(r["sequence"], r["seed"]): r[column] for r in select(rows, method=under)}
    found: dict[int, list[float]] = {}
    for row in select(rows, method=over):
        if below := known.get((row["sequence"], row["seed"])):
            found.setdefault(row["seed"], []).append(row[column] / below)
    return mean_interval([fmean(ratios) for ratios in found.values()])


def _number(value: float) -> str:
    return "none" if value == float("inf") else plain_number(value, 2)
