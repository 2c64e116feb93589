"""The sensor options: preset, file and single values, and their errors."""

from dataclasses import replace
from pathlib import Path
from typing import Any

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
from scenarios.commands.converge import Converge
from scenarios.commands.demo import Demo
from scenarios.commands.emulate import Emulate
from scenarios.commands.envelope import Envelope
from scenarios.commands.run import Run
from scenarios.commands.study import Study
from scenarios.commands.sweep import Sweep
from scenarios.commands.velocity_sweep import VelocitySweep
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


def test_without_options_the_sensor_is_the_default() -> None:
    assert SensorOptions().config() == SensorConfig()
    assert SensorOptions().name == "davis346"
    assert SensorOptions("ideal").config() == preset("ideal")


def test_values_override_the_file_and_the_file_overrides_the_preset(file: Path) -> None:
    given = ("theta_off=0.3", "aps.read_noise_e=20", "aps.noise=false", "biases.on=[6, 200]")
    found = SensorOptions(str(file), set=given).config()
    biases = Biases(on=Bias(6, 200), refractory=Bias(4, 10))
    expected = with_biases(preset("dvs128"), biases)
    assert (found.width, found.theta_mismatch) == (128, 0.021)
    assert (found.theta_on, found.theta_off) == (0.25, 0.3)
    assert found.refractory_us == expected.refractory_us == 8
    assert found.follower_hz == expected.follower_hz
    assert found.aps == ApsConfig(shutter="rolling", read_noise_e=20.0, noise=False)


def test_the_readout_is_set_by_value_or_by_table(tmp_path: Path) -> None:
    given = ("readout.limit_hz=2e6", "readout.kind=scan")
    found = SensorOptions("dvxplorer", set=given).config()
    assert found.readout == replace(preset("dvxplorer").readout, limit_hz=2e6)
    file = tmp_path / "bus.toml"
    file.write_text("[readout]\nlatency_us = 7\n", encoding="utf-8")
    assert SensorOptions(str(file)).config().readout == ReadoutConfig(latency_us=7)
    with pytest.raises(ScenarioError, match=r"readout\.limit"):
        SensorOptions(set=("readout.limit=3",)).config()


def test_a_preset_given_as_a_value_overrides_that_of_the_file(file: Path) -> None:
    assert SensorOptions(str(file), set=("preset=davis240",)).config().width == 240


