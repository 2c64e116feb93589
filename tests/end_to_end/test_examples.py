"""The scripts in `examples` run."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from emulator import ApsFrame
from emulator.pixel.optics import lux_per_cd_m2
from flybench.events import EVENT_DTYPE
from formats import open_writer

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def run_example(script: str, *arguments: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(EXAMPLES / script), *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_robot_arm_writes_a_picture(tmp_path: Path) -> None:
    printed = run_example(
        *("robot_arm/arm.py", "--seconds", "0.04", "--step-px", "8", "--picture", "arm.png"),
        folder=tmp_path,
    )
    assert "events" in printed
    picture = cv2.imread(str(tmp_path / "arm.png"))
    assert picture is not None
    assert picture.std() > 20


def test_other_libraries_make_the_same_picture(tmp_path: Path) -> None:
    pytest.importorskip("tonic")
    pytest.importorskip("dv_processing")
    printed = run_example("peers.py", "--picture", "peers.png", folder=tmp_path)
    assert printed.splitlines()[-1] == "the same picture"
    assert "tonic 1." in printed
    assert "dv-processing 2." in printed
    picture = cv2.imread(str(tmp_path / "peers.png"))
    assert picture is not None
    assert picture.std() > 20


def test_the_comparison_notices_one_moved_event(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tonic")
    pytest.importorskip("dv_processing")
    spec = importlib.util.spec_from_file_location("peers", EXAMPLES / "peers.py")
    assert spec is not None
    assert spec.loader is not None
    peers = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(peers)
    events, size = peers.emulated_disc()
    ours = peers.our_pictures(events, size)
    moved = events.copy()
    moved["x"][-1] += 1
    pictures = {"ours": ours, "theirs": peers.tonic_pictures(moved, size)}
    assert peers.compare(pictures, events.size) == 1
    assert "NOT the same picture" in capsys.readouterr().out
    inverted = events.copy()
    inverted["p"] = ~events["p"]
    assert not np.array_equal(peers.tonic_pictures(inverted, size)[0], ours[0])


def test_the_frames_of_a_recording_become_luminance_without_their_noise(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with open_writer(tmp_path / "real.aedat4", width=32, height=24) as writer:
        writer.write(np.array([(k * 1000, 1, 1, k % 2) for k in range(90)], EVENT_DTYPE))
        for k in range(4):
            image = rng.normal(400, 2.0, (24, 32))
            image[:, 8 * k] = 800  # moves
            times = 20_000 * k, 20_000 * k + 10_000
            writer.write_frame(ApsFrame(*times, image.astype(np.uint16)))
    printed = run_example("own_frames.py", "real.aedat4", "frames", folder=tmp_path)
    assert "4 frames" in printed
    luminance = np.load(tmp_path / "frames.npy")
    assert luminance.shape == (4, 24, 32)
    assert np.ptp(luminance[:, :, 1:8], axis=0).max() == 0.0
    moved = luminance[1, :, 8].mean()
    assert moved / luminance[0, :, 8].mean() == pytest.approx(2.0, rel=0.02)
    lux_s = moved * lux_per_cd_m2(f_number=1.4, transmission=0.9) * 10e-3
    assert lux_s * 2.0e5 == pytest.approx(800 * 37_000 / 680, rel=1e-3)
    assert (tmp_path / "frames.txt").read_text() == "5000\n25000\n45000\n65000\n"
