"""From a sweep file to its points, and files that are refused."""

from pathlib import Path

import pytest

from flybench.direction import Direction
from scenarios.options.sensor import SensorOptions
from scenarios.pipeline.run_config import RunConfig
from scenarios.sweep.plan import Plan, read_plan
from scenarios.sweep.sweep_file import SweepFileError
from sim import CrossingConfig, Distractors, RelativeDirection

EXAMPLES = Path(__file__).parents[3] / "scenarios" / "sweep" / "examples"


def plan(tmp_path: Path, text: str) -> Plan:
    path = tmp_path / "sweep.toml"
    path.write_text(text)
    return read_plan(path)


def test_dotted_names_may_be_keys_quoted_or_headers(tmp_path: Path) -> None:
    dotted = "[grid]\ncrossing.omega_rad_s = [1, 2]\nsensor.aps.noise = [true]"
    quoted = '[grid]\n"crossing.omega_rad_s" = [1, 2]\n"sensor.aps.noise" = [true]'
    headers = "[grid.crossing]\nomega_rad_s = [1, 2]\n[grid.sensor.aps]\nnoise = [true]"
    points = plan(tmp_path, dotted).points
    assert plan(tmp_path, quoted).points == points
    assert plan(tmp_path, headers).points == points
    assert [p.config.crossing.omega_rad_s for p in points] == [1.0, 2.0]


def test_seeds_vary_fastest_then_draws_then_the_last_axis(tmp_path: Path) -> None:
    text = """
        seeds = [7, 3]
        [fixed]
        crossing.lead_s = 0.1
        [grid]
        crossing.direction = ["up", "left"]
        [[levels.clutter]]
        name = "calm"
        [[levels.clutter]]
        name = "busy"
        crossing.distractors.far_vehicle = "same"
        crossing.distractors.wind_grade = 3
        [sample]
        count = 2
        sensor.theta_on = {uniform = [0.1, 0.2]}
    """
    points = plan(tmp_path, text).points
    assert len(points) == 16
    got = [(p.config.crossing.direction.value, p.labels["clutter"]) for p in points[::4]]
    assert got == [("up", "calm"), ("up", "busy"), ("left", "calm"), ("left", "busy")]
    assert [p.config.seed for p in points[:4]] == [7, 3, 7, 3]
    drawn = [p.config.sensor.theta_on for p in points]
    assert drawn == drawn[:4] * 4
    assert drawn[0] == drawn[1] != drawn[2] == drawn[3]
    busy = Distractors(far_vehicle=RelativeDirection.SAME, wind_grade=3)
    assert points[4].config.crossing == CrossingConfig(
        direction=Direction.UP, lead_s=0.1, distractors=busy
    )
    assert set(points[4].varied) == {"crossing.direction", "sensor.theta_on", "seed"}


def test_the_preset_is_a_label(tmp_path: Path) -> None:
    points = plan(tmp_path, '[grid]\nsensor.preset = ["dvs128", "davis346"]').points
    assert [dict(p.labels) for p in points] == [
        {"sensor.preset": "dvs128"},
        {"sensor.preset": "davis346"},
    ]
    assert points[1].config == RunConfig()
    assert points[0].config.sensor.width == 128


def test_equal_points_appear_once(tmp_path: Path) -> None:
    text = '[sample]\ncount = 50\ncrossing.vehicle = {choice = ["van", "sedan"]}'
    assert len(plan(tmp_path, text).points) == 2


def test_the_examples_are_valid() -> None:
    counts = {path.stem: len(read_plan(path).points) for path in EXAMPLES.glob("*.toml")}
    assert counts == {
        "speed_illuminance": 72,
        "noise_contrast": 32,
        "direction_clutter": 40,
        "random_sensor": 60,
        "thresholds_refractory": 320,
    }


