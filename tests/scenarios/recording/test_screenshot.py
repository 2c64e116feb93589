"""Screenshots of a recording."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from scenarios.recording import Recorder
from scenarios.recording.screenshot import ScreenshotError, screenshot
from sim import Crossing, CrossingConfig, TruthProbe
from tests.sim.body_labels import target_body_labels

SMALL_PX = (640, 400)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "recording.rrd"
    crossing = Crossing(CrossingConfig())
    _, jpeg = cv2.imencode(".jpg", np.full((260, 346, 3), (250, 0, 0), np.uint8))
    probe = TruthProbe(crossing.scene, crossing.intrinsics)
    unseen = target_body_labels(np.zeros((260, 346), np.bool_), crossing.scene)
    truth = probe.measure(0, crossing.seconds(0), unseen)
    with Recorder(path, crossing=crossing, parameters={}) as recorder:
        recorder.log_preview(jpeg.tobytes(), truth, scale=1.0)
    return path


def test_a_screenshot_shows_the_recording(path: Path, tmp_path: Path) -> None:
    png = tmp_path / "shot.png"
    screenshot(path, png, at_s=0.02, size_px=SMALL_PX)
    picture = cv2.imread(str(png))
    assert picture is not None
    assert picture.shape == (400, 640, 3)
    blue = np.all(np.abs(picture.astype(int) - (250, 0, 0)) < 10, axis=2)
    assert blue.sum() > 1000


def test_a_time_outside_the_recording_is_refused(path: Path, tmp_path: Path) -> None:
    png = tmp_path / "shot.png"
    with pytest.raises(ScreenshotError, match=r"time is 99\.0 s\. Allowed is 0 to 1\.\d+ s"):
        screenshot(path, png, at_s=99.0, size_px=SMALL_PX)
    assert not png.exists()


def test_a_missing_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScreenshotError, match=r"gone\.rrd is not a file"):
        screenshot(tmp_path / "gone.rrd", tmp_path / "shot.png")


def test_a_missing_folder_is_refused(path: Path, tmp_path: Path) -> None:
    with pytest.raises(ScreenshotError, match="does not exist"):
        screenshot(path, tmp_path / "nowhere" / "shot.png")


def test_a_missing_vulkan_driver_is_reported(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WGPU_BACKEND", "vulkan")
    monkeypatch.setenv("VK_DRIVER_FILES", os.devnull)
    monkeypatch.setenv("VK_ICD_FILENAMES", os.devnull)
    with pytest.raises(ScreenshotError, match=r"Vulkan driver\. `flybench doctor`"):
        screenshot(path, tmp_path / "shot.png")
