"""The sequences of a dataset; every one is drawn and checked before anything is rendered."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

from emulator import SensorConfig, preset
from emulator.presets import PresetName
from emulator.sensor import sensor_bytes
from flybench.errors import FlybenchError
from flybench.memory import check_memory
from flybench.sources import sources_digest
from scenarios.dataset.draws import SENSOR_FILE, Draws
from scenarios.dataset.labels.kinds import Label
from scenarios.dataset.spec_file import DatasetSpec, DatasetSpecError, read_spec
from scenarios.dataset.splits import SHORT_NAMES, VEHICLE, divide
from scenarios.errors import ScenarioError
from scenarios.output.versions import versions
from scenarios.pipeline.run_config import flatten
from scenarios.sweep.parameters import PRESET, Settings, changed, check_name
from scenarios.sweep.random_sample import UNIFORM, Distribution
from sim import Crossing, CrossingConfig, Intrinsics, Profile
from sim.render.filament import rendering_bytes

SENSOR_SEED = "seed"
_FAR_KIND = "crossing.distractors.far_vehicle_kind"
_ALWAYS_DRAWN = ("crossing.street_seed", "crossing.distractors.seed")
"""Seeds that differ from sequence to sequence, unless the file sets them."""
_DEFAULT: PresetName = "davis346"
_SOURCES = (
    "flybench",
    "sim",
    "emulator",
    "formats/writers",
    "scenarios/dataset/labels",
    "scenarios/dataset/layout.py",
    "scenarios/dataset/sequence.py",
)
"""Sources that determine the files of a sequence."""


@dataclass(frozen=True)
class SequencePlan:
    """Everything that determines the files of one sequence.

    Attributes:
        split: name of its split.
        number: its number in the split, from 0 on.
        name: path of its folder in the dataset, such as "train/0000".
        variant: name of its variant; empty if there are none.
        sensor_name: preset or file of the sensor.
        crossing: the scene and its motion.
        sensor: the event camera.
        seed: seed of the sensor.
        labels: labels to write.
        period_us: time between labels [µs].
        drawn: names of the parameters that are drawn.
    """

    split: str
    number: int
    name: str
    variant: str
    sensor_name: str
    crossing: CrossingConfig
    sensor: SensorConfig
    seed: int
    labels: tuple[Label, ...]
    period_us: int
    drawn: tuple[str, ...] = ()

    @property
    def lens(self) -> Intrinsics:
        """Lens and sensor for the renderer."""
        return Intrinsics(self.sensor.width, self.sensor.height, self.sensor.focal_length_px)

    def parameters(self) -> dict[str, object]:
        """Return every parameter by its dotted name, such as "crossing.omega_rad_s"."""
        tables = {"crossing": self.crossing.resolved(), "sensor": asdict(self.sensor)}
        return {PRESET: self.sensor_name} | dict(flatten(tables)) | {SENSOR_SEED: self.seed}

    def key(self) -> str:
        """Return a digest of everything that determines the files, except the machine."""
        inputs = {
            "parameters": self.parameters(),
            "labels": self.labels,
            "period_us": self.period_us,
            "code": code_digest(),
        }
        return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


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


@cache
def code_digest() -> str:
    """Return a digest of this process's versions and of the sources that determine a sequence."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    digest.update(sources_digest(*_SOURCES).encode())
    return digest.hexdigest()


def read_plan(path: Path) -> DatasetPlan:
    """Read the file of a dataset, and draw and check its sequences. Nothing is rendered.

    Raises:
        DatasetSpecError: the file cannot be read, a value is out of range or conflicts with
            another, or a split cannot be disjoint.
    """
    spec = read_spec(path)
    try:
        ranges = _ranges(spec)
        sequences = tuple(s for split in spec.counts for s in _sequences(spec, split, ranges))
        _check(sequences)
    except FlybenchError as error:
        raise DatasetSpecError(f"{path}: {error}") from error
    return DatasetPlan(spec, sequences, ranges)