REFUSED = {
    "crossing.omega_rad_s = 1": (
        "crossing is not a key of a sweep. Allowed at the top level is seeds, fixed"
    ),
    "[grids]\nmethod = ['fly']": "grids is not a key of a sweep. .* Did you mean grid",
    "grid = 3": r"grid is 3. Allowed is a table. Write \[grid\] above it",
    "": "Nothing varies in this file. Allowed is a file with",
    "[fixed]\nseed = 3": "Nothing varies",
    "[grid]": "Nothing varies",
    "[grid]\ncrossing.omega = [1]": "no parameter crossing.omega. Similar names are crossing.ome",
    "[grid]\ncrossing.omega_rad_s = []": r"crossing.omega_rad_s is \[\]. Allowed in \[grid\] is a",
    "[grid]\ncrossing.omega_rad_s = 2": r"is 2. Allowed in \[grid\] is a list .* use \[fixed\]",
    "[grid]\ncrossing.omega_rad_s = [1, 1.0]": "crossing.omega_rad_s holds 1.0 twice",
    "[grid]\ncrossing.omega_rad_s = [1, 'a']": "crossing.omega_rad_s is 'a'. Allowed is a number",
    "[grid]\ncrossing.omega_rad_s = [1, -1]": "crossing.omega_rad_s is -1.0. Allowed is",
    "[grid]\ncrossing.omega_rad_s = [nan]": "crossing.omega_rad_s is nan. Allowed is",
    "[grid]\ncrossing.omega_rad_s = [1979-05-27]": "omega_rad_s is datetime.date.*a number",
    "[grid]\ncrossing = ['a']": "no parameter crossing",
    "[grid]\nmethod = ['bee']": "The method is 'bee'. Allowed is fly",
    "[grid]\nmethod = ['no_such_module:Bee']": "no module no_such_module",
    "[grid]\nmethod = ['fly']\nmethod = ['wide']\n": (
        "not valid TOML: Cannot overwrite a value .*line 3"
    ),
    "[grid]\n'sensor.theta_on' = [0.1]\nsensor.theta_on = [0.2]": (
        r"sensor.theta_on is set twice, in \[grid\]. Allowed is once"
    ),
    "[fixed]\nsensor.theta_on = 0.2\n[grid]\nsensor.theta_on = [0.1]": (
        r"sensor.theta_on is set twice, in \[fixed\] and in \[grid\]"
    ),
    "seeds = 2\n[grid]\nseed = [1]": r"seed is set twice, in (seeds|\[grid\]) and in",
    "seeds = 0": "seeds is 0. Allowed is a number of seeds from 1 to 100,000, or a list",
    "seeds = 1.5": "seeds is 1.5. Allowed is a number of seeds",
    "seeds = true": "seeds is True. Allowed is a number of seeds",
    "seeds = []": r"seeds is \[\]. Allowed is a number of seeds",
    "seeds = [1, 1]": r"seeds is \[1, 1\]. Allowed is every seed once",
    "seeds = ['a']": "seed is 'a'. Allowed is a whole number",
    "seeds = [-1]": "seed is -1. Allowed is a whole number from 0 to",
    "seeds = 4294967297": "seeds is 4294967297. Allowed is a number of seeds from 1 to",
    "[sample]\ncount = 3": r"\[sample\] holds no parameter. Allowed is one parameter or more",
    "[sample]\nsensor.theta_on = {uniform = [0.1, 0.2]}": "sample.count is None. Allowed",
    "[sample]\ncount = 0\nsensor.theta_on = {uniform = [0.1, 0.2]}": "sample.count is 0",
    "[sample]\ncount = 1\nseed = -1\nsensor.theta_on = {uniform = [1, 2]}": "sample.seed is -1",
    "[sample]\ncount = 1\nsensor.theta_on = 0.2": r"sensor.theta_on is 0.2. Allowed in \[sample\]",
    "[sample]\ncount = 9\nsensor.theta_on = {uniform = [11, 12]}": "sensor.theta_on is 11",
    "[levels]\nclutter = 3": r"levels.clutter is 3. .* Write \[\[levels.clutter\]\] above each",
    "[[levels.clutter]]\nseed = 3": "levels.clutter.name is None. Allowed is text in quotes",
    "[[levels.method]]\nname = 'a'": "levels.method is not a valid name for an axis",
    "[[levels.sensor]]\nname = 'a'": "levels.sensor is not a valid name for an axis",
    "[[levels.a]]\nname = 'a'\n[[levels.a]]\nname = 'a'": "levels.a are a, a. Allowed is each name",
    "[[levels.a]]\nname = 'a'\nwind = 3": "no parameter wind. Similar names are .*wind_grade",
    "[fixed]\nseed = 1\n[[levels.a]]\nname = 'a'\nseed = 3": r"seed is set twice, in \[fixed\] and",
    "[[levels.a]]\nname = 'a'\nsensor.theta_on = 0.1\n'sensor.theta_on' = 0.2": (
        "sensor.theta_on is set twice, in levels.a a"
    ),
    "[fixed]\nmethod = 'plane-fit'\n[grid]\nfly.alpha = [0.2]": "method is plane-fit, but",
    "[fixed]\ncrossing.profile = 'constant_omega'\n[grid]\ncrossing.lead_s = [9.0]": "lead",
    "grid = [": "is not valid TOML: ",
}


