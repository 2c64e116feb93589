"""`flybench calibrate`: what it writes and prints, its errors, and real recordings."""

import json
import math
import os
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from formats import open_writer, write_events
from scenarios.commands.sensor.calibrate import NUMBERS, PAGE, SENSOR, Calibrate
from scenarios.options.sensor import SensorOptions
from scenarios.output.terminal import execute
from tests.scenarios.calibrate.moving_texture import HEIGHT, WIDTH, recorded
from tests.scenarios.calibrate.test_calibration import SENSORS

REAL = os.environ.get("FLYBENCH_RECORDINGS")
TRUE = SENSORS["dull, fast and noisy"]
SHORT = {"move_s": 0.3, "still_s": 0.6}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half a second of motion after half a second of rest, with frames."""
    path = tmp_path_factory.mktemp("recorded") / "made.aedat4"
    events, frames = recorded(TRUE, **SHORT)
    with open_writer(path, width=WIDTH, height=HEIGHT) as writer:
        writer.write(events)
        for frame in frames:
            writer.write_frame(frame)
    return path


@pytest.fixture(scope="module")
def found(recording: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """What the command writes and prints, started from another sensor than the default."""
    out = tmp_path_factory.mktemp("out") / "found"
    start = SensorOptions("davis240", set=("follower_hz=0", "aps.target_dn=150"))
    with redirect_stdout(StringIO()) as printed:
        assert execute(Calibrate(recording, sensor=start, json=True, out=out)) == 0
    return out, printed.getvalue()


@pytest.fixture(scope="module")
def folder(found: tuple[Path, str]) -> Path:
    """Folder that the command writes."""
    return found[0]


def test_the_folder_contains_sensor_page_and_numbers(folder: Path) -> None:
    names = {path.name for path in folder.iterdir()}
    assert names == {PAGE, NUMBERS, SENSOR, "summary.json"}
    page = (folder / PAGE).read_text(encoding="utf-8")
    assert page.count("<svg") >= 3
    assert "Change from frame to frame" in page
    assert "http" not in page.replace("http://www.w3.org", "")


def test_every_command_takes_the_file_as_it_is(folder: Path) -> None:
    sensor = SensorOptions(str(folder / SENSOR)).config()
    numbers = json.loads((folder / NUMBERS).read_text(encoding="utf-8"))
    told = {k: p["value"] for k, p in numbers["parameters"].items() if p["value"] is not None}
    assert {"theta_on", "theta_off"} <= set(told)
    for name, value in told.items():
        assert getattr(sensor, name) == pytest.approx(value, rel=1e-3), name
    assert sensor.theta_on == pytest.approx(TRUE.theta_on, rel=0.15)
    assert (sensor.width, sensor.height) == (WIDTH, HEIGHT)
    assert (sensor.follower_hz, sensor.aps.target_dn) == (0.0, 150)


def test_what_is_not_told_stays_and_is_named(folder: Path) -> None:
    text = (folder / SENSOR).read_text(encoding="utf-8")
    assert "leak_hz_per_lux [Hz/lux]: not told by the recording" in " ".join(text.split("\n# "))
    assert "# leak_hz_per_lux = 2.6e-05" in text
    assert "not told" in (folder / PAGE).read_text(encoding="utf-8")


def test_the_check_predicts_the_second_half(found: tuple[Path, str]) -> None:
    out, text = found
    printed = json.loads(text)
    prediction = printed["prediction"]
    assert prediction is None or prediction["fitted_error"] >= 0.0
    assert printed == json.loads((out / NUMBERS).read_text(encoding="utf-8"))


def test_frames_of_a_folder_of_images_are_used(tmp_path: Path) -> None:
    """The frames of the recording as linear grey levels in files, beside its events."""
    events, frames = recorded(TRUE, **SHORT)
    write_events(tmp_path / "events.npz", [events], width=WIDTH, height=HEIGHT)
    images = tmp_path / "images"
    images.mkdir()
    middles = [(frame.start_us + frame.end_us) // 2 for frame in frames]
    for t_us, frame in zip(middles, frames, strict=True):
        cv2.imwrite(str(images / f"{t_us}.png"), (frame.image * 64).astype(np.uint16))
    out = tmp_path / "found"
    command = Calibrate(
        tmp_path / "events.npz",
        frames=images,
        frames_from_ms=middles[0] / 1e3,
        transfer="linear",
        check=False,
        out=out,
    )
    assert execute(command) == 0
    numbers = json.loads((out / NUMBERS).read_text(encoding="utf-8"))
    assert numbers["parameters"]["theta_on"]["value"] == pytest.approx(TRUE.theta_on, rel=0.25)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"path": Path("missing.aedat4")}, "missing.aedat4"),
        ({"fps": 30.0}, "--fps is 30, but --frames is not given"),
        ({"frames_from_ms": 5.0}, "--frames-from-ms is 5, but --frames is not given"),
        ({"white_cd_m2": 90.0}, "--white-cd-m2 is 90, but --frames is not given"),
        ({"transfer": "linear"}, "--transfer is linear, but --frames is not given"),
        ({"frames": Path("a.mp4"), "frames_from_ms": math.nan}, "--frames-from-ms is nan. Allowed"),
        ({"frames": Path("a.mp4"), "frames_from_ms": 1e30}, "a number from -1e+12 to 1e+12 ms."),
        ({"frames": Path("missing.mp4")}, "missing.mp4 does not exist"),
        ({"sensor": SensorOptions("kodak")}, "--sensor is 'kodak'"),
    ],
)
def test_invalid_arguments_give_a_one_line_error(
    changes: Any, words: str, recording: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert execute(Calibrate(**({"path": recording, "out": out} | changes))) == 2
    err = capsys.readouterr().err
    assert words in err
    assert len([line for line in err.splitlines() if line.startswith("flybench: ")]) == 1
    assert not out.exists()


def test_a_recording_without_frames_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    events, _ = recorded(TRUE, **SHORT)
    write_events(tmp_path / "events.npz", [events], width=WIDTH, height=HEIGHT)
    assert execute(Calibrate(tmp_path / "events.npz", out=tmp_path / "out")) == 2
    assert "has no frames" in capsys.readouterr().err


@pytest.mark.skipif(REAL is None, reason="FLYBENCH_RECORDINGS names no folder")
def test_a_laboratory_under_mains_light_shows_flicker_and_the_refractory_period(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    lab = Path(str(REAL)) / "lab.aedat4"
    assert execute(Calibrate(lab, check=False, json=True, out=out)) == 0
    found = json.loads(capsys.readouterr().out)
    frequency = next(q for q in found["figures"]["flicker"] if q["name"] == "frequency")
    assert frequency["value"] == pytest.approx(100.0, abs=0.5)
    assert found["parameters"]["refractory_us"]["value"] == pytest.approx(270, rel=0.1)
    assert found["parameters"]["theta_on"]["value"] is None


@pytest.mark.skipif(REAL is None, reason="FLYBENCH_RECORDINGS names no folder")
def test_half_of_a_real_recording_predicts_the_other_half_better_than_the_default(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cradle = Path(str(REAL)) / "cradle.aedat4"
    assert execute(Calibrate(cradle, json=True, out=tmp_path / "out")) == 0
    found = json.loads(capsys.readouterr().out)
    prediction = found["prediction"]
    assert prediction["fitted_error"] < 0.95 * prediction["start_error"]
    assert found["parameters"]["refractory_us"]["value"] is None
