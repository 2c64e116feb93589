"""The scripts in `examples` run."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

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