@pytest.mark.parametrize("text", REFUSED)
def test_an_invalid_file_is_refused_with_the_reason(text: str, tmp_path: Path) -> None:
    with pytest.raises(SweepFileError, match=f"sweep.toml.*{REFUSED[text]}"):
        plan(tmp_path, text)


def test_too_many_points_are_refused_before_they_are_made(tmp_path: Path) -> None:
    numbers = list(range(1, 1001))
    text = f"[grid]\nsensor.refractory_us = {numbers}\nsensor.readout.latency_us = {numbers}"
    with pytest.raises(SweepFileError, match=r"1,000,000 points\. Allowed are 100,000"):
        plan(tmp_path, text)


def test_a_file_that_cannot_be_read_is_reported(tmp_path: Path) -> None:
    with pytest.raises(SweepFileError, match=r"no.toml cannot be read \(No such file"):
        read_plan(tmp_path / "no.toml")
    with pytest.raises(SweepFileError, match=r"cannot be read \(Is a directory"):
        read_plan(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(
        SweepFileError, match=r"is not a text file\. Allowed is a TOML file in UTF-8"
    ):
        read_plan(tmp_path / "bytes.toml")


def test_a_sensor_that_does_not_fit_into_memory_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "huge.toml"
    path.write_text("[fixed]\nsensor.width = 30000\nsensor.height = 30000\n[grid]\nseed = [1, 2]\n")
    with pytest.raises(SweepFileError, match=r"30000×30000 px needs .* Allowed is 4 GB"):
        read_plan(path)


def test_scene_sensor_and_detector_must_fit_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "fine.toml"
    path.write_text("[grid]\nseed = [1, 2]\n")
    monkeypatch.setattr("flybench.memory._counted", {})
    monkeypatch.setenv("FLYBENCH_MEMORY_GB", "0.1")
    with pytest.raises(SweepFileError, match="Rendering and emulation of 346×260 px"):
        read_plan(path)


def test_a_long_axis_takes_no_quadratic_time(tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    path.write_text(f"[grid]\nseed = {list(range(150_000))}\n")
    with pytest.raises(SweepFileError, match="The sweep has 150,000 points"):
        read_plan(path)


def test_a_sensor_of_the_command_line_is_the_base_of_every_point(tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[grid]\nsensor.theta_on = [0.3, 0.4]\n", encoding="utf-8")
    options = SensorOptions("dvs128", set=("theta_off=0.5",))
    sensors = [point.config.sensor for point in read_plan(file, options).points]
    assert [(s.width, s.theta_on, s.theta_off) for s in sensors] == [
        (128, 0.3, 0.5),
        (128, 0.4, 0.5),
    ]
    file.write_text('seeds = 2\n[fixed]\nsensor.preset = "davis240"\n', encoding="utf-8")
    assert read_plan(file).points[0].config.sensor.width == 240
    with pytest.raises(SweepFileError, match=r"sensor.preset is 'davis240', and a sensor is given"):
        read_plan(file, options)
