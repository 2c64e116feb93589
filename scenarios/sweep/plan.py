"""The points of a sweep, in order; every point is checked before anything is rendered."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flybench.errors import FlybenchError
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions
from scenarios.pipeline.run_config import RunConfig
from scenarios.pipeline.running import check_run_memory, make_crossing
from scenarios.sweep.parameters import PRESET, SEED, BaseSensor, Settings, make_config
from scenarios.sweep.sweep_file import MAX_POINTS, SweepFile, SweepFileError, read_sweep
from sim import Profile


@dataclass(frozen=True)
class Point:
    """One run of a sweep.

    Attributes:
        config: configuration of the run.
        labels: further columns of the table: names of levels, and the sensor's preset if the file
            sets one.
        varied: values that come from the grid, the sample and the seeds.
    """

    config: RunConfig
    labels: Mapping[str, str] = field(default_factory=dict)
    varied: Settings = field(default_factory=dict)


@dataclass(frozen=True)
class Plan:
    """All runs that a sweep file describes.

    Attributes:
        points: every combination of the levels of all axes, with the last axis varying fastest;
            within each combination every draw, and within each draw every seed. Equal points
            appear once.
        text: text of the file.
    """

    points: tuple[Point, ...]
    text: str


def read_plan(path: Path, sensor: SensorOptions | None = None) -> Plan:
    """Read a sweep file and return its points, all checked.

    Args:
        path: path of the file.
        sensor: the sensor of points that set no other preset; parameters of the file change it.
            None: the default.

    Raises:
        ScenarioError: the options of the sensor are wrong.
        SensorConfigError: the sensor is invalid.
        SweepFileError: the file cannot be read, a value is out of range or conflicts with another,
            there are too many points, or a detector does not exist.
    """
    base = None if sensor is None or sensor.is_default else BaseSensor.of(sensor)
    file = read_sweep(path)
    try:
        points = _points(file, base)
        _check_runs([point.config for point in points])
    except FlybenchError as error:
        raise SweepFileError(f"{path}: {error}") from error
    return Plan(points, file.text)


def _points(file: SweepFile, base: BaseSensor | None) -> tuple[Point, ...]:
    count = math.prod(len(axis) for axis in file.axes) * max(1, len(file.seeds))
    count *= file.sample.count if file.sample else 1
    if count > MAX_POINTS:
        raise ScenarioError(
            f"The sweep has {count:,} points. Allowed are {MAX_POINTS:,}. Choose fewer levels or "
            "seeds, or a sample instead of a grid."
        )
    points: dict[tuple[RunConfig, tuple[str, ...]], Point] = {}
    for level_labels, level_settings, varied in _combinations(file):
        settings = dict(file.fixed) | level_settings | varied
        labels = level_labels | ({PRESET: settings[PRESET]} if PRESET in settings else {})
        point = Point(make_config(settings, base), labels, varied)
        points.setdefault((point.config, tuple(labels.values())), point)
    return tuple(points.values())


def _combinations(
    file: SweepFile,
) -> Iterator[tuple[dict[str, str], dict[str, Any], dict[str, Any]]]:
    """Yield the labels, the settings of named levels, and those of grid, sample and seeds."""
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
    """Create every detector, and every crossing with constant angular velocity, to find errors now.

    The memory of every run is added up, too.

    Such a crossing may have no end, which no check of its parameters finds.
    """
    runs = {
        (c.method, c.fly, c.sensor.width, c.sensor.height, c.crossing.supersample): c
        for c in configs
    }
    for config in runs.values():
        check_run_memory(config)
    constant_omega = [c for c in configs if c.crossing.profile is Profile.CONSTANT_OMEGA]
    for config in {
        (c.crossing, c.sensor.width, c.sensor.height, c.sensor.focal_length_px): c
        for c in constant_omega
    }.values():
        make_crossing(config)
