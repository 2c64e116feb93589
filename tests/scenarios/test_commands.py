"""The small commands: doctor, run, demo and velocity-sweep."""

import csv
import json
from pathlib import Path

import pytest

from scenarios.commands import doctor, velocity_sweep
from scenarios.commands.demo import Demo
from scenarios.commands.doctor import Doctor
from scenarios.commands.run import Run
from scenarios.commands.velocity_sweep import VelocitySweep
from scenarios.errors import MethodError, ScenarioError
from scenarios.output.terminal import execute
from scenarios.pipeline.run_config import RunConfig
from scenarios.runs.run_table import print_runs
from sim import Lighting
from sim.errors import RendererError
from sim.render.vulkan import INSTALL_COMMAND, VECTOR_WIDTH, VulkanDevice


def test_doctor_shows_device_and_speed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "FRAMES", 2)
    assert Doctor().execute() == 0
    printed = capsys.readouterr().out
    for words in ("Vulkan device", "per second", "mujoco", "Nothing is missing"):
        assert words in printed


def test_doctor_names_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_devices() -> list[VulkanDevice]:
        return []

    monkeypatch.setattr(doctor, "vulkan_devices", no_devices)
    assert Doctor().execute() == 1
    assert INSTALL_COMMAND in capsys.readouterr().out


def test_doctor_says_that_the_vectors_are_too_narrow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(VECTOR_WIDTH, "128")
    assert Doctor().execute() == 1
    printed = capsys.readouterr().out
    assert f"{VECTOR_WIDTH} is 128" in printed
    assert "Unset the variable" in printed
    assert "per second" not in printed


def test_without_vulkan_a_run_ends_with_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("sim.render.vulkan.ctypes.util.find_library", lambda _: None)
    assert execute(Run(out=tmp_path / "out")) == 2
    assert INSTALL_COMMAND in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert issubclass(RendererError, ValueError)


def test_speed_and_angular_velocity_agree() -> None:
    by_speed = Run(speed_km_h=40).config().crossing.omega_rad_s
    assert by_speed == pytest.approx(1.61, abs=0.01)
    at_night = Run(lighting="night", speed_km_h=40).config().crossing
    assert at_night.omega_rad_s == pytest.approx(1.42, abs=0.01)
    assert Run(lighting="night").config().crossing.lighting is Lighting.NIGHT


def test_a_filter_is_part_of_the_method_of_a_run() -> None:
    assert Run(filter="baf", method="wide").config().method == "baf+wide"


def test_parameters_have_dotted_names() -> None:
    parameters = RunConfig(seed=3).parameters()
    assert parameters["crossing.omega_rad_s"] == 1.61
    assert parameters["sensor.aps.noise"] is True
    assert parameters["seed"] == 3


def test_a_velocity_sweep_prints_and_writes_truth_and_estimate(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    sweep = VelocitySweep(omegas=(2.42,), step_px=8.0, supersample=1, seeds=2, out=out)
    assert sweep.execute() == 0
    printed = capsys.readouterr().out
    for words in ("2.42", "right", "moving right, event-driven fly, seeds: 2"):
        assert words in printed
    assert {path.name for path in out.iterdir()} == {
        "velocities.csv",
        "grms.png",
        "grms.svg",
        "summary.json",
    }
    with (out / "velocities.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["seed"] for row in rows] == ["0", "1"]
    assert {(row["direction"], row["method"], row["truth"]) for row in rows} == {
        ("right", "fly", "right")
    }
    assert len({row["grms"] for row in rows}) == 2  # one rendering, two sensors
    summary = json.loads((out / "summary.json").read_text())
    assert summary["spearman"] == {"day": {"0": None, "1": None}}


def test_a_velocity_sweep_keeps_the_velocities_at_which_the_detector_works(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def measure(config: RunConfig, *_: object, **__: object) -> list[dict[str, object]]:
        if config.crossing.omega_rad_s == 2.0:
            raise MethodError("mine:Own: push raised an error")
        return [{"omega_rad_s": config.crossing.omega_rad_s}]

    printed: list[object] = []
    monkeypatch.setattr(velocity_sweep, "measure_velocity", measure)
    monkeypatch.setattr(velocity_sweep, "print_rows", printed.extend)
    assert VelocitySweep(omegas=(1.0, 2.0, 2.5)).execute() == 1
    assert printed == [{"omega_rad_s": 1.0}, {"omega_rad_s": 2.5}]
    reason = "flybench: mine:Own: push raised an error (sequence day_right_2rad_s_seed0"
    assert reason in capsys.readouterr().err
    assert execute(VelocitySweep(omegas=(2.0,))) == 2
    assert reason in capsys.readouterr().err


@pytest.mark.parametrize("seeds", [0, 101])
def test_a_velocity_sweep_with_too_few_or_too_many_seeds_is_refused(seeds: int) -> None:
    with pytest.raises(ScenarioError, match=rf"--seeds is {seeds}\. Allowed is .* from 1 to 100"):
        VelocitySweep(seeds=seeds).execute()


@pytest.mark.parametrize("command", [VelocitySweep, Run, Demo])
def test_an_unknown_method_is_refused_before_rendering(
    command: type[VelocitySweep | Run | Demo], tmp_path: Path
) -> None:
    with pytest.raises(MethodError, match=r"'bee'\. Allowed is fly"):
        command(method="bee", out=tmp_path / "out").execute()
    assert list(tmp_path.iterdir()) == []


def test_the_table_has_one_column_for_each_run(capsys: pytest.CaptureFixture[str]) -> None:
    def summary(latency_ms: float | None) -> dict[str, object]:
        return {
            "truth": {
                "direction": "right",
                "omega_rad_s": 1.61,
                "speed_km_h": 39.9,
                "image_speed_px_s": 522.0,
                "duration_us": 1_000_000,
            },
            "events": {
                "count": 1234567,
                "on": 1000000,
                "off": 234567,
                "by_cause": {"signal": 1234560, "leak": 5, "shot": 1, "hot": 1},
            },
            "detector": {
                "method": "mine:Own",
                "direction": "right",
                "accuracy": 0.9,
                "accuracy_after_100ms": None,
                "steps_in_view": 100,
                "latency_ms": latency_ms,
                "roi_iou": 0.42,
                "centroid_error_px": None,
                "grms": 1.5,
            },
            "wall_s": {"render": 1.0, "emulate": 2.0, "total": 3.5},
        }

    print_runs([(Path("logs/a"), summary(50.0)), (Path("logs/b"), summary(None))])
    printed = capsys.readouterr().out
    for words in (
        "1,234,567",
        "mine:Own",
        "42 %",
        "50 ms after entry",
        "never",
        "no step",
        "logs/b/recording.rrd",
        "3.5 s",
    ):
        assert words in printed
