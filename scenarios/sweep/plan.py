"""The points of a sweep, in order, each checked before anything is rendered."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flybench.errors import FlybenchError
from scenarios.errors import ScenarioError
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import make_crossing, make_detector
from scenarios.sweep.parameters import PRESET, SEED, Settings, make_config
from scenarios.sweep.sweep_file import MOST_POINTS, SweepFile, SweepFileError, read_sweep
from sim import Profile


@dataclass(frozen=True)
class Point:
    """One run of a sweep.

    Attributes:
        config: the run.
        labels: what the table says of it besides its parameters: names of levels, and of the
            sensor's preset where one was given.
        varied: the parameters that the grid, the sample and the seeds give it.
    """

    config: RunConfig
    labels: Mapping[str, str] = field(default_factory=dict)
    varied: Settings = field(default_factory=dict)


@dataclass(frozen=True)
class Plan:
    """What a sweep's file asks for.

    Attributes:
        points: every combination of the levels of all axes, the last axis fastest; within each,
            every draw; within that, every seed. What is drawn twice stands once.
        text: the file's.
    """

    points: tuple[Point, ...]
    text: str


def read_plan(path: Path) -> Plan:
    """The points of a sweep's file, each checked.

    Raises:
        SweepFileError: the file cannot be read, a value is out of range or does not go with
            another, there are too many points, or a detector that is not there.
    """
    file = read_sweep(path)
    try:
        points = _points(file)
        _check_runs([point.config for point in points])
    except FlybenchError as error:
        raise SweepFileError(f"{path}: {error}") from error
    return Plan(points, file.text)


def _points(file: SweepFile) -> tuple[Point, ...]:
    count = math.prod(len(axis) for axis in file.axes) * max(1, len(file.seeds))
    count *= file.sample.count if file.sample else 1
    if count > MOST_POINTS:
        raise ScenarioError(
            f"the sweep has {count:,} points; allowed are {MOST_POINTS:,}; give fewer levels or "
            "seeds, or a sample in place of a grid"
        )
    points: dict[tuple[RunConfig, tuple[str, ...]], Point] = {}
    for labels, named, varied in _combinations(file):
        given = dict(file.fixed) | named | varied
        own = labels | ({PRESET: given[PRESET]} if PRESET in given else {})
        point = Point(make_config(given), own, varied)
        points.setdefault((point.config, tuple(own.values())), point)
    return tuple(points.values())


def _combinations(
    file: SweepFile,
) -> Iterator[tuple[dict[str, str], dict[str, Any], dict[str, Any]]]:
    """Labels, what the levels that have them set, and what grid, sample and seeds set."""
    draws = file.sample.settings() if file.sample else [{}]
    seeds = [{SEED: seed} for seed in file.seeds] or [{}]
    for levels in itertools.product(*file.axes):
        labels = {name: text for level in levels for name, text in level.labels.items()}
        named = _merged(level.settings for level in levels if level.labels)
        grid = _merged(level.settings for level in levels if not level.labels)
        for drawn, seed in itertools.product(draws, seeds):
            yield labels, named, grid | dict(drawn) | seed


def _merged(all_settings: Iterable[Settings]) -> dict[str, Any]:
    return {name: value for settings in all_settings for name, value in settings.items()}


def _check_runs(configs: Sequence[RunConfig]) -> None:
    """Refuse what only shows when it is made: a detector, or a motion without an end."""
    detectors = {(c.method, c.fly, c.sensor.width, c.sensor.height): c for c in configs}
    for config in detectors.values():
        make_detector(config)
    turning = [c for c in configs if c.crossing.profile is Profile.CONSTANT_OMEGA]
    for config in {
        (c.crossing, c.sensor.width, c.sensor.height, c.sensor.focal_length_px): c for c in turning
    }.values():
        make_crossing(config)
