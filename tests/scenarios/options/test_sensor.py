"""Which sensor the arguments ask for: preset, file and single values, and what is refused."""

from dataclasses import replace
from pathlib import Path

import pytest
import tyro

from emulator import (
    ApsConfig,
    Bias,
    Biases,
    ReadoutConfig,
    SensorConfig,
    SensorConfigError,
    preset,
    with_biases,
)
from scenarios.commands.characterise import Characterise
from scenarios.errors import ScenarioError
from scenarios.options.sensor import SensorOptions, sensor_of

FILE = """
preset = "dvs128"
theta_on = 0.25
biases = { refractory = [4, 10] }

[aps]
shutter = "rolling"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "sensor.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def test_nothing_given_is_the_default_sensor() -> None:
    assert SensorOptions().sensor() == SensorConfig()
    assert SensorOptions().name == "davis346"
    assert SensorOptions(preset="ideal").sensor() == preset("ideal")


def test_single_values_come_on_top_of_the_file_and_that_on_top_of_the_preset(file: Path) -> None:
    given = ("theta_off=0.3", "aps.read_noise_e=20", "aps.noise=false", "biases.on=[6, 200]")
    found = SensorOptions(config=file, set=given).sensor()
    biases = Biases(on=Bias(6, 200), refractory=Bias(4, 10))
    expected = with_biases(preset("dvs128"), biases)
    assert (found.width, found.theta_mismatch) == (128, 0.021)
    assert (found.theta_on, found.theta_off) == (0.25, 0.3)
    assert found.refractory_us == expected.refractory_us == 8
    assert found.follower_hz == expected.follower_hz
    assert found.aps == ApsConfig(shutter="rolling", read_noise_e=20.0, noise=False)


def test_the_readout_is_set_by_value_or_by_table(tmp_path: Path) -> None:
    given = ("readout.limit_hz=2e6", "readout.kind=scan")
    found = SensorOptions(preset="dvxplorer", set=given).sensor()
    assert found.readout == replace(preset("dvxplorer").readout, limit_hz=2e6)
    file = tmp_path / "bus.toml"
    file.write_text("[readout]\nlatency_us = 7\n", encoding="utf-8")
    assert SensorOptions(config=file).sensor().readout == ReadoutConfig(latency_us=7)
    with pytest.raises(ScenarioError, match=r"no 'readout\.limit'.* did you mean limit_hz\?"):
        SensorOptions(set=("readout.limit=3",)).sensor()


def test_the_argument_for_the_preset_outweighs_the_file(file: Path) -> None:
    assert SensorOptions(preset="davis240", config=file).sensor().width == 240


def test_the_command_line_takes_them() -> None:
    line = ["--preset", "dvs128", "--set", "theta_on=0.2", "aps.shutter=rolling", "--seed", "3"]
    made = tyro.cli(Characterise, args=line)
    assert made.seed == 3
    assert made.sensor.sensor() == sensor_of(
        {"preset": "dvs128", "theta_on": 0.2, "aps": {"shutter": "rolling"}}
    )


@pytest.mark.parametrize(
    "line",
    [
        ["--set", "theta_on=0.25", "theta_off=0.3", "aps.shutter=rolling"],
        ["--set", "theta_on=0.25", "--set", "theta_off=0.3", "--set", "aps.shutter=rolling"],
        ["--set", "theta_on=0.25", "--set", "theta_off=0.3", "aps.shutter=rolling"],
    ],
)
def test_values_may_stand_together_or_apart(line: list[str]) -> None:
    found = tyro.cli(Characterise, args=line).sensor.sensor()
    assert (found.theta_on, found.theta_off, found.aps.shutter) == (0.25, 0.3, "rolling")


def test_a_name_given_twice_is_refused() -> None:
    with pytest.raises(ScenarioError, match="--set has theta_on 2 times; allowed is each name"):
        SensorOptions(set=("theta_on=0.2", "theta_off=0.2", "theta_on=0.3")).sensor()


def test_help_tells_what_a_bias_brings_along(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(Characterise, args=["--help"])
    said = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "those not named are the maker's" in said


@pytest.mark.parametrize(("given", "frames"), [("dvs128", False), ("davis240", True)])
def test_frames_are_those_of_the_chip_whatever_is_altered(given: str, frames: bool) -> None:
    assert SensorOptions(set=(f"preset={given}", "theta_on=0.3")).frames == frames


def test_a_name_tells_sensors_apart() -> None:
    names = [
        SensorOptions(set=given).name
        for given in (("theta_on=0.2",), ("theta_on=0.21",), ("theta_on=0.2", "width=20"))
    ]
    assert len({*names, "davis346"}) == 4
    assert all(name.startswith("davis346_") for name in names)
    assert SensorOptions(set=("width=20", "theta_on=0.2")).name == names[2]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("theta_onn=0.3", "no 'theta_onn'; allowed here .* did you mean theta_on?"),
        ("aps.noises=true", "no 'aps.noises'; allowed here .* did you mean noise?"),
        ("biases.up=[1,2]", "no 'biases.up'"),
        ("optics.f_number=2", "no 'optics'"),
        ("theta_on", "'theta_on' is no NAME=VALUE"),
        ("theta_on=", "no NAME=VALUE"),
        ("theta_on=1,5", "value that cannot be read"),
        ("biases.on=6", "biases.on is 6; allowed is a coarse and a fine code"),
        ("aps=3", "aps is 3; allowed is a table"),
    ],
)
def test_what_a_sensor_does_not_have_is_refused(given: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        SensorOptions(set=(given,)).sensor()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("theta_on=-1", "theta_on is -1. Allowed is a number from 0.01"),
        ("theta_on=wide", "theta_on is 'wide'"),
        ("theta_on=nan", "theta_on is nan"),
        ("theta_on.x=3", "theta_on is"),
        ("preset=kodak", "the preset is 'kodak'"),
        ("preset=[1]", r"the preset is \[1\]"),
        ("biases.on=[6,900]", "biases.on: fine is 900"),
        ("biases.off=[9,200]", "biases.off: coarse is 9. Allowed is"),
        ("biases.on=[4,39]", "theta_on is 0.0"),
        ("aps.shutter=slow", "shutter is 'slow'"),
    ],
)
def test_values_out_of_range_are_refused_by_the_sensor(given: str, words: str) -> None:
    with pytest.raises(SensorConfigError, match=words):
        SensorOptions(set=(given,)).sensor()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"theta_on 0.2", "is no TOML"),
        (b"\xff\xfe", "is no TOML"),
        (b"theta_onn = 0.2", "no 'theta_onn'"),
        (b"theta_on = 0.2\n[theta_on]\n", "is no TOML"),
        (None, "cannot be read"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path: Path, content: bytes | None, words: str) -> None:
    path = tmp_path / "sensor.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ScenarioError, match=words):
        SensorOptions(config=path).sensor()
