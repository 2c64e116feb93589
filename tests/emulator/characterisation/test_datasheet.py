"""Data sheets of several experiments, for many kinds of sensors."""

from dataclasses import replace

import pytest

from emulator import SensorConfig, SensorConfigError, preset
from emulator.characterisation import EXPERIMENTS, Section, characterise, datasheet
from tests.emulator.characterisation.plain_sensor import PLAIN

QUICK = ("latency", "dynamic_range", "refractory")


def select_experiments(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    chosen = {name: measure for name, measure in EXPERIMENTS.items() if name in names}
    monkeypatch.setattr(datasheet, "EXPERIMENTS", chosen)


def test_a_data_sheet_recovers_the_configuration(monkeypatch: pytest.MonkeyPatch) -> None:
    select_experiments(monkeypatch, "s_curve", "refractory", "leak")
    progress: list[tuple[int, int]] = []
    config = replace(PLAIN, theta_on=0.3, leak_hz=0.4, refractory_us=20)
    sheet = characterise(config, seed=2, progress=lambda *done: progress.append(done))
    assert sheet.config == config
    assert list(sheet.sections) == ["s_curve", "refractory", "leak"]
    assert progress == [(1, 3), (2, 3), (3, 3)]
    figures = {n: f for section in sheet.sections.values() for n, f in section.figures.items()}
    assert figures["ON threshold at 1 klux"].measured == pytest.approx(0.3, rel=0.03)
    assert figures["OFF threshold at 1 klux"].measured == pytest.approx(0.22, rel=0.03)
    assert figures["leak without light"].measured == pytest.approx(0.4, rel=0.05)
    assert figures["refractory period"].measured == pytest.approx(20.0, rel=0.05)


@pytest.mark.parametrize(
    "config",
    [
        preset("ideal"),
        SensorConfig(follower_hz=400.0),
        replace(SensorConfig.noise_free(), bandwidth_hz_per_lux=0.01),
        SensorConfig(dead_fraction=1.0),
    ],
    ids=["ideal", "second order", "slow", "dead"],
)
def test_any_sensor_has_a_data_sheet(config: SensorConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    select_experiments(monkeypatch, *QUICK)
    assert list(characterise(config).sections) == list(QUICK)


def test_only_a_sensor_configuration_is_accepted() -> None:
    with pytest.raises(SensorConfigError, match="the sensor is 'davis346'"):
        characterise("davis346")  # type: ignore[arg-type]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_experiment_refuses_a_negative_seed(name: str) -> None:
    with pytest.raises(SensorConfigError, match="the seed is -1"):
        EXPERIMENTS[name](SensorConfig(), seed=-1)


@pytest.mark.parametrize(
    ("config", "frames", "named"),
    [
        (preset("dvs128"), None, []),
        (preset("dvs128"), True, ["photon_transfer"]),
        (SensorConfig(), None, ["photon_transfer"]),
        (SensorConfig(), False, []),
    ],
)
def test_a_chip_without_frames_has_no_section_on_them(
    config: SensorConfig, frames: bool | None, named: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = {"photon_transfer": lambda *_, **__: Section("", "", [])}
    monkeypatch.setattr(datasheet, "EXPERIMENTS", nothing)
    assert list(characterise(config, frames=frames).sections) == named


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(SensorConfigError, match="the seed is -1"):
        characterise(SensorConfig(), seed=-1)