def _ranges(spec: DatasetSpec) -> dict[str, Draws]:
    """Return what each split draws from, with values of disjoint parameters divided."""
    base = spec.base
    set_in_variants = {name for draws in spec.variants.values() for name in draws.names}
    missing = [n for n in _ALWAYS_DRAWN if n not in base.names | set_in_variants]
    seeds = tuple(Distribution(name, UNIFORM, (0, 2**32 - 1)) for name in missing)
    base = replace(base, drawn=base.drawn + seeds)
    ranges = dict.fromkeys(spec.counts, base)
    for given in spec.disjoint:
        name = SHORT_NAMES.get(given, given)
        check_name(name)
        distribution = next((d for d in base.drawn if d.name == name), None)
        if distribution is None or name in set_in_variants:
            place = "in [[variants]]" if name in set_in_variants else "not drawn"
            raise ScenarioError(
                f"splits.disjoint holds {given!r}, and {name} is {place}. Allowed are parameters "
                f"that are drawn for all sequences. Write {name} = {{choice = [one, another]}} in "
                f"[{name.split('.')[0]}], or remove it from the list."
            )
        parts = divide(distribution, spec.counts)
        for split, part in parts.items():
            changes = (part, *_far_kinds(given, part, spec, set_in_variants))
            ranges[split] = ranges[split].with_changes(Draws({}, changes))
    return ranges


def _far_kinds(
    given: str, part: Distribution, spec: DatasetSpec, in_variants: set[str]
) -> list[Distribution]:
    """Return the kinds of the second vehicle, which must not be those of other splits either."""
    if given not in (VEHICLE, SHORT_NAMES[VEHICLE]):
        return []
    if _FAR_KIND in spec.base.names | in_variants:
        raise ScenarioError(
            f"splits.disjoint holds {given!r}, and {_FAR_KIND} is set. It is then drawn from the "
            f"vehicles of each split. Remove {_FAR_KIND}, or {given!r} from the list."
        )
    return [Distribution(_FAR_KIND, part.kind, part.values)]


def _sequences(
    spec: DatasetSpec, split: str, ranges: Mapping[str, Draws]
) -> Iterator[SequencePlan]:
    """Draw and check the sequences of a split. They do not depend on the number of any split."""
    count = spec.counts[split]
    seed = int.from_bytes(hashlib.sha256(f"{spec.seed} {split}".encode()).digest()[:8], "big")
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
            crossing, sensor, sensor_name = _configs(spec, settings)
        except FlybenchError as error:
            raise ScenarioError(f"sequence {folder}: {error}") from error
        yield SequencePlan(
            split=split,
            number=n,
            name=folder,
            variant=variant,
            sensor_name=sensor_name,
            crossing=crossing,
            sensor=sensor,
            seed=sensor_seeds[n],
            labels=spec.labels,
            period_us=spec.period_us,
            drawn=tuple(drawn),
        )


def _configs(spec: DatasetSpec, settings: Settings) -> tuple[CrossingConfig, SensorConfig, str]:
    """Return scene, sensor and the name of the sensor for these values."""
    file = settings.get(SENSOR_FILE)
    name = file or settings.get(PRESET, _DEFAULT)
    base = spec.sensors[file] if file else preset(name)
    return (
        changed(CrossingConfig(), "crossing", settings),
        changed(base, "sensor", settings),
        str(name),
    )


def _check_bounds(spec: DatasetSpec, draws: Draws, first: Settings) -> None:
    """Check both ends of every range, which perhaps no sequence draws."""
    for distribution in draws.drawn:
        for value in dict.fromkeys(distribution.values):
            _configs(spec, dict(draws.fixed) | dict(first) | {distribution.name: value})


def _check(sequences: tuple[SequencePlan, ...]) -> None:
    """Check the memory of every kind of sensor, and motions that may have no end."""
    kinds = {(s.sensor.width, s.sensor.height, s.crossing.supersample): s for s in sequences}
    for kind in kinds.values():
        needed = sensor_bytes(kind.sensor) + rendering_bytes(kind.lens, kind.crossing.supersample)
        check_memory(
            f"Rendering and emulation of {kind.sensor.width}×{kind.sensor.height} px", needed
        )
    for sequence in sequences:
        if sequence.crossing.profile is Profile.CONSTANT_OMEGA:
            Crossing(sequence.crossing, sequence.lens)