def test_the_command_line_takes_the_options() -> None:
    line = ["--sensor", "dvs128", "--set", "theta_on=0.2", "aps.shutter=rolling", "--seed", "3"]
    made = tyro.cli(Characterise, args=line)
    assert made.seed == 3
    assert made.sensor.config() == sensor_of(
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
def test_set_takes_several_values_and_may_be_repeated(line: list[str]) -> None:
    found = tyro.cli(Characterise, args=line).sensor.config()
    assert (found.theta_on, found.theta_off, found.aps.shutter) == (0.25, 0.3, "rolling")


def test_a_name_given_twice_is_refused() -> None:
    with pytest.raises(ScenarioError, match="--set has theta_on 2 times"):
        SensorOptions(set=("theta_on=0.2", "theta_off=0.2", "theta_on=0.3")).config()


def test_help_explains_the_effect_of_a_bias(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(Characterise, args=["--help"])
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "Biases that are not set then have the manufacturer's values" in text


@pytest.mark.parametrize(("given", "frames"), [("dvs128", False), ("davis240", True)])
def test_whether_there_are_frames_depends_on_the_preset(given: str, frames: bool) -> None:
    assert SensorOptions(set=(f"preset={given}", "theta_on=0.3")).frames == frames


def test_different_sensors_have_different_names() -> None:
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
        ("theta_onn=0.3", "no parameter 'theta_onn'. Allowed .* Did you mean theta_on?"),
        ("aps.noises=true", "no parameter 'aps.noises'. Allowed .* Did you mean noise?"),
        ("biases.up=[1,2]", "no parameter 'biases.up'"),
        ("optics.f_number=2", "no parameter 'optics'"),
        ("theta_on", "'theta_on' is not NAME=VALUE"),
        ("theta_on=", "is not NAME=VALUE"),
        ("theta_on=1,5", "value that cannot be read"),
        ("biases.on=6", "biases.on is 6. Allowed is a coarse and a fine code"),
        ("aps=3", "aps is 3. Allowed is a table"),
    ],
)
def test_unknown_names_and_malformed_values_are_refused(given: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        SensorOptions(set=(given,)).config()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("theta_on=-1", "theta_on is -1"),
        ("theta_on=wide", "theta_on is 'wide'"),
        ("theta_on=nan", "theta_on is nan"),
        ("theta_on.x=3", "theta_on is"),
        ("preset=kodak", "preset is 'kodak'"),
        ("preset=[1]", r"preset is \[1\]"),
        ("biases.on=[6,900]", "biases.on: fine is 900"),
        ("biases.off=[9,200]", "biases.off: coarse is 9"),
        ("biases.on=[4,39]", "theta_on is 0.0"),
        ("aps.shutter=slow", "shutter is 'slow'"),
    ],
)
def test_values_out_of_range_are_refused_by_the_sensor(given: str, words: str) -> None:
    with pytest.raises(SensorConfigError, match=words):
        SensorOptions(set=(given,)).config()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"theta_on 0.2", "is not valid TOML"),
        (b"\xff\xfe", "is not a text file"),
        (b"theta_onn = 0.2", "no parameter 'theta_onn'"),
        (b"theta_on = 0.2\n[theta_on]\n", "is not valid TOML"),
        (None, "cannot be read"),
    ],
)
def test_an_invalid_file_is_refused(tmp_path: Path, content: bytes | None, words: str) -> None:
    path = tmp_path / "sensor.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ScenarioError, match=words):
        SensorOptions(str(path)).config()


def test_a_value_in_a_file_that_is_out_of_range_is_refused_with_the_name_of_the_file(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mine"
    path.write_text("theta_on = -1", encoding="utf-8")
    with pytest.raises(SensorConfigError, match="mine: theta_on is -1"):
        SensorOptions(str(path)).config()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("davis364", "--sensor is 'davis364'. Allowed is a TOML file or one of .* davis346?"),
        ("kodak", "Give the path of an existing file"),
        ("none.toml", "none.toml cannot be read"),
        ("", "--sensor is ''"),
    ],
)
def test_a_sensor_that_is_neither_preset_nor_file_is_refused(given: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        SensorOptions(given).config()


COMMANDS = (Run, Demo, Emulate, Study, Sweep, VelocitySweep, Envelope, Characterise, Converge)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.__name__)
def test_every_command_that_makes_a_sensor_takes_a_file(command: Any, file: Path) -> None:
    line = ["--sensor", str(file), "--set", "theta_on=0.4"]
    if command is Emulate:
        line = ["in.mp4", "--out", "out.npz", *line]
    made = tyro.cli(command, args=line)
    assert (made.sensor.config().width, made.sensor.config().theta_on) == (128, 0.4)


def test_run_and_study_use_the_sensor_of_the_file(file: Path) -> None:
    options = SensorOptions(str(file))
    assert Run(sensor=options).config().sensor == options.config()
    study = Study(sensor=options, methods=("fly",))
    assert all(task.sensor == options.config() for task in study.tasks())
    with pytest.raises(ScenarioError, match="needs APS frames, and the sensor is dvs128"):
        Study(sensor=options, methods=("frame-fly",)).tasks()


def test_the_options_state_the_words_that_repeat_them() -> None:
    words = SensorOptions("my sensor.toml", set=("theta_on=0.4",)).arguments()
    assert words == ["--sensor", "'my sensor.toml'", "--set", "theta_on=0.4"]
    assert SensorOptions().arguments() == []
