"""The sequences of a dataset; every one is drawn and checked before anything is rendered."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from emulator import SensorConfig, preset
from emulator.presets import PresetName
from emulator.sensor import sensor_bytes
from flybench.errors import FlybenchError
from flybench.memory import check_memory
from scenarios.dataset.draws import CROSSING, SENSOR, SENSOR_FILE, SPEED, Draws
from scenarios.dataset.ranges import split_ranges
from scenarios.dataset.scenes.model import ModelScene, take_digest
from scenarios.dataset.scenes.model_take import MODEL, ModelTake, model_take
from scenarios.dataset.sequence_plan import SENSOR_SEED, SequencePlan
from scenarios.dataset.spec_file import DatasetSpec, DatasetSpecError, read_spec
from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import PRESET, Settings, changed
from scenarios.sweep.random_sample import UNIFORM, Distribution
from sim import Crossing, CrossingConfig, Profile, SceneConfigError, omega_from_speed
from sim.config import RANGES
from sim.render.filament import rendering_bytes

_DEFAULT: PresetName = "davis346"


@dataclass(frozen=True)
class DatasetPlan:
    """All sequences of a dataset.

    Attributes:
        spec: the file.
        sequences: the sequences, split by split.
        ranges: what the parameters of each split are drawn from.
    """

    spec: DatasetSpec
    sequences: tuple[SequencePlan, ...]
    ranges: Mapping[str, Draws]


def read_plan(path: Path) -> DatasetPlan:
    """Read the file of a dataset, and draw and check its sequences. Nothing is rendered.

    Raises:
        DatasetSpecError: the file cannot be read, a value is out of range or conflicts with
            another, or a split cannot be disjoint.
    """
    spec = read_spec(path)
    try:
        ranges = split_ranges(spec)
        sequences = tuple(s for split in spec.counts for s in _sequences(spec, split, ranges))
        _check(sequences)
    except FlybenchError as error:
        raise DatasetSpecError(f"{path}: {error}") from error
    return DatasetPlan(spec, sequences, ranges)


def _sequences(
    spec: DatasetSpec, split: str, ranges: Mapping[str, Draws]
) -> Iterator[SequencePlan]:
    """Draw and check the sequences of a split. They do not depend on the number of any split."""
    count = spec.counts[split]
    seed = int.from_bytes(hashlib.sha256(f"{spec.seed} {split}".encode()).digest()[:8], "big")
    digests: dict[tuple[str, str], str] = {}
    variants = {
        name: ranges[split].with_changes(changes)
        for name, changes in (spec.variants or {"": Draws()}).items()
    }
    sensor_seeds = Distribution(SENSOR_SEED, UNIFORM, (0, 2**32 - 1)).draw(count, seed)
    columns = {
        name: {d.name: d.draw(count, seed) for d in draws.drawn} for name, draws in variants.items()
    }
    digits = max(4, len(str(count - 1)))
    for name, draws in variants.items():
        _check_bounds(spec, draws, {n: column[0] for n, column in columns[name].items()})
    for n in range(count):
        variant = list(variants)[n % len(variants)]
        drawn = {name: column[n] for name, column in columns[variant].items()}
        settings = dict(variants[variant].fixed) | drawn
        folder = f"{split}/{n:0{digits}d}"
        try:
            scene, sensor, sensor_name = _configs(spec, settings)
        except FlybenchError as error:
            raise ScenarioError(f"sequence {folder}: {error}") from error
        yield SequencePlan(
            split=split,
            number=n,
            name=folder,
            variant=variant,
            sensor_name=sensor_name,
            scene=scene,
            scene_digest=_digest(scene, digests),
            sensor=sensor,
            seed=sensor_seeds[n],
            labels=spec.labels,
            period_us=spec.period_us,
            drawn=tuple(drawn),
        )


def _digest(scene: CrossingConfig | ModelTake, known: dict[tuple[str, str], str]) -> str:
    """Return the digest of a model and its trajectory, computed once for each pair."""
    if isinstance(scene, CrossingConfig):
        return ""
    pair = scene.file, scene.trajectory
    if pair not in known:
        known[pair] = take_digest(scene)
    return known[pair]


def _configs(
    spec: DatasetSpec, settings: Settings
) -> tuple[CrossingConfig | ModelTake, SensorConfig, str]:
    """Return scene, sensor and the name of the sensor for these values."""
    file = settings.get(SENSOR_FILE)
    name = file or settings.get(PRESET, _DEFAULT)
    base = spec.sensors[file] if file else preset(name)
    scene: CrossingConfig | ModelTake
    if spec.is_model:
        of_model = {n: v for n, v in settings.items() if n.startswith(f"{MODEL}.")}
        scene = model_take(spec.path.parent.absolute(), of_model)
    else:
        scene = _crossing(settings)
    return scene, changed(base, SENSOR, settings), str(name)


def _crossing(settings: Settings) -> CrossingConfig:
    config = changed(CrossingConfig(), CROSSING, settings)
    speed_km_h = settings.get(SPEED)
    if speed_km_h is None:
        return config
    omega_rad_s, allowed = omega_from_speed(speed_km_h, config.distance), RANGES["omega_rad_s"]
    if not allowed.low <= omega_rad_s <= allowed.high:
        low, high = (omega * config.distance * 3.6 for omega in (allowed.low, allowed.high))
        raise ScenarioError(
            f"{SPEED} is {speed_km_h:g}, which is {omega_rad_s:.3g} rad/s at a distance of "
            f"{config.distance:g} m. Allowed there is {low:.3g} to {high:.3g} km/h. Choose a speed "
            "in that range."
        )
    return replace(config, omega_rad_s=omega_rad_s)


def _check_bounds(spec: DatasetSpec, draws: Draws, first: Settings) -> None:
    """Check both ends of every range, which perhaps no sequence draws."""
    settings = dict(draws.fixed) | dict(first)
    candidates = [
        settings | {distribution.name: value}
        for distribution in draws.drawn
        for value in dict.fromkeys(distribution.values)
    ]
    for candidate in (*candidates, settings):
        scene, sensor, _ = _configs(spec, candidate)
        if isinstance(scene, ModelTake):
            ModelScene(scene, sensor.width, sensor.height).check(spec.labels)


def _check(sequences: tuple[SequencePlan, ...]) -> None:
    """Check the memory of every kind of sensor, and motions that may have no end."""
    kinds = {(s.sensor.width, s.sensor.height, s.scene.supersample): s for s in sequences}
    for kind in kinds.values():
        needed = sensor_bytes(kind.sensor) + rendering_bytes(kind.lens, kind.scene.supersample)
        check_memory(
            f"Rendering and emulation of {kind.sensor.width}×{kind.sensor.height} px", needed
        )
    for sequence in sequences:
        scene = sequence.scene
        if isinstance(scene, CrossingConfig) and scene.profile is Profile.CONSTANT_OMEGA:
            try:
                Crossing(scene, sequence.lens)
            except SceneConfigError as error:
                raise ScenarioError(
                    f"sequence {sequence.name}: crossing.lead_s is {scene.lead_s:g}: {error}"
                ) from error
